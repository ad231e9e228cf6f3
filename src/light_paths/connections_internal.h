// Connections at work, for src/light_paths and its tests.
#ifndef REFRAME_LIGHT_PATHS_CONNECTIONS_INTERNAL_H
#define REFRAME_LIGHT_PATHS_CONNECTIONS_INTERNAL_H

#include "light_paths/connections.h"

#define RF_MOST_CANDIDATES 512
#define RF_STEP_MARGIN 1.4f // first steps, in reaches of connections

// Of the random numbers of a connection; below them those of its repeated trials.
#define RF_DIMENSION_CHOOSE 0x40000000u
#define RF_DIMENSION_ACCEPT 0x40000001u

// The light paths or particles whose footprints hold a camera vertex.
typedef struct RfCandidates
{
    const RfLightPathConnector* settings;
    const RfFootprintTree* tree;
    RfFootprintFound* note; // counts those that are candidates, and keeps them by rf_keep_candidate
    RfVec3 y, ng, n;
    int spent, vertex;
    int count;
    int kept;
    uint32_t path[RF_MOST_CANDIDATES];
    float light[RF_MOST_CANDIDATES]; // predicted for them
    // second search, where there are more: those numbered next, next + stride …
    double next, stride;
    bool thinned;
} RfCandidates;

// A light path and a camera vertex inside its footprint.
typedef struct RfConnection
{
    int lane;
    const RfLightPath* path;
    RfRandomKey key;
    float scale;   // reciprocal of the probability with which it was accepted
    float offered; // that probability at a share of 1, unclamped
    float chance;  // of rf_chance_area; 0: connections alone find this light
    // connections of this kind that a full set would find within the clamped footprints
    float most, rare_most;
    RfChain chain; // solved
    RfReach reach; // of the solution
    float repeats; // trials until success
    bool open;
    float area; // that it covers at the vertex, for rf_own_weight
    RfVec3 wi, light;
} RfConnection;

// A particle, its VPL, and a camera vertex inside its footprint.
typedef struct RfVplConnection
{
    int lane;
    const RfLightPath* path;
    RfRandomKey key;
    float scale;               // 1 / the probability of accepting it
    RfVec3 d;                  // from the VPL to the vertex, unit
    float cosine;              // at which that leaves the VPL
    float cone;                // squared sine of the cone around it
    float versine;             // of the same cone
    float most;                // the largest cosine in it
    float repeats;             // trials until success
    float inverse_probability; // of a particle that covers the vertex
    bool open;
    RfVec3 light;
} RfVplConnection;

struct RfConnectionWork
{
    const RfLightPathConnector* settings;
    RfWavefront* keys;
    const RfRayLanes* rays; // NULL: connections are not weighted
    int vertex;
    const RfVertexLanes* v;
    RfConnectionLanes* out;
    RfConnection connection[RF_CHAIN_BLOCK];
    RfManifoldWalk walk[RF_CHAIN_BLOCK];
    int count;
    RfVplConnection vpl_connection[RF_CHAIN_BLOCK];
    int vpl_count;
    float chosen[RF_LANES]; // the sum of what was drawn from
};

static inline RfVec3 rf_lane_of( const float ( *array )[RF_LANES], int i ) { return RF_GET3( array, i ); }

static inline RfVec3 rf_start_of( const RfVertexLanes* v, int i )
{
    return rf_madd( rf_lane_of( v->p, i ), rf_lane_of( v->ng, i ), v->offset[i] );
}

// Counts a candidate with its expected contribution; keeps it if there is room.
void rf_keep_candidate( RfCandidates* candidates, uint32_t number, float light );

// For the rows of RfNormalization: candidates by their derivatives, connections by manifold walks and shadow rays, and the
// weights of scattered rays.
void rf_note_path( void* candidates, uint32_t number );
void rf_walk_to_vertices( RfConnectionWork* work );
float rf_weigh_chance( const RfConnector* connector, const RfTrail* trail, int length, uint32_t triangle, RfVec3 point );

// Connects a lane to VPLs, and adds the light of all connections to VPLs that wait.
void rf_connect_vpls( RfConnectionWork* work, RfRandomKey lane, int i );
void rf_flush_vpls( RfConnectionWork* work );

// Counts, for each open connection, the light paths drawn around the solution until a manifold walk from one converges to the
// same solution: an unbiased estimate of the reciprocal of that probability.
void rf_repeat_trials( RfConnectionWork* work );

#endif
