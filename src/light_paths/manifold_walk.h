// Specular chains traced from the light, through mirrors and smooth glass, and the manifold walk that moves a
// chain until it meets a point. Two parameters steer it: the direction of emission, or for lights at infinity the
// position of the ray. Ray differentials (Igehy, Tracing Ray Differentials, 1999) give how its end moves with
// these. src/reuse/estimators.md, section 16.
#ifndef REFRAME_LIGHT_PATHS_MANIFOLD_WALK_H
#define REFRAME_LIGHT_PATHS_MANIFOLD_WALK_H

#include "base/random.h"
#include "light/emission.h"
#include "trace/trace.h"

// The reach of a connection: an ellipse around a chain's start in its steering parameters, in the plane of
// rf_basis of the direction: chords of the sphere of directions, or metres.
typedef struct RfReach
{
    float axis[2];       // unit, of `along`
    float along, across; // half the axes
} RfReach;

static inline float rf_reach_area( const RfReach* reach ) { return RF_PI * reach->along * reach->across; }

// The squared distance from its middle; 1: the edge.
static inline float rf_reach_squared( const RfReach* reach, float x, float y )
{
    float a = ( x * reach->axis[0] + y * reach->axis[1] ) / reach->along,
          b = ( y * reach->axis[0] - x * reach->axis[1] ) / reach->across;
    return a * a + b * b;
}

static inline RfReach rf_scaled_reach( const RfReach* reach, float scale )
{
    return ( RfReach ){ { reach->axis[0], reach->axis[1] }, scale * reach->along, scale * reach->across };
}

// The squared distance of a start from the middle. Of directions by Lambert's projection, which keeps areas.
static inline float rf_reach_to( const RfReach* reach, const RfEmission* middle, const RfEmission* e )
{
    RfVec3 t, b, apart = e->infinite ? rf_sub( e->position, middle->position ) : rf_sub( e->direction, middle->direction );
    rf_basis( middle->direction, &t, &b );
    float x = rf_dot( apart, t ), y = rf_dot( apart, b ), flat = sqrtf( x * x + y * y );
    float scale = e->infinite || !( flat > 0.0f ) ? 1.0f : rf_length( apart ) / flat;
    return rf_reach_squared( reach, scale * x, scale * y );
}

// A point of the ellipse, evenly for u and v from [0, 1): the chord from the middle, and its unit direction.
static inline RfVec3 rf_sample_reach( const RfReach* reach, RfVec3 direction, float u, float v, float* chord )
{
    RfVec3 t, b;
    float phi = 2.0f * RF_PI * v, a = reach->along * sqrtf( u ) * cosf( phi ), c = reach->across * sqrtf( u ) * sinf( phi );
    float x = a * reach->axis[0] - c * reach->axis[1], y = a * reach->axis[1] + c * reach->axis[0];
    *chord = sqrtf( a * a + c * c );
    float inverse = *chord > 0.0f ? 1.0f / *chord : 0.0f;
    rf_basis( direction, &t, &b );
    return rf_add( rf_scale( t, x * inverse ), rf_scale( b, y * inverse ) );
}

#define RF_CHAIN_BLOCK 64

// The thin panes that rays or segments of a block passed (src/reuse/estimators.md, section 11).
typedef struct RfPassedPanes
{
    bool any;                          // in the scene; else there are none
    float probability[RF_CHAIN_BLOCK]; // q, by which scattered rays pass them
    float weight[3][RF_CHAIN_BLOCK];   // κ
} RfPassedPanes;

// T = q κ of what ray number `i` passed.
static inline RfVec3 rf_passed_colour( const RfPassedPanes* panes, int i )
{
    RfVec3 kappa = RF_GET3( panes->weight, i );
    return panes->any ? rf_scale( kappa, panes->probability[i] ) : rf_vec3( 1.0f, 1.0f, 1.0f );
}

// Nearest hits beyond all thin panes, of `count` ≤ RF_CHAIN_BLOCK rays, and visibility past them.
void rf_trace_light( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], uint32_t* triangle,
                     float* u, float* v, RfPassedPanes* panes );
void rf_trace_light_segments( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], float* visible,
                              RfPassedPanes* panes );

// A ray with its differentials by two parameters.
typedef struct RfRayPair
{
    RfVec3 o, d;
    RfVec3 dp[2], dd[2];
} RfRayPair;

typedef struct RfChainVertex
{
    RfVec3 p;
    RfVec3 n;   // unit shading normal, on the side that the light comes from
    RfVec3 out; // unit, in which the light goes on
    uint32_t triangle;
    float normal_scale; // of the normal's derivatives: its sign over the length of the interpolated normal; 0: flat
    float eta;          // refractive index of the far over the near side; 0: a mirror
    bool refracted;
    bool facet; // of a plate: its facet with these coordinates in rf_basis( n ) reflects
    float at[2];
    float flux_scale; // of a facet: the factor for flux over that for radiance
} RfChainVertex;

typedef struct RfChain
{
    RfEmission start; // with position and direction
    uint32_t events;  // bit k: vertex k refracts
    uint32_t plate;   // 1 + the material of the plate (rf_is_plate) that is its only vertex; 0: it has none
    float facet[2];   // that reflects there
    int length;
    RfChainVertex vertex[RF_MAX_CHAIN];
    RfVec3 weight;     // throughput of reflections, refractions, media and panes
    float probability; // of these events, where they were drawn
    float passes;      // probability of passing the panes, of scattered rays: light paths pass them for sure
    RfRayPair end;     // the ray that leaves, with derivatives by the steering parameters
    float way;         // m, up to the last vertex
    uint32_t first_triangle;
    float first_area_pdf;  // the first vertex: |cos| over distance² (with a place), or |cos|
    RfVec3 end_absorption; // of the medium of the ray that leaves, 1/m
    bool ends_inside;      // of a body
} RfChain;

static inline void rf_pass_panes( const RfPassedPanes* panes, int ray, RfChain* chain )
{
    chain->weight = rf_mul( chain->weight, rf_passed_colour( panes, ray ) );
    chain->passes *= panes->probability[ray];
}

// Where a chain's events come from.
typedef enum RfChainEvents
{
    RF_CHAIN_DRAW, // drawn, until the chain leaves specular surfaces
    RF_CHAIN_COPY, // given: `length` of them in `events`
} RfChainEvents;

// Walks `count` ≤ RF_CHAIN_BLOCK chains from their starts. Inactive ones are left alone. Chains that fail get
// length 0, as do drawn ones of more than RF_MAX_CHAIN vertices or without an end. *land has the triangle and
// barycentrics where they end; with `land`, copied chains fail unless they end on a non-specular surface.
typedef struct RfLanding
{
    uint32_t triangle[RF_CHAIN_BLOCK];
    float u[RF_CHAIN_BLOCK], v[RF_CHAIN_BLOCK];
    float offset[RF_CHAIN_BLOCK]; // of rays that start there
    RfVec3 p[RF_CHAIN_BLOCK];
} RfLanding;
void rf_walk_chains( const RfTracer* tracer, RfChainEvents events, const RfRandomKey* keys, const bool* active, int count,
                     RfChain* const* chains, RfLanding* land, uint64_t* rays );

// The steps of rf_walk_chains: begins a chain without vertices, and adds the next at a surface that it is known to
// hit. False: it ends there.
void rf_begin_chain( RfChain* chain );
bool rf_step_chain( const RfTracer* tracer, uint32_t triangle, float u, float v, RfChainEvents events, RfRandomKey key,
                    RfChain* chain );

// The intersection of a ray with the plane through p with normal n, and its derivatives. False: there is none.
bool rf_meet_plane( const RfRayPair* ray, RfVec3 p, RfVec3 n, RfVec3* meet, RfVec3 moves[2] );

// The measure sampled at the light per unit solid angle at y, along this chain: for finite lights the area
// perpendicular to the ray, for infinite ones the solid angle.
float rf_chain_spread( const RfTracer* tracer, const RfChain* chain, RfVec3 y );

// Moves the steering parameters: a direction by a tangent vector, for infinite lights a position by a shift.
static inline void rf_steer( RfEmission* e, float s1, float s2 )
{
    RfVec3 t, b;
    rf_basis( e->direction, &t, &b );
    RfVec3 shift = rf_add( rf_scale( t, s1 ), rf_scale( b, s2 ) );
    if ( e->infinite )
        e->position = rf_add( e->position, shift );
    else
        e->direction = rf_normalize( rf_add( e->direction, shift ) );
}

// Ray number `i` of a block, as rf_trace_nearest and rf_trace_segments take them.
static inline void rf_put_ray( float o[3][RF_CHAIN_BLOCK], float d[3][RF_CHAIN_BLOCK], int i, RfVec3 from, RfVec3 way )
{
    RF_PUT3( o, i, from );
    RF_PUT3( d, i, way );
}

// Throughput of flux over that of radiance, which scales with the squared index: not 1 if light starts inside a
// body and ends outside.
static inline float rf_flux_over_radiance( const RfChain* chain )
{
    float scale = 1.0f;
    for ( int k = 0; k < chain->length; ++k )
    {
        const RfChainVertex* v = chain->vertex + k;
        scale *= v->facet ? v->flux_scale : 1.0f;
        scale /= v->refracted ? v->eta * v->eta : 1.0f;
    }
    return scale;
}

// A manifold walk in progress.
typedef struct RfManifoldWalk
{
    RfChain at;   // the best so far
    RfVec3 y;     // to be met
    RfVec3 n;     // unit geometric normal there
    RfReach most; // limit of the first step
    bool active;
    bool met; // out: `at` meets y
} RfManifoldWalk;

// Newton's step from a ray towards y, its distance from y, and the Jacobian from the parameters to area on the plane. False: it
// is singular.
bool rf_newton_step( const RfRayPair* ray, RfVec3 y, RfVec3 n, float step[2], float* miss, float* spread );

// Walks the active ones of `count` ≤ RF_CHAIN_BLOCK chains to their points. Of `at` only start, events, plate, facet, length and
// end must be set. Whether a walk succeeds depends on these and y alone.
void rf_walk_manifold( const RfTracer* tracer, int count, RfManifoldWalk* walks, uint64_t* rays );

#endif
