// Internal to this folder: Embree's filter function for alpha-masked and alpha-blended surfaces
// and thin panes.
#ifndef REFRAME_TRACE_FILTER_H
#define REFRAME_TRACE_FILTER_H

#include "trace/bvh.h"

#define RF_PACKET 16

typedef enum RfQueryKind
{
    RF_QUERY_NEAREST,  // find the nearest hit
    RF_QUERY_SEGMENTS, // accumulate transmittance and panes
    RF_QUERY_PANES,    // accumulate the panes before hits that are known
} RfQueryKind;

// The query that a packet belongs to; the ids of its rays are their lanes.
typedef struct RfQuery
{
    RfRayContext context; // first member: Embree passes its address to the filter
    RfQueryKind kind;
    bool pass_panes; // else panes are surfaces like any others
    bool passed;     // some pane was passed
    int traps;       // of the caller (base/float_traps.h)
    // per ray, initially 1
    float transmittance[RF_PACKET];
    float pane_probability[RF_PACKET];
    float pane_weight[3][RF_PACKET];
    uint32_t hit[RF_PACKET]; // RF_QUERY_PANES: the triangle hit, which was not passed
} RfQuery;

// Rejects hits where the surface is masked out. On a blended surface, rays hit with
// probability alpha, by a hash of the ray; segments are attenuated by 1 − alpha. Thin panes
// are passed likewise, and their factors accumulated for segments.
void rf_filter_hits( const struct RTCFilterFunctionNArguments* args );

#endif
