// Light at hits that is kept apart, weighted as in a group of one frame and added to the hit's own pixel as a glint: what holds in
// the frame of its path alone, since what moves touches the path in some frame of the group (src/reuse/estimators.md, section 18), or
// caustics, which go to what is taken out of the picture (section 19).
#include "reuse/harvest/harvest_steps.h"

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
}

// Multiplies the light by the filters of the ways to the camera, as accumulation does for what is shared, and by the throughput
// of chains.
static void dim( const RfHarvest* harvest, const RfHitBatch* batch, const RfHarvestScratch* scratch, float ( *light )[RF_LANES] )
{
    RF_ALIGN float filter[3][RF_LANES], density[RF_LANES];
    RfProjectedLanes out = { .density = density, .filter = { filter[0], filter[1], filter[2] } };
    rf_own_densities( rf_tracer_mirrors( harvest->path.tracer ), harvest->eyes + batch->eye, batch, out );
    for ( int c = 0; c < 3; ++c )
    {
        const float* kappa = batch->panes[c] != NULL ? batch->panes[c] + (size_t)batch->eye * RF_LANES : NULL;
        for ( int i = 0; i < batch->count; ++i )
        {
            bool chain = batch->view[i] == RF_VIEW_CHAIN;
            float left = chain ? scratch->chains->throughput[c][scratch->hits->slot[i]] : filter[c][i];
            light[c][i] *= left * ( kappa != NULL ? kappa[i] : 1.0f );
        }
    }
}

// A new glint for a hit, without light.
static int append_glint( const RfHarvestScratch* scratch, int hit, RfHitBatch* batch )
{
    int slot = scratch->hits->slot[hit], glint = batch->glint_count++, at = batch->count + batch->miss_count + glint;
    rf_glint_pixel( batch )[glint] = scratch->pixel[slot];
    memset( rf_glint_radiance( batch ) + 4 * (size_t)glint, 0, 4 * sizeof( float ) );
    if ( batch->removed != NULL )
        memset( batch->removed + 4 * (size_t)at, 0, 4 * sizeof( float ) );
    for ( int c = 0; c < 2 && batch->offset[0] != NULL; ++c )
        batch->offset[c][at] = scratch->place[c][slot];
    return glint;
}

void rf_add_own_light( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch )
{
    float( *light )[RF_LANES] = scratch->own->light;
    bool caustics = scratch->own->paths.caustics, clamped = rf_clamps_own( scratch );
    int32_t glint_of[RF_LANES];
    if ( rf_has_views( batch ) )
        dim( harvest, batch, scratch, light );
    if ( rf_has_views( batch ) && rf_clamps_own( scratch ) )
        dim( harvest, batch, scratch, scratch->clamp->own );
    memset( glint_of, -1, sizeof glint_of );
    for ( int g = 0; g < batch->glint_count; ++g )
        glint_of[scratch->glint_slot[g]] = g;
    for ( int i = 0; i < batch->count; ++i )
    {
        if ( !( light[0][i] + light[1][i] + light[2][i] > 0.0f ) )
            continue;
        int glint = glint_of[scratch->hits->slot[i]];
        glint = glint >= 0 ? glint : append_glint( scratch, i, batch );
        float* picture = rf_glint_radiance( batch ) + 4 * (size_t)glint;
        size_t at = 4 * (size_t)( batch->count + batch->miss_count + glint );
        float* removed = batch->removed != NULL ? batch->removed + at : NULL;
        for ( int c = 0; c < 3; ++c )
        {
            *( caustics ? removed + c : picture + c ) += light[c][i];
            if ( clamped )
                removed[c] += scratch->clamp->own[c][i];
        }
        batch->any_removed |= caustics;
    }
}

static float sample_luminance( const RfLightLanes* direct, int i )
{
    RfVec3 light = rf_vec3( direct->radiance_cos[0][i], direct->radiance_cos[1][i], direct->radiance_cos[2][i] );
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
