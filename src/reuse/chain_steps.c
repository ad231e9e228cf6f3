#include "reuse/chain_steps.h"

// Chains this long end by Russian roulette, from the same throughput on as paths.
#define ROULETTE_AFTER 4

void rf_go_to( const RfVertexLanes* found, RfVertexLanes* at )
{
    int first = rf_record_count( found );
    at->count = found->count - first;
    for ( int kind = 0; kind <= RF_BSDF_KIND_COUNT; ++kind )
    {
        at->first[kind] = kind <= RF_BSDF_FIRST_UNEVALUABLE ? 0 : found->first[kind] - first;
        if ( kind < RF_BSDF_FIRST_UNEVALUABLE || kind == RF_BSDF_KIND_COUNT )
            continue;
        int begin = found->first[kind], count = found->first[kind + 1] - begin;
        rf_copy_vertices( found, begin, count, rf_bsdf_model( (RfBsdfKind)kind )->params, at, begin - first );
    }
}

static uint32_t dimension_of( const RfPathSettings* path, int vertex )
{
    return RF_DIMENSION_CHAINS + rf_vertex_dimension( vertex, path->light_samples );
}

// True if light sampling can find light at a vertex: some of its lobes are no deltas.
static bool is_lit( const RfVertexLanes* v, int i )
{
    float base = v->param[RF_PARAM_DIFFUSE][i] + v->param[RF_PARAM_DIFFUSE + 1][i] + v->param[RF_PARAM_DIFFUSE + 2][i];
    return v->param[RF_PARAM_SHAPE][i] > 0.0f || base > 0.0f;
}

static bool any_is_lit( const RfVertexLanes* v )
{
    for ( int i = 0; i < v->count; ++i )
    {
        if ( is_lit( v, i ) )
            return true;
    }
    return false;
}

void rf_light_chains( const RfPathSettings* path, int vertex, const RfVertexLanes* v, RfWavefront* wavefront,
                      const RfChains* chains )
{
    RfLightLanes* lights = &wavefront->lights;
    RfLaneScratch* s = &wavefront->scratch;
    float k = (float)path->light_samples, *f[3] = { s->f[0], s->f[1], s->f[2] };
    if ( !any_is_lit( v ) )
        return;
    for ( int j = 0; j < path->light_samples; ++j )
    {
        uint32_t dimension = dimension_of( path, vertex ) + RF_DIMENSION_LIGHTS + 3u * (uint32_t)j;
        wavefront->shadow_rays += (uint64_t)rf_sample_lights( path, wavefront, v, dimension, lights, s );
        const float* wi[3] = { lights->wi[0], lights->wi[1], lights->wi[2] };
        rf_evaluate_lanes( v, wi, f, s->pdf );
        for ( int i = 0; i < v->count; ++i )
        {
            int slot = v->slot[i];
            float scale = 1.0f / ( k * lights->pdf_solid_angle[i] + s->pdf[i] );
            for ( int c = 0; c < 3; ++c )
                wavefront->arrivals.rest[c][slot] +=
                    chains->throughput[c][slot] * s->f[c][i] * lights->radiance_cos[c][i] * scale;
        }
    }
}

// Writes the ray that leaves lane i to lane `to` of the rays.
static void write_ray( const RfVertexLanes* v, int i, const RfLaneScratch* s, float side, RfVec3 t, RfRayLanes* rays, int to )
{
    for ( int c = 0; c < 3; ++c )
    {
        rays->o[c][to] = v->p[c][i] + v->ng[c][i] * ( side * v->offset[i] );
        rays->d[c][to] = s->wi[c][i];
        rays->n[c][to] = v->n[c][i];
    }
    rays->throughput[0][to] = t.x;
    rays->throughput[1][to] = t.y;
    rays->throughput[2][to] = t.z;
    rays->pdf_solid_angle[to] = s->pdf[i];
    rays->slot[to] = v->slot[i];
}

void rf_scatter_chains( const RfPathSettings* path, int vertex, const RfVertexLanes* v, RfWavefront* wavefront, RfChains* chains )
{
    RfRayLanes* rays = &wavefront->rays;
    RfLaneScratch* s = &wavefront->scratch;
    float* wi[3] = { s->wi[0], s->wi[1], s->wi[2] };
    rf_scatter_lanes( wavefront, v, dimension_of( path, vertex ) + RF_DIMENSION_SCATTER, wi, s );
    rf_draw_lanes( wavefront, v->count, v->slot, dimension_of( path, vertex ) + RF_DIMENSION_ROULETTE, 1, s->random );
    int kept = 0;
    for ( int i = 0; i < v->count; ++i )
    {
        float direction[3] = { s->wi[0][i], s->wi[1][i], s->wi[2][i] };
        float side = rf_leaving_side( v, i, direction );
        RfVec3 t = rf_mul( rf_throughput_of( chains, v->slot[i] ), rf_vec3( s->f[0][i], s->f[1][i], s->f[2][i] ) );
        float survival = vertex < ROULETTE_AFTER ? 1.0f : rf_minf( rf_max_component( t ) / RF_ROULETTE_BELOW, 1.0f );
        if ( side == 0.0f || !( rf_max_component( t ) > 0.0f ) || s->random[0][i] >= survival )
            continue;
        chains->reflected[v->slot[i]] = side > 0.0f;
        write_ray( v, i, s, side, rf_scale( t, 1.0f / survival ), rays, kept++ );
    }
    rays->count = kept;
}
