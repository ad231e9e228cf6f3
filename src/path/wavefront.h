// The path tracer: one walk, by wavefronts. A caller finds first vertices,
// samples lights and scatters there as it likes, and hands the scattered rays
// to rf_trace_tails, which brings back the radiance that arrives along them.
#ifndef REFRAME_PATH_WAVEFRONT_H
#define REFRAME_PATH_WAVEFRONT_H

#include "path/lanes.h"

// What all paths of a render share.
typedef struct RfPathSettings
{
    const RfTracer* tracer;
    int max_depth;     // path vertices after the eye, ≥ 1
    int light_samples; // K ≥ 1 per vertex
    RfLightSampling light_sampling;
} RfPathSettings;

// What arrives along the ray of each path slot. The light emitted by what the
// ray finds is apart, since light sampling at the ray's origin could have found
// it too (estimators.md E3).
typedef struct RfArrivals
{
    RF_ALIGN float emitted[3][RF_LANES];
    float light_pdf_solid_angle[RF_LANES]; // of that vertex, by light sampling at the origin
    float rest[3][RF_LANES];               // all longer paths
} RfArrivals;

// A thread's wavefront.
typedef struct RfWavefront
{
    // in, by slot
    RF_ALIGN uint32_t key_a[RF_LANES];
    uint32_t key_b[RF_LANES];
    float roulette_scale[RF_LANES]; // largest channel of the path's weight before its throughput begins
    RfRayLanes rays;                // in: the scattered rays; used up
    // out, by slot
    RfArrivals arrivals;
    uint64_t path_rays, shadow_rays; // counted up
    // inside
    RfRayLanes next;
    RfVertexLanes vertices;
    RfLightLanes lights;
    RfLaneScratch scratch;
} RfWavefront;

// Traces the rays and fills the vertices they find, sorted by scattering
// model, in the rays' order within a model. Rays that miss leave no vertex.
// `coherent` is a hint for the traversal.
void rf_find_vertices( const RfPathSettings* settings, const RfRayLanes* rays, bool coherent, RfVertexLanes* vertices,
                       RfLaneScratch* scratch );

// `numbers` uniform random numbers per lane, from `dimension` on.
void rf_draw_lanes( const RfWavefront* keys, int count, const int32_t* slot, uint32_t dimension, int numbers,
                    float random[][RF_LANES] );

// One light sample for every vertex lane, with its visibility tested. Random
// numbers: `dimension` and the two after it. Returns the shadow rays traced.
int rf_sample_lights( const RfPathSettings* settings, const RfWavefront* keys, const RfVertexLanes* vertices, uint32_t dimension,
                      RfLightLanes* lights, RfLaneScratch* scratch );

// f and density for all lanes of the vertices, model by model (see bsdf.h).
void rf_evaluate_lanes( const RfVertexLanes* vertices, const float* const wi[3], float* const f[3], float* pdf_solid_angle );

// The same for the lanes of one model, seen from wo; lane i of all arrays is
// lane i of the vertices. Either output may be NULL.
void rf_evaluate_seen_from( const RfVertexLanes* vertices, RfBsdfKind kind, const float* const wo[3], const float* const wi[3],
                            float* const f[3], float* pdf_solid_angle );

// Scatters all lanes of the vertices: wi from three random numbers each, and
// into scratch f and density of it; of native lanes the weight f |cos| / density.
void rf_scatter_lanes( const RfWavefront* keys, const RfVertexLanes* vertices, uint32_t dimension, float* const wi[3],
                       RfLaneScratch* scratch );

// Adds the light that rays find at their ends, of surfaces (the vertices, with
// the triangles in scratch) and of the sky, to the arrivals: `apart` as emitted,
// or weighed by the balance heuristic.
void rf_add_emission_hits( const RfPathSettings* settings, const RfRayLanes* rays, const RfVertexLanes* vertices,
                           const uint32_t* triangle, bool apart, RfArrivals* arrivals );

// On which side of the surface wi leaves a native lane: 1 on the eye's, −1
// beyond, 0 where normal and face disagree about it and nothing leaves.
static inline float rf_leaving_side( const RfVertexLanes* v, int i, const float wi[3] )
{
    float cos_x = v->n[0][i] * wi[0] + v->n[1][i] * wi[1] + v->n[2][i] * wi[2];
    float cos_g = v->ng[0][i] * wi[0] + v->ng[1][i] * wi[1] + v->ng[2][i] * wi[2];
    if ( cos_x * cos_g <= 0.0f )
        return 0.0f;
    return cos_g > 0.0f ? 1.0f : -1.0f;
}

// Part of the light that is left after a way through an absorbing inside.
static inline RfVec3 rf_transmittance( RfVec3 absorption, float distance )
{
    return rf_vec3( expf( -absorption.x * distance ), expf( -absorption.y * distance ), expf( -absorption.z * distance ) );
}

// The part of the light that the inside of its body leaves of what goes from a
// glass lane to `o`, where its ray began (Beer, Lambert); 1 from the outside.
static inline RfVec3 rf_left_of_way( const RfVertexLanes* v, int i, RfVec3 o )
{
    RfVec3 absorption = rf_vec3( v->absorption[0][i], v->absorption[1][i], v->absorption[2][i] );
    if ( rf_max_component( absorption ) == 0.0f )
        return rf_vec3( 1, 1, 1 );
    return rf_transmittance( absorption, rf_length( rf_sub( rf_vec3( v->p[0][i], v->p[1][i], v->p[2][i] ), o ) ) );
}

// Scatters all lanes of the vertices, the path's `vertex`-th, with the weights
// left to the caller: rays of the directions that can carry light into
// walk->rays, whose throughput is 1 where records are made and the weight
// f |cos| / density from native lanes; walk->roulette_scale takes what is left
// out. Directions into wi, their densities into walk->scratch.pdf.
void rf_scatter_deferred( const RfPathSettings* settings, RfWavefront* walk, const RfVertexLanes* vertices, int vertex,
                          float* const wi[3] );

// The vertices at the ends of rays, and into walk->arrivals the light found
// there: `apart` as emitted, or weighed by the balance heuristic.
void rf_find_lit_vertices( const RfPathSettings* settings, RfWavefront* walk, RfRayLanes* rays, bool apart,
                           RfVertexLanes* vertices );

// Radiance that arrives along walk->rays, which left vertex first_vertex − 1 of
// their paths: all further vertices, lights sampled and scattered directions
// combined by the balance heuristic, roulette after the third vertex.
// walk->arrivals must be zero for the slots of the rays.
void rf_trace_tails( const RfPathSettings* settings, RfWavefront* walk, int first_vertex );

#endif
