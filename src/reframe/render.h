// Renders frames of a camera path with unbiased frame reuse (Méndez Feliu,
// Sbert, Szirmay-Kalos, Reusing Frames in Camera Animation, WSCG 2006;
// estimators.md sections 1 to 3 and 7): harvest and compute over sliding
// groups of 2n+1 frames.
#ifndef REFRAME_RENDER_H
#define REFRAME_RENDER_H

#include "base/arena.h"
#include "image/exr.h"
#include "film/aov.h"
#include "reuse/tile.h"
#include "scene/eye.h"
#include "trace/trace.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum RfWeights
{
    RF_WEIGHTS_EXACT,      // (E1), (E3): the balance heuristic over all eyes
    RF_WEIGHTS_EQ15,       // FR (15): biased, for comparison
    RF_WEIGHTS_UNWEIGHTED, // all hits of a pixel averaged: biased, for comparison
} RfWeights;

typedef enum RfNormalize
{
    RF_NORMALIZE_CROSSFIT, // (E2): unbiased
    RF_NORMALIZE_RATIO,    // A/B: small bias
    RF_NORMALIZE_NONE,     // A: unbiased, noisy
} RfNormalize;

// The files that callbacks->frame writes, for the memory that it takes to write one.
typedef struct RfFrameFiles
{
    bool written; // else the rest does not matter
    bool half;    // colour, and the layers that can be
    RfExrCompression compression;
} RfFrameFiles;

// How the pixels of a frame are estimated.
typedef struct RfEstimator RfEstimator;

// The estimator called `name`; NULL where there is none. "reuse" is the one of frames and tiles.
const RfEstimator* rf_find_estimator( const char* name );
const char* rf_estimator_name( const RfEstimator* estimator );

typedef struct RfRenderSettings
{
    const RfEstimator* estimator;
    int spp;            // native samples per pixel and frame in all; with noise or time about the most
    double noise;       // each frame stops when its estimated relMSE is below; 0: spp are rendered
    double time;        // seconds for each frame asked for, in the mean; 0: as many as it takes
    int group;          // half-width n, cut to the path; RF_GROUP_AUTO: chosen
    RfTile tile;        // pixels of a frame that share their paths
    bool tile_roulette; // Russian roulette on connections in a tile that are worth little
    bool adaptive;      // extra native samples for pixels that few other frames help; RF_WEIGHTS_EXACT only
    RfWeights weights;
    RfNormalize normalize;
    int max_depth;                  // path vertices after the eye
    int light_samples;              // K per vertex
    RfLightSampling light_sampling; // how their lights are picked
    uint64_t seed;
    int threads;        // 0: all cores
    size_t memory;      // budget in bytes; 0: half of what is free
    int queue;          // finished frames, at most, that callbacks->frame is given in a thread of its own
                        // while rendering goes on; fewer where memory is short. 0: it is called in between
    bool hold_all;      // all hit records of a group at once, as the paper has it, packed: for comparison, the
                        // pictures are the same; else as few as serve the threads
    unsigned layers;    // RF_AOV_BIT of those that are wanted besides the colour, which they do not change
    RfFrameFiles files; // part of the budget
} RfRenderSettings;

#define RF_GROUP_AUTO ( -1 )
#define RF_MAX_SPP ( 1 << 20 )
#define RF_MAX_NOISE 1e6
#define RF_MAX_TIME 1e9
#define RF_MAX_GROUP ( 1 << 20 )
#define RF_MAX_DEPTH ( 1 << 20 )
#define RF_MAX_LIGHT_SAMPLES 64
#define RF_MAX_QUEUE 64
#define RF_MAX_IMAGE_SIDE ( 1 << 15 ) // pixels

RfRenderSettings rf_default_render_settings( void );

// The settings as a render of this path will use them: group chosen by the plan
// (reuse/plan.h: some thousand paths are traced for RF_GROUP_AUTO) and cut to
// the path, spp rounded up to what its groups need, threads and memory filled
// in, normalisation that the weights allow. Rendering with the result is the
// same as with the settings. Fails with RF_ERROR_USAGE for values out of range.
RfResult rf_resolve_settings( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                              RfRenderSettings* resolved, RfError* error );

// How a render fits its budget. What is short costs time and changes no pixel:
// fewer threads, batches of hit records one after the other, and where not even
// the films of a group fit, several sweeps over the path, each for some frames.
typedef struct RfMemoryFit
{
    int threads;
    int films;   // held at once
    int sweeps;  // how often the path is gone through, each time for `films` frames; 1: the films all fit
    int batches; // of hit records held at once
    int chunks;  // that a pass of a full group takes
    size_t bytes_films, bytes_hits, bytes_lists; // films and images; hit records; workspaces: index lists, the writing of files
    size_t least;                                // the smallest budget that works
} RfMemoryFit;

// The fit of a render of `frame_count` frames with resolved settings. Fails with
// RF_ERROR_MEMORY, and a line that names the smallest budget, where there is none.
// With hold_all the held records are not in it, nor is it an error: only rf_render
// knows how many there are, and says so before it renders.
RfResult rf_fit_memory( const RfScene* scene, const RfEye* eyes, int eye_count, int frame_count, const RfRenderSettings* settings,
                        RfMemoryFit* fit, RfError* error );

// A finished frame. The pixels are valid during the callback only.
typedef struct RfFrameResult
{
    int frame; // index into the eyes, from 0
    int width, height;
    const float* rgb;    // 3 × width × height
    const float* weight; // width × height: B, the mean of the summed weights; E[B] = 1 with exact weights, else hits per pass
    const float* layers[RF_AOV_COUNT]; // rf_aov_channels × width × height; NULL: not asked for
    double seconds;                    // wall time since the frame before it
    double relmse_estimate;            // from the film halves; NaN with a single pass
    double native_spp;                 // native samples traced per pixel
    double effective_spp;              // samples that landed per pixel, native and reused
    bool reached;                      // the estimate is below settings.noise, or nothing was asked
} RfFrameResult;

typedef struct RfProgress
{
    int frames_done, frames_all;
    double share;   // of the whole work, 0 to 1
    double samples; // native samples traced so far
    double seconds; // since the start
    double relmse;  // estimate of the last finished frame; NaN: not known
} RfProgress;

// Either callback may be NULL. `frame` failing stops the render with its
// error; `progress` returning false stops it with RF_ERROR_INTERRUPTED. With
// settings.queue > 0 `frame` is called from another thread, still once at a
// time and in order, while `progress` is called from that of rf_render; when
// the render is stopped, the frames that are finished are still handed over,
// before rf_render returns.
typedef struct RfRenderCallbacks
{
    void* user;
    RfResult ( *frame )( void* user, const RfFrameResult* result, RfError* error );
    bool ( *progress )( void* user, const RfProgress* progress );
} RfRenderCallbacks;

typedef struct RfRayCounts
{
    uint64_t primary, path, shadow, tile, eye;
} RfRayCounts;

typedef struct RfRenderStats
{
    double seconds;
    RfRayCounts rays;
    size_t peak_bytes, budget_bytes;
    int group;   // as rendered
    int spp;     // as rendered: rounded up to what the groups need
    int threads; // likewise: fewer where memory is short
    RfMemoryFit fit;
    int missed;   // frames finished with an estimate above settings.noise
    bool hurried; // settings.time was too short for the least: two passes of a frame
    int entry_count;
    RfArenaEntry entries[RF_ARENA_MAX_NAMES]; // what the bytes were for, with the most of each
} RfRenderStats;

// Renders `frames` (ascending indices into the `eye_count` eyes of the whole
// path; a frame's result does not depend on which others are asked for, except
// with noise or time, which look at what was rendered before) and
// hands each to callbacks->frame as soon as it is finished, in order. All eyes
// have the same film size. Two runs, and any number of threads, give the same
// bits, except with time. Fails with RF_ERROR_USAGE for settings out of range, RF_ERROR_MEMORY
// where the smallest chunk of a single film does not fit the budget.
RfResult rf_render( const RfTracer* tracer, const RfEye* eyes, int eye_count, const int* frames, int frame_count,
                    const RfRenderSettings* settings, const RfRenderCallbacks* callbacks, RfRenderStats* stats, RfError* error );

#endif
