// A strict reader of glTF 2.0 (.gltf and .glb), with jansson. Every violation of the
// specification is an error that names the file and the object.
#ifndef REFRAME_SCENE_GLTF_GLTF_H
#define REFRAME_SCENE_GLTF_GLTF_H

#include "scene/scene.h"

// Loads the default scene of a file, transformed to world space. Unsupported features that the
// file uses are logged once each. On failure `scene` is left empty.
RfResult rf_load_gltf( const char* path, RfScene* scene, RfLog* log, RfError* error );

#endif
