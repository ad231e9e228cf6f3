// Light at hits that is kept apart, weighted as in a group of one frame and added to the hit's own pixel as a glint: what holds in
// the frame of its path alone, since what moves touches the path in some frame of the group (src/reuse/estimators.md, section 18), or
// caustics, which go to what is taken out of the picture (section 19).
#include "reuse/harvest/passes.h"

#include <string.h>

void rf_note_moving_hits( const RfTracer* tracer, RfHarvestScratch* scratch )
{
    const RfVertexLanes* v = &scratch->first;
    memset( scratch->own->moving, 0, sizeof scratch->own->moving );
    for ( int i = 0; i < rf_record_count( v ) && rf_tracer_has_ghosts( tracer ); ++i )
        scratch->own->moving[v->slot[i]] = rf_is_moving( tracer, scratch->wavefront.scratch.triangle[v->ray[i]] );
}

void rf_add_own_glossy( RfHitBatch* batch, const float* const wi[3], RfHarvestScratch* scratch )
{
    int first = batch->first[RF_BSDF_FIRST_GLOSSY];
    RfLaneScratch* s = &scratch->wavefront.scratch;
    RfOwnHits* own = scratch->own;
    if ( !rf_any_arrives( &own->arrival, first, batch->count ) )
        return;
    const float *wo[3] = { batch->wo[0], batch->wo[1], batch->wo[2] }, *in[3] = { wi[0] + first, wi[1] + first, wi[2] + first };
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    rf_evaluate_glossy( batch, wo, in, f, s->pdf );
    for ( int i = first; i < batch->count; ++i )
    {
        float q[3];
        if ( rf_clamps_own( scratch ) )
        {
            float of_lobes[3] = { f[0][i - first], f[1][i - first], f[2][i - first] };
            rf_add_clamped_own( &own->arrival, i, s->pdf[i - first], of_lobes, batch, scratch );
            continue;
        }
        rf_weigh_arrival( &own->arrival, i, s->pdf[i - first], q );
        for ( int c = 0; c < 3; ++c )
            own->light[c][i] += f[c][i - first] * q[c];
    }
    if ( batch->passes != NULL )
        rf_pass_own( &own->arrival, first, batch->count, s->pdf, f, scratch );
}

// A new glint for a hit, without light.
static int append_glint( const RfPathSettings* path, const RfHarvestScratch* scratch, int hit, RfHitBatch* batch )
{
    int slot = scratch->hits->slot[hit], glint = batch->glint_count++, at = batch->count + batch->miss_count + glint;
    rf_glint_pixel( batch )[glint] = scratch->pixel[slot];
    for ( int base = 0; base < rf_base_parts( path ); ++base )
    {
        RfHitBatch of_part = rf_batch_of_part( batch, base, true );
        memset( of_part.radiance + 4 * (size_t)at, 0, 4 * sizeof( float ) );
        if ( of_part.removed != NULL )
            memset( of_part.removed + 4 * (size_t)at, 0, 4 * sizeof( float ) );
    }
    for ( int k = 0; k < RF_OTHER_PASSES && batch->passes != NULL; ++k )
        memset( rf_other_pass( batch, k, at ), 0, 4 * sizeof( float ) );
    for ( int c = 0; c < 2 && batch->offset[0] != NULL; ++c )
        batch->offset[c][at] = scratch->place[c][slot];
    return glint;
}

// That of a base part; glint_of[] has the glint of each slot, or −1.
static void add_group( const RfHarvest* harvest, int base, int32_t* glint_of, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    float( *light )[RF_LANES] = rf_own_group( scratch, base )->light,
                  ( *taken )[RF_LANES] = rf_own_group( scratch, base )->removed;
    bool caustics = scratch->own->paths.caustics, clamped = rf_clamps_own( scratch );
    if ( rf_has_views( batch ) )
        rf_dim_own( harvest, batch, scratch, light );
    if ( rf_has_views( batch ) && clamped )
        rf_dim_own( harvest, batch, scratch, taken );
    RfHitBatch of_part = rf_batch_of_part( batch, base, true );
    for ( int i = 0; i < batch->count; ++i )
    {
        int32_t* glint = glint_of + scratch->hits->slot[i];
        if ( !( light[0][i] + light[1][i] + light[2][i] > 0.0f ) )
            continue;
        *glint = *glint >= 0 ? *glint : append_glint( &harvest->path, scratch, i, batch );
        size_t at = 4 * (size_t)( batch->count + batch->miss_count + *glint );
        float *picture = of_part.radiance + at, *removed = of_part.removed != NULL ? of_part.removed + at : NULL;
        for ( int c = 0; c < 3; ++c )
        {
            *( caustics ? removed + c : picture + c ) += light[c][i];
            if ( clamped )
                removed[c] += taken[c][i];
        }
        batch->any_removed |= caustics;
    }
}

void rf_add_own_light( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    int32_t glint_of[RF_LANES];
    memset( glint_of, -1, sizeof glint_of );
    for ( int g = 0; g < batch->glint_count; ++g )
        glint_of[scratch->glint_slot[g]] = g;
    for ( int base = 0; base < rf_base_parts( &harvest->path ); ++base )
        add_group( harvest, base, glint_of, batch, scratch );
    if ( batch->passes != NULL && !scratch->own->paths.caustics )
        rf_pass_own_light( harvest, glint_of, batch, scratch );
}

static float sample_luminance( const RfLightLanes* direct, int i )
{
    RfVec3 light = RF_GET3( direct->radiance_cos, i );
    return direct->pdf_solid_angle[i] > 0.0f ? rf_luminance( light ) / direct->pdf_solid_angle[i] : 0.0f;
}

// The light samples that bring light, and as much the scattered ray, if it reached anything.
static float part_of_hit( const RfHarvest* harvest, const RfHarvestScratch* scratch, bool reached, int i )
{
    float own = 0.0f, all = 0.0f, scattered = (float)scratch->own->paths.touched[scratch->hits->slot[i]];
    for ( int j = 0; j < harvest->shape.light_samples; ++j )
    {
        float light = sample_luminance( scratch->direct + j, i );
        all += light;
        own += scratch->direct[j].touched[i] ? light : 0.0f;
    }
    if ( all == 0.0f )
        return scattered;
    return reached ? 0.5f * ( own / all + scattered ) : own / all;
}

void rf_find_own_parts( const RfHarvest* harvest, const uint32_t* triangle, RfHarvestScratch* scratch )
{
    const RfVertexLanes* second = &scratch->wavefront.vertices;
    const RfTracer* tracer = harvest->path.tracer;
    bool reached[RF_LANES];
    rf_touch_by_rays( tracer, &scratch->wavefront.rays, second, triangle, scratch->own->paths.touched );
    memset( reached, rf_has_sky( rf_tracer_lights( tracer ) ), sizeof reached );
    for ( int i = 0; i < second->count; ++i )
        reached[second->slot[i]] = true;
    for ( int i = 0; i < rf_record_count( scratch->hits ); ++i )
        scratch->own->part[i] = part_of_hit( harvest, scratch, reached[scratch->hits->slot[i]], i );
}
