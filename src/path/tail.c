// The path tracer proper: path tails from the second vertex on.
#include "base/fault.h"
#include "path/wavefront.h"

#include <string.h>

#define ROULETTE_AFTER 3 // vertices

static RfBsdfLanes bsdf_lanes( const RfVertexLanes* v, int first )
{
    RfBsdfLanes lanes = { .n = { v->n[0] + first, v->n[1] + first, v->n[2] + first } };
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
        lanes.param[p] = v->param[p] + first;
    return lanes;
}

void rf_evaluate_seen_from( const RfVertexLanes* v, RfBsdfKind kind, const float* const wo[3], const float* const wi[3],
                            float* const f[3], float* pdf_solid_angle )
{
    int first = v->first[kind], count = v->first[kind + 1] - first;
    if ( count == 0 )
        return;
    RfBsdfLanes lanes = bsdf_lanes( v, first );
    const float* seen_from[3] = { wo[0] + first, wo[1] + first, wo[2] + first };
    const float* in[3] = { wi[0] + first, wi[1] + first, wi[2] + first };
    float* pdf = pdf_solid_angle != NULL ? pdf_solid_angle + first : NULL;
    if ( f == NULL )
    {
        rf_bsdf_evaluate( kind, count, &lanes, seen_from, in, NULL, pdf );
        return;
    }
    float* out[3] = { f[0] + first, f[1] + first, f[2] + first };
    rf_bsdf_evaluate( kind, count, &lanes, seen_from, in, out, pdf );
}

static void evaluate_kinds( const RfVertexLanes* v, int kinds, const float* const wi[3], float* const f[3],
                            float* pdf_solid_angle )
{
    const float* wo[3] = { v->wo[0], v->wo[1], v->wo[2] };
    for ( int kind = 0; kind < kinds; ++kind )
    {
        if ( rf_is_model_built( (RfBsdfKind)kind ) )
            rf_evaluate_seen_from( v, (RfBsdfKind)kind, wo, wi, f, pdf_solid_angle );
    }
}

void rf_evaluate_lanes( const RfVertexLanes* v, const float* const wi[3], float* const f[3], float* pdf_solid_angle )
{
    evaluate_kinds( v, RF_BSDF_KIND_COUNT, wi, f, pdf_solid_angle );
}

// Samples directions for the lanes of non-specular models.
static void sample_nonspecular_lanes( const RfVertexLanes* v, const RfLaneScratch* scratch, float* const wi[3] )
{
    for ( int kind = 0; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
    {
        int first = v->first[kind], count = v->first[kind + 1] - first;
        if ( count == 0 || !rf_is_model_built( (RfBsdfKind)kind ) )
            continue;
        RfBsdfLanes lanes = bsdf_lanes( v, first );
        const float* wo[3] = { v->wo[0] + first, v->wo[1] + first, v->wo[2] + first };
        const float* u[3] = { scratch->random[0] + first, scratch->random[1] + first, scratch->random[2] + first };
        float* out[3] = { wi[0] + first, wi[1] + first, wi[2] + first };
        rf_bsdf_sample( (RfBsdfKind)kind, count, &lanes, wo, u, out );
    }
}

static void sample_specular_lanes( const RfVertexLanes* v, RfLaneScratch* s, float* const wi[3] )
{
    for ( int kind = RF_BSDF_FIRST_SPECULAR; kind < RF_BSDF_KIND_COUNT; ++kind )
    {
        int first = v->first[kind], count = v->first[kind + 1] - first;
        if ( count == 0 || !rf_is_model_built( (RfBsdfKind)kind ) )
            continue;
        RfBsdfLanes lanes = bsdf_lanes( v, first );
        const float* wo[3] = { v->wo[0] + first, v->wo[1] + first, v->wo[2] + first };
        const float* u[3] = { s->random[0] + first, s->random[1] + first, s->random[2] + first };
        float* out[3] = { wi[0] + first, wi[1] + first, wi[2] + first };
        float* weight[3] = { s->f[0] + first, s->f[1] + first, s->f[2] + first };
        rf_bsdf_sample_weighted( (RfBsdfKind)kind, count, &lanes, wo, u, out, weight, s->pdf + first );
    }
}

void rf_scatter_lanes( const RfWavefront* keys, const RfVertexLanes* v, uint32_t dimension, float* const wi[3],
                       RfLaneScratch* scratch )
{
    const float* wi_in[3] = { wi[0], wi[1], wi[2] };
    float* f[3] = { scratch->f[0], scratch->f[1], scratch->f[2] };
    rf_draw_lanes( keys, v->count, v->slot, dimension, 3, scratch->random );
    sample_nonspecular_lanes( v, scratch, wi );
    evaluate_kinds( v, RF_BSDF_FIRST_SPECULAR, wi_in, f, scratch->pdf );
    sample_specular_lanes( v, scratch, wi );
}

static void add_light_samples( const RfPathSettings* settings, RfWavefront* wavefront, const RfRayLanes* rays, int vertex )
{
    const RfVertexLanes* v = &wavefront->vertices;
    RfLightLanes* lights = &wavefront->lights;
    RfLaneScratch* s = &wavefront->scratch;
    float k = (float)settings->light_samples;
    for ( int j = 0; j < rf_light_lanes_count( settings ); ++j )
    {
        uint32_t dimension = rf_vertex_dimension( vertex, settings->light_samples ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)j;
        if ( j < settings->light_samples )
        {
            wavefront->shadow_rays += (uint64_t)rf_sample_lights( settings, wavefront, v, dimension, lights, s );
            rf_note_lit( settings, wavefront, lights, j, v->count );
        }
        else
            settings->connector->sample( settings->connector, wavefront, rays, v, vertex, lights, NULL );
        const float* wi[3] = { lights->wi[0], lights->wi[1], lights->wi[2] };
        float* f[3] = { s->f[0], s->f[1], s->f[2] };
        rf_evaluate_lanes( v, wi, f, s->pdf );
        for ( int i = 0; i < v->count; ++i )
        {
            int slot = v->slot[i], r = v->ray[i];
            float scale = 1.0f / ( k * lights->pdf_solid_angle[i] + s->pdf[i] );
            for ( int c = 0; c < 3; ++c )
                wavefront->arrivals.rest[c][slot] += rays->throughput[c][r] * s->f[c][i] * lights->radiance_cos[c][i] * scale;
        }
    }
}

// Survival probability of the roulette, from the throughput of the path.
static float survival( const RfWavefront* wavefront, int vertex, int slot, const float throughput[3] )
{
    if ( vertex < ROULETTE_AFTER )
        return 1.0f;
    float carried = rf_maxf( throughput[0], rf_maxf( throughput[1], throughput[2] ) ) * wavefront->roulette_scale[slot];
    return rf_minf( carried / RF_ROULETTE_BELOW, 1.0f );
}

// Writes the ray that leaves vertex lane i to lane `at` of next.
static inline void write_ray( const RfVertexLanes* v, int i, const float wi[3], float side, float pdf, RfRayLanes* next, int at )
{
    for ( int c = 0; c < 3; ++c )
    {
        next->o[c][at] = v->p[c][i] + v->ng[c][i] * ( side * v->offset[i] );
        next->d[c][at] = wi[c];
        next->n[c][at] = v->n[c][i];
    }
    next->pdf_solid_angle[at] = pdf;
    next->slot[at] = v->slot[i];
}

// Lanes with a non-specular BSDF.
static int scatter_nonspecular_lanes( RfWavefront* wavefront, const RfRayLanes* rays, int vertex, RfRayLanes* next )
{
    const RfVertexLanes* v = &wavefront->vertices;
    const RfLaneScratch* s = &wavefront->scratch;
    int kept = 0, count = rf_record_count( v );
    for ( int i = 0; i < count; ++i )
    {
        float wi[3] = { s->wi[0][i], s->wi[1][i], s->wi[2][i] };
        float cos_x = v->n[0][i] * wi[0] + v->n[1][i] * wi[1] + v->n[2][i] * wi[2];
        float cos_g = v->ng[0][i] * wi[0] + v->ng[1][i] * wi[1] + v->ng[2][i] * wi[2];
        float pdf = s->pdf[i];
        int r = v->ray[i];
        float scale = pdf > 0.0f ? cos_x / pdf : 0.0f;
        float t[3];
        for ( int c = 0; c < 3; ++c )
            t[c] = rays->throughput[c][r] * s->f[c][i] * scale;
        float q = survival( wavefront, vertex, v->slot[i], t );
        for ( int c = 0; c < 3; ++c )
            next->throughput[c][kept] = q > 0.0f ? t[c] / q : 0.0f;
        write_ray( v, i, wi, 1.0f, pdf, next, kept );
        kept += ( cos_x > 0.0f ) & ( cos_g > 0.0f || RF_FAULT( below_triangle ) ) & ( pdf > 0.0f ) & ( s->random[0][i] < q );
    }
    return kept;
}

// Specular lanes: sampling returned their weight, and they may leave on either side.
static int scatter_specular_lanes( RfWavefront* wavefront, const RfRayLanes* rays, int vertex, RfRayLanes* next, int kept )
{
    const RfVertexLanes* v = &wavefront->vertices;
    const RfLaneScratch* s = &wavefront->scratch;
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        float wi[3] = { s->wi[0][i], s->wi[1][i], s->wi[2][i] };
        float side = rf_leaving_side( v, i, wi );
        int r = v->ray[i];
        float t[3];
        for ( int c = 0; c < 3; ++c )
            t[c] = rays->throughput[c][r] * s->f[c][i];
        float q = survival( wavefront, vertex, v->slot[i], t );
        for ( int c = 0; c < 3; ++c )
            next->throughput[c][kept] = q > 0.0f || RF_FAULT( roulette_0 ) ? t[c] / q : 0.0f;
        write_ray( v, i, wi, side, s->pdf[i], next, kept );
        kept += ( side != 0.0f ) & ( rf_maxf( t[0], rf_maxf( t[1], t[2] ) ) > 0.0f ) & ( s->random[0][i] < q );
    }
    return kept;
}

static void scatter( const RfPathSettings* settings, RfWavefront* wavefront, const RfRayLanes* rays, int vertex,
                     RfRayLanes* next )
{
    const RfVertexLanes* v = &wavefront->vertices;
    RfLaneScratch* s = &wavefront->scratch;
    uint32_t dimension = rf_vertex_dimension( vertex, settings->light_samples );
    float* wi[3] = { s->wi[0], s->wi[1], s->wi[2] };
    rf_scatter_lanes( wavefront, v, dimension + RF_DIMENSION_SCATTER, wi, s );
    rf_count_deltas( settings, wavefront, v, vertex, s->pdf );
    rf_note_chain_events( wavefront->chain_light, v, vertex, (const float* const*)wi, s->pdf );
    rf_draw_lanes( wavefront, v->count, v->slot, dimension + RF_DIMENSION_ROULETTE, 1, s->random );
    next->count =
        scatter_specular_lanes( wavefront, rays, vertex, next, scatter_nonspecular_lanes( wavefront, rays, vertex, next ) );
}

void rf_absorb( const RfVertexLanes* v, RfRayLanes* rays )
{
    for ( int i = v->first[RF_BSDF_GLASS]; rf_is_built( RF_EFFECT_ABSORPTION ) && i < v->first[RF_BSDF_GLASS + 1]; ++i )
    {
        int r = v->ray[i];
        RfVec3 transmittance = rf_transmittance_from( v, i, rf_vec3( rays->o[0][r], rays->o[1][r], rays->o[2][r] ) );
        rays->throughput[0][r] *= transmittance.x;
        rays->throughput[1][r] *= transmittance.y;
        rays->throughput[2][r] *= transmittance.z;
    }
}

const float* rf_find_lit_vertices( const RfPathSettings* settings, RfWavefront* wavefront, RfRayLanes* rays, bool defer_mis,
                                   RfVertexLanes* vertices )
{
    rf_count_path_rays( wavefront, rays );
    const float* pane_probability = rf_find_vertices_past_panes( settings, rays, 0, vertices, &wavefront->scratch );
    rf_absorb( vertices, rays );
    rf_leave_to_connections( settings, wavefront, rays, vertices );
    rf_add_emission_hits( settings, rays, vertices, wavefront->scratch.triangle, pane_probability, defer_mis,
                          wavefront->chain_light, &wavefront->arrivals );
    return pane_probability;
}

void rf_end_spent_paths( const RfPathSettings* settings, const RfWavefront* wavefront, int vertex, RfRayLanes* rays )
{
    if ( wavefront->spent == NULL )
        return;
    for ( int r = 0; r < rays->count; ++r )
    {
        if ( wavefront->spent[rays->slot[r]] + vertex < settings->max_depth )
            continue;
        for ( int c = 0; c < 3; ++c )
            rays->throughput[c][r] = 0.0f;
    }
}

void rf_trace_tails( const RfPathSettings* settings, RfWavefront* wavefront, int first_vertex )
{
    RfRayLanes* rays = &wavefront->rays;
    RfRayLanes* next = &wavefront->next;
    int most = settings->max_depth + ( wavefront->spent != NULL && rf_tracer_has_panes( settings->tracer ) );
    for ( int vertex = first_vertex; vertex <= most && rays->count > 0; ++vertex )
    {
        rf_find_lit_vertices( settings, wavefront, rays, vertex == first_vertex, &wavefront->vertices );
        if ( vertex == most )
            break;
        rf_end_spent_paths( settings, wavefront, vertex, rays );
        add_light_samples( settings, wavefront, rays, vertex );
        scatter( settings, wavefront, rays, vertex, next );
        RfRayLanes* swap = rays;
        rays = next;
        next = swap;
    }
}
