// Which surface a triangle number names: a triangle in world space, or one of a mesh at the place of the world where
// a placement puts it.
#ifndef REFRAME_SCENE_PLACEMENT_H
#define REFRAME_SCENE_PLACEMENT_H

#include "scene/scene.h"

#include <stdint.h>

typedef struct RfTriangleAt
{
    const RfTriangles* triangles;
    uint32_t index;               // in them
    const RfPlacement* placement; // NULL: they are in world space
} RfTriangleAt;

// A triangle of a placement.
RfTriangleAt rf_locate_placed_triangle( const RfScene* scene, uint32_t triangle );

static inline RfTriangleAt rf_locate_triangle( const RfScene* scene, uint32_t triangle )
{
    return triangle < scene->triangles.count ? ( RfTriangleAt ){ &scene->triangles, triangle, NULL }
                                             : rf_locate_placed_triangle( scene, triangle );
}

#endif
