// Opens any scene that a command accepts: a .glb or .gltf, or a scene file (*.json) that
// refers to one and adds what glTF lacks: camera path, environment, overrides of materials,
// render defaults. The format is described by scenes/scene.schema.json.
#ifndef REFRAME_SCENE_FILE_SCENE_FILE_H
#define REFRAME_SCENE_FILE_SCENE_FILE_H

#include "base/json.h"
#include "gltf/gltf.h"
#include "scene/scene.h"

typedef struct RfSceneFile
{
    char* path;
    RfJsonDocument document; // empty for glTF
} RfSceneFile;

// Opens a scene: parses a scene file; of a glTF nothing is read yet. On failure the file is
// empty; free with rf_close_scene_file.
RfResult rf_open_scene_file( const char* path, RfSceneFile* file, RfError* error );

// Frees what an open scene file holds.
void rf_close_scene_file( RfSceneFile* file );

// The object of render defaults, not yet validated; its json is NULL if there is none. Valid
// while the file is open.
RfField rf_scene_file_defaults( const RfSceneFile* file, RfError* error );

// Loads the scene; see rf_load_gltf. Its content hash covers the scene file, its camera path
// and its environment map as well.
RfResult rf_load_scene_file( const RfSceneFile* file, const RfSceneOptions* options, RfScene* scene, RfLog* log, RfError* error );

// Opens, loads and closes, for callers that do not need the defaults.
RfResult rf_load_scene_with( const char* path, const RfSceneOptions* options, RfScene* scene, RfLog* log, RfError* error );
RfResult rf_load_scene( const char* path, RfScene* scene, RfLog* log, RfError* error );

#endif
