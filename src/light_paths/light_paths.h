// Light paths: from emitters through mirrors and glass to the first non-specular surface. They know no camera, so
// one set serves all frames of a group. src/reuse/estimators.md, section 16.
#ifndef REFRAME_LIGHT_PATHS_LIGHT_PATHS_H
#define REFRAME_LIGHT_PATHS_LIGHT_PATHS_H

#include "base/layout.h"
#include "light_paths/footprints.h"
#include "light_paths/manifold_walk.h"
#include "path/wavefront.h"
#include "render/estimator.h"

#define RF_TRIAL_CONNECTIONS 8.0f        // of a camera path's first vertex
#define RF_TRIAL_CONNECTIONS_BEYOND 1.0f // of others
#define RF_TRIED 0.3f                    // fraction of these that other light leaves, as weights assume

// Where a light path lands and scatters: a virtual point light.
typedef struct RfVpl
{
    bool scatters; // the surface is matte, so particles go on from it
    RfVec3 ng, n;  // unit geometric and shading normal, on the side that the light comes from
    uint32_t triangle;
    float u, v, offset;
    float falloff; // attenuation by the light's range, up to here
    float area;    // m²: the area that a connection covers here, per connection found in it (rf_own_weight)
    float share;   // weight of connections in its light (rf_connection_weight)
} RfVpl;

// A light path, as connections need it.
typedef struct RfLightPath
{
    RfEmission start;
    uint32_t events;
    uint32_t plate; // of its chain
    float facet[2];
    int length;        // vertices of its chain
    float weight;      // 1 / (density of the steering parameters × probability of the events)
    RfReach reach;     // of connections
    RfFootprintBox at; // where it lands, with its footprint
    RfVec3 flux;       // over the density of the path, W
    float chance;      // sr, of rf_chance_area
    float light;       // luminance of a connection, times the area over which it spreads
    RfRayPair end;     // the ray that lands
    RfVpl vpl;
} RfLightPath;

// Where a particle landed that a VPL scattered.
typedef struct RfScatteredPath
{
    RfFootprintBox at; // around a ball
    uint32_t path;
} RfScatteredPath;

typedef struct RfLightPaths
{
    int listed_for;    // 1 + the number of the group, since surfaces may move: its surfaces and emitters are listed; 0: none are
    int share_of;      // the group that `share` was chosen for, from 1; 0: none yet
    float share;       // of the light paths and connections of a set that is drawn
    bool balls;        // footprints are balls, else boxes (RfNormalization)
    bool measures;     // connections estimate their error with other shares (RfConnectionLanes)
    uint32_t emitted;  // n, with those that were lost
    uint32_t count;    // stored
    float connections; // c: light paths that a camera vertex finds, on average, per chain that leads light to it
    float rare_connections; // the same where footprints are clamped
    float most_radius;      // of footprints
    RfLightPath* path;
    RfFootprintTree tree; // of `path`
    // what they scatter
    float vpl_connections; // connections of a vertex to the VPLs of one light path, on average
    uint32_t scattered_count;
    RfScatteredPath* scattered;
    RfFootprintTree scattered_tree;
    // mirrors and glass, sorted by triangle
    uint32_t surface_count;
    uint32_t* triangle;
    double* cumulative; // of their probabilities
    float* pdf_area;    // of their points
    bool emission;      // of surfaces and the sky is found, too: there are mirrors or glass; plates serve punctual lights alone
    // the lights that light paths start from
    uint32_t light_count;
    uint32_t* light;
    double* light_cumulative; // of their powers
    uint64_t rays;            // traced for this set
} RfLightPaths;

// A set, whose memory is all zero at first.
RfLightPaths* rf_place_light_paths( const RfEstimatorGroup* group, RfLayout* layout );

// Draws the light paths of a pass of a group. The same bits for any number of threads.
void rf_draw_light_paths( const RfEstimatorGroup* group, int pass, void* memory );

// The set, or NULL: none was drawn.
static inline const RfLightPaths* rf_drawn_light_paths( const RfLightPaths* paths )
{
    return paths != NULL && paths->share > 0.0f ? paths : NULL;
}

// The density with which a chain is drawn that starts like this one, by the parameters that steer it; 0: it is never drawn.
float rf_steer_pdf( const RfLightPaths* paths, const RfChain* chain );

// Reciprocal of the expected number of connections per steradian at p that find the light which arrives there by a chain, sr: a
// function of the path alone. 0: no other technique finds that light. Infinity: connections do not.
float rf_chance_area( const RfLightPaths* paths, const RfChain* chain, float area, float steer_pdf, RfVec3 p );

// The largest number of trial connections at a path's `vertex`-th vertex, with this share.
static inline float rf_trial_connections( float share, int vertex )
{
    return share * ( vertex == 1 ? RF_TRIAL_CONNECTIONS : RF_TRIAL_CONNECTIONS_BEYOND );
}

// Fraction of the connections found that are tried, as weights assume it: the fraction that the vertex's other
// light leaves is not known from other vertices.
static inline float rf_tried( const RfLightPaths* paths, float share, int vertex )
{
    return rf_minf( RF_TRIED * rf_trial_connections( share, vertex ) / paths->connections, 1.0f );
}

// The balance weight of a connection at a path's `vertex`-th vertex against cosine-weighted scattered rays
// (src/reuse/estimators.md, section 16). `chance`: from rf_chance_area.
static inline float rf_connection_weight( const RfLightPaths* paths, float chance, float cosine, int vertex )
{
    float tried = rf_tried( paths, paths->share, vertex );
    return rf_balance_weight( tried, chance * RF_INV_PI * rf_maxf( cosine, 1e-6f ) );
}

// A chain as it arrives at a point of a surface.
typedef struct RfFootprint
{
    // Of connections around it: so far that `connections` of them are found on average, as far as footprints go. 0: there is none
    RfReach reach;
    float most, rare_most; // the largest area that footprints allow, usually and where fewer than rare_connections are found
    RfVec3 half;           // of the box around the footprint, m
    float radius;          // of a ball instead (GK 7); its longer axis where it is stretched
} RfFootprint;
RfFootprint rf_find_footprint( const RfLightPaths* paths, const RfLights* lights, const RfChain* chain, float pdf, RfVec3 p,
                               RfVec3 normal );

// Particles: scattered by VPLs. A camera vertex inside the footprint of a particle connects to its VPL.
#define RF_SCATTERED_PER_PATH 2u
#define RF_VPL_CONNECTIONS 3.0f // found by a vertex, on average

// Whether there may be a VPL where a chain ends: not inside bodies, where flux and radiance scale differently.
static inline bool rf_may_scatter( const RfChain* chain ) { return !chain->ends_inside; }

// Where rays start at the VPL.
static inline RfVec3 rf_vpl_start( const RfLightPath* path ) { return rf_madd( path->at.p, path->vpl.ng, path->vpl.offset ); }

// The squared sine of the cone around the direction to a point, which leaves the VPL at this cosine: particles within the cone
// cover the point. It is wider at grazing angles, so that the expected number of connections is the same everywhere.
static inline float rf_vpl_cone( const RfLightPaths* paths, float cosine )
{
    return paths->vpl_connections / ( (float)RF_SCATTERED_PER_PATH * rf_maxf( cosine, RF_LEAST_VPL_COSINE ) );
}

// The radius of a particle's footprint, m. `hit`: where it landed.
float rf_scattered_radius( const RfLightPaths* paths, const RfLightPath* path, RfVec3 hit, RfVec3 ng );

#endif
