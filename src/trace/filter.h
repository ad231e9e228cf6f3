// Inside of trace.c: what Embree asks at each hit of a surface that may be cut
// out or is blended.
#ifndef REFRAME_TRACE_FILTER_H
#define REFRAME_TRACE_FILTER_H

#include "trace/bvh.h"

#define RF_PACKET 16

// The query that a packet belongs to; its rays' ids are their lanes.
typedef struct RfQuery
{
    struct RTCIntersectContext context; // first: Embree hands it on
    bool segments;                      // asks for transmittance, not for the nearest hit
    float transmittance[RF_PACKET];     // of each ray, 1 to begin with
} RfQuery;

// Lets rays through where the surface is cut out; where it is blended, rays
// with the chance that their own bits decide, and segments, which lose a part.
void rf_filter_hits( const struct RTCFilterFunctionNArguments* args );

#endif
