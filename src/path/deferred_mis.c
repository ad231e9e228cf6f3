// Scattering with deferred MIS: the caller weights the rays, since other cameras or
// other paths will reuse them.
#include "base/fault.h"
#include "path/wavefront.h"

// Floor for the roulette weight: other cameras may see a path that is nearly
// invisible to its own.
#define MIN_ROULETTE_SCALE 0.1f

// Writes the ray that leaves vertex lane i to lane `at` of the rays.
static inline void write_ray( const RfVertexLanes* v, int i, float* const wi[3], float side, float pdf, RfRayLanes* rays, int at )
{
    for ( int c = 0; c < 3; ++c )
    {
        rays->o[c][at] = v->p[c][i] + v->ng[c][i] * ( side * v->offset[i] );
        rays->d[c][at] = wi[c][i];
        rays->n[c][at] = v->n[c][i];
    }
    rays->pdf_solid_angle[at] = pdf;
    rays->slot[at] = v->slot[i];
}

// Lanes that become records: the caller applies f and the weight.
static int scatter_nonspecular( const RfVertexLanes* v, float* const wi[3], RfWavefront* wavefront )
{
    RfRayLanes* rays = &wavefront->rays;
    const RfLaneScratch* s = &wavefront->scratch;
    int kept = 0, count = rf_record_count( v );
    for ( int i = 0; i < count; ++i )
    {
        float cos_x = v->n[0][i] * wi[0][i] + v->n[1][i] * wi[1][i] + v->n[2][i] * wi[2][i];
        float cos_g = v->ng[0][i] * wi[0][i] + v->ng[1][i] * wi[1][i] + v->ng[2][i] * wi[2][i];
        float pdf = s->pdf[i];
        for ( int c = 0; c < 3; ++c )
            rays->throughput[c][kept] = 1.0f;
        write_ray( v, i, wi, 1.0f, pdf, rays, kept );
        float weight = pdf > 0.0f ? rf_maxf( s->f[0][i], rf_maxf( s->f[1][i], s->f[2][i] ) ) * cos_x / pdf : 0.0f;
        wavefront->roulette_scale[v->slot[i]] *= rf_maxf( weight, MIN_ROULETTE_SCALE );
        kept += ( cos_x > 0.0f ) & ( cos_g > 0.0f || RF_FAULT( below_triangle ) ) & ( pdf > 0.0f );
    }
    return kept;
}

// Specular lanes: the ray carries the weight.
static int scatter_specular( const RfVertexLanes* v, float* const wi[3], RfWavefront* wavefront, int kept )
{
    RfRayLanes* rays = &wavefront->rays;
    const RfLaneScratch* s = &wavefront->scratch;
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        float direction[3] = { wi[0][i], wi[1][i], wi[2][i] };
        float side = rf_leaving_side( v, i, direction );
        for ( int c = 0; c < 3; ++c )
            rays->throughput[c][kept] = s->f[c][i];
        write_ray( v, i, wi, side, s->pdf[i], rays, kept );
        kept += ( side != 0.0f ) & ( rf_maxf( s->f[0][i], rf_maxf( s->f[1][i], s->f[2][i] ) ) > 0.0f );
    }
    return kept;
}

void rf_scatter_deferred( const RfPathSettings* settings, RfWavefront* wavefront, const RfVertexLanes* v, int vertex,
                          float* const wi[3] )
{
    uint32_t dimension = rf_vertex_dimension( vertex, settings->light_samples ) + RF_DIMENSION_SCATTER;
    rf_scatter_lanes( wavefront, v, dimension, wi, &wavefront->scratch );
    rf_count_deltas( settings, wavefront, v, vertex, wavefront->scratch.pdf );
    rf_note_chain_events( wavefront->chain_light, v, vertex, (const float* const*)wi, wavefront->scratch.pdf );
    wavefront->rays.count = scatter_specular( v, wi, wavefront, scatter_nonspecular( v, wi, wavefront ) );
}
