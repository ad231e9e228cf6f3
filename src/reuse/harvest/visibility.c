// Which cameras of the group see which hits of a batch, and with what film density. Visibility is tested by packets from the
// camera (src/reuse/estimators.md, section 8).
#include "base/fault.h"
#include "reuse/harvest/visibility.h"
#include "reuse/harvest/hit_list.h"

#include "reuse/chains/mirrored.h"
#include "reuse/harvest/eye_rays.h"
#include "scene/projection.h"

#include <stdint.h>
#include <string.h>

// Offsets the hits from their surface, the ends of segments from the cameras, by more than the rounding of the cameras'
// coordinates as well.
static void lift_hits( const RfHarvest* harvest, const RfHitBatch* batch, const float* restrict offset,
                       float lifted[3][RF_LANES] )
{
    float least = 0.0f;
    for ( int l = 0; l < harvest->shape->eyes; ++l )
        least = RF_FAULT( eye_rounding ) ? 0.0f : rf_maxf( least, rf_ray_offset( rf_eye_reach( harvest->eyes + l ) ) );
    for ( int c = 0; c < 3; ++c )
    {
        const float* restrict p = batch->p[c];
        const float* restrict ng = batch->ng[c];
        float* restrict out = lifted[c];
#pragma omp simd
        for ( int i = 0; i < batch->count; ++i )
            out[i] = p[i] + ng[i] * ( offset[i] > least ? offset[i] : least );
    }
}

// Visibility bits, the sum of the densities and the rows that hits land in, of
// one camera; a density of 0 is a hit that it does not see.
static void note_seen( const float* restrict density, const int32_t* restrict pixel, int eye, int width, RfHitBatch* batch )
{
    uint32_t* restrict seen = batch->seen + ( eye / 32 ) * RF_LANES;
    float* restrict sum = batch->density_sum;
    uint32_t bit = 1u << ( eye % 32 );
    int32_t low = INT32_MAX, high = -1;
#pragma omp simd reduction( min : low ) reduction( max : high )
    for ( int i = 0; i < batch->count; ++i )
    {
        int visible = density[i] > 0.0f;
        int32_t from = visible ? pixel[i] : INT32_MAX, to = visible ? pixel[i] : -1;
        seen[i] |= visible ? bit : 0u;
        sum[i] += density[i];
        low = from < low ? from : low;
        high = to > high ? to : high;
    }
    batch->rows[2 * eye] = low / width;
    batch->rows[2 * eye + 1] = high < 0 ? -1 : high / width;
}

// Visibility is tested in the scene of the camera's frame, not in that of the hits.
static const RfTracer* world_of( const RfHarvest* harvest, int eye )
{
    return RF_FAULT( neighbour_world ) ? harvest->path.tracer : rf_harvest_tracer( harvest, eye );
}

// Tests the straight segments to hits with density > 0. Hits behind thin panes are reused, except on smooth coats, which are
// split where a camera sees them directly.
static int see_straight( const RfHarvest* harvest, int eye, const RfHitBatch* batch, const float* const lifted[3],
                         uint32_t* first, float* density )
{
    const RfTracer* tracer = world_of( harvest, eye );
    const RfEye* from = harvest->eyes + eye;
    if ( batch->panes[0] == NULL )
        return rf_trace_from_eye( tracer, from, batch->count, lifted, density );
    float past[RF_LANES], probability[RF_LANES];
    size_t at = (size_t)eye * RF_LANES;
    RfPaneLanes panes = { .probability = probability,
                          .weight = { batch->panes[0] + at, batch->panes[1] + at, batch->panes[2] + at },
                          .first = first };
    bool pass = harvest->path.max_depth > 1;
    for ( int i = 0; i < batch->count; ++i )
    {
        past[i] = pass && batch->view[i] == RF_VIEW_DIRECT ? density[i] : 0.0f;
        density[i] = past[i] > 0.0f ? 0.0f : density[i];
        probability[i] = panes.weight[0][i] = panes.weight[1][i] = panes.weight[2][i] = 1.0f;
    }
    int rays = rf_trace_from_eye( tracer, from, batch->count, lifted, density );
    rays += rf_trace_from_eye_past_panes( tracer, from, batch->count, lifted, past, &panes );
    for ( int i = 0; i < batch->count; ++i )
        density[i] = past[i] > 0.0f ? past[i] * probability[i] : density[i];
    return rays;
}

// Tests the hits with density > 0, directly or by way of the mirror in which they were found. `first`: the first pane or the mirror
// before each that is seen, where there is one; NULL: not asked for.
static int see( const RfHarvest* harvest, int eye, const RfHitBatch* batch, const float* const lifted[3], uint32_t* first,
                float* density )
{
    if ( !rf_has_views( batch ) )
        return see_straight( harvest, eye, batch, lifted, first, density );
    float straight[RF_LANES];
    for ( int i = 0; i < batch->count; ++i )
        straight[i] = rf_is_straight( batch->view[i] ) ? density[i] : 0.0f;
    int rays = see_straight( harvest, eye, batch, lifted, first, straight );
    rays += rf_see_mirrored( world_of( harvest, eye ), harvest->eyes + eye, batch, lifted, first, density );
    for ( int i = 0; i < batch->count; ++i )
        density[i] = rf_is_straight( batch->view[i] ) ? straight[i] : density[i];
    return rays;
}

// No panes on the way to the hits' own camera.
static void clear_panes( const RfHitBatch* batch )
{
    for ( int c = 0; c < 3 && batch->panes[c] != NULL; ++c )
    {
        for ( int i = 0; i < batch->count; ++i )
            batch->panes[c][(size_t)batch->eye * RF_LANES + (size_t)i] = 1.0f;
    }
}

// Lists in way[] the hits that panes or blended surfaces may hide from their own camera in part, with their densities; returns
// their number. To the others the camera ray has tested the way.
static int list_partial( const RfHarvest* harvest, const RfHarvestScratch* scratch, int count, const float* density, float* way )
{
    bool all = rf_tracer_is_blended( harvest->path.tracer ), chains = rf_follows_chains( scratch );
    int listed = 0;
    for ( int i = 0; i < count; ++i )
    {
        bool partial = all || ( chains && scratch->chains->straight[scratch->hits->slot[i]] );
        way[i] = partial ? density[i] : 0.0f;
        listed += partial;
    }
    return listed;
}

// A hit's own camera sees it in the pixel it was drawn in, whatever rounding does to its
// projection.
static void see_from_own_eye( const RfHarvest* harvest, const RfHitBatch* batch, const float* const lifted[3],
                              RfHarvestScratch* scratch, float* density, RfRayCounts* rays )
{
    int32_t* pixel = scratch->landed_pixel;
    const RfEye* eye = harvest->eyes + batch->eye;
    rf_own_densities( rf_tracer_mirrors( harvest->path.tracer ), eye, batch, ( RfProjectedLanes ){ .density = density } );
    memcpy( pixel, batch->pixel, (size_t)batch->count * sizeof *pixel );
    if ( RF_FAULT( own_pixel ) )
        rf_project_batch( rf_tracer_mirrors( harvest->path.tracer ), eye, batch,
                          ( RfProjectedLanes ){ .pixel = pixel, .density = density } );
    clear_panes( batch );
    float way[RF_LANES];
    bool partial = batch->densities != NULL && rf_tracer_is_partial( harvest->path.tracer );
    if ( !partial || list_partial( harvest, scratch, batch->count, density, way ) == 0 )
        return;
    bool listed[RF_LANES];
    for ( int i = 0; i < batch->count; ++i )
        listed[i] = way[i] > 0.0f;
    rays->eye += (uint64_t)see( harvest, batch->eye, batch, lifted, NULL, way );
    // transmittance is never 0: the camera ray did get through
    for ( int i = 0; i < batch->count; ++i )
        density[i] = listed[i] ? rf_maxf( way[i], 1e-12f * density[i] ) : density[i];
}

// Cameras see what moves in their own frame alone.
static void hide_moving( const RfHarvestScratch* scratch, int count, float* density )
{
    for ( int i = 0; i < count; ++i )
        density[i] = scratch->own->moving[scratch->hits->slot[i]] ? 0.0f : density[i];
}

void rf_test_batch_visibility( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    int eyes = harvest->shape->eyes;
    memset( batch->seen, 0, (size_t)rf_seen_words( eyes ) * RF_LANES * sizeof *batch->seen );
    memset( batch->density_sum, 0, (size_t)batch->count * sizeof( float ) );
    lift_hits( harvest, batch, scratch->hits->offset, scratch->lifted );
    const float* lifted[3] = { scratch->lifted[0], scratch->lifted[1], scratch->lifted[2] };
    for ( int l = 0; l < eyes; ++l )
    {
        const RfEye* eye = harvest->eyes + l;
        float* density = scratch->density + (size_t)l * RF_LANES;
        if ( l != batch->eye && rf_shares_nothing( harvest ) )
        {
            memset( density, 0, (size_t)batch->count * sizeof *density );
            batch->rows[2 * l] = 0;
            batch->rows[2 * l + 1] = -1;
            if ( batch->densities != NULL )
                memset( batch->densities + (size_t)l * RF_LANES, 0, (size_t)batch->count * sizeof *density );
            continue;
        }
        if ( l == batch->eye )
            see_from_own_eye( harvest, batch, lifted, scratch, density, rays );
        else
        {
            RfProjectedLanes out = { .pixel = scratch->landed_pixel, .density = density };
            rf_project_batch( rf_tracer_mirrors( harvest->path.tracer ), eye, batch, out );
            if ( rf_splits_light( harvest ) )
                hide_moving( scratch, batch->count, density );
            if ( batch->surface_seen != NULL )
                memset( scratch->first_seen, 0xff, (size_t)batch->count * sizeof *scratch->first_seen ); // RF_MISS
            rays->eye +=
                (uint64_t)see( harvest, l, batch, lifted, batch->surface_seen != NULL ? scratch->first_seen : NULL, density );
            if ( batch->surface_seen != NULL )
                rf_note_surfaces_seen( harvest, l, density, scratch, batch );
        }
        if ( batch->densities != NULL )
            memcpy( batch->densities + (size_t)l * RF_LANES, density, (size_t)batch->count * sizeof *density );
        note_seen( density, scratch->landed_pixel, l, eye->width, batch );
    }
    // rows of misses count, too
    for ( int i = 0; i < batch->miss_count + batch->glint_count; ++i )
    {
        int32_t* rows = batch->rows + 2 * batch->eye;
        int row = rf_miss_pixel( batch )[i] / harvest->eyes[batch->eye].width;
        rows[0] = row < rows[0] ? row : rows[0];
        rows[1] = row > rows[1] ? row : rows[1];
    }
}
