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

struct RfSwept
{
    RTCScene embree_scene;
    float reach;   // as that of RfLights, in all frames of the group
    RfBoxes boxes; // in the world
};

struct RfTracer
{
    RfTracerRecords known; // first member: rf_tracer_records
    const RfTracer* still; // with which all that stands still is shared, of the scene as it was loaded; NULL: this has it
    float own_reach;       // as lights.reach, without swept geometry
    const RfSwept* swept;
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
RfResult rf_fill_records( RfTracer* tracer, RfError* error );

// Triangles that reach far beyond what is looked at, such as a ground of kilometres under a room. Embree's arithmetic in floats
// starts at vertex 0, and hits have an error in proportion to their distance from it, unless the triangle is parallel to an axis
// plane. Where that is too much, hits are checked in doubles.

// Embree takes the edges, their cross product N, and N·(p0 − o): at most 8 roundings of 2⁻²⁴ each.
#define RF_EMBREE_ERROR 5e-7f

// How far off its plane Embree may find a triangle that it starts `way` from vertex 0: the products in
// N·way, without their signs, over the length of N.
float rf_embree_error( RfVec3 e1, RfVec3 e2, RfVec3 way );

// Whether hits on this triangle may have an error above far_error. Of a mesh that is placed any of such an extent may have: what its
// corners add to the error where the matrix turns it is not known.
static inline bool rf_is_far_triangle( const RfTriangles* t, uint32_t triangle, float far_error, bool placed )
{
    RfVec3 p0 = rf_corner( t, triangle, 0 );
    RfVec3 e1 = rf_sub( rf_corner( t, triangle, 1 ), p0 ), e2 = rf_sub( rf_corner( t, triangle, 2 ), p0 );
    RfVec3 extent = { rf_maxf( fabsf( e1.x ), fabsf( e2.x ) ), rf_maxf( fabsf( e1.y ), fabsf( e2.y ) ),
                      rf_maxf( fabsf( e1.z ), fabsf( e2.z ) ) };
    // slivers have a large bound, but their area is small
    return rf_largest_coordinate( extent ) * 3.0f * RF_EMBREE_ERROR > far_error &&
           ( placed || rf_embree_error( e1, e2, extent ) > far_error );
}

// The distance, in lengths of d, at which the ray crosses the plane of the triangle, in doubles; false if it
// runs parallel to it.
bool rf_cross_plane( const RfTriangleRecord* t, RfVec3 o, RfVec3 d, double* distance );

// For a matrix whose entries are rounded by these magnitudes.
RfPlacedBvh rf_note_matrix( const RfMat4* matrix, const RfMat4* most );

#endif
