// The tails of paths: from the second vertex on.
#include "path/walk.h"

#include <string.h>

#define ROULETTE_AFTER 3 // vertices

static RfBsdfLanes bsdf_lanes( const RfVertexLanes* v, int first )
{
    return ( RfBsdfLanes ){
        .n = { v->n[0] + first, v->n[1] + first, v->n[2] + first },
        .diffuse = { v->diffuse[0] + first, v->diffuse[1] + first, v->diffuse[2] + first },
        .specular = { v->specular[0] + first, v->specular[1] + first, v->specular[2] + first },
        .shape = v->shape + first,
        .f90 = v->f90 + first,
        .coat_f0 = v->coat_f0 + first,
        .coat_f90 = v->coat_f90 + first,
    };
}

void rf_evaluate_lanes( const RfVertexLanes* v, const float* const wi[3], float* const f[3], float* pdf_solid_angle )
{
    for ( int kind = 0; kind < RF_BSDF_KIND_COUNT; ++kind )
    {
        int first = v->first[kind], count = v->first[kind + 1] - first;
        if ( count == 0 )
            continue;
        RfBsdfLanes lanes = bsdf_lanes( v, first );
        const float* wo[3] = { v->wo[0] + first, v->wo[1] + first, v->wo[2] + first };
        const float* in[3] = { wi[0] + first, wi[1] + first, wi[2] + first };
        float* out[3] = { f[0] + first, f[1] + first, f[2] + first };
        rf_bsdf_evaluate( (RfBsdfKind)kind, count, &lanes, wo, in, out, pdf_solid_angle + first );
    }
}

void rf_scatter_lanes( const RfWalk* keys, const RfVertexLanes* v, uint32_t dimension, float* const wi[3],
                       RfLaneScratch* scratch )
{
    rf_draw_lanes( keys, v->count, v->slot, dimension, 3, scratch->random );
    for ( int kind = 0; kind < RF_BSDF_KIND_COUNT; ++kind )
    {
        int first = v->first[kind], count = v->first[kind + 1] - first;
        if ( count == 0 )
            continue;
        RfBsdfLanes lanes = bsdf_lanes( v, first );
        const float* wo[3] = { v->wo[0] + first, v->wo[1] + first, v->wo[2] + first };
        const float* u[3] = { scratch->random[0] + first, scratch->random[1] + first, scratch->random[2] + first };
        float* out[3] = { wi[0] + first, wi[1] + first, wi[2] + first };
        rf_bsdf_sample( (RfBsdfKind)kind, count, &lanes, wo, u, out );
    }
}

// Light emitted by the vertices towards the rays that found them. At the
// second vertex it is kept apart; later the balance heuristic weighs it here.
static void add_emission( const RfWalkSettings* settings, const RfRayLanes* rays, const RfVertexLanes* v, int vertex,
                          RfArrivals* arrivals )
{
    for ( int i = 0; i < v->count; ++i )
    {
        if ( v->light_pdf_solid_angle[i] == 0.0f )
            continue;
        int slot = v->slot[i], r = v->ray[i];
        if ( vertex == 2 )
        {
            for ( int c = 0; c < 3; ++c )
                arrivals->emitted[c][slot] = v->emission[c][i];
            arrivals->light_pdf_solid_angle[slot] = v->light_pdf_solid_angle[i];
            continue;
        }
        float pdf = rays->pdf_solid_angle[r];
        float weight = pdf / ( pdf + (float)settings->light_samples * v->light_pdf_solid_angle[i] );
        for ( int c = 0; c < 3; ++c )
            arrivals->rest[c][slot] += rays->throughput[c][r] * v->emission[c][i] * weight;
    }
}

static void add_light_samples( const RfWalkSettings* settings, RfWalk* walk, const RfRayLanes* rays, int vertex )
{
    const RfVertexLanes* v = &walk->vertices;
    RfLightLanes* lights = &walk->lights;
    RfLaneScratch* s = &walk->scratch;
    float k = (float)settings->light_samples;
    for ( int j = 0; j < settings->light_samples; ++j )
    {
        uint32_t dimension = rf_vertex_dimension( vertex, settings->light_samples ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)j;
        walk->shadow_rays += (uint64_t)rf_sample_lights( settings, walk, v, dimension, lights, s );
        const float* wi[3] = { lights->wi[0], lights->wi[1], lights->wi[2] };
        float* f[3] = { s->f[0], s->f[1], s->f[2] };
        rf_evaluate_lanes( v, wi, f, s->pdf );
        for ( int i = 0; i < v->count; ++i )
        {
            int slot = v->slot[i], r = v->ray[i];
            float scale = 1.0f / ( k * lights->pdf_solid_angle[i] + s->pdf[i] );
            for ( int c = 0; c < 3; ++c )
                walk->arrivals.rest[c][slot] += rays->throughput[c][r] * s->f[c][i] * lights->radiance_cos[c][i] * scale;
        }
    }
}

// Survival probability of the roulette: what the path still carries.
static float survival( const RfWalk* walk, int vertex, int slot, const float throughput[3] )
{
    if ( vertex < ROULETTE_AFTER )
        return 1.0f;
    float carried = rf_maxf( throughput[0], rf_maxf( throughput[1], throughput[2] ) ) * walk->roulette_scale[slot];
    return rf_minf( carried, 1.0f );
}

static void scatter( const RfWalkSettings* settings, RfWalk* walk, const RfRayLanes* rays, int vertex, RfRayLanes* next )
{
    const RfVertexLanes* v = &walk->vertices;
    RfLaneScratch* s = &walk->scratch;
    uint32_t dimension = rf_vertex_dimension( vertex, settings->light_samples );
    float* wi[3] = { s->wi[0], s->wi[1], s->wi[2] };
    const float* wi_in[3] = { s->wi[0], s->wi[1], s->wi[2] };
    float* f[3] = { s->f[0], s->f[1], s->f[2] };
    rf_scatter_lanes( walk, v, dimension + RF_DIMENSION_SCATTER, wi, s );
    rf_evaluate_lanes( v, wi_in, f, s->pdf );
    rf_draw_lanes( walk, v->count, v->slot, dimension + RF_DIMENSION_ROULETTE, 1, s->random );
    int kept = 0;
    for ( int i = 0; i < v->count; ++i )
    {
        float x = s->wi[0][i], y = s->wi[1][i], z = s->wi[2][i];
        float cos_x = v->n[0][i] * x + v->n[1][i] * y + v->n[2][i] * z;
        float cos_g = v->ng[0][i] * x + v->ng[1][i] * y + v->ng[2][i] * z;
        float pdf = s->pdf[i];
        int r = v->ray[i];
        float scale = cos_x / pdf;
        float t[3];
        for ( int c = 0; c < 3; ++c )
            t[c] = rays->throughput[c][r] * s->f[c][i] * scale;
        float q = survival( walk, vertex, v->slot[i], t );
        for ( int c = 0; c < 3; ++c )
        {
            next->throughput[c][kept] = t[c] / q;
            next->o[c][kept] = v->p[c][i] + v->ng[c][i] * v->offset[i];
            next->d[c][kept] = s->wi[c][i];
        }
        next->pdf_solid_angle[kept] = pdf;
        next->slot[kept] = v->slot[i];
        kept += ( cos_x > 0.0f ) & ( cos_g > 0.0f ) & ( pdf > 0.0f ) & ( s->random[0][i] < q );
    }
    next->count = kept;
}

void rf_trace_tails( const RfWalkSettings* settings, RfWalk* walk )
{
    RfRayLanes* rays = &walk->rays;
    RfRayLanes* next = &walk->next;
    for ( int vertex = 2; vertex <= settings->max_depth && rays->count > 0; ++vertex )
    {
        walk->path_rays += (uint64_t)rays->count;
        rf_find_vertices( settings, rays, false, &walk->vertices, &walk->scratch );
        add_emission( settings, rays, &walk->vertices, vertex, &walk->arrivals );
        if ( vertex == settings->max_depth )
            break;
        add_light_samples( settings, walk, rays, vertex );
        scatter( settings, walk, rays, vertex, next );
        RfRayLanes* swap = rays;
        rays = next;
        next = swap;
    }
}
