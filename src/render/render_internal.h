// The state of a render, shared by its files: settings, memory, driver.
#ifndef REFRAME_RENDER_RENDER_INTERNAL_H
#define REFRAME_RENDER_RENDER_INTERNAL_H

#include "base/arena.h"
#include "reuse/accumulate.h"
#include "render/frame_queue.h"
#include "render/groups.h"
#include "reuse/harvest.h"
#include "film/aov_film.h"
#include "reframe/render.h"
#include "render/stop_rule.h"

// A film in use, of one frame of the path.
typedef struct LiveFilm
{
    int frame; // −1: free
    RfFilm film;
    RfAovFilm layers;
    uint32_t* landed_eyes; // eq15 only
    double noise, seen;    // as in RfFrameNoise
    float* need;           // extra samples wanted by each pixel in a pass; NULL: not adaptive
    float most_need;
} LiveFilm;

// All that is allocated, from one arena.
typedef struct RenderMemory
{
    RfArena arena;
    bool has_writer;                      // its bytes are counted
    RfHarvestScratch** harvest_scratch;   // per thread
    RfAccumulateScratch* compute_scratch; // per thread
    RfHitBatch* batches;
    int batch_slots;
    int batches_laid_out; // of them, while they are being allocated
    LiveFilm* films;
    int film_slots;
    RfFrameNoise* looks;    // as many; with settings.noise or time only
    RfFrameBuffer* buffers; // finished frames on their way to the caller
    int buffer_count;
} RenderMemory;

// What the sizes depend on.
typedef struct RenderSizes
{
    int width, height;
    RfPatchLayout patches;
    int threads;
    int films;       // held at once
    int buffers;     // wanted
    unsigned layers; // RF_AOV_BIT of those asked for
    int total_every; // passes of a half of a film before it is emptied; 0: never
    bool stopping;   // by noise or time
    bool adaptive;
    RfFrameFiles files;
    size_t held; // of records besides the batches, the most of any window; with settings.hold_all only
    RfBatchShape shape;
} RenderSizes;

// A render as a whole.
typedef struct RfRenderer
{
    const RfTracer* tracer;
    const RfEye* eyes;
    const int* frames; // of this sweep, ascending
    int frame_count;
    int frames_all;            // asked for
    RfRenderSettings settings; // resolved
    RfRenderCallbacks callbacks;
    RfGroupPlan plan;
    RfStop stop; // with settings.noise or time
    RfMemoryFit fit;
    RenderSizes sizes;
    RenderMemory memory;
    RfFrameQueue delivery;
    RfRayCounts rays;
    double start, last_frame; // seconds
    double batches_done, batches_all;
    int frames_done;
    double last_relmse; // of the last finished frame
} RfRenderer;

static inline bool rf_is_stopping( const RfRenderSettings* settings ) { return settings->noise > 0.0 || settings->time > 0.0; }

// The groups of a render with so many samples, of no more than RF_MAX_SPP where that can be had.
RfGroupPlan rf_plan_samples( int frames, int half_width, int spp );

void rf_add_rays( RfRayCounts* sum, const RfRayCounts* part );

// One pass of a window, into the films.
RfResult rf_render_pass( RfRenderer* renderer, const RfHarvest* harvest, const RfGroup* window, int pass, RfError* error );

// The passes of a window, as many as noise and time want.
RfResult rf_render_until( RfRenderer* renderer, const RfHarvest* harvest, RfError* error );

// The film of a frame in use, −1 for a free one; NULL where there is none.
LiveFilm* rf_find_film( const RfRenderer* renderer, int frame );

RfFilmCombine rf_film_combine( RfNormalize normalize );

// Was any frame of the window asked for?
bool rf_group_wanted( const RfRenderer* renderer, RfGroup window );

// Clears films for the asked frames that a window is the first to hold.
void rf_open_films( RfRenderer* renderer, int window );

// Hands over the frames whose last window is done, in order.
RfResult rf_close_films( RfRenderer* renderer, int window, RfError* error );

// Jobs [first, first + count) of a pass into the batches.
void rf_harvest_chunk( RfRenderer* renderer, const RfHarvest* harvest, const RfGroup* window, int pass, int first, int count );
// Batches of a pass into the films, between its begin and its end.
void rf_accumulate_chunk( RfRenderer* renderer, const RfHarvest* harvest, const RfGroup* window, int pass,
                          const RfHitBatch* batches, int count );
void rf_begin_pass( RfRenderer* renderer, const RfHarvest* harvest );
void rf_end_pass( RfRenderer* renderer, const RfHarvest* harvest, const RfGroup* window, int pass );
// After so many batches: progress, interruption, and what became of frames handed over.
RfResult rf_end_chunk( RfRenderer* renderer, int count, RfError* error );

// The harvest of window `number`.
RfHarvest rf_group_harvest( const RfRenderer* renderer, int number );

// Settles sizes.held for the frames asked for, by tracing the camera rays of each
// window; fails with RF_ERROR_MEMORY where the system has no room for a batch.
RfResult rf_count_held( RfRenderer* renderer, RfError* error );

// A window with the hit records of all its passes at once (settings.hold_all).
RfResult rf_render_held( RfRenderer* renderer, const RfHarvest* harvest, const RfGroup* window, RfError* error );

// Adds the native hits of the batch just harvested to the layers of its own
// frame, eye `eye` of the window.
void rf_add_aovs( const RfRenderer* renderer, const RfHarvest* harvest, const RfGroup* window, int eye,
                  const RfHarvestScratch* scratch );

// Bytes that are allocated, exactly: films; one image on its way to the caller;
// workspaces; what writing a file takes (counted only); so many batches of hit records; all but the batches, with one
// image. Of single arrays: which eyes landed where; a film's totals; what is
// known of the films' noise; what an adaptive film has besides; a layer
// while it is rendered, and finished. 0: not needed.
size_t rf_films_bytes( const RenderSizes* sizes );
size_t rf_image_bytes( const RenderSizes* sizes );
size_t rf_scratch_bytes( const RenderSizes* sizes );
size_t rf_writer_bytes( const RenderSizes* sizes );
size_t rf_records_bytes( const RenderSizes* sizes, int batches );
size_t rf_fixed_bytes( const RenderSizes* sizes );
size_t rf_landed_bytes( const RenderSizes* sizes );
size_t rf_totals_bytes( const RenderSizes* sizes );
size_t rf_noise_estimates_bytes( const RenderSizes* sizes );
size_t rf_need_bytes( const RenderSizes* sizes );
size_t rf_extra_bytes( const RenderSizes* sizes );
size_t rf_aov_film_bytes( const RenderSizes* sizes, int layer );
size_t rf_aov_image_bytes( const RenderSizes* sizes, int layer );

// Batches at once that serve all threads.
int rf_batches_wanted( const RenderSizes* sizes );

// Settles threads and films for the budget, and tells how. Fails with
// RF_ERROR_MEMORY where not even the smallest render fits, with its size.
RfResult rf_fit_sizes( size_t budget, int frames, RenderSizes* sizes, RfMemoryFit* fit, RfError* error );

// Allocates films, scratch, and as many batches as serve the threads and fit
// the budget; frame buffers beyond the first only where these all fit too. On failure what was allocated stays for rf_free_render_memory.
RfResult rf_alloc_render_memory( const RenderSizes* sizes, RenderMemory* memory, RfError* error );
void rf_free_render_memory( const RenderSizes* sizes, RenderMemory* memory );

// Sizes for `films` frames held at once, with settings that are resolved.
RenderSizes rf_render_sizes( const RfScene* scene, const RfEye* eyes, const RfGroupPlan* plan, int films,
                             const RfRenderSettings* settings );

#endif
