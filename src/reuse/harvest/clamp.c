// The clamp on the light of hit records: what paths bring from one direction is split into what is kept and what is taken out.
#include "reuse/harvest/harvest_steps.h"

#include <string.h>

void rf_begin_removed( const RfHarvest* harvest, RfHitBatch* batch )
{
    batch->any_removed = false;
    size_t listed = (size_t)( batch->count + batch->miss_count + batch->glint_count );
    memset( batch->removed, 0, 4 * listed * sizeof( float ) );
    for ( int d = 0; batch->removed_directions != NULL && d < rf_direction_count( &harvest->shape ); ++d )
        batch->removed_directions[d].dark = true;
}

void rf_begin_clamp( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    RfClampHits* clamp = scratch->clamp;
    for ( int kind = 0; kind < RF_CLAMP_KINDS; ++kind )
        clamp->threshold[kind] = harvest->clamps != NULL ? harvest->clamps[batch->eye].threshold[kind] : INFINITY;
    clamp->watch = harvest->clamp_watch;
    bool chains = rf_follows_chains( scratch );
    for ( int i = 0; i < batch->count; ++i )
    {
        int slot = scratch->hits->slot[i];
        clamp->dimmed[i] = 1.0f;
        if ( chains && batch->view[i] == RF_VIEW_CHAIN )
            clamp->dimmed[i] = rf_luminance( RF_GET3( scratch->chains->throughput, slot ) );
    }
    for ( int c = 0; c < 3 * rf_base_parts( &harvest->path ) && scratch->own != NULL; ++c )
        memset( rf_own_group( scratch, c / 3 )->removed[c % 3], 0, (size_t)batch->count * sizeof( float ) );
    if ( scratch->own != NULL )
        rf_set_own_group( scratch, 0 );
}

// Light from one direction, times f: the part that is clamped and the part that is not.
typedef struct Parts
{
    float direct[3], indirect[3];
} Parts;

static Parts weigh_parts( const RfArrivalLanes* arrival, bool all_indirect, int i, float pdf, const float f[3] )
{
    Parts parts;
    float scale_a, scale_b;
    rf_arrival_scales( arrival, i, pdf, &scale_a, &scale_b );
    for ( int c = 0; c < 3; ++c )
    {
        float a = f[c] * ( arrival->a[c][i] * scale_a );
        parts.direct[c] = all_indirect ? 0.0f : a;
        parts.indirect[c] = f[c] * ( arrival->b[c][i] * scale_b ) + ( all_indirect ? a : 0.0f );
    }
    return parts;
}

void rf_add_clamped_diffuse( const RfArrivalLanes* arrival, bool all_indirect, const float* pdf, float* const f[3],
                             RfHitBatch* batch, RfHarvestScratch* scratch )
{
    for ( int i = 0; i < batch->first[RF_BSDF_FIRST_GLOSSY]; ++i )
    {
        Parts parts = weigh_parts( arrival, all_indirect, i, pdf[i], ( float[3] ){ f[0][i], f[1][i], f[2][i] } );
        for ( int c = 0; c < 3; ++c )
            batch->radiance[4 * i + c] += parts.direct[c];
        batch->any_removed |= rf_add_clamped( scratch->clamp, RF_CLAMP_PATHS, batch, i, parts.indirect, batch->radiance + 4 * i,
                                              batch->removed + 4 * (size_t)i );
    }
}

void rf_add_clamped_light( float ( *const light )[RF_LANES], const float* const factor[3], int count, RfHitBatch* batch,
                           RfHarvestScratch* scratch )
{
    for ( int i = 0; i < count; ++i )
    {
        float value[3] = { factor[0][i] * light[0][i], factor[1][i] * light[1][i], factor[2][i] * light[2][i] };
        if ( value[0] + value[1] + value[2] > 0.0f )
            batch->any_removed |= rf_add_clamped( scratch->clamp, RF_CLAMP_PATHS, batch, i, value, batch->radiance + 4 * i,
                                                  batch->removed + 4 * (size_t)i );
    }
}

void rf_clamp_seen_emission( RfHitBatch* batch, RfHarvestScratch* scratch )
{
    for ( int i = 0; i < batch->count; ++i )
    {
        float* radiance = batch->radiance + 4 * (size_t)i;
        float value[3] = { radiance[0], radiance[1], radiance[2] };
        if ( batch->view[i] != RF_VIEW_CHAIN || !( value[0] + value[1] + value[2] > 0.0f ) )
            continue;
        memset( radiance, 0, sizeof value );
        batch->any_removed |=
            rf_add_clamped( scratch->clamp, RF_CLAMP_CHAINS, batch, i, value, radiance, batch->removed + 4 * (size_t)i );
    }
}

// To the light that holds in a hit's own frame alone.
static void add_own( const float value[3], int i, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    float share = rf_clamp_share( scratch->clamp, RF_CLAMP_PATHS, batch, i, value );
    for ( int c = 0; c < 3; ++c )
    {
        float kept = share * value[c];
        scratch->own->light[c][i] += kept;
        scratch->clamp->own[c][i] += value[c] - kept;
    }
    batch->any_removed |= share < 1.0f;
}

void rf_add_clamped_own( const RfArrivalLanes* arrival, int i, float pdf, const float f[3], RfHitBatch* batch,
                         RfHarvestScratch* scratch )
{
    Parts parts = weigh_parts( arrival, false, i, pdf, f );
    for ( int c = 0; c < 3; ++c )
        scratch->own->light[c][i] += parts.direct[c];
    add_own( parts.indirect, i, batch, scratch );
}

void rf_add_clamped_own_light( float ( *const light )[RF_LANES], const float* const factor[3], int count, RfHitBatch* batch,
                               RfHarvestScratch* scratch )
{
    for ( int i = 0; i < count; ++i )
    {
        float value[3] = { factor[0][i] * light[0][i], factor[1][i] * light[1][i], factor[2][i] * light[2][i] };
        if ( value[0] + value[1] + value[2] > 0.0f )
            add_own( value, i, batch, scratch );
    }
}

static bool any_indirect( const RfArrivalLanes* arrival, bool all_indirect, int first, int end )
{
    for ( int i = first; i < end; ++i )
    {
        float sum = arrival->b[0][i] + arrival->b[1][i] + arrival->b[2][i];
        if ( sum + ( all_indirect ? arrival->a[0][i] + arrival->a[1][i] + arrival->a[2][i] : 0.0f ) > 0.0f )
            return true;
    }
    return false;
}

void rf_clamp_direction( int direction, const RfArrivalLanes* arrival, bool all_indirect, const float* mixture, RfHitBatch* batch,
                         RfHarvestScratch* scratch )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY], count = batch->count - first;
    if ( !any_indirect( arrival, all_indirect, first, batch->count ) )
        return;
    const RfDirectionLanes *kept = batch->directions + direction, *removed = batch->removed_directions + direction;
    RfLaneScratch* s = &scratch->wavefront.scratch;
    const float *wo[3] = { batch->wo[0], batch->wo[1], batch->wo[2] }, *wi[3] = { kept->wi[0], kept->wi[1], kept->wi[2] };
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    rf_evaluate_glossy( batch, wo, wi, f, s->pdf );
    bool any = false;
    for ( int i = 0; i < count; ++i )
    {
        const float one[3] = { 1.0f, 1.0f, 1.0f };
        Parts q = weigh_parts( arrival, all_indirect, first + i, mixture[i], one );
        // as the hit's own camera alone would have drawn it
        Parts value = weigh_parts( arrival, all_indirect, first + i, s->pdf[i], ( float[3] ){ f[0][i], f[1][i], f[2][i] } );
        float share = rf_clamp_share( scratch->clamp, RF_CLAMP_PATHS, batch, first + i, value.indirect );
        for ( int c = 0; c < 3; ++c )
        {
            float left = share * q.indirect[c];
            kept->q[c][i] = q.direct[c] + left;
            removed->q[c][i] = q.indirect[c] - left;
        }
        any |= share < 1.0f;
    }
    batch->removed_directions[direction].dark = !any;
    batch->any_removed |= any;
}
