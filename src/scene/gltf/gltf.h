// A strict reader of glTF 2.0 (.gltf and .glb) over jansson. Everything that a
// file may get wrong is an error line that names the file and the object.
#ifndef REFRAME_SCENE_GLTF_GLTF_H
#define REFRAME_SCENE_GLTF_GLTF_H

#include "scene/scene.h"

// Loads the default scene of a file, baked to world space. What the file asks
// for and we do not have is named once each in the log. On failure `scene` is
// left empty and nothing leaks.
RfResult rf_load_gltf( const char* path, RfScene* scene, RfLog* log, RfError* error );

#endif
