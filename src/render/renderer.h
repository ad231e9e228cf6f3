// A render: what is settled before it begins, and its state. Shared by the files of the driver.
#ifndef REFRAME_RENDER_RENDERER_H
#define REFRAME_RENDER_RENDERER_H

#include "render/memory/memory.h"
#include "render/surface_layers.h"
#include "render/worlds.h"
#include "scene/light_groups.h"

#define RF_NO_FRAME ( -2 ) // not even the one before the first

// What is settled before the first pass.
typedef struct RfRenderSetup
{
    RfShot shot;
    RfRenderSettings settings; // resolved
    RfRenderCallbacks callbacks;
    RfGroupPlan plan;
    RfMemoryFit fit;
    RfRenderSizes sizes;
    RfSceneTraits traits;
    RfPixelFilter filter;                    // made unless the settings have the plain one
    RfLightGroups groups;                    // that light is split by
    char* group_names[RF_LIGHT_GROUPS_MOST]; // of their layers
    RfTracer* split;                         // the shot's tracer then; NULL: the caller's own
} RfRenderSetup;

// Frames asked for whose films are held at once, or follow each other through the films of a group.
typedef struct RfSweep
{
    const int* frames; // ascending
    int count;
} RfSweep;

// Where a render is: after so many batches of a pass of a group.
typedef struct RfPlace
{
    int group, pass, batches;
} RfPlace;

// A group that is rendered until a goal is reached.
typedef struct RfUntil
{
    int done, next, due; // passes: done, before the next decision, wanted
    RfNoiseEstimates estimates;
} RfUntil;

// A render under way. state.c saves what a later one needs to go on.
struct RfRenderer
{
    const RfRenderSetup* setup;
    RfSweep sweep;
    int first_sweep; // frames of the first sweep, where it was begun before; 0: as the plan has it
    RfPlace at;
    bool resuming; // until the pass at this place goes on
    RfStop stop;   // with settings.noise, flicker or time
    RfUntil until;
    char* compiled; // groups of 1, 2, … frames (RfEstimatorGroup.compiled); NULL: there is nothing
    RfRenderMemory memory;
    RfFrameQueue queue;
    RfWorlds worlds;
    RfGuide* learned;          // by the pilot; NULL: nothing
    const RfGuide* guide;      // of paths: that, or the settings'; NULL: none
    RfClampThresholds* clamps; // by frame of the path: thresholds; NULL without a clamp
    RfSurfaceTables surfaces;  // what they are called
    int* traced_jobs;          // of a pass, with settings.pieces; NULL: all jobs
    RfRayCounts rays;
    double start, last_frame; // seconds
    double batches_done, batches_all;
    double share;        // of the work, as last reported
    double next_preview; // not before this time
    int frames_done;
    int adaptive_frames; // of these with extra samples
    double last_relmse;  // of the last finished frame
    bool last_is_lower_bound;
    double last_flicker; // of the last pair that it finished
    bool last_flicker_is_lower_bound;
    int kept_frame; // whose errors memory.kept_errors holds
};

// A pass of a group.
typedef struct RfPass
{
    const RfEstimatorGroup* group;
    int number;
    int half;   // of the films that it goes to
    int weight; // in the mean of a frame
} RfPass;

RfPass rf_make_pass( const RfEstimatorGroup* estimator_group, const RfGroup* group, int number );

// What is done with a batch when it is traced, by the thread that did it; `scratch` is the estimator's.
typedef void RfTracedFn( RfRenderer* renderer, const RfPass* pass, int eye, const void* batch, const void* scratch, void* user );

// Traces batches [first, first + count) of a pass in parallel, those beyond its last of the passes that follow, into memory.batches[0 … count), and counts their rays.
void rf_trace_batches( RfRenderer* renderer, const RfPass* pass, int first, int count, RfTracedFn* traced, void* user );

// Rows of a frame of the group as one of `bands` jobs.
RfAccumulateJob rf_accumulate_job( const RfRenderer* renderer, RfLiveFilm* live, const RfPass* pass, int band, int bands );

// Compiles the groups, before all else that is done with them.
RfResult rf_compile_groups( RfRenderer* renderer, RfError* error );

// A group of so many frames compiled.
static inline const void* rf_compiled( const RfRenderer* renderer, int eye_count )
{
    size_t each = renderer->setup->sizes.of_estimator.compiled;
    return renderer->compiled != NULL ? renderer->compiled + (size_t)( eye_count - 1 ) * each : NULL;
}

// Group `number` of the path as the estimator sees it.
RfEstimatorGroup rf_estimator_group( RfRenderer* renderer, int number );

// Any `eye_count` frames of the path from `first_frame` on, as a group with the random numbers of `number`.
RfEstimatorGroup rf_frames_as_group( RfRenderer* renderer, int first_frame, int eye_count, int number );

// sum += part
void rf_add_rays( RfRayCounts* sum, const RfRayCounts* part );

// Makes the picture of a frame's films; returns the estimate of its relMSE.
RfRelmse rf_finish_picture( const RfRenderer* renderer, const RfLiveFilm* live, RfPicture* picture );

// Does memory.kept_errors hold the frame before, of the same shot?
static inline bool rf_is_kept_before( const RfRenderer* renderer, int frame )
{
    return renderer->kept_frame == frame - 1 && rf_share_shot( &renderer->setup->plan, frame - 1, frame );
}

// The film of a frame in use, −1 for a free one; NULL where there is none.
RfLiveFilm* rf_find_film( const RfRenderer* renderer, int frame );

#endif
