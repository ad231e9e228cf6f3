// Joins scenes: what is placed in a scene from another file becomes part of it.
#ifndef REFRAME_SCENE_MERGE_H
#define REFRAME_SCENE_MERGE_H

#include "scene/scene.h"

// Gives each triangle vertices of its own. False if there is no memory: the triangles are to be destroyed.
bool rf_spread_vertices( RfTriangles* t );

// Appends triangles, whose materials become those from `first_material` on; without those that have collapsed to two equal
// corners. Attributes that only one of the lists has are filled in. False if there is no memory: `to` is to be destroyed.
bool rf_append_triangles( RfTriangles* to, const RfTriangles* from, uint32_t first_material );

// Moves all of a scene that has the same origin into another: triangles, meshes, placements and what moves them, materials with
// textures, lamps, nodes with their channels, and what the file or its program warns of, after `name`. Its cameras, its
// environment and its film are left behind. `placed` is destroyed. Fails with RF_ERROR_MEMORY, or RF_ERROR_UNSUPPORTED where there
// are too many triangles; `scene` is then still to be destroyed.
RfResult rf_merge_scene( RfScene* scene, RfScene* placed, const char* name, RfError* error );

#endif
