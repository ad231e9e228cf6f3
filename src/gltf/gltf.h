// A strict reader of glTF 2.0 (.gltf and .glb), with jansson. Every violation of the
// specification is an error that names the file and the object.
#ifndef REFRAME_GLTF_GLTF_H
#define REFRAME_GLTF_GLTF_H

#include "base/json.h"
#include "scene/scene.h"

// Loads the default scene of a file, transformed to world space. Unsupported features that the
// file uses are logged once each. What moves becomes placements that rf_pose_scene poses, and what cannot be rendered so
// is listed in scene->unrendered. On failure `scene` is left empty.
RfResult rf_load_gltf( const char* path, RfScene* scene, RfLog* log, RfError* error );

// How a file is read; zeros are as rf_load_gltf reads it.
typedef struct RfGltfOptions
{
    bool freeze;               // all but cameras stands still, as in the first frame of the default camera: scene->frozen
    const char* animation;     // those of this name go before the others, where several move the same; NULL: the first
    bool accept_losses;        // textures that cannot be read are left out: scene->losses
    const char* variant;       // whose materials its primitives have; NULL: their own
    RfField materials, lights; // of a scene file: what it says of them by their names (gltf.c), in the
                               // place of what the glTF says; without json: nothing
    // Is shown the document before it is read, and may set `channels`; NULL: nobody is.
    RfResult ( *survey )( void* user, const json_t* root, RfError* error );
    void* user;
    int channel_count;
    const RfChannel* channels; // from elsewhere, in the place of those of the file, and copied; without keys: a value that
                               // stands still
    const char* top;           // a node of this name has all of the file below it, and the channels of node −1; or NULL
    bool no_environment;       // that of the file is left out
    const RfClock* clock;      // of the animations of the file, all of whose keys are played: start, speed, loops; or NULL
    const double* origin;      // that the scene gets; NULL: its own
    RfFps fps;                 // of image sequences that do not say, and of keys of materials; 0/0: those of the file
    bool* in_frames;           // set where keys of materials are numbers of frames; or NULL
    const double* frozen_at;   // seconds; NULL: as in the first frame of its own default camera
} RfGltfOptions;

// When the default camera has its first frame: at 0 s, unless its path begins with the number of another.
double rf_gltf_first_time( const RfScene* scene );

// Fails with RF_ERROR_USAGE, naming those there are, if no animation or variant has the name asked for.
RfResult rf_load_gltf_with( const char* path, const RfGltfOptions* options, RfScene* scene, RfLog* log, RfError* error );

#endif
