// Internal to this folder: Embree's scene. Alpha-masked and alpha-blended triangles and thin panes
// are a geometry with a filter function; scenes without any have a single geometry.
//
// Triangles that reach far beyond what is looked at, such as a ground of kilometres under a room: Embree's arithmetic in
// floats starts at vertex 0, and hits have an error in proportion to their distance from it, unless the triangle is parallel to
// an axis plane. Where that is too much, hits are checked in doubles.
#ifndef REFRAME_TRACE_BVH_H
#define REFRAME_TRACE_BVH_H

#include "scene/mirrors.h"
#include "scene/scene.h"
#include "trace/embree.h"
#include "trace/trace.h"

typedef struct RfBvh
{
    const RfScene* scene;
    const RfTriangleRecord* triangles; // set by the owner
    RTCScene embree_scene;
    bool blended;          // some triangles are alpha-blended
    bool panes;            // some may be thin panes
    bool any_blended;      // some triangles are blended, and not because it is forced
    bool halved;           // packets are traced in halves (trace/embree.h)
    bool partial;          // one of the two, and not because it is forced
    float scale;           // of Embree's scene and its rays over the scene: a power of two, 1 but for tiny and huge scenes
    float far_error;       // triangles beyond this error are checked (trace/bvh.h)
    uint32_t masked_first; // first index in `order` that has the filter: masked, blended, panes and far triangles
    uint32_t* order;       // scene triangles in the order of the two geometries; NULL: original order
} RfBvh;

// Builds the BVH. The filter keeps the address of `bvh`, which must not move. Embree's errors
// are reported to the device's error handler.
RfResult rf_build_bvh( RTCDevice device, const RfScene* scene, RfBvh* bvh, RfError* error );

// A scene of the mirrors' triangles alone, in their order; NULL if there are none.
RTCScene rf_build_mirror_scene( RTCDevice device, const RfScene* scene, float scale, const RfMirrors* mirrors );

// Releases Embree's scene.
void rf_destroy_bvh( RfBvh* bvh );

// Converts primitive ids within a geometry to triangle indices of the scene; needed if `order`
// is set.
void rf_restore_order( const RfBvh* bvh, int count, const unsigned int* geometry, uint32_t* triangle );

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

// Whether hits on this triangle may have an error above far_error.
bool rf_is_far_triangle( const RfTriangles* triangles, uint32_t triangle, float far_error );

#endif
