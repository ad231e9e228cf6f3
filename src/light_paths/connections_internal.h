// Internal to this folder: connections at work.
#ifndef REFRAME_LIGHT_PATHS_CONNECTIONS_INTERNAL_H
#define REFRAME_LIGHT_PATHS_CONNECTIONS_INTERNAL_H

#include "light_paths/connections.h"
#include "light_paths/vpls.h"
#include "light_paths/solve.h"

#define RF_STEP_MARGIN 1.4f // first steps, in reaches of connections
#define RF_MOST_CANDIDATES 512

// Of the random numbers of a connection; below them those of its repeated trials.
#define RF_DIMENSION_CHOOSE 0x40000000u
#define RF_DIMENSION_ACCEPT 0x40000001u

// A light path and the eye vertex that its footprint holds.
typedef struct RfConnection
{
    int lane;
    const RfLightPath* path;
    RfRandomKey key;
    float scale;   // one over the probability with which it was accepted
    float offered; // that probability with all connections, more than one perhaps
    float chance;  // of rf_chance_area
    float most,
        rare_most; // connections of a way that all light paths could find; `connections` of them, or rare_connections, are wanted
    RfChain chain; // solved
    RfReach reach; // of the solution
    float repeats; // trials until it was found again
    bool open;
    float area; // that it covers at the vertex, for rf_own_weight
    RfVec3 wi, light;
} RfConnection;

// A particle whose footprint holds an eye vertex, and its VPL.
typedef struct RfVplConnection
{
    int lane;
    const RfLightPath* path;
    RfRandomKey key;
    float scale;   // one over the probability with which it was accepted
    RfVec3 d;      // from the VPL to the vertex, unit
    float cosine;  // at which that leaves the VPL
    float cone;    // squared sine of the cone around it
    float versine; // of the same cone
    float most;    // the largest cosine in it
    float repeats;
    bool open;
    RfVec3 light;
} RfVplConnection;

typedef struct RfConnectionWork
{
    const RfLightPathConnector* settings;
    RfWavefront* keys;
    const RfRayLanes* rays; // NULL: connections are not weighted
    int vertex;
    const RfVertexLanes* v;
    RfConnectionLanes* out;
    RfConnection connection[RF_CHAIN_BLOCK];
    RfBend bend[RF_CHAIN_BLOCK];
    int count;
    RfVplConnection vpl_connection[RF_CHAIN_BLOCK];
    int vpl_count;
    float chosen[RF_LANES]; // the sum of what was drawn from
} RfConnectionWork;

// Light paths, or particles, whose footprint holds an eye vertex.
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
    float light[RF_MOST_CANDIDATES]; // that they are expected to bring
    // second search, where there are more: those numbered next, next + stride …
    double next, stride;
    bool thinned;
} RfCandidates;

static inline RfVec3 rf_lane_of( const float ( *array )[RF_LANES], int i )
{
    return rf_vec3( array[0][i], array[1][i], array[2][i] );
}

// Where segments to lights start as well.
static inline RfVec3 rf_start_of( const RfVertexLanes* v, int i )
{
    return rf_madd( rf_lane_of( v->p, i ), rf_lane_of( v->ng, i ), v->offset[i] );
}

// Sets up the search for the candidates of a lane.
void rf_begin_candidates( const RfConnectionWork* work, int i, const RfFootprintTree* tree, RfFootprintFound* note,
                          RfCandidates* candidates );

// Counts a candidate that is expected to bring so much light; keeps it if there is room.
void rf_keep_candidate( RfCandidates* candidates, uint32_t number, float light );

// Notes light paths, and particles.
RfFootprintFound rf_note_path, rf_note_particle;

// The trial connections of one lane: each candidate is accepted in proportion to what it is expected to bring.
typedef struct RfAcceptance
{
    RfRandomKey lane;
    float scale;  // from rf_find_candidates
    float trials; // connections wanted
    float sum;    // that all candidates are expected to bring
} RfAcceptance;
RfAcceptance rf_weigh_candidates( const RfConnectionWork* work, RfRandomKey lane, float scale, int i,
                                  const RfCandidates* candidates );

// The part of the trial connections that a candidate is offered.
float rf_offered( const RfAcceptance* acceptance, const RfCandidates* candidates, int k );

// The key of a candidate, and one over the probability of accepting it; 0: it was not.
float rf_accept( const RfAcceptance* acceptance, const RfCandidates* candidates, int k, RfRandomKey* key );

// Connections a lane to VPLs, and does what is left to do.
void rf_connect_vpls( RfConnectionWork* work, RfRandomKey lane, int i );
void rf_flush_vpls( RfConnectionWork* work );

// Adds the light of a connection to its lane.
void rf_add_light( RfConnectionWork* work, int i, RfRandomKey key, RfVec3 wi, RfVec3 light, float area );

// Counts up what the square of this light would be with other shares, before its balance weight.
void rf_measure_connection( const RfConnectionWork* work, const RfConnection* connection, float light );

// Finds candidates; of more than there is room for every k-th. Returns one over the probability of being among them.
float rf_find_candidates( RfCandidates* candidates, RfRandomKey key );

// Counts, for all open connections, the light paths drawn from around the solution until one is found that a connection would bend to the
// same: on average one over the probability of that.
void rf_repeat_trials( RfConnectionWork* work );

#endif
