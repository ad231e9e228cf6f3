// Scattering whose weights are left to the caller: other eyes, or other paths,
// will share the rays.
#include "path/wavefront.h"

// What the roulette takes a path for whose own eye sees next to nothing of it:
// other eyes may see more.
#define MIN_ROULETTE_SCALE 0.1f

// The ray that leaves lane i of the vertices, at place `at` of the rays.
static inline void leave( const RfVertexLanes* v, int i, float* const wi[3], float side, float pdf, RfRayLanes* rays, int at )
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

// Lanes that records are made of.
static int scatter_records( const RfVertexLanes* v, float* const wi[3], RfWavefront* walk )
{
    RfRayLanes* rays = &walk->rays;
    const RfLaneScratch* s = &walk->scratch;
    int kept = 0, count = rf_record_count( v );
    for ( int i = 0; i < count; ++i )
    {
        float cos_x = v->n[0][i] * wi[0][i] + v->n[1][i] * wi[1][i] + v->n[2][i] * wi[2][i];
        float cos_g = v->ng[0][i] * wi[0][i] + v->ng[1][i] * wi[1][i] + v->ng[2][i] * wi[2][i];
        float pdf = s->pdf[i];
        for ( int c = 0; c < 3; ++c )
            rays->throughput[c][kept] = 1.0f;
        leave( v, i, wi, 1.0f, pdf, rays, kept );
        float weight = rf_maxf( s->f[0][i], rf_maxf( s->f[1][i], s->f[2][i] ) ) * cos_x / pdf;
        walk->roulette_scale[v->slot[i]] *= rf_maxf( weight, MIN_ROULETTE_SCALE );
        kept += ( cos_x > 0.0f ) & ( cos_g > 0.0f ) & ( pdf > 0.0f );
    }
    return kept;
}

// Native lanes: the weight goes along.
static int scatter_natives( const RfVertexLanes* v, float* const wi[3], RfWavefront* walk, int kept )
{
    RfRayLanes* rays = &walk->rays;
    const RfLaneScratch* s = &walk->scratch;
    for ( int i = rf_record_count( v ); i < v->count; ++i )
    {
        float direction[3] = { wi[0][i], wi[1][i], wi[2][i] };
        float side = rf_leaving_side( v, i, direction );
        for ( int c = 0; c < 3; ++c )
            rays->throughput[c][kept] = s->f[c][i];
        leave( v, i, wi, side, s->pdf[i], rays, kept );
        kept += ( side != 0.0f ) & ( rf_maxf( s->f[0][i], rf_maxf( s->f[1][i], s->f[2][i] ) ) > 0.0f );
    }
    return kept;
}

void rf_scatter_deferred( const RfPathSettings* settings, RfWavefront* walk, const RfVertexLanes* v, int vertex,
                          float* const wi[3] )
{
    uint32_t dimension = rf_vertex_dimension( vertex, settings->light_samples ) + RF_DIMENSION_SCATTER;
    rf_scatter_lanes( walk, v, dimension, wi, &walk->scratch );
    walk->rays.count = scatter_natives( v, wi, walk, scatter_records( v, wi, walk ) );
}
