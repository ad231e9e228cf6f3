// Internal to trace.c: Embree's filter function for alpha-masked and alpha-blended surfaces.
#ifndef REFRAME_TRACE_FILTER_H
#define REFRAME_TRACE_FILTER_H

#include "trace/bvh.h"

#define RF_PACKET 16

// The query that a packet belongs to; the ids of its rays are their lanes.
typedef struct RfQuery
{
    struct RTCIntersectContext context; // first member: Embree passes its address to the filter
    bool segments;                      // accumulate transmittance instead of finding the nearest hit
    float transmittance[RF_PACKET];     // per ray, initially 1
} RfQuery;

// Rejects hits where the surface is masked out. On a blended surface, rays hit with
// probability alpha, by a hash of the ray; segments are attenuated by 1 − alpha.
void rf_filter_hits( const struct RTCFilterFunctionNArguments* args );

#endif
