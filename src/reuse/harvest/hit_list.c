// Lists what the camera rays of a batch have found: hits, misses, glints, and which surfaces they see first (film/covering.h).
#include "reuse/harvest/hit_list.h"

#include <string.h>

// Turns ng of hits that have drawn a side to the cameras, which are on the side that is seen, wherever light arrives
// (src/reuse/estimators.md, section 20).
static void face_cameras( const RfVertexLanes* v, RfHitBatch* batch )
{
    for ( int i = rf_first_sided( v ); i < rf_record_count( v ); ++i )
    {
        for ( int c = 0; c < 3; ++c )
            batch->ng[c][i] *= v->param[RF_PARAM_CHOICE][i];
    }
}

static void copy_hits( const RfVertexLanes* v, RfHitBatch* batch )
{
    batch->count = rf_record_count( v );
    for ( int k = 0; k <= RF_BSDF_KIND_COUNT; ++k )
        batch->first[k] = v->first[k] < batch->count ? v->first[k] : batch->count;
    size_t bytes = (size_t)batch->count * sizeof( float );
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( batch->p[c], v->p[c], bytes );
        memcpy( batch->ng[c], v->ng[c], bytes );
    }
    int first = v->first[RF_BSDF_FIRST_GLOSSY];
    bytes = (size_t)( batch->count - first ) * sizeof( float );
    if ( bytes == 0 )
        return;
    face_cameras( v, batch );
    for ( int c = 0; c < 3; ++c )
    {
        memcpy( batch->n[c], v->n[c] + first, bytes );
        memcpy( batch->wo[c], v->wo[c] + first, bytes );
    }
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
    {
        if ( batch->param[p] != NULL )
            memcpy( batch->param[p], v->param[p] + first, bytes );
    }
}

static void copy_views( const RfHarvestScratch* scratch, RfHitBatch* batch )
{
    batch->has_views = batch->view != NULL && ( rf_follows_chains( scratch ) || batch->panes[0] != NULL );
    if ( batch->view == NULL )
        return;
    for ( int i = 0; i < batch->count; ++i )
        batch->view[i] = !rf_follows_chains( scratch ) ? RF_VIEW_DIRECT : scratch->chains->view[scratch->hits->slot[i]];
    for ( int i = batch->first[RF_BSDF_FROSTED]; i < batch->first[RF_BSDF_FROSTED + 1]; ++i )
        batch->view[i] = RF_VIEW_FROSTED;
}

// Lists the own-frame samples behind the misses: specular first hits, and chains that end without a non-specular vertex.
static void note_own_frame( const RfVertexLanes* first, const uint8_t* recorded, RfHarvestScratch* scratch, RfHitBatch* batch )
{
    for ( int i = 0; i < first->count; ++i )
    {
        int slot = first->slot[i];
        if ( recorded[slot] )
            continue;
        rf_miss_pixel( batch )[batch->miss_count] = scratch->pixel[slot];
        scratch->miss_slot[batch->miss_count++] = slot;
    }
}

// All that a chain finds.
static float light_of_chain( const RfChains* chains, int base_parts, int slot )
{
    float sum = 0.0f;
    for ( int k = 0; k < base_parts * chains->events; ++k )
    {
        for ( int c = 0; c < 3; ++c )
            sum += chains->finds[k].light[c][slot] + ( chains->clamped ? chains->finds[k].found[c][slot] : 0.0f );
    }
    return sum;
}

// Lists glints: light that a chain finds on its way, for pixels that have a hit as well.
static void note_glints( const RfHarvestScratch* scratch, int base_parts, RfHitBatch* batch, int32_t* glint_slot )
{
    for ( int i = 0; i < batch->count; ++i )
    {
        int slot = scratch->hits->slot[i];
        if ( light_of_chain( scratch->chains, base_parts, slot ) == 0.0f )
            continue;
        rf_glint_pixel( batch )[batch->glint_count] = scratch->pixel[slot];
        glint_slot[batch->glint_count++] = slot;
    }
}

// Notes the pixel of each hit, miss and own-frame sample.
static void note_pixels( int base_parts, int count, RfHarvestScratch* scratch, RfHitBatch* batch )
{
    uint8_t hit[RF_LANES], recorded[RF_LANES];
    memset( hit, 0, (size_t)count );
    memset( recorded, 0, (size_t)count );
    for ( int i = 0; i < scratch->first.count; ++i )
        hit[scratch->first.slot[i]] = 1;
    for ( int i = 0; i < batch->count; ++i )
    {
        int slot = scratch->hits->slot[i];
        recorded[slot] = 1;
        batch->pixel[i] = scratch->pixel[slot];
    }
    int32_t* miss_pixel = rf_miss_pixel( batch );
    batch->miss_count = batch->glint_count = 0;
    for ( int slot = 0; slot < count; ++slot )
    {
        miss_pixel[batch->miss_count] = scratch->pixel[slot];
        scratch->miss_slot[batch->miss_count] = slot;
        batch->miss_count += !hit[slot];
    }
    scratch->ray_miss_count = batch->sky_count = batch->miss_count;
    note_own_frame( &scratch->first, recorded, scratch, batch );
    if ( rf_follows_chains( scratch ) )
        note_glints( scratch, base_parts, batch, scratch->glint_slot );
}

// Film offsets of what is listed from `first` on.
static void note_offsets( const RfHarvestScratch* scratch, int first, int count, const int32_t* slot, RfHitBatch* batch )
{
    for ( int i = 0; i < count; ++i )
    {
        for ( int c = 0; c < 2; ++c )
            batch->offset[c][first + i] = scratch->place[c][slot[i]];
    }
}

void rf_list_hits( const RfHarvest* harvest, int count, RfHarvestScratch* scratch, RfHitBatch* batch )
{
    copy_hits( scratch->hits, batch );
    copy_views( scratch, batch );
    note_pixels( rf_base_parts( &harvest->path ), count, scratch, batch );
    if ( batch->offset[0] == NULL )
        return;
    note_offsets( scratch, 0, batch->count, scratch->hits->slot, batch );
    note_offsets( scratch, batch->count, batch->miss_count, scratch->miss_slot, batch );
    note_offsets( scratch, batch->count + batch->miss_count, batch->glint_count, scratch->glint_slot, batch );
}

// What cameras see first on their way to the hits of a batch: their own camera what its ray hit; another the hit itself, unless a thin
// pane or the mirror that shows it is before it.
static uint32_t number_of( const RfHarvest* harvest, uint32_t triangle )
{
    return rf_surface_number( rf_tracer_scene( harvest->path.tracer ), harvest->shape->covering, triangle );
}

void rf_note_surfaces( const RfHarvest* harvest, int count, const RfHarvestScratch* scratch, RfHitBatch* batch )
{
    const RfVertexLanes* first = &scratch->first;
    uint32_t by_slot[RF_LANES];
    memset( by_slot, 0, (size_t)count * sizeof *by_slot );
    for ( int i = 0; i < first->count; ++i )
        by_slot[first->slot[i]] = number_of( harvest, scratch->surfaces->triangle[first->ray[i]] );
    for ( int i = 0; i < batch->count; ++i )
        batch->surface[i] = by_slot[scratch->hits->slot[i]];
    for ( int k = 0; k < batch->miss_count; ++k )
        batch->surface[batch->count + k] = by_slot[scratch->miss_slot[k]];
}

void rf_note_surfaces_seen( const RfHarvest* harvest, int eye, const float* density, const RfHarvestScratch* scratch,
                            RfHitBatch* batch )
{
    uint32_t* seen = batch->surface_seen + (size_t)eye * RF_LANES;
    bool chains = rf_follows_chains( scratch );
    for ( int i = 0; i < batch->count; ++i )
    {
        int slot = scratch->hits->slot[i];
        uint32_t before = scratch->first_seen[i], end = chains ? scratch->chains->triangle[slot] : RF_MISS;
        if ( !( density[i] > 0.0f ) )
            continue;
        if ( before != RF_MISS )
            seen[i] = number_of( harvest, before );
        else
            seen[i] = end != RF_MISS ? number_of( harvest, end ) : batch->surface[i];
    }
}
