// A strict reader of glTF 2.0 (.gltf and .glb), with jansson. Every violation of the
// specification is an error that names the file and the object.
#ifndef REFRAME_SCENE_GLTF_GLTF_H
#define REFRAME_SCENE_GLTF_GLTF_H

#include "scene/scene.h"

// Loads the default scene of a file, transformed to world space. Unsupported features that the
// file uses are logged once each. What moves becomes placements that rf_pose_scene poses, and what cannot be rendered so
// is listed in scene->unrendered. On failure `scene` is left empty.
RfResult rf_load_gltf( const char* path, RfScene* scene, RfLog* log, RfError* error );

// How a file is read; zeros are as rf_load_gltf reads it.
typedef struct RfGltfOptions
{
    bool freeze;                   // all but cameras stands still, as in the first frame of the default camera: scene->frozen
    const char* animation;         // those of this name go before the others, where several move the same; NULL: the first
    const char* variant;           // whose materials its primitives have; NULL: their own
    const struct RfGltfEdit* edit; // of the document, before it is read (scene/gltf/gltf_document.h); or NULL
    int channel_count;
    const RfChannel* channels; // from elsewhere, in the place of those of the file; without keys: in the place of what moves
                               // there, which stands still. Read after the edit; copied
    int change_count;
    const struct RfChange* changes; // of materials by their numbers, which nothing in the file changes; set by the edit
    int override_count;
    const struct RfOverride* overrides; // likewise
    const RfClock* clock;    // of the animations of the file, all of whose keys are played: start, speed, loops; or NULL
    const double* origin;    // that the scene gets; NULL: its own
    const char* beside;      // the file that names the image sequences that the edit adds, which lie beside it
    RfFps fps;               // of image sequences that do not say; 0/0: the frames per second of the file
    const double* frozen_at; // seconds; NULL: as in the first frame of its own default camera
} RfGltfOptions;

// When the default camera has its first frame: at 0 s, unless its path begins with the number of another.
double rf_gltf_first_time( const RfScene* scene );

// Fails with RF_ERROR_USAGE, naming those there are, if no animation or variant has the name asked for.
RfResult rf_load_gltf_with( const char* path, const RfGltfOptions* options, RfScene* scene, RfLog* log, RfError* error );

#endif
