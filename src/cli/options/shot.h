// What tune and cost load before they work: scene, camera path, the frames asked
// for, and a tracer.
#ifndef REFRAME_CLI_OPTIONS_SHOT_H
#define REFRAME_CLI_OPTIONS_SHOT_H

#include "cli/options/render_options.h"
#include "reframe/camera.h"
#include "reframe/render.h"
#include "scene_file/scene_file.h"

typedef struct RfLoadedShot
{
    RfSceneFile file; // options may point into it
    RfScene scene;
    RfCameraPath path; // its frames are the runs of the camera's: equal frames are rendered once
    int* frames;       // of these to be rendered, indices from 0
    int frame_count;
    int* asked; // numbers of all frames asked for, equal ones too, and the run of each
    int* asked_runs;
    int asked_count;
    RfTracer* tracer;
    double beyond_depth; // share of the light (rf_find_light_beyond_depth)
} RfLoadedShot;

// Takes a scene file's defaults into the options; the command line overrides them.
typedef RfResult RfTakeDefaults( const RfField* defaults, void* user, RfError* error );

// Loads what `options` name, after `take` was called with the scene file's defaults, if it
// has any. The size becomes that of the path. Warnings go to standard error. Free with rf_destroy_shot, on failure too.
RfResult rf_load_shot( const char* command, RfRenderOptions* options, RfTakeDefaults* take, void* user, RfLoadedShot* shot,
                       RfError* error );
void rf_destroy_shot( RfLoadedShot* shot );

// What is rendered of it.
static inline RfShot rf_shot_to_render( const RfLoadedShot* loaded )
{
    return ( RfShot ){ loaded->tracer, loaded->path.eyes, loaded->path.count, loaded->frames, loaded->frame_count };
}

// What loading, begun at `start`, has left of a budget of seconds, at least half of it, and when that is well over: both on
// rf_wall_seconds.
double rf_budget_left( double budget, double start, double* deadline );

// Warns where max_depth takes light, and says its share; 0 without a limit.
RfResult rf_warn_of_depth( const RfShot* shot, const RfRenderSettings* settings, RfLog* log, double* share, RfError* error );

// The runs of the path that hold any of the frames, ascending, and their number: what is to be rendered. The
// caller frees them; NULL where memory ran out.
int* rf_runs_of_frames( const RfCameraPath* path, const int* frames, int frame_count, int* run_count );

// Why a row of a plan is excluded, with the least budget where it does not fit: "does
// not fit in memory, needs at least 3M". NULL where it is not left out.
const char* rf_format_excluded( const char* excluded, const RfMemoryFit* fit, char* text, size_t size );

#endif
