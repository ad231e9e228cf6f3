// Lists what camera rays and their chains found: hits, misses and glints, with their pixels.
#include "reuse/harvest_internal.h"

#include <string.h>

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
}

// Lists specular hits and chains without a hit, of mirrors, glass and coats, behind the rays that missed.
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

// Lists the pixels whose chain brought light and has a hit, too.
static void note_glints( const RfHarvestScratch* scratch, RfHitBatch* batch, int32_t* glint_slot )
{
    const RfChains* chains = scratch->chains;
    for ( int i = 0; i < batch->count; ++i )
    {
        int slot = scratch->hits->slot[i];
        if ( chains->light[0][slot] + chains->light[1][slot] + chains->light[2][slot] == 0.0f )
            continue;
        rf_glint_pixel( batch )[batch->glint_count] = scratch->pixel[slot];
        glint_slot[batch->glint_count++] = slot;
    }
}

// Hits keep the pixel they were drawn in. Rays that hit nothing are misses; what has no record is listed behind these.
static void note_pixels( int count, RfHarvestScratch* scratch, RfHitBatch* batch )
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
        note_glints( scratch, batch, scratch->glint_slot );
}

// Places in the pixels of what is listed from `first` on.
static void note_offsets( const RfHarvestScratch* scratch, int first, int count, const int32_t* slot, RfHitBatch* batch )
{
    for ( int i = 0; i < count; ++i )
    {
        for ( int c = 0; c < 2; ++c )
            batch->offset[c][first + i] = scratch->place[c][slot[i]];
    }
}

void rf_list_hits( int count, RfHarvestScratch* scratch, RfHitBatch* batch )
{
    copy_hits( scratch->hits, batch );
    copy_views( scratch, batch );
    note_pixels( count, scratch, batch );
    if ( batch->offset[0] == NULL )
        return;
    note_offsets( scratch, 0, batch->count, scratch->hits->slot, batch );
    note_offsets( scratch, batch->count, batch->miss_count, scratch->miss_slot, batch );
    note_offsets( scratch, batch->count + batch->miss_count, batch->glint_count, scratch->glint_slot, batch );
}
