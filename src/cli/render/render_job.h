// Internal to `reframe render`: its state, and all that is loaded and settled before the first ray.
#ifndef REFRAME_CLI_RENDER_RENDER_JOB_H
#define REFRAME_CLI_RENDER_RENDER_JOB_H

#include "cli/messages.h"
#include "cli/options/effect_options.h"
#include "cli/options/render_options.h"
#include "cli/render/frame_errors.h"
#include "cli/render/progress.h"
#include "reframe/output.h"
#include "scene/json/scene_file.h"

#include <jansson.h>
#include <pthread.h>

// State of a render, created in this order and freed by rf_destroy_render_job.
typedef struct RfRenderJob
{
    int argc; // the command line, which overrides the scene file that is read later
    char** argv;
    RfRenderOptions options;
    RfRenderSettings asked; // before they were resolved
    RfMemoryFit fit;
    RfLog log;
    RfToldWarnings told;
    RfSceneFile file; // options may point into it
    RfScene scene;
    RfCameraPath path;
    int* frames; // to be written, indices from 0
    int frame_count;
    int* runs; // of the path that hold them: to be rendered
    int run_count;
    int* kept; // by --resume, likewise
    int kept_count;
    RfTracer* tracer;
    RfEffect effects[RF_MAX_EFFECTS]; // by path and settings
    int effect_count;
    char calls_for[RF_EFFECTS_TEXT_SIZE]; // their names
    RfOutput output;
    pthread_mutex_t speech; // guards messages: frames are written by another thread
    RfProgressLine line;
    int frames_done;
    bool told_black; // the warning comes once
    RfFrameErrors errors;
    json_t* frames_json;
    double start, seconds_scene; // monotonic time of the start; seconds until rays can be traced
    RfRenderStats stats;
} RfRenderJob;

// Loads the scene, the path and the frames of the options, and settles what is left to render: told on standard error.
RfResult rf_load_render_job( RfRenderJob* job, RfError* error );

void rf_destroy_render_job( RfRenderJob* job );

// What can be warned of before the work.
void rf_warn_before_render( RfRenderJob* job );

#endif
