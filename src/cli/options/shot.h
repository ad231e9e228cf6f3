// What commands that look at a render before it is made need: its scene, its
// camera's path, the frames asked for, and rays.
#ifndef REFRAME_CLI_OPTIONS_SHOT_H
#define REFRAME_CLI_OPTIONS_SHOT_H

#include "cli/options/render_options.h"
#include "reframe/camera.h"
#include "scene/json/scene_file.h"

typedef struct RfShot
{
    RfSceneFile file; // options may point into it
    RfScene scene;
    RfCameraPath path;
    int* frames; // indices from 0
    int frame_count;
    RfTracer* tracer;
} RfShot;

// Takes the defaults of a scene file into the options, under what the command line says.
typedef RfResult RfTakeDefaults( const RfField* defaults, void* user, RfError* error );

// Loads what `options` name, after `take` had the scene file's defaults, if it has
// any. Warnings go to standard error as the command's. Free with rf_destroy_shot,
// on failure too.
RfResult rf_load_shot( const char* command, const RfRenderOptions* options, RfTakeDefaults* take, void* user, RfShot* shot,
                       RfError* error );
void rf_destroy_shot( RfShot* shot );

// Why a setting is left out, with the least budget where it does not fit: "does
// not fit the memory, the least is 2644K". NULL where it is not left out.
const char* rf_tell_excluded( const char* excluded, const RfMemoryFit* fit, char* text, size_t size );

#endif
