// Renders frames of a camera path, with paths reused by neighbouring frames (Méndez
// Feliu, Sbert, Szirmay-Kalos, Reusing Frames in Camera Animation, WSCG 2006) and by neighbouring
// pixels (Bekaert, Sbert, Halton, Accelerating Path Tracing by Re-Using Paths, EGWR 2002).
//
//     RfRenderSettings asked = rf_default_render_settings(), settings;
//     asked.spp = 16;
//     RfShot shot = { tracer, path.eyes, path.count, frames, frame_count };
//     RfRenderCallbacks callbacks = { .user = user, .frame = take_frame };
//     if ( rf_resolve_settings( &shot, &asked, &settings, &error ) == RF_OK )
//         result = rf_render( &shot, &settings, &callbacks, &stats, &error );
//
// Every sample that a frame traces also serves the frames of its group, n before and n after it.
// A group of n = 0 and tiles of one pixel are path tracing.
#ifndef REFRAME_RENDER_H
#define REFRAME_RENDER_H

#include "reframe/aov.h"
#include "reframe/camera.h"
#include "reframe/denoise.h"
#include "reframe/error.h"
#include "reframe/render_settings.h"
#include "reframe/scene.h"
#include "reframe/types.h"

RF_API_BEGIN

// What is rendered: some frames of a camera's path through a scene. It points to what the caller keeps, during a call only.
// `frames` may be NULL, with a frame_count of 0, for functions that do not look at them and say so.
typedef struct RfShot
{
    const RfTracer* tracer;
    const RfEye* eyes; // the cameras of the whole path, all with one film size; cuts between them: RfEye.shot
    int eye_count;     // at least 1
    const int* frames; // those asked for: indices into the cameras, from 0, ascending
    int frame_count;
} RfShot;

// The settings as a render of this shot will use them: group and tile chosen by the plan
// (reframe/plan.h: some thousand paths are traced for RF_GROUP_AUTO and RF_TILE_AUTO), the group cut to
// the path, spp rounded up to what its groups need, threads and memory filled
// in, the width of the filter, normalisation that the weights allow, RF_ADAPTIVE_AUTO off where no frame can
// have extra samples. Rendering with the result is the same as with the settings. The frames of
// the shot are not looked at. Fails with RF_ERROR_USAGE for values out of range and for what this build lacks, and
// with RF_GROUP_AUTO with RF_ERROR_MEMORY where not even single frames fit.
RfResult rf_resolve_settings( const RfShot* shot, const RfRenderSettings* settings, RfRenderSettings* resolved, RfError* error );

// How a render fits its budget. What is short costs time and changes no pixel:
// fewer threads, batches of hit records one after the other, and where not even
// the films of a group fit, several sweeps over the path, each for some frames.
typedef struct RfMemoryFit
{
    int threads;
    int films;          // held at once; 0: it does not fit, and only `least` is valid
    int sweeps;         // over the path, each for `films` frames; 1: the films all fit
    int batches;        // of hit records held at once
    int chunks;         // that a pass of a full group takes
    size_t bytes_films; // films and images
    size_t bytes_hits;  // hit records
    size_t bytes_lists; // workspaces: index lists, the writing of files, what moves
    size_t least;       // the smallest budget that works
} RfMemoryFit;

// The fit of a render of the shot with resolved settings; of its frames only their number is looked at. Fails with
// RF_ERROR_MEMORY where the budget is too small: fit->least and error->least_memory are what is needed.
RfResult rf_fit_memory( const RfShot* shot, const RfRenderSettings* settings, RfMemoryFit* fit, RfError* error );

// How the reconstruction of a frame went (`gradient`).
typedef enum RfSolved
{
    RF_SOLVED,         // or there was nothing to solve
    RF_SOLVED_ROUGHLY, // it stopped before its residual was below the tolerance, which is far below the noise
    RF_SOLVED_NOT,     // samples were not finite: the picture is that of the pixels alone
} RfSolved;

// Pixels whose error is more than 64 times the mean of the others': white specks in the picture.
typedef enum RfSpeckKind
{
    RF_SPECK_GLINT,  // of something bright that is smaller than a pixel: emission or direct light differs within it
    RF_SPECK_CHANCE, // of light that mirrors, glass or gloss send on, found by chance
    RF_SPECK_OTHER,
} RfSpeckKind;

#define RF_SPECK_KINDS 3

// "glint", "chance", "other".
const char* rf_speck_kind_name( RfSpeckKind kind );

// Those of one kind on one material.
typedef struct RfSpeckPart
{
    RfSpeckKind kind;
    int material; // that is seen there first, index into the scene's; −1: the sky
    int pixels;
    double share; // of relmse_likely
} RfSpeckPart;

#define RF_MAX_SPECK_PARTS 64

// Where a frame's error is. The worst 64 specks are examined; where there are more they stand for all.
typedef struct RfSpecks
{
    int pixels;                            // 0: none stand out, or it is not known
    double share;                          // of relmse_likely
    double rest;                           // relMSE without them; NaN: not known
    int part_count;                        // 0 also where the estimator has no means to tell
    RfSpeckPart parts[RF_MAX_SPECK_PARTS]; // by share, descending
} RfSpecks;

#define RF_LIGHT_LAYER "light_" // begins the name of a light group's layer

// A pass of a frame that only this render has, such as a light group: channels of their own in a file, NAME.LETTER.
typedef struct RfLayer
{
    const char* name;    // "light_key"
    const char* letters; // of its channels, such as "RGB"
    const float* values; // as many floats as letters × width × height
    bool half;           // 16 bits are enough in a file
} RfLayer;

// A finished frame. The pixels are valid during the callback only.
typedef struct RfFrameResult
{
    int frame; // index into the cameras, from 0
    int width, height;
    const float* rgb;                // 3 × width × height
    const float* weight;             // width × height: the mean of the summed weights B; E[B] = 1 with exact
                                     // weights, else hits per pass
    const float* aovs[RF_AOV_COUNT]; // rf_aov_channels × width × height; NULL: not asked for
    const RfLayer* layers; // what else was asked for: "light_NAME" with settings.light_groups, which add up to the picture;
                           // "CryptoObject00" and so on with settings.cryptomatte
    int layer_count;
    double seconds;             // wall time since the frames before it; those that a group finishes together share it
    double relmse_estimate;     // from two halves of the samples; NaN with a single pass
    bool relmse_is_lower_bound; // the estimate is what the relMSE is at least: more is not known
    double relmse_likely;       // the best guess: the estimate, or above it where that is a lower bound
    double worst_ten_share;     // part of relmse_likely that its ten worst pixels carry, 0 to 1
    RfSpecks specks;
    RfSolved solved;
    double clamp;         // what a path could bring to this frame's hits, luminance; 0: any light
    double clamp_chains;  // and what lights could that camera rays find by mirrors and glass
    bool removes;         // light is taken out of the frame: by the clamp, or with caustics that are left out
    double removed;       // share of the frame's light that it is, by luminance, 0 to 1
    double native_spp;    // samples: traced for the frame, per pixel, extra ones too
    double effective_spp; // effective samples: all that landed in a pixel, with those reused from other frames
    // With settings.flicker: relative F1 of this frame and the one before (NaN: that was not rendered now), as of the relMSE
    double flicker_estimate;
    bool flicker_is_lower_bound;
    double flicker_likely;
    double flicker_worst_ten_share; // of the pixels in F1 squared
    const RfDenoised* denoised;     // NULL: it was not denoised (rf_denoise_frame)
    bool noise_missed;              // the relMSE may be above settings.noise
    bool flicker_missed;            // F1 may be above settings.flicker
    bool reached;                   // neither, by all that is known, or nothing was asked
} RfFrameResult;

typedef struct RfProgress
{
    int frames_done, frames_all;
    double share;   // of the whole work, 0 to 1
    double samples; // traced so far
    double seconds; // since the start
    double relmse;  // estimate of the last finished frame; NaN: not known
    bool relmse_is_lower_bound;
    double flicker; // of the last pair, likewise
    bool flicker_is_lower_bound;
    double left; // seconds to the end, in proportion to the work done; NaN: not known yet
} RfProgress;

// The frame in work, the oldest that is not finished: what its samples so far make. Valid during the callback only.
typedef struct RfPreview
{
    int frame; // index into the cameras, from 0
    int width, height;
    const float* rgb;  // 3 × width × height
    double native_spp; // samples traced for the frame so far, per pixel
} RfPreview;

// Each callback may be NULL. `frame` failing stops the render with its
// error; `progress` returning false stops it with RF_ERROR_INTERRUPTED. With
// settings.queue > 0 `frame` is called from another thread, still once at a
// time and in order, while `progress` is called from that of rf_render; when
// the render is stopped, the frames that are finished are still handed over,
// before rf_render returns.
//
// `preview` is called after the first pass, and then from time to time: at most once a second, and for at most 1 % of the
// time of the render, the callback's own time with it. It changes no picture.
//
// An interrupted render writes its state by `save`, piece by piece, after the frames that are finished: the films of the
// frames in work, which `load` gives back to a render of the frames that were left, in the same pieces. It goes on from there
// with the same bits, for any number of threads. The caller sees to it that scene, path and settings are the same
// (rf_frame_fingerprint). `save` failing ends the saving alone; `load` failing fails the render.
//
// With settings.noise, `judge` tells the error of what is made of a frame in work, such as its denoised picture, and the render
// goes on until that or the relMSE of the frame itself is below. The frame has its picture, the AOVs for denoisers and `half`
// as far as they were asked for, and the samples so far. It is called between passes, by the thread of rf_render.
//
// `saves` is asked after each chunk of batches whether the state is to be saved now, too, for a render that may be killed: the
// state takes up to `bytes`. If so, all finished frames are handed over, `save` gets the state, and NULL at its end.
typedef struct RfJudged
{
    double relmse;   // that the error hardly exceeds; NaN: not known
    double exponent; // it falls as the samples to the power of -exponent: 1 for noise alone
} RfJudged;

typedef struct RfRenderCallbacks
{
    void* user;
    RfResult ( *frame )( void* user, const RfFrameResult* result, RfError* error );
    bool ( *progress )( void* user, const RfProgress* progress );
    void ( *preview )( void* user, const RfPreview* preview );
    RfJudged ( *judge )( void* user, const RfFrameResult* frame );
    RfResult ( *save )( void* user, const void* bytes, size_t size, RfError* error );
    bool ( *saves )( void* user, size_t bytes );
    RfResult ( *load )( void* user, void* bytes, size_t size, RfError* error );
} RfRenderCallbacks;

typedef struct RfRayCounts
{
    uint64_t primary; // from the camera
    uint64_t path;    // of paths beyond the first hit
    uint64_t shadow;  // to lights
    uint64_t tile;    // that connect paths of a tile
    uint64_t eye;     // from hits to the cameras of other frames
    // no rays, but paths (`gradient`): those that tiles could share, and those that its roulette left to be shared
    uint64_t thinned, kept;
} RfRayCounts;

// Memory of a render by what it is for.
typedef struct RfMemoryEntry
{
    const char* name; // a string literal
    size_t bytes;     // in use now
    size_t peak;      // the most that was ever in use
} RfMemoryEntry;

#define RF_MAX_MEMORY_ENTRIES 32

typedef struct RfRenderStats
{
    double seconds;
    RfRayCounts rays;
    size_t peak_bytes, budget_bytes;
    int group;   // as rendered
    int spp;     // as rendered: rounded up to what the groups need
    int threads; // as rendered: fewer where memory is short
    RfMemoryFit fit;
    int missed;          // frames finished with an estimate above settings.noise
    int flicker_missed;  // the same of pairs and settings.flicker, counted at the later frame
    bool hurried;        // settings.time was too short for the least: two passes of a frame
    int adaptive_frames; // finished frames with extra samples
    int guide_tables;    // densities of the guide (RfGuiding); 0: paths were not guided
    double clamp;        // threshold of the first frame asked for; 0: none was needed, or found
    double clamp_chains; // likewise that of lights found by mirrors and glass
    int entry_count;     // of the entries
    RfMemoryEntry entries[RF_MAX_MEMORY_ENTRIES];
} RfRenderStats;

// Settings for renders of parts of a shot that are guided as one of all of it is: *parts are `settings` with what a pilot over the shot
// has learned, which the caller destroys after them; *guide is NULL where it guides nothing. Fails as rf_render.
RfResult rf_guide_parts( const RfShot* shot, const RfRenderSettings* settings, RfRenderSettings* parts, RfGuide** guide,
                         RfError* error );
void rf_forget_guide( RfGuide* guide ); // may be NULL

// Renders the frames of a shot and hands each to callbacks->frame as soon as it is finished, in order. A frame does
// not depend on which others are asked for, except with noise, flicker or time, which look at what was
// rendered before. Two runs, and any number of threads, give the same bits, except with time.
// `stats` may be NULL. Fails with RF_ERROR_USAGE for settings out of range, no frames, or frames that do not ascend or are not
// of the path, RF_ERROR_MEMORY where the smallest chunk of a single film does not fit the budget,
// RF_ERROR_INTERRUPTED, or as a callback does.
RfResult rf_render( const RfShot* shot, const RfRenderSettings* settings, const RfRenderCallbacks* callbacks,
                    RfRenderStats* stats, RfError* error );

// What rf_denoise takes of a frame, but for layers and the frames beside it. Its pointers are the frame's.
RfNoisyFrame rf_noisy_frame( const RfFrameResult* frame );

// The share of the light of all of a shot's path that is beyond settings->max_depth and is missing in its frames, 0 to 1: about, by
// small pictures of some frames that are rendered with and without. 0 without a limit. Its seed is its own. Fails as rf_render.
RfResult rf_find_light_beyond_depth( const RfShot* shot, const RfRenderSettings* settings, double* share, RfError* error );

RF_API_END

#endif
