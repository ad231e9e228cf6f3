// Specular chains as seen from the light, and the manifold walk that moves one so that it arrives at a point. A chain goes
// from an emitter through mirrors and smooth glass to where it leaves. It is steered by two numbers, the direction of a light
// with a place, or the place of a ray of an infinite light; its differentials tell how its end moves (Igehy, Tracing Ray
// Differentials, 1999), and how its start moves when the end stays. src/reuse/estimators.md, section 16.
#ifndef REFRAME_LIGHT_PATHS_MANIFOLD_WALK_H
#define REFRAME_LIGHT_PATHS_MANIFOLD_WALK_H

#include "base/random.h"
#include "light/emission.h"
#include "trace/trace.h"

// How far connections reach in what steers a chain: an ellipse around its start, in the plane of rf_basis of the direction:
// chords of the sphere of directions, or metres.
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
    float normal_scale; // of the derivatives of the normal: its side over the length of the interpolated one; 0: flat
    float eta;          // index of the far side over that of the near one; 0: a mirror
    bool refracted;
} RfChainVertex;

typedef struct RfChain
{
    RfEmission start; // with position and direction
    uint32_t events;  // bit k: vertex k refracts
    int length;
    RfChainVertex vertex[RF_MAX_CHAIN];
    RfVec3 weight;     // what reflections, refractions and media leave of the light
    float probability; // of these events, where they were drawn
    RfRayPair end;     // the ray that leaves, with its derivatives by the parameters that steer
    float way;         // m, up to the last vertex
    uint32_t first_triangle;
    float first_area_pdf;  // the first vertex: |cos| over distance² (with a place), or |cos|
    RfVec3 end_absorption; // of what the ray that leaves runs through, 1/m
    bool ends_inside;      // of a body
} RfChain;

// How chains take events.
typedef enum RfChainEvents
{
    RF_CHAIN_DRAW, // at random, until they leave the delta surfaces
    RF_CHAIN_COPY, // those in `events`, `length` of them
} RfChainEvents;

// Walks `count` ≤ RF_CHAIN_BLOCK chains from their starts. Chains whose index is not in `active` are left alone. Those that
// cannot be walked get length 0. Drawn chains that lead to more than RF_MAX_CHAIN vertices or to nothing do so too.
// Drawn: *land has the triangle and barycentrics where they end. Copied, with `land` ≠ NULL: likewise, and a chain that
// does not end on another surface than those of chains gets length 0.
#define RF_CHAIN_BLOCK 64
typedef struct RfLanding
{
    uint32_t triangle[RF_CHAIN_BLOCK];
    float u[RF_CHAIN_BLOCK], v[RF_CHAIN_BLOCK];
    float offset[RF_CHAIN_BLOCK]; // of rays that start there
    RfVec3 p[RF_CHAIN_BLOCK];
} RfLanding;
void rf_walk_chains( const RfTracer* tracer, RfChainEvents events, const RfRandomKey* keys, const bool* active, int count,
                     RfChain* const* chains, RfLanding* land, uint64_t* rays );

// A chain from its start, without vertices, and its next one, at a surface that it is known to hit; a step of
// rf_walk_chains. False: it ends there.
void rf_begin_chain( RfChain* chain );
bool rf_step_chain( const RfTracer* tracer, uint32_t triangle, float u, float v, RfChainEvents events, RfRandomKey key,
                    RfChain* chain );

// The intersection of a ray with the plane through p with normal n, and its derivatives. False: there is none.
bool rf_meet_plane( const RfRayPair* ray, RfVec3 p, RfVec3 n, RfVec3* meet, RfVec3 moves[2] );

// The measure of what is sampled at the light per unit solid angle at y, for light that comes to y by this chain: for lights
// with a place, the area perpendicular to the ray at the light; for infinite ones the solid angle.
float rf_chain_spread( const RfTracer* tracer, const RfChain* chain, RfVec3 y );

// Steers a start: directions by a tangent vector, infinite lights' positions by a shift.
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
    o[0][i] = from.x;
    o[1][i] = from.y;
    o[2][i] = from.z;
    d[0][i] = way.x;
    d[1][i] = way.y;
    d[2][i] = way.z;
}

// What flux keeps of a chain over what radiance keeps, which scales with the squared index: other than 1 if light starts within a
// body and ends outside.
static inline float rf_flux_over_radiance( const RfChain* chain )
{
    float scale = 1.0f;
    for ( int k = 0; k < chain->length; ++k )
    {
        const RfChainVertex* v = chain->vertex + k;
        scale /= v->refracted ? v->eta * v->eta : 1.0f;
    }
    return scale;
}

// A chain on its way to a point.
typedef struct RfManifoldWalk
{
    RfChain at;   // the best so far
    RfVec3 y;     // to be met
    RfVec3 n;     // unit geometric normal there
    RfReach most; // refuses first steps beyond this
    bool active;
    bool met; // out: `at` meets y
} RfManifoldWalk;

// Newton's step from a ray towards y, its distance from y, and the Jacobian from the parameters to area on the plane. False: it
// is singular.
bool rf_newton_step( const RfRayPair* ray, RfVec3 y, RfVec3 n, float step[2], float* miss, float* spread );

// Walks the active ones of `count` ≤ RF_CHAIN_BLOCK chains. Of `at` only start, events, length and end need be set. Whether
// and where it succeeds depends on these and on y alone.
void rf_walk_manifold( const RfTracer* tracer, int count, RfManifoldWalk* walks, uint64_t* rays );

#endif
