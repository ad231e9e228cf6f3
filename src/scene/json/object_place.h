// What `objects` of a scene file do to a scene: they move nodes of its file, and place other files in it.
#ifndef REFRAME_SCENE_JSON_OBJECT_PLACE_H
#define REFRAME_SCENE_JSON_OBJECT_PLACE_H

#include "scene/gltf/gltf.h"
#include "scene/json/object.h"

// Finds the nodes that objects name, in the document of the scene's own file, and appends what places, hides and moves them to
// `channels` (RfGltfOptions), which has room for 5 for each object. Fails where a name is not that of one node.
RfResult rf_find_nodes( const RfObjects* objects, const json_t* root, RfChannel* channels, int* count );

// Loads the files that objects place and makes them part of the scene, of so many frames per second: frozen at a time, in seconds,
// unless that is NULL.
RfResult rf_place_files( const RfObjects* objects, RfFps fps, const double* frozen_at, RfScene* scene, RfLog* log );

#endif
