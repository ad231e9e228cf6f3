// Internal to `reframe render`: its state.
#ifndef REFRAME_CLI_RENDER_RENDER_COMMAND_H
#define REFRAME_CLI_RENDER_RENDER_COMMAND_H

#include "cli/messages.h"
#include "cli/options/render_options.h"
#include "cli/render/films_file.h"
#include "cli/render/preview_output.h"
#include "cli/render/progress.h"
#include "reframe/camera.h"
#include "reframe/effects.h"
#include "reframe/output.h"
#include "reframe/plan.h"
#include "reframe/render.h"
#include "scene_file/scene_file.h"

#include <jansson.h>
#include <pthread.h>

// The errors that finished frames have by their own estimates: their mean and the worst, for the last line and the warnings.

typedef struct RfFrameErrors
{
    int frames;
    double relmse_sum;  // of the frames' estimates
    double likely_sum;  // and of their best guesses
    double removed_sum; // of the shares of light that were taken out
    bool removes;
    int lower_bounds;   // among them
    int missed;         // frames above --noise
    int flicker_missed; // and above --flicker, with the frame before
    double worst_flicker;
    int worst_pair; // its later frame
    double worst_relmse;
    int worst_frame; // its number
    bool worst_is_lower_bound;
    int roughly, not_solved;           // frames whose reconstruction stopped early, or failed
    int first_rough, first_not_solved; // the number of the first of them
} RfFrameErrors;

// State of a render, created in this order and freed by the command.
typedef struct RfRenderJob
{
    int argc; // the command line, which overrides the scene file that is read later
    char** argv;
    RfRenderOptions options;
    RfRenderSettings asked; // before they were resolved
    RfMemoryFit fit;
    RfHalo halo; // of the frames that are rendered
    RfLog log;
    RfReportedWarnings reported;
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
    bool reported_black; // the warning comes once
    RfFrameErrors errors;
    FILE* films;           // of an interrupted render, which this one goes on from; NULL: from the beginning
    RfFilmsWriter keeping; // those of this one
    int kept_films;        // the first frame of the last that are in a file; −1: none are
    RfError not_kept;      // why the last were not; RF_OK: they were, or there are none
    RfAutosave autosave;
    RfLivePreview preview;
    RfDenoiser* denoiser; // with --denoise
    pthread_mutex_t denoising;
    RfError not_judged; // why a frame in work could not be denoised
    RfDenoisedSums denoised;
    double noisy_sum; // of relMSE before, of frames whose error is known
    json_t* frames_json;
    double start, seconds_scene; // monotonic time of the start; seconds until rays can be traced
    RfRenderStats stats;
} RfRenderJob;

#endif
