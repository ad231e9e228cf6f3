// Eye visibility of a batch: which eyes of the group see which hits, and with
// what film density. The tests are packets from the eye (estimators.md 8).
#include "reuse/harvest_internal.h"

#include <stdint.h>
#include <string.h>

// Where the hits fall on the film of an eye: density 0 where they do not.
static void project_hits( const RfEye* eye_in, const RfHitBatch* batch, int32_t* restrict row, float* restrict density )
{
    RfEye eye = *eye_in;
    const float* restrict px = batch->p[0];
    const float* restrict py = batch->p[1];
    const float* restrict pz = batch->p[2];
    const float* restrict nx = batch->ng[0];
    const float* restrict ny = batch->ng[1];
    const float* restrict nz = batch->ng[2];
#pragma omp simd
    for ( int i = 0; i < batch->count; ++i )
    {
        RfProjection at = rf_project( &eye, rf_vec3( px[i], py[i], pz[i] ), rf_vec3( nx[i], ny[i], nz[i] ) );
        row[i] = at.y;
        density[i] = at.seen ? at.density : 0.0f;
    }
}

// Segments from the eye to the hits that may be seen, lifted off their surface.
static int list_candidates( const RfEye* eye, const RfHitBatch* batch, float offset, const float* density,
                            int32_t* candidate, RfLaneScratch* s )
{
    int kept = 0;
    for ( int i = 0; i < batch->count; ++i )
    {
        candidate[kept] = i;
        s->d[0][kept] = batch->p[0][i] + batch->ng[0][i] * offset - eye->origin.x;
        s->d[1][kept] = batch->p[1][i] + batch->ng[1][i] * offset - eye->origin.y;
        s->d[2][kept] = batch->p[2][i] + batch->ng[2][i] * offset - eye->origin.z;
        kept += density[i] > 0.0f;
    }
    return kept;
}

// Visibility bits, the sum of the densities and the rows that hits land in, of
// one eye; a density of 0 is a hit that it does not see.
static void note_seen( const float* restrict density, const int32_t* restrict row, int eye, RfHitBatch* batch )
{
    uint32_t* restrict seen = batch->seen + ( eye / 32 ) * RF_LANES;
    float* restrict sum = batch->density_sum;
    uint32_t bit = 1u << ( eye % 32 );
    int32_t low = batch->rows[2 * eye], high = batch->rows[2 * eye + 1];
#pragma omp simd reduction( min : low ) reduction( max : high )
    for ( int i = 0; i < batch->count; ++i )
    {
        int lands = density[i] > 0.0f;
        int32_t from = lands ? row[i] : INT32_MAX, to = lands ? row[i] : -1;
        seen[i] |= lands ? bit : 0u;
        sum[i] += density[i];
        low = from < low ? from : low;
        high = to > high ? to : high;
    }
    batch->rows[2 * eye] = low;
    batch->rows[2 * eye + 1] = high;
}

static void see_from_other( const RfHarvest* harvest, int eye, const RfHitBatch* batch, RfHarvestScratch* scratch,
                            float* density, RfRayCounts* rays )
{
    RfLaneScratch* s = &scratch->walk.scratch;
    float offset = rf_ray_offset( rf_tracer_scene( harvest->walk.tracer ) );
    project_hits( harvest->eyes + eye, batch, scratch->row, density );
    int count = list_candidates( harvest->eyes + eye, batch, offset, density, scratch->candidate, s );
    const float* d[3] = { s->d[0], s->d[1], s->d[2] };
    rf_trace_segments_from( harvest->walk.tracer, harvest->eyes[eye].origin, count, d, s->visible );
    rays->eye += (uint64_t)count;
    for ( int k = 0; k < count; ++k )
        density[scratch->candidate[k]] *= (float)s->visible[k];
}

// Its own eye sees a hit in the pixel it was drawn in, whatever rounding makes
// of its projection.
static void see_from_own( const RfHarvest* harvest, const RfHitBatch* batch, int32_t* row, float* density )
{
    const RfEye* eye = harvest->eyes + batch->eye;
    for ( int i = 0; i < batch->count; ++i )
    {
        RfVec3 p = rf_vec3( batch->p[0][i], batch->p[1][i], batch->p[2][i] );
        RfVec3 ng = rf_vec3( batch->ng[0][i], batch->ng[1][i], batch->ng[2][i] );
        density[i] = rf_project( eye, p, ng ).density;
        row[i] = batch->pixel[i] / eye->width;
    }
}

void rf_see_batch( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    int eyes = harvest->shape.eyes;
    memset( batch->seen, 0, (size_t)rf_seen_words( eyes ) * RF_LANES * sizeof *batch->seen );
    memset( batch->density_sum, 0, (size_t)batch->count * sizeof( float ) );
    for ( int l = 0; l < eyes; ++l )
    {
        float* density = scratch->density + (size_t)l * RF_LANES;
        batch->rows[2 * l] = INT32_MAX;
        batch->rows[2 * l + 1] = -1;
        if ( l == batch->eye )
            see_from_own( harvest, batch, scratch->row, density );
        else
            see_from_other( harvest, l, batch, scratch, density, rays );
        note_seen( density, scratch->row, l, batch );
    }
    // the rows of misses belong to the batch as well
    for ( int i = 0; i < batch->miss_count; ++i )
    {
        int32_t* rows = batch->rows + 2 * batch->eye;
        int row = batch->miss_pixel[i] / harvest->eyes[batch->eye].width;
        rows[0] = row < rows[0] ? row : rows[0];
        rows[1] = row > rows[1] ? row : rows[1];
    }
}
