// Inside of trace.c: Embree's scene. Triangles that may be cut out by their
// alpha, or are blended, are a geometry with a filter; scenes without them have
// none of that.
#ifndef REFRAME_TRACE_BVH_H
#define REFRAME_TRACE_BVH_H

#include "scene/scene.h"

#include <embree3/rtcore.h>

typedef struct RfBvh
{
    const RfScene* scene;
    RTCScene embree_scene;
    bool blended;          // some let part of the light through
    uint32_t masked_first; // first of the order below that has the filter
    uint32_t* order;       // the scene's triangles in the order of the two geometries; NULL: the scene's own order
} RfBvh;

// The filter keeps the address of `bvh`, which must not move. Failures of
// Embree go to the device's error handler.
RfResult rf_build_bvh( RTCDevice device, const RfScene* scene, RfBvh* bvh, RfError* error );
void rf_destroy_bvh( RfBvh* bvh );

// From numbers within a geometry to the scene's; needed where there is an order.
void rf_restore_order( const RfBvh* bvh, int count, const unsigned int* geometry, uint32_t* triangle );

#endif
