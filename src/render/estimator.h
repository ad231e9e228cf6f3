// The socket for estimators: a table of functions, one row for each way of
// estimating pixels. The driver (render.h) knows frames, groups, passes, films,
// memory and threads; the estimator knows what a batch of samples is. The table's
// functions are called per batch, per band of rows or per frame, never per sample.
//
// A pass of a frame consists of `jobs` batches. The driver traces some batches in
// parallel, of one pass or several, each into records of its own, and then adds them to the films of all
// frames of the group in a fixed order, band by band in parallel. So a picture does
// not depend on the number of threads, on memory, or on which frames are asked for,
// as long as `trace` depends on (group, job) alone and `accumulate` adds batches in
// the order given.
//
// To add an estimator: a folder with its functions, one row in estimators/estimators.h with its include in estimators.c, its
// level in tests/scripts/check-includes, and its name in scenes/scene.schema.json (a test compares). The option, its help and
// the defaults in it follow. A minimal one, a path tracer, is in tests/render/test_second_estimator.c. This header is the
// documentation of the table: required are name, films, sizes, lay_out_batch, lay_out_scratch, trace and accumulate.
#ifndef REFRAME_RENDER_ESTIMATOR_H
#define REFRAME_RENDER_ESTIMATOR_H

#include "film/aov.h"
#include "film/covering.h"
#include "film/film.h"
#include "film/film_error.h"
#include "film/pixel_filter.h"
#include "path/guide.h"
#include "reframe/render.h"
#include "render/clamp_threshold.h"
#include "render/traits.h"

// Numbers of groups for what has random numbers of its own; no group of the path has them. Extra samples and glints of group n have
// n more.
#define RF_GROUP_OF_PILOT 0x40000000u
#define RF_GROUP_OF_GUIDE 0x50000000u
#define RF_GROUP_OF_CLAMP 0x60000000u
#define RF_GROUP_OF_EXTRA 0x80000000u
#define RF_GROUP_OF_GLINTS 0xa0000000u
#define RF_GROUP_OF_NOISE 0xc0000000u
#define RF_GROUP_OF_SPECKS 0xe0000000u

// A group of frames, as every batch of it sees it.
typedef struct RfEstimatorGroup
{
    const RfTracer* tracer;           // of one frame, or of what stands still in several; NULL where only sizes are asked for
    const RfTracer* const* tracers;   // where something moves: those of the group's frames; NULL: all are `tracer`
    const RfRenderSettings* settings; // resolved
    RfSceneTraits traits;
    int width, height;           // of all films, pixels
    int max_depth;               // path vertices after the camera: that of the settings, or less
    const RfPixelFilter* filter; // that samples are added by, and those of `need` drawn by; NULL: each counts in its own pixel
    const RfEye* eyes;           // of the group's frames
    int eye_count;
    int first_frame;       // of the path, from 0: the frame of eyes[0]
    int number;            // of the group; with the seed it selects the random numbers
    int64_t passes_before; // of the groups before it; −1: these are no passes of the path, and go to either half
    // adaptive sampling: own-frame samples wanted per pixel, NULL where every pixel is sampled once.
    // Of them this is the part between `round` and `round` + 1.
    const float* need;
    int round;
    bool packed;          // instead all of them, as many tiles at once as fill a batch: the batch number `round` of these
    bool single;          // pixel by pixel, not in tiles
    bool first_hits_only; // no light: for add_own_shares and count_reuse alone
    bool probe;           // it stands for groups of more frames: finds the hits that these have
    const RfGuide* guide; // of paths, for estimators that heed one; NULL: none
    const RfClampThresholds* clamp; // with settings.clamp: the threshold of each frame, like eyes; NULL: none
    RfClampWatch* clamp_watch;      // is told of what paths bring, by one thread (render/clamp_threshold.h); NULL: nobody
    const void* compiled;           // what `compile` made for groups of so many frames; NULL where only sizes are asked for
    const void* shared;             // what `prepare` made for the pass; NULL: there is nothing
} RfEstimatorGroup;

// The tracer of one of the group's frames.
static inline const RfTracer* rf_group_tracer( const RfEstimatorGroup* group, int eye )
{
    return group->tracers != NULL ? group->tracers[eye] : group->tracer;
}

// Sizes in bytes and counts for groups of up to group->eye_count frames.
typedef struct RfEstimatorSizes
{
    int jobs;                  // batches of a pass of one frame
    size_t compiled;           // what `compile` makes; 0: nothing
    size_t batch;              // a batch's records
    size_t trace_scratch;      // workspace of `trace`, per thread
    size_t accumulate_scratch; // workspace of `accumulate`, per thread
    size_t landing;            // what `land` keeps of a batch for a frame; 0: `accumulate` is called instead
    size_t finish_scratch;     // workspace of `finish`; 0: none
    size_t tile_pilot;         // workspace of `count_tiles`; 0: none
    size_t shared;             // what all batches of a pass share, all zero at first; 0: nothing
    const char* shared_name;   // of that, in the report of memory
    bool splits;               // films have sums of own-frame light (RfFilm.split)
    // for the report of the plan
    size_t diffuse_record, glossy_record; // bytes of one hit
    int directions;                       // that a glossy hit's record holds
} RfEstimatorSizes;

// One batch of a pass.
typedef struct RfTraceJob
{
    int eye; // index in the group of the frame whose samples these are
    int job; // from 0 to sizes.jobs − 1
    int pass;
} RfTraceJob;

// Rows [first_row, end_row) of one frame of the group.
typedef struct RfAccumulateJob
{
    int eye; // index in the group
    int first_row, end_row;
    RfFilm* films;        // as many as the estimator asks for
    RfFilm* groups;       // of light groups, in the order of RfLightGroups; NULL: none
    RfFilm* passes;       // of RF_PASS_AOVS that are asked for, in their order; NULL: none
    int half;             // of the films, which the pass goes to
    float weight;         // of the pass in the film
    uint32_t* landed;     // samples that landed, per pixel, counted up (RF_AOV_SAMPLES); or NULL
    float* sky;           // weight of the camera rays that missed, per pixel, counted up (RF_AOV_ALPHA); or NULL
    RfCovering* covering; // of the pixels by surfaces, counted up; or NULL
} RfAccumulateJob;

// How well other frames of a group see the hits of a batch, for the plan.
typedef struct RfReuseCount
{
    double hits;      // of camera rays
    double glossy;    // among them those whose light depends on the camera
    double own_share; // sum over the hits of the share of their weight that their own frame keeps, 0 to 1
    double eye_rays;  // visibility tests traced
} RfReuseCount;

// How light varies, for the plan: sums over pixels of variances of a sample, relative to the squared brightness around it, without
// reuse between frames (src/reuse/estimators.md, E29).
#define RF_TILE_CHOICES 6
extern const int rf_tile_sides[RF_TILE_CHOICES]; // of the blocks that are weighed: 1 to 8 pixels
// By size, since a few that are large tell little: from 2^(k + RF_FIRST_TILE_OCTAVE) on, and below in the first.
#define RF_TILE_OCTAVES 32
#define RF_FIRST_TILE_OCTAVE ( -8 )
typedef struct RfTileCount
{
    double connected[RF_TILE_CHOICES]; // second vertices that other hits of these tiles see
    double pixels;
    double light_sample; // what a light sample less at first hits adds
    struct
    {
        double pixels;
        double own;    // of light that no other frame has
        double shared; // of all other light, with the tile traced
    } pairs[RF_TILE_OCTAVES];
    struct
    {
        double paths;
        double moment[RF_TILE_CHOICES]; // the part that paths bring, in these tiles
    } paths[RF_TILE_OCTAVES];
} RfTileCount;

// The picture that is made of a frame's films.
typedef struct RfPicture
{
    float* rgb;      // 3 per pixel
    float* weight;   // the mean of B, 1 per pixel; NULL: not asked for
    float* variance; // RF_AOV_VARIANCE, 3 per pixel; NULL: not asked for
    RfSolved solved; // how a reconstruction went
} RfPicture;

struct RfEstimator
{
    const char* name;     // for rf_find_estimator
    int films;            // per frame, 1 to RF_MAX_FILMS. Film 0 is the picture, unless `finish` makes it of all
    bool filters;         // it heeds RfEstimatorGroup.filter; else settings with another than the plain filter are refused
    bool draws_by_filter; // and draws its samples by it, so that each counts in its own pixel alone, in AOVs as well
    bool has_gradients;   // films 0 to 2 are values and differences: RF_GRADIENT_AOVS
    bool has_alpha;       // it counts RfAccumulateJob.sky
    bool has_features;    // `first_hits` has what RF_DENOISE_AOVS are made of
    bool has_covering;    // and RfAccumulateJob.covering
    bool clamps;       // with settings.clamp, or without caustics (RfSceneTraits), it adds the light taken out to one film more,
                       // whose weights do not matter
    bool guides;       // it heeds RfEstimatorGroup.guide
    bool splits_light; // it adds each light group (RfSceneTraits.light_groups) to a film of its own, whose weights do not matter,
                       // and each of RF_PASS_AOVS
    bool biased;       // for other RfRenderSettings.weights than RF_WEIGHTS_EXACT
    const RfEstimator* other_weights; // takes its place for those that it does not have, under the same name; NULL: none does
    bool has_variance;                // `finish` fills RfPicture.variance
    int usual_passes;                 // from which on `finish` works as with many passes; 0: always
    RfTile tile;                      // that it has where none is asked for (rf_default_tile)

    // May be NULL. Refuses settings that this estimator cannot follow, with RF_ERROR_USAGE.
    RfResult ( *check )( const RfRenderSettings* settings, RfError* error );

    // Sizes for such groups. Only traits, settings, film size and eye_count count.
    RfEstimatorSizes ( *sizes )( const RfEstimatorGroup* group );

    // NULL without sizes.compiled. Derives once, before all else, what depends on traits, settings, film size and eye_count alone.
    void ( *compile )( const RfEstimatorGroup* group, void* compiled );

    // Prepare sizes.batch and sizes.trace_scratch bytes, aligned to 64, before their first use.
    // A batch laid out for a group serves groups of fewer cameras, too.
    void ( *lay_out_batch )( const RfEstimatorGroup* group, void* batch );
    void ( *lay_out_scratch )( const RfEstimatorGroup* group, void* scratch );

    // May be NULL. Makes what all batches of a pass of a group share, sizes.shared bytes. By all threads of the settings.
    void ( *prepare )( const RfEstimatorGroup* group, int pass, void* shared, RfRayCounts* rays );

    // Traces one batch into records and adds to the counts of rays. Returns its own-frame samples.
    // Called by several threads, each with its own batch and scratch.
    int ( *trace )( const RfEstimatorGroup* group, RfTraceJob job, void* batch, void* scratch, RfRayCounts* rays );

    // Would `trace` trace any sample of the job, if only the settings' pieces are? NULL where there are no pieces.
    bool ( *is_traced )( const RfEstimatorGroup* group, RfTraceJob job );

    // The camera rays of the batch just traced and their hits, for AOVs; NULL where there are none of these.
    RfFirstHits ( *first_hits )( const void* scratch );

    // Adds batches to some rows of a frame's films, in the order given; returns how many samples
    // landed there. Called by several threads, for different rows or frames.
    uint64_t ( *accumulate )( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count,
                              void* scratch );

    // The same in two steps, with sizes.landing, so that what does not depend on rows is done once. `land` keeps what a batch brings to
    // a frame, all rows of it, `add_landings` adds this of each batch to some rows. Called by several threads, `land` for different
    // batches or frames.
    void ( *land )( const RfEstimatorGroup* group, RfAccumulateJob job, const void* batch, void* scratch, void* landing );
    uint64_t ( *add_landings )( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, void* const* landings,
                                int batch_count );

    // May be NULL: film 0 is the picture. Fills the picture, all zero but for its pointers, from a frame's films and returns the
    // estimate of its relMSE (likely: NaN where it is unknown).
    RfRelmse ( *finish )( const RfRenderSettings* settings, const RfFilm* films, RfPicture* picture, void* scratch );

    // Adaptive sampling; both NULL where the estimator has none. It needs an estimator of one film. `add_own_shares` adds, per pixel,
    // the share of each sample's weight that its own frame keeps (1 where no other frame sees it, or the light holds in one frame alone)
    // for a batch just traced. `count_samples` adds `weight` per own-frame sample, returns their number.
    void ( *add_own_shares )( const void* batch, const void* scratch, float* sum );
    uint64_t ( *count_samples )( const void* batch, float weight, float* sum );

    // Glints; NULL where the estimator has none. One camera ray for each pixel of a block of RF_GLINT_BLOCK² of the group's first
    // frame, numbered by rows. Adds to four floats per pixel: the mean and the mean square that samples will have of the light of
    // lamps, mirrored or in view; about what else the surface reflects, and 1, where it mirrors lamps.
    void ( *add_glints )( const RfEstimatorGroup* group, int block, void* scratch, float* sums, RfRayCounts* rays );

    // Counts for the plan; NULL where frames share nothing. Adds what a batch that was traced for its own
    // frame alone (where something moves, for the first hits of `group`) would find in `group`, where that frame has index `eye`.
    void ( *count_reuse )( const RfEstimatorGroup* group, int eye, void* batch, void* scratch, RfReuseCount* count );

    // For the choice of a tile; NULL: the tile is `tile` unless another is asked for. Is given pairs of batches of the same pixels,
    // each traced for a group of one frame with the largest tile that is looked at: of the first of them `count` is NULL.
    void ( *count_tiles )( const RfEstimatorGroup* group, void* batch, void* scratch, void* pilot, RfTileCount* count );
};

#define RF_MAX_FILMS 8
#define RF_GLINT_BLOCK 32 // pixels, the side of a block of add_glints

#endif
