// A render's memory: how it fits its budget, and all that is allocated, from one arena.
#ifndef REFRAME_RENDER_MEMORY_MEMORY_H
#define REFRAME_RENDER_MEMORY_MEMORY_H

#include "base/arena.h"
#include "render/frame_queue.h"
#include "render/sizes.h"
#include "render/stop/stop_rule.h"

// The films of one frame of the path while it is rendered. render/state.c saves all of it.
typedef struct RfLiveFilm
{
    int frame;     // −1: free
    RfFilm* films; // RfRenderSizes.film_count; the first counts passes and samples
    RfAovFilm aovs;
    RfCovering* covering;              // of the pixels by surfaces; NULL: not asked for
    double noise, flicker, noise_seen; // as `noise`, `flicker` and `seen` in RfFrameNoise
    RfPairNoise pair;
    float* need; // adaptive sampling: extra samples wanted by each pixel in a pass; NULL: none in this render
    float most_need;
    float* glints; // the same for glints, pixel by pixel (render/adaptive/glint_pilot.h); NULL: none in this render
    float most_glints;
} RfLiveFilm;

typedef struct RfRenderMemory
{
    RfArena arena;
    bool has_writer;           // its bytes are counted
    bool has_moving;           // likewise those of what moves
    void** trace_scratch;      // per thread
    void** accumulate_scratch; // per thread
    void** landings;           // of batches in frames; NULL: none
    int landing_slots;
    void* finish_scratch; // NULL: none
    void* shared;         // by the batches of a pass; NULL: nothing is
    void** batches;
    int batch_slots;
    RfLiveFilm* films;
    int film_slots;
    RfFrameNoise* noise_estimates; // as many as films; with settings.noise, flicker or time only
    float* kept_errors;            // of the frame finished last; with settings.flicker only
    struct RfMaterialNoise* noise; // of each material, for adaptive sampling; NULL: all are alike
    bool noise_known;              // it has been measured
    RfFrameBuffer* buffers;        // finished frames on their way to the caller
    int buffer_count;
} RfRenderMemory;

// Goes through blocks of memory, in the same order each time: their names in the arena, their bytes, and the pointers to them.
typedef struct RfMemoryWalk
{
    void ( *take )( struct RfMemoryWalk* walk, const char* name, size_t bytes, void** block );
    const RfRenderSizes* sizes;
} RfMemoryWalk;

// The arrays of a live film and of its films.
void rf_walk_film_arrays( RfMemoryWalk* walk, RfLiveFilm* live );

// Bytes of the films of all frames held at once, with their AOVs.
size_t rf_films_bytes( const RfRenderSizes* sizes );

// Settles threads and films for the budget. Fails with RF_ERROR_MEMORY where not even the smallest
// render fits; fit->least is set then, too.
RfResult rf_fit_sizes( size_t budget, int frames, RfRenderSizes* sizes, RfMemoryFit* fit, RfError* error );

// Allocates films, workspaces, and as many batches as serve the threads and fit the budget; buffers
// beyond the first only where these all fit too. On failure what was allocated stays for
// rf_free_render_memory.
RfResult rf_alloc_render_memory( const RfEstimatorGroup* group, const RfRenderSizes* sizes, RfRenderMemory* memory,
                                 RfError* error );
void rf_free_render_memory( const RfRenderSizes* sizes, RfRenderMemory* memory );

#endif
