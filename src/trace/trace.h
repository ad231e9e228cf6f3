// Embree behind a small door: nearest hits and occlusion, always for arrays of
// rays, as structures of arrays. Rays are traced in packets of 16 in the order
// given; what lies next to each other in the arrays should be close in space.
#ifndef REFRAME_TRACE_TRACE_H
#define REFRAME_TRACE_TRACE_H

#include "light/light.h"
#include "scene/scene.h"

#include <stddef.h>
#include <stdint.h>

typedef struct RfTracer RfTracer;

// Builds the BVH of a scene, which must outlive the tracer. An empty scene is
// allowed: every ray misses.
RfResult rf_create_tracer( const RfScene* scene, RfTracer** tracer, RfError* error );
void rf_destroy_tracer( RfTracer* tracer );

const RfScene* rf_tracer_scene( const RfTracer* tracer );
// Does some surface let part of the light through (alpha blending)? Then
// visibility is any number from 0 to 1.
bool rf_tracer_is_blended( const RfTracer* tracer );
// Has some material of it what hits must look up (RfMaterial.textured)?
bool rf_tracer_is_textured( const RfTracer* tracer );
// The lights of the scene, collected at creation (light/light.h).
const RfLights* rf_tracer_lights( const RfTracer* tracer );
// What the image depends on besides the scene: Embree's version and instruction set.
const char* rf_tracer_device( const RfTracer* tracer );
// Memory that Embree holds, bytes.
size_t rf_tracer_bytes( const RfTracer* tracer );

#define RF_MISS 0xffffffffu

// What a surface is at a triangle, in one place: a hit reads one of these.
// Edges and normal differences are relative to vertex 0, for barycentrics u, v.
typedef struct RfTriangleRecord
{
    RfVec3 p0, e1, e2; // position = p0 + u e1 + v e2
    RfVec3 n0, d1, d2; // shading normal = n0 + u d1 + v d2, not unit
    RfVec3 ng;         // unit geometric normal of the front
    uint32_t material;
    uint32_t light; // index into RfLights, or RF_NO_LIGHT
    uint32_t flat;  // 1: the shading normal is the geometric one
    float offset;   // what lifts a point off this triangle (rf_ray_offset)
} RfTriangleRecord;

const RfTriangleRecord* rf_tracer_triangles( const RfTracer* tracer );

// Nearest hits of `count` rays o + t d, t > 0: triangle index (RF_MISS where
// there is none) and barycentrics. `coherent` is a hint for the traversal.
// A blended surface is met with the chance of its alpha, which the bits of the
// ray decide.
void rf_trace_nearest( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], bool coherent,
                       uint32_t* triangle, float* u, float* v );

// The part of the light that gets through on the segments from o to o + d: 1
// or 0, or between where blended surfaces are in the way.
void rf_trace_segments( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], float* visible );

// Segments from one common origin to points, in packets (estimators.md 8):
// tested where weight > 0, which is multiplied by the part that gets through.
// Returns how many were tested.
int rf_trace_from_origin( const RfTracer* tracer, RfVec3 origin, int count, const float* const point[3], float* weight );

// Set flush-to-zero for this thread: call at the top of main and of every
// parallel region, so that results do not depend on the thread.
void rf_set_float_mode( void );

#endif
