// A render's memory: how it fits its budget, and all that is allocated, from one arena.
#ifndef REFRAME_RENDER_MEMORY_MEMORY_H
#define REFRAME_RENDER_MEMORY_MEMORY_H

#include "reframe/render.h"
#include "render/estimator.h"
#include "render/frame_queue.h"
#include "render/groups.h"
#include "render/stop/stop_rule.h"

#include <stddef.h>

// A budgeted arena: everything that a render allocates, apart from scene and BVH, comes from one. Each allocation has a name, so
// that a report can list what the memory is used for. The arena only counts; the memory itself comes from the system, aligned to a
// cache line.
typedef struct RfArena
{
    size_t budget; // bytes; 0: unlimited
    size_t bytes;  // in use
    size_t peak;   // high-water mark
    int entry_count;
    RfMemoryEntry entries[RF_MAX_MEMORY_ENTRIES];
} RfArena;

RfArena rf_create_arena( size_t budget );

// Allocates `bytes` (aligned to 64) under `name`. Fails with RF_ERROR_MEMORY if the budget or
// the system has no room; the message gives the size and purpose of the allocation and the
// memory in use. Not thread-safe: allocate outside parallel loops.
RfResult rf_arena_alloc( RfArena* arena, const char* name, size_t bytes, void** memory, RfError* error );
void rf_arena_free( RfArena* arena, const char* name, void* memory, size_t bytes );

// What an allocation of `bytes` takes from the budget.
size_t rf_arena_size( size_t bytes );

// What the sizes depend on.
typedef struct RfRenderSizes
{
    const RfEstimator* estimator;
    RfEstimatorSizes of_estimator; // for a full group
    int film_count; // of a frame: the estimator's, that of removed light, those of passes (RF_PASS_AOVS), those of light groups
    int pass_films, group_films;
    int width, height;
    int eyes; // of a full group
    int threads;
    int passes;           // of a full group that may be traced at once
    int films;            // frames whose films are held at once
    int buffers;          // finished frames held at once, if there is room
    int ring;             // and the size of the table of them
    unsigned aovs;        // RF_AOV_BIT of the AOVs asked for
    unsigned cryptomatte; // kinds asked for
    bool covering;        // surfaces of pixels are counted, for these or index AOVs
    bool filtered;        // by another than the plain pixel filter
    int film_block;       // passes (RfFilm.block)
    bool stopping;        // by noise, flicker or time
    bool paired;          // by flicker: the films of a group are held at once, and the errors of one more frame
    bool adaptive;        // films may get extra samples
    bool glints;          // likewise for glints
    int materials;        // whose noise is measured for these; 0: all are alike
    int worlds;           // frames whose moving things are held at once (render/worlds.h)
    size_t moving;        // bytes of these: counted, not allocated by memory.h
    RfFrameFiles files;
} RfRenderSizes;

static inline int rf_first_pass_film( const RfRenderSizes* s ) { return s->film_count - s->group_films - s->pass_films; }

// A group of `eye_count` cameras for asking an estimator for its sizes.
RfEstimatorGroup rf_size_group( const RfScene* scene, RfSceneTraits called, const RfEye* eyes, int eye_count,
                                const RfRenderSettings* settings );

// Sizes with the films of `films` frames held at once. The settings must be resolved.
RfRenderSizes rf_render_sizes( const RfScene* scene, const RfEye* eyes, const RfGroupPlan* plan, int films,
                               const RfRenderSettings* settings );

// Batches of a pass of a full group.
static inline int rf_batches_of_pass( const RfRenderSizes* sizes ) { return sizes->eyes * sizes->of_estimator.jobs; }

static inline size_t rf_film_pixels( const RfRenderSizes* sizes ) { return (size_t)sizes->width * (size_t)sizes->height; }

// Entries of RfRenderMemory.noise: one more for the materials that are alike.
static inline size_t rf_material_noises( const RfRenderSizes* sizes )
{
    return sizes->materials > 0 ? (size_t)sizes->materials + 1 : 0;
}

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
    float* glints; // the same for glints, pixel by pixel (render/adaptive/adaptive.h); NULL: none in this render
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
