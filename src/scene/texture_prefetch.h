// Fetches what lookups in textures are about to read into the cache, for many points at once: in large scenes most of the time
// of a lookup is spent waiting for memory.
#ifndef REFRAME_SCENE_TEXTURE_PREFETCH_H
#define REFRAME_SCENE_TEXTURE_PREFETCH_H

#include "scene/scene.h"

// A point on a triangle, by barycentrics, with a material that has `textured`.
typedef struct RfTexturedPoint
{
    const RfMaterial* material;
    uint32_t triangle;
    float u, v;
} RfTexturedPoint;

// Changes nothing but the time that rf_material_at and the other lookups of scene/textured.h take at these points.
void rf_prefetch_textures( const RfScene* scene, const RfTexturedPoint* points, int count );

#endif
