// Any scene that a command can be given: a .glb or .gltf, or a scene file of
// ours (*.json) that names one and adds what it lacks: camera path, environment,
// materials by name, defaults of a render. scenes/scene.schema.json tells the format.
#ifndef REFRAME_SCENE_JSON_SCENE_FILE_H
#define REFRAME_SCENE_JSON_SCENE_FILE_H

#include "scene/json/json_document.h"
#include "scene/scene.h"

typedef struct RfSceneFile
{
    char* path;
    RfJsonDocument document; // empty for glTF
} RfSceneFile;

// Opens a scene: of a scene file the text is parsed, of glTF nothing is read
// yet. On failure it is empty; free with rf_close_scene_file.
RfResult rf_open_scene_file( const char* path, RfSceneFile* file, RfError* error );
void rf_close_scene_file( RfSceneFile* file );

// The object of defaults for a render, not looked into; its json is NULL where
// there is none. Valid while the file is open.
RfField rf_scene_file_defaults( const RfSceneFile* file, RfError* error );

// Loads what the file says; see rf_load_gltf. The scene's content hash covers
// the scene file, its camera path and its map too.
RfResult rf_load_scene_file( const RfSceneFile* file, RfScene* scene, RfLog* log, RfError* error );

// All three in one, for those who want no defaults.
RfResult rf_load_scene( const char* path, RfScene* scene, RfLog* log, RfError* error );

#endif
