#include "reuse/chain_steps.h"

// Chains longer than this end by Russian roulette, from the same throughput on as paths. Up to there they may have passed panes
// straight, and what an eye sees straight is weighted by the panes' q alone (reuse/visibility.c).
#define NO_ROULETTE_UP_TO RF_MOST_SPLIT

void rf_go_to( const RfVertexLanes* found, RfVertexLanes* at )
{
    int first = rf_record_count( found );
    at->count = found->count - first;
    for ( int kind = 0; kind <= RF_BSDF_KIND_COUNT; ++kind )
    {
        at->first[kind] = kind <= RF_BSDF_FIRST_SPECULAR ? 0 : found->first[kind] - first;
        if ( kind < RF_BSDF_FIRST_SPECULAR || kind == RF_BSDF_KIND_COUNT )
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

// A vertex of chains that scatters.
typedef struct Scattering
{
    const RfPathSettings* path;
    int vertex; // of its chains
    bool roulette;
    const RfVertexLanes* v;
    const RfLaneScratch* s;
} Scattering;

// Whether panes are vertices to the ray that leaves lane i on this side: to those of delta lobes, which no light sample competes
// with, that have room for one within max_depth.
static bool ends_at_panes( const Scattering* at, const RfChains* chains, int i, float side )
{
    int slot = at->v->slot[i], passed = chains->straight[slot] + ( chains->pane[slot] && side < 0.0f );
    return at->s->pdf[i] >= RF_DELTA_PDF && at->vertex + 1 - passed < at->path->max_depth;
}

// Appends the rays that end at panes, or the others.
static void append_rays( const Scattering* at, bool end_at_panes, RfChains* chains, RfRayLanes* rays )
{
    const RfVertexLanes* v = at->v;
    const RfLaneScratch* s = at->s;
    for ( int i = 0; i < v->count; ++i )
    {
        float direction[3] = { s->wi[0][i], s->wi[1][i], s->wi[2][i] };
        float side = rf_leaving_side( v, i, direction );
        RfVec3 t = rf_mul( rf_throughput_of( chains, v->slot[i] ), rf_vec3( s->f[0][i], s->f[1][i], s->f[2][i] ) );
        float survival = at->roulette ? rf_minf( rf_max_component( t ) / RF_ROULETTE_BELOW, 1.0f ) : 1.0f;
        if ( side == 0.0f || !( rf_max_component( t ) > 0.0f ) || s->random[0][i] >= survival ||
             ends_at_panes( at, chains, i, side ) != end_at_panes )
            continue;
        chains->reflected[v->slot[i]] = side > 0.0f;
        write_ray( v, i, s, side, rf_scale( t, 1.0f / survival ), rays, rays->count++ );
    }
}

int rf_scatter_chains( const RfPathSettings* path, int vertex, int followed, const RfVertexLanes* v, RfWavefront* wavefront,
                       RfChains* chains )
{
    RfLaneScratch* s = &wavefront->scratch;
    float* wi[3] = { s->wi[0], s->wi[1], s->wi[2] };
    rf_scatter_lanes( wavefront, v, dimension_of( path, vertex ) + RF_DIMENSION_SCATTER, wi, s );
    rf_draw_lanes( wavefront, v->count, v->slot, dimension_of( path, vertex ) + RF_DIMENSION_ROULETTE, 1, s->random );
    Scattering at = { path, vertex, followed > NO_ROULETTE_UP_TO, v, s };
    wavefront->rays.count = 0;
    append_rays( &at, true, chains, &wavefront->rays );
    int end_at_panes = wavefront->rays.count;
    append_rays( &at, false, chains, &wavefront->rays );
    return end_at_panes;
}
