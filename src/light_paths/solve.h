// Bends chains so that they meet a point, by Newton's method in what steers them.
#ifndef REFRAME_LIGHT_PATHS_SOLVE_H
#define REFRAME_LIGHT_PATHS_SOLVE_H

#include "light_paths/chain.h"
#include "light_paths/reach.h"

// A chain on its way to a point.
typedef struct RfBend
{
    RfChain at;   // the best so far
    RfVec3 y;     // to be met
    RfVec3 n;     // unit geometric normal there
    RfReach most; // refuses first steps beyond this
    bool active;
    bool met; // out: `at` meets y
} RfBend;

// The step of Newton's method from a ray towards y; by how far it misses; the area on the plane per unit of what steers.
// False: there is none.
bool rf_newton_step( const RfRayPair* ray, RfVec3 y, RfVec3 n, float step[2], float* miss, float* spread );

// Bends the active ones of `count` ≤ RF_CHAIN_BLOCK chains. Of `at` only start, events, length and end need be set. Whether
// and where it succeeds depends on these and on y alone.
void rf_bend_chains( const RfTracer* tracer, int count, RfBend* bends, uint64_t* rays );

#endif
