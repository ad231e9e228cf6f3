// Large occluders that are tried before the BVH: in rooms most shadow rays that are blocked meet one of a few walls. A thread learns
// from its shadow rays which. Rays are only counted as blocked where Embree is sure to find them blocked as well, so results do not
// depend on what has been learned.
#ifndef REFRAME_TRACE_OCCLUDERS_H
#define REFRAME_TRACE_OCCLUDERS_H

#include "trace/trace.h"

#define RF_MOST_OCCLUDERS 8
#define RF_MOST_SHADOW_RAYS 2048 // of a call

// A triangle, or two of them that make a parallelogram.
typedef struct RfOccluder
{
    RfVec3 p, n;          // a corner, unit normal
    RfVec3 a, b;          // x = p + u e1 + v e2 has a·(x − p) = u, b·(x − p) = v
    float extent, margin; // of its corners from p; of u and v, for each unit of length of ray and extent
    float skew;           // 1: a triangle, u + v < 1; 0: a parallelogram, u < 1, v < 1
    uint32_t triangle[2]; // twice the same: a triangle
} RfOccluder;

// What may be learned: the largest of the opaque triangles that stand still.
typedef struct RfOccluderList
{
    int count;
    RfOccluder list[];
} RfOccluderList;

#define RF_OCCLUDER_SAMPLES 64

// What a thread has learned. All 0: nothing as yet.
typedef struct RfOccluders
{
    const RfOccluderList* of;
    int count;
    RfOccluder list[RF_MOST_OCCLUDERS];
    // since it learned last
    uint32_t rays, blocked, period; // it learns again after as many rays
    int samples;                    // of the blocked ones
    float o[3][RF_OCCLUDER_SAMPLES], d[3][RF_OCCLUDER_SAMPLES];
} RfOccluders;

// As rf_trace_segments, or with panes rf_trace_segments_past_panes (trace/trace.h), for up to RF_MOST_SHADOW_RAYS segments, many of
// which are blocked. What panes hold of those is not set.
void rf_trace_shadow_rays( const RfTracer* tracer, RfOccluders* occluders, int count, const float* const o[3],
                           const float* const d[3], float* visible, const RfPaneLanes* panes );

// Lists those of `count` segments that the occluders do not block for sure. Returns how many. `open` holds `count`.
int rf_list_open_segments( const RfOccluders* occluders, int count, const float* const o[3], const float* const d[3],
                           int32_t* open );

// The largest occluders of a tracer that has all but these; NULL: no memory. To be freed.
RfOccluderList* rf_find_occluders( const RfTracer* tracer );

#endif
