// Internal to this folder: links at work.
#ifndef REFRAME_KERNEL_LINKS_INTERNAL_H
#define REFRAME_KERNEL_LINKS_INTERNAL_H

#include "kernel/links.h"
#include "kernel/solve.h"

#define RF_STEP_MARGIN 1.4f // first steps, in reaches of links
#define RF_MOST_CANDIDATES 512

// Of the random numbers of a link; below them those of its repeated trials.
#define RF_DIMENSION_CHOOSE 0x40000000u
#define RF_DIMENSION_ACCEPT 0x40000001u

// A light path and the eye vertex that its footprint holds.
typedef struct RfLink
{
    int lane;
    const RfLightPath* path;
    RfRandomKey key;
    float scale;   // one over the probability with which it was accepted
    RfChain chain; // solved
    float reach;   // of the solution
    float repeats; // trials until it was found again
    bool open;
    RfVec3 wi, light;
} RfLink;

typedef struct RfLinkWork
{
    const RfKernelLinker* settings;
    RfWavefront* keys;
    int vertex;
    const RfVertexLanes* v;
    RfLinkLanes* out;
    RfLink link[RF_CHAIN_BLOCK];
    RfBend bend[RF_CHAIN_BLOCK];
    int count;
    float chosen[RF_LANES]; // the sum of what was drawn from
} RfLinkWork;

// Light paths whose footprint holds an eye vertex.
typedef struct RfCandidates
{
    const RfKernelLinker* settings;
    RfVec3 y, n;
    int spent;
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

// How far two starts are apart, in what steers them.
static inline float rf_steered_apart( const RfEmission* a, const RfEmission* b )
{
    RfVec3 apart = a->infinite ? rf_sub( a->position, b->position ) : rf_sub( a->direction, b->direction );
    return rf_length( apart );
}

// Finds candidates; of more than there is room for every k-th. Returns one over the probability of being among them.
float rf_find_candidates( RfCandidates* candidates, RfRandomKey key );

// Counts, for all open links, the light paths drawn from around the solution until one is found that a link would bend to the
// same: on average one over the probability of that.
void rf_repeat_trials( RfLinkWork* work );

#endif
