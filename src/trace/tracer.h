// Internal to this folder: a scene ready for rays.
#ifndef REFRAME_TRACE_TRACER_H
#define REFRAME_TRACE_TRACER_H

#include "light/changing.h"
#include "light/light.h"
#include "scene/mirrors.h"
#include "scene/placement.h"
#include "trace/bvh.h"
#include "trace/occluders.h"
#include "trace/trace.h"

struct RfGhosts
{
    RTCScene embree_scene;
    float reach;   // as that of RfLights, in all frames of the group
    RfBoxes boxes; // in the world
};

struct RfTracer
{
    RfTracerRecords known; // first member: rf_tracer_records
    const RfTracer* still; // with which all that stands still is shared, of the scene as it was loaded; NULL: this has it
    float own_reach;       // as lights.reach, without ghosts
    const RfGhosts* ghosts;
    const RfScene* scene;
    float moment; // of rays, where the shutter is open: that of the scene
    RTCDevice device;
    RfBvh bvh;
    RfLights lights;
    RfMirrors mirrors;
    RfChainBounds chain_bounds;
    const RfOccluderList* occluders; // of what stands still; posed tracers share them
    RTCScene mirror_scene;           // the triangles of the mirrors alone; NULL: none
    RfTriangleRecord* triangles;     // `known`, owned
    bool textured;
    long bytes;
    char text[64];
    char message[256]; // the first error of Embree
};

// The first error of Embree, in the tracer that has the device; empty: none.
static inline const char* rf_tracer_error( const RfTracer* tracer )
{
    return tracer->still != NULL ? rf_tracer_error( tracer->still ) : tracer->message;
}

// As rf_trace_segments and rf_trace_segments_past_panes (trace/trace.h), of those segments that are listed; NULL: the first `count`.
void rf_trace_listed_segments( const RfTracer* tracer, int count, const int32_t* listed, const float* const o[3],
                               const float* const d[3], float* visible, const RfPaneLanes* panes );

// Frees what a posed tracer does not share.
void rf_destroy_posed_tracer( RfTracer* tracer );

// Makes the records of the triangles in world space.
RfResult rf_fill_records( RfTracer* tracer, RfError* error );

// The record of a placement's triangle, made at `place`.
void rf_make_placed_record( const RfTracer* tracer, const RfTriangleAt* at, RfTriangleRecord* place );

#endif
