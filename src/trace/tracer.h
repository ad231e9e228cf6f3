// Internal to this folder: a scene ready for rays.
#ifndef REFRAME_TRACE_TRACER_H
#define REFRAME_TRACE_TRACER_H

#include "light/light.h"
#include "scene/chain_bounds.h"
#include "trace/bvh.h"
#include "trace/trace.h"

struct RfTracer
{
    const RfScene* scene;
    RTCDevice device;
    RfBvh bvh;
    RfLights lights;
    RfMirrors mirrors;
    RfChainBounds chain_bounds;
    RTCScene mirror_scene; // the triangles of the mirrors alone; NULL: none
    RfTriangleRecord* triangles;
    bool textured;
    long bytes;
    char text[64];
    char message[256]; // the first error of Embree
};

#endif
