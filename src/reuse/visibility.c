// Eye visibility of a batch: which eyes of the group see which hits, and with
// what film density. The tests are packets from the eye (estimators.md 8).
#include "reuse/harvest_internal.h"

#include <stdint.h>
#include <string.h>

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
static void note_seen( const float* restrict density, const int32_t* restrict pixel, int eye, int width, RfHitBatch* batch )
{
    uint32_t* restrict seen = batch->seen + ( eye / 32 ) * RF_LANES;
    float* restrict sum = batch->density_sum;
    uint32_t bit = 1u << ( eye % 32 );
    int32_t low = INT32_MAX, high = -1;
#pragma omp simd reduction( min : low ) reduction( max : high )
    for ( int i = 0; i < batch->count; ++i )
    {
        int lands = density[i] > 0.0f;
        int32_t from = lands ? pixel[i] : INT32_MAX, to = lands ? pixel[i] : -1;
        seen[i] |= lands ? bit : 0u;
        sum[i] += density[i];
        low = from < low ? from : low;
        high = to > high ? to : high;
    }
    batch->rows[2 * eye] = low / width;
    batch->rows[2 * eye + 1] = high < 0 ? -1 : high / width;
}

static void see_from_other( const RfHarvest* harvest, int eye, const RfHitBatch* batch, RfHarvestScratch* scratch,
                            float* density, RfRayCounts* rays )
{
    RfLaneScratch* s = &scratch->walk.scratch;
    float offset = rf_ray_offset( rf_tracer_scene( harvest->walk.tracer ) );
    rf_project_batch( harvest->eyes + eye, batch, scratch->landing, density );
    int count = list_candidates( harvest->eyes + eye, batch, offset, density, scratch->candidate, s );
    const float* d[3] = { s->d[0], s->d[1], s->d[2] };
    rf_trace_segments_from( harvest->walk.tracer, harvest->eyes[eye].origin, count, d, s->visible );
    rays->eye += (uint64_t)count;
    for ( int k = 0; k < count; ++k )
        density[scratch->candidate[k]] *= (float)s->visible[k];
}

// Its own eye sees a hit in the pixel it was drawn in, whatever rounding makes
// of its projection.
static void see_from_own( const RfHarvest* harvest, const RfHitBatch* batch, int32_t* pixel, float* density )
{
    rf_own_densities( harvest->eyes + batch->eye, batch, density );
    memcpy( pixel, batch->pixel, (size_t)batch->count * sizeof *pixel );
}

void rf_see_batch( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch, RfRayCounts* rays )
{
    int eyes = harvest->shape.eyes;
    memset( batch->seen, 0, (size_t)rf_seen_words( eyes ) * RF_LANES * sizeof *batch->seen );
    memset( batch->density_sum, 0, (size_t)batch->count * sizeof( float ) );
    for ( int l = 0; l < eyes; ++l )
    {
        float* density = scratch->density + (size_t)l * RF_LANES;
        if ( l == batch->eye )
            see_from_own( harvest, batch, scratch->landing, density );
        else
            see_from_other( harvest, l, batch, scratch, density, rays );
        note_seen( density, scratch->landing, l, harvest->eyes[l].width, batch );
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
