// How a render fits its budget, and what it allocates.
#include "render/memory/memory.h"

#include "base/layout.h"
#include "base/remedy.h"
#include "base/system.h"
#include "image/exr.h"
#include "render/adaptive/adaptive.h"
#include "render/settings.h"
#include "render/worlds.h"

#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// The arena: allocations counted by name against a budget; a request beyond it fails.

#define ALIGNMENT 64

size_t rf_arena_size( size_t bytes ) { return ( ( bytes > 0 ? bytes : 1 ) + ALIGNMENT - 1 ) / ALIGNMENT * ALIGNMENT; }

static RfMemoryEntry* find_entry( RfArena* arena, const char* name )
{
    for ( int i = 0; i < arena->entry_count; ++i )
    {
        if ( strcmp( arena->entries[i].name, name ) == 0 )
            return arena->entries + i;
    }
    if ( arena->entry_count == RF_MAX_MEMORY_ENTRIES )
        return NULL;
    RfMemoryEntry* entry = arena->entries + arena->entry_count++;
    *entry = ( RfMemoryEntry ){ .name = name };
    return entry;
}

RfArena rf_create_arena( size_t budget ) { return ( RfArena ){ .budget = budget }; }

static size_t arena_room( const RfArena* arena )
{
    if ( arena->budget == 0 )
        return SIZE_MAX;
    return arena->budget > arena->bytes ? arena->budget - arena->bytes : 0;
}

// Counts `bytes` that are allocated elsewhere, by code that cannot use an arena. Fails like
// rf_arena_alloc.
static RfResult arena_reserve( RfArena* arena, const char* name, size_t bytes, RfError* error )
{
    if ( bytes > SIZE_MAX - ALIGNMENT )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: %zu bytes are more than any machine has", name, bytes );
    size_t rounded = rf_arena_size( bytes );
    if ( rounded > arena_room( arena ) )
        return rf_advise( rf_fail( error, RF_ERROR_MEMORY, "%s: %.1f MiB do not fit, %.1f of %.1f MiB are in use", name,
                                   (double)rounded / 1048576.0, (double)arena->bytes / 1048576.0,
                                   (double)arena->budget / 1048576.0 ),
                          RF_REMEDY_MEMORY, 0, error );
    RfMemoryEntry* entry = find_entry( arena, name );
    if ( entry == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: the arena has no room for another name", name );
    arena->bytes += rounded;
    entry->bytes += rounded;
    if ( arena->bytes > arena->peak )
        arena->peak = arena->bytes;
    if ( entry->bytes > entry->peak )
        entry->peak = entry->bytes;
    return RF_OK;
}

static void arena_release( RfArena* arena, const char* name, size_t bytes )
{
    size_t rounded = rf_arena_size( bytes );
    RfMemoryEntry* entry = find_entry( arena, name );
    arena->bytes -= rounded;
    if ( entry != NULL )
        entry->bytes -= rounded;
}

RfResult rf_arena_alloc( RfArena* arena, const char* name, size_t bytes, void** memory, RfError* error )
{
    *memory = NULL;
    RfResult result = arena_reserve( arena, name, bytes, error );
    if ( result != RF_OK )
        return result;
    *memory = aligned_alloc( ALIGNMENT, rf_arena_size( bytes ) );
    if ( *memory != NULL )
        return RF_OK;
    arena_release( arena, name, bytes );
    return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory, %.1f MiB more are needed", name,
                    (double)rf_arena_size( bytes ) / 1048576.0 );
}

void rf_arena_free( RfArena* arena, const char* name, void* memory, size_t bytes )
{
    if ( memory == NULL )
        return;
    free( memory );
    arena_release( arena, name, bytes );
}

// The sizes of all buffers, from what the render and its estimator need.

#define BATCHES_PER_THREAD 16 // in a chunk: enough to share out, few enough to stay in the cache
#define LANDINGS_PER_THREAD 4 // likewise

// First hits go to AOVs when they are traced, light paths and pieces are those of a pass, and a goal is looked at after each.
static int passes_at_once( const RfEstimatorSizes* sizes, const RfGroupPlan* plan, const RfRenderSettings* settings )
{
    bool whole = sizes->shared > 0 || settings->pieces != NULL || rf_is_stopping( settings );
    bool of_pass = whole || ( settings->aovs & RF_FIRST_HIT_AOVS ) != 0;
    return of_pass ? 1 : plan->passes > 0 ? plan->passes : ( settings->spp - 1 ) / plan->eyes + 1;
}

// Adaptive sampling takes memory wherever it may happen: frames decide one by one.
static bool may_adapt( const RfRenderSettings* settings, int eyes )
{
    bool may = settings->adaptive == RF_ADAPTIVE_ON || ( settings->adaptive == RF_ADAPTIVE_AUTO && eyes > 1 );
    return rf_calls_for( may, RF_EFFECT_ADAPTIVE );
}

RfRenderSizes rf_render_sizes( const RfScene* scene, const RfEye* eyes, const RfGroupPlan* plan, int films,
                               const RfRenderSettings* settings )
{
    RfSceneTraits called = rf_scene_traits( scene, eyes, plan->frames, settings );
    RfEstimatorGroup group = rf_size_group( scene, called, eyes, plan->eyes, settings );
    // as many additions to a pixel as the group has frames
    bool adaptive = may_adapt( settings, plan->eyes );
    int materials = adaptive && rf_noise_differs( &called ) ? (int)scene->material_count : 0;
    bool glints = adaptive && called.sharp && settings->estimator->add_glints != NULL &&
                  ( settings->adaptive == RF_ADAPTIVE_ON || settings->spp >= RF_LEAST_GLINT_SPP );
    int block = rf_film_block( plan->eyes * rf_filter_pixels( settings ) + ( adaptive ? rf_most_extra( materials > 0 ) : 0 ) +
                               ( glints ? RF_MOST_GLINTS : 0 ) );
    int passes = __builtin_popcount( settings->aovs & RF_PASS_AOVS );
    int worlds = rf_worlds_held( scene, plan->frames, plan->eyes, rf_follows_motion( settings ), adaptive );
    RfEstimatorSizes of_estimator = settings->estimator->sizes( &group );
    return ( RfRenderSizes ){
        .estimator = settings->estimator,
        .of_estimator = of_estimator,
        .film_count = settings->estimator->films + rf_keeps_removed( scene, settings ) + passes + called.light_groups,
        .pass_films = passes,
        .group_films = called.light_groups,
        .width = eyes->width,
        .height = eyes->height,
        .eyes = plan->eyes,
        .threads = settings->threads,
        .passes = passes_at_once( &of_estimator, plan, settings ),
        .films = films < plan->eyes ? films : plan->eyes,
        .buffers = settings->queue > films ? films
                   : settings->queue > 1   ? settings->queue
                                           : 1,
        // of any number of frames: the least budget must not depend on it
        .ring = settings->queue > 1 ? settings->queue : 1,
        .aovs = settings->aovs,
        .cryptomatte = settings->cryptomatte,
        .covering = rf_wants_covering( settings ),
        .filtered = !rf_is_plain_filter( settings ) && !settings->estimator->draws_by_filter,
        .film_block = block,
        .stopping = rf_is_stopping( settings ),
        .paired = rf_is_stopping( settings ) && settings->flicker > 0.0,
        .adaptive = adaptive,
        .glints = glints,
        .materials = materials,
        .worlds = worlds,
        .moving = rf_worlds_bytes( scene, worlds, called.blur_steps ),
        .files = settings->files,
    };
}

RfEstimatorGroup rf_size_group( const RfScene* scene, RfSceneTraits called, const RfEye* eyes, int eye_count,
                                const RfRenderSettings* settings )
{
    return ( RfEstimatorGroup ){
        .settings = settings,
        .traits = rf_running_traits( scene, called ),
        .width = eyes->width,
        .height = eyes->height,
        .max_depth = settings->max_depth,
        .eyes = eyes,
        .eye_count = eye_count,
    };
}

static int matte_kinds( const RfRenderSizes* s )
{
    int kinds = 0;
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
        kinds += ( s->cryptomatte & 1u << k ) != 0;
    return kinds;
}

// Batches at once that keep all threads busy.
static int batches_wanted( const RfRenderSizes* s )
{
    int jobs = rf_batches_of_pass( s ), wanted = s->threads * BATCHES_PER_THREAD;
    int64_t all = (int64_t)jobs * ( s->threads > 1 ? s->passes : 1 );
    return all < wanted ? (int)all : wanted;
}

// What is kept at once of batches for frames (RfEstimator.land): of as many batches for each of `films` frames. One thread has no bands
// to share it among.
static int landing_count( const RfRenderSizes* s )
{
    if ( s->of_estimator.landing == 0 || s->threads == 1 || s->films == 0 ) // no films: none fits
        return 0;
    int each = ( s->threads * LANDINGS_PER_THREAD + s->films - 1 ) / s->films, batches = batches_wanted( s );
    return s->films * ( each < batches ? each : batches );
}

// Bytes that writing a frame takes. They are counted, not allocated here.
static size_t writer_bytes( const RfRenderSizes* s )
{
    int pixel_bytes =
        ( 1 + s->group_films ) * ( s->files.half ? 3 * 2 : 3 * 4 ) + matte_kinds( s ) * RF_CRYPTOMATTE_LAYERS * 4 * 4;
    for ( int a = 0; a < RF_AOV_COUNT; ++a )
    {
        if ( ( s->aovs & RF_AOV_BIT( a ) ) != 0 )
            pixel_bytes += rf_aov_channels( (RfAov)a ) * ( s->files.half && rf_aov_is_half( (RfAov)a ) ? 2 : 4 );
    }
    return s->files.written ? rf_exr_work_bytes( s->width, s->height, s->files.compression, pixel_bytes ) : 0;
}

#define WRITER "writer" // of files: allocated by OpenEXRCore while a frame is handed over
#define MOVING "moving" // what moves: allocated by render/worlds.h and Embree

#define MATTES ( RF_CRYPTOMATTE_KINDS * RF_CRYPTOMATTE_LAYERS )

// What is allocated is described once, by functions that take the blocks one after the other: to measure, allocate or free them,
// or to save them (render/state.c). Tables of blocks are left before they are allocated and after they are freed, so those who
// walk through them have a `none` for their entries.

typedef struct Walk
{
    RfMemoryWalk walk;
    RfArena* arena;
    size_t bytes;
    RfResult result;
    RfError* error;
} Walk;

static void measure( RfMemoryWalk* walk, const char* name, size_t bytes, void** block )
{
    (void)name, (void)block;
    ( (Walk*)walk )->bytes += rf_arena_size( bytes );
}

static void allocate( RfMemoryWalk* walk, const char* name, size_t bytes, void** block )
{
    Walk* w = (Walk*)walk;
    if ( w->result == RF_OK )
        w->result = rf_arena_alloc( w->arena, name, bytes, block, w->error );
}

static void release( RfMemoryWalk* walk, const char* name, size_t bytes, void** block )
{
    rf_arena_free( ( (Walk*)walk )->arena, name, *block, bytes );
}

static Walk begin_measuring( const RfRenderSizes* s ) { return ( Walk ){ .walk = { .take = measure, .sizes = s } }; }

static Walk begin_allocating( const RfRenderSizes* s, RfRenderMemory* m, RfError* error )
{
    return ( Walk ){ .walk = { .take = allocate, .sizes = s }, .arena = &m->arena, .error = error };
}

static Walk begin_freeing( const RfRenderSizes* s, RfRenderMemory* m )
{
    return ( Walk ){ .walk = { .take = release, .sizes = s }, .arena = &m->arena };
}

#define TAKE( walk, name, at, count )                                                                                            \
    do                                                                                                                           \
    {                                                                                                                            \
        if ( ( count ) > 0 )                                                                                                     \
            ( walk )->take( ( walk ), ( name ), (size_t)( count ) * sizeof *( at ), (void**)&( at ) );                           \
    } while ( 0 )

// Tables begin as zeros. They are closed after all that is in them.
#define OPEN_TABLE( walk, name, at, count )                                                                                      \
    do                                                                                                                           \
    {                                                                                                                            \
        if ( ( walk )->take != release )                                                                                         \
            TAKE( walk, name, at, count );                                                                                       \
        if ( ( walk )->take == allocate && ( at ) != NULL )                                                                      \
            memset( ( at ), 0, (size_t)( count ) * sizeof *( at ) );                                                             \
    } while ( 0 )
#define CLOSE_TABLE( walk, name, at, count )                                                                                     \
    do                                                                                                                           \
    {                                                                                                                            \
        if ( ( walk )->take == release )                                                                                         \
            TAKE( walk, name, at, count );                                                                                       \
    } while ( 0 )

// Blocks of `bytes` each, with a table of pointers to them.
static void walk_blocks( RfMemoryWalk* w, const char* name, int count, size_t bytes, void*** blocks )
{
    OPEN_TABLE( w, name, *blocks, count );
    for ( int i = 0; i < count; ++i )
    {
        void* none = NULL;
        w->take( w, name, bytes, *blocks != NULL ? *blocks + i : &none );
    }
    CLOSE_TABLE( w, name, *blocks, count );
}

// One frame on its way to the caller.
static void walk_buffer( RfMemoryWalk* w, RfFrameBuffer* buffer )
{
    const RfRenderSizes* s = w->sizes;
    size_t pixels = rf_film_pixels( s );
    TAKE( w, "image", buffer->rgb, 3 * pixels );
    TAKE( w, "image", buffer->weight, pixels );
    for ( int a = 0; a < RF_AOV_COUNT; ++a )
        TAKE( w, "layer images", buffer->layers[a],
              ( s->aovs & RF_AOV_BIT( a ) ) != 0 ? pixels * (size_t)rf_aov_channels( (RfAov)a ) : 0 );
    for ( int i = 0; i < MATTES; ++i )
        TAKE( w, "layer images", buffer->mattes[i], ( s->cryptomatte & 1u << i / RF_CRYPTOMATTE_LAYERS ) != 0 ? 4 * pixels : 0 );
    TAKE( w, "layer images", buffer->list, matte_kinds( s ) * RF_CRYPTOMATTE_LAYERS + s->group_films );
    for ( int g = 0; g < s->group_films; ++g )
        TAKE( w, "layer images", buffer->groups[g], 3 * pixels );
}

static void walk_film( RfMemoryWalk* w, RfFilm* film )
{
    const RfRenderSizes* s = w->sizes;
    bool split = s->of_estimator.splits;
    size_t means = ( split ? 2 : 1 ) * rf_film_pixels( s );
    if ( w->take == allocate )
        *film = ( RfFilm ){ .width = s->width, .height = s->height, .split = split, .block = s->film_block };
    for ( int h = 0; h < 2; ++h )
        TAKE( w, "films", film->half[h], 4 * means );
    TAKE( w, "films", film->mean, means );
}

void rf_walk_film_arrays( RfMemoryWalk* w, RfLiveFilm* live )
{
    const RfRenderSizes* s = w->sizes;
    size_t pixels = rf_film_pixels( s );
    RfFilm none = { 0 }, *first = live->films != NULL ? live->films : &none;
    for ( int f = 0; f < s->film_count; ++f )
        walk_film( w, live->films != NULL ? live->films + f : &none );
    for ( int h = 0; h < 2; ++h )
        TAKE( w, "adaptive", first->extra[h], s->adaptive ? pixels : 0 );
    TAKE( w, "adaptive", first->mean_b, s->adaptive ? pixels : 0 );
    TAKE( w, "adaptive", live->need, s->adaptive ? pixels : 0 );
    TAKE( w, "adaptive", live->glints, s->glints ? pixels : 0 );
    TAKE( w, "surfaces", live->covering, s->covering ? pixels : 0 );
    for ( int a = 0; a < RF_AOV_COUNT; ++a )
    {
        size_t floats = ( s->aovs & RF_AOV_BIT( a ) ) != 0 ? pixels * (size_t)rf_aov_film_floats( (RfAov)a, s->filtered ) : 0;
        if ( a == RF_AOV_SAMPLES )
            TAKE( w, "layers", live->aovs.landed, floats );
        else
            TAKE( w, "layers", live->aovs.mean[a], floats );
    }
}

static void walk_films( RfMemoryWalk* w, RfRenderMemory* m )
{
    const RfRenderSizes* s = w->sizes;
    OPEN_TABLE( w, "film table", m->films, s->films );
    TAKE( w, "film table", m->noise_estimates, s->stopping ? s->films : 0 );
    TAKE( w, "film table", m->kept_errors, s->paired ? RF_KEPT_FLOATS * rf_film_pixels( s ) : 0 );
    TAKE( w, "adaptive", m->noise, rf_material_noises( s ) );
    for ( int i = 0; i < s->films; ++i )
    {
        RfLiveFilm none = { 0 }, *live = m->films != NULL ? m->films + i : &none;
        OPEN_TABLE( w, "film table", live->films, s->film_count );
        rf_walk_film_arrays( w, live );
        CLOSE_TABLE( w, "film table", live->films, s->film_count );
    }
    CLOSE_TABLE( w, "film table", m->films, s->films );
}

static void walk_buffers( RfMemoryWalk* w, RfRenderMemory* m )
{
    OPEN_TABLE( w, "image", m->buffers, w->sizes->ring );
    for ( int i = 0; i < m->buffer_count; ++i )
        walk_buffer( w, m->buffers + i );
    CLOSE_TABLE( w, "image", m->buffers, w->sizes->ring );
}

static void walk_scratch( RfMemoryWalk* w, RfRenderMemory* m )
{
    const RfRenderSizes* s = w->sizes;
    walk_blocks( w, "scratch", s->threads, s->of_estimator.trace_scratch, &m->trace_scratch );
    walk_blocks( w, "scratch", s->threads, s->of_estimator.accumulate_scratch, &m->accumulate_scratch );
    walk_blocks( w, "scratch", landing_count( s ), s->of_estimator.landing, &m->landings );
    if ( s->of_estimator.finish_scratch > 0 )
        w->take( w, "scratch", s->of_estimator.finish_scratch, &m->finish_scratch );
    if ( s->of_estimator.shared > 0 )
        w->take( w, s->of_estimator.shared_name, s->of_estimator.shared, &m->shared );
}

// What they measure.

static size_t measured( const RfRenderSizes* s, void ( *walk )( RfMemoryWalk*, RfRenderMemory* ) )
{
    RfRenderMemory none = { 0 };
    Walk w = begin_measuring( s );
    walk( &w.walk, &none );
    return w.bytes;
}

size_t rf_films_bytes( const RfRenderSizes* s ) { return measured( s, walk_films ); }

static size_t image_bytes( const RfRenderSizes* s )
{
    RfFrameBuffer none = { 0 };
    Walk w = begin_measuring( s );
    walk_buffer( &w.walk, &none );
    return w.bytes;
}

static size_t records_bytes( const RfRenderSizes* s, int batches )
{
    void** none = NULL;
    Walk w = begin_measuring( s );
    walk_blocks( &w.walk, "hit records", batches, s->of_estimator.batch, &none );
    return w.bytes;
}

// Of everything but the batches, with one finished frame.
static size_t fixed_bytes( const RfRenderSizes* s )
{
    size_t counted = rf_piece_bytes( writer_bytes( s ) ) + rf_piece_bytes( s->moving );
    return rf_films_bytes( s ) + measured( s, walk_buffers ) + image_bytes( s ) + measured( s, walk_scratch ) + counted;
}

static RfResult alloc_buffer( const RfRenderSizes* s, RfRenderMemory* m, RfError* error )
{
    Walk w = begin_allocating( s, m, error );
    walk_buffer( &w.walk, m->buffers + m->buffer_count++ );
    return w.result;
}

// Pieces clear their frames only where they are traced. What lands elsewhere is never looked at, but it must not be added to
// what the memory happens to hold.
static void clear_films( const RfRenderSizes* s, RfRenderMemory* m )
{
    for ( int i = 0; i < s->films * s->film_count; ++i )
        rf_clear_film( m->films[i / s->film_count].films + i % s->film_count );
}

// As many batches at once as serve the threads and fit the budget, at least one.
static int batch_slots( const RfRenderSizes* s, const RfRenderMemory* m )
{
    int slots = batches_wanted( s );
    size_t room = arena_room( &m->arena );
    if ( records_bytes( s, slots ) <= room )
        return slots;
    int fit = (int)( room / ( records_bytes( s, slots ) / (size_t)slots ) ); // upper bound
    while ( fit > 1 && records_bytes( s, fit ) > room )
        fit -= 1;
    return fit > 1 ? fit : 1;
}

// More buffers, as long as they leave room for all batches.
static RfResult alloc_more_buffers( const RfRenderSizes* s, RfRenderMemory* m, RfError* error )
{
    size_t batches = records_bytes( s, batch_slots( s, m ) );
    RfResult result = RF_OK;
    while ( result == RF_OK && m->buffer_count < s->buffers && arena_room( &m->arena ) > batches &&
            arena_room( &m->arena ) - batches >= image_bytes( s ) )
        result = alloc_buffer( s, m, error );
    return result;
}

static RfResult alloc_batches( const RfEstimatorGroup* group, const RfRenderSizes* s, RfRenderMemory* m, RfError* error )
{
    Walk w = begin_allocating( s, m, error );
    m->batch_slots = batch_slots( s, m );
    walk_blocks( &w.walk, "hit records", m->batch_slots, s->of_estimator.batch, &m->batches );
    for ( int i = 0; i < m->batch_slots && w.result == RF_OK; ++i )
        s->estimator->lay_out_batch( group, m->batches[i] );
    return w.result;
}

// A process that goes beyond the limit of its control group is killed in the midst of its work.
static RfResult check_permitted( const RfRenderSizes* s, RfRenderMemory* m, RfError* error )
{
    size_t permitted = rf_permitted_memory();
    size_t needed = fixed_bytes( s ) + records_bytes( s, 1 );
    if ( needed > permitted )
    {
        char needs[RF_BYTES_TEXT_SIZE], may[RF_BYTES_TEXT_SIZE];
        rf_format_memory( ( ( needed >> 20 ) + 1 ) << 20, needs );
        rf_format_memory( permitted >> 20 << 20, may );
        return rf_advise( rf_fail( error, RF_ERROR_MEMORY,
                                   "frames of %dx%d need %s, and the limit of this process (control group, ulimit -v) leaves %s",
                                   s->width, s->height, needs, may ),
                          RF_REMEDY_LIMIT, 0, error );
    }
    m->arena.budget = m->arena.budget < permitted ? m->arena.budget : permitted;
    return RF_OK;
}

RfResult rf_alloc_render_memory( const RfEstimatorGroup* group, const RfRenderSizes* sizes, RfRenderMemory* memory,
                                 RfError* error )
{
    RfResult result = check_permitted( sizes, memory, error );
    if ( result == RF_OK && writer_bytes( sizes ) > 0 )
        result = arena_reserve( &memory->arena, WRITER, writer_bytes( sizes ), error );
    memory->has_writer = writer_bytes( sizes ) > 0 && result == RF_OK;
    if ( result == RF_OK && sizes->moving > 0 )
        result = arena_reserve( &memory->arena, MOVING, sizes->moving, error );
    memory->has_moving = sizes->moving > 0 && result == RF_OK;
    if ( result != RF_OK )
        return result;
    Walk w = begin_allocating( sizes, memory, error );
    walk_films( &w.walk, memory );
    memory->film_slots = memory->films != NULL ? sizes->films : 0;
    for ( int i = 0; i < memory->film_slots; ++i )
        memory->films[i].frame = -1;
    if ( w.result == RF_OK && group->settings->pieces != NULL )
        clear_films( sizes, memory );
    walk_buffers( &w.walk, memory );
    if ( w.result == RF_OK )
        w.result = alloc_buffer( sizes, memory, error ); // at least one is needed
    memory->landing_slots = landing_count( sizes );
    walk_scratch( &w.walk, memory );
    if ( w.result != RF_OK )
        return w.result;
    for ( int t = 0; t < sizes->threads; ++t )
        sizes->estimator->lay_out_scratch( group, memory->trace_scratch[t] );
    if ( memory->shared != NULL )
        memset( memory->shared, 0, sizes->of_estimator.shared );
    result = alloc_more_buffers( sizes, memory, error );
    return result == RF_OK ? alloc_batches( group, sizes, memory, error ) : result;
}

void rf_free_render_memory( const RfRenderSizes* s, RfRenderMemory* m )
{
    Walk w = begin_freeing( s, m );
    if ( m->has_writer )
        arena_release( &m->arena, WRITER, writer_bytes( s ) );
    if ( m->has_moving )
        arena_release( &m->arena, MOVING, s->moving );
    walk_films( &w.walk, m );
    walk_buffers( &w.walk, m );
    walk_scratch( &w.walk, m );
    walk_blocks( &w.walk, "hit records", m->batch_slots, s->of_estimator.batch, &m->batches );
}

// How a render fits its budget: first with fewer batches at once, then with fewer threads or with the films of fewer frames,
// whichever costs less time.

// Fewest batches that keep all threads busy.
static int batches_needed( const RfRenderSizes* s )
{
    int wanted = batches_wanted( s );
    return wanted < s->threads ? wanted : s->threads;
}

static size_t needed_bytes( const RfRenderSizes* s ) { return fixed_bytes( s ) + records_bytes( s, batches_needed( s ) ); }

// Most threads that fit the budget, up to sizes.threads; 0: none.
static int threads_that_fit( size_t budget, RfRenderSizes sizes )
{
    int low = 0, high = sizes.threads;
    while ( low < high )
    {
        sizes.threads = ( low + high + 1 ) / 2;
        if ( needed_bytes( &sizes ) <= budget )
            low = sizes.threads;
        else
            high = sizes.threads - 1;
    }
    return low;
}

// A sweep for k frames renders groups of the 2n frames around them, too.
static double time_of( int films, int threads, int frames, int eyes )
{
    double sweeps = films == frames || films == eyes ? 1.0 : (double)( films + eyes - 1 ) / (double)films;
    return sweeps / (double)threads;
}

static void choose( size_t budget, int frames, RfRenderSizes* sizes )
{
    RfRenderSizes best = *sizes, tried = *sizes;
    best.films = best.threads = 0;
    double least = 0.0;
    for ( tried.films = sizes->films; tried.films > ( sizes->paired ? sizes->films - 1 : 0 ); --tried.films )
    {
        int threads = threads_that_fit( budget, tried );
        double time = threads > 0 ? time_of( tried.films, threads, frames, sizes->eyes ) : 0.0;
        if ( threads == 0 || ( best.threads > 0 && time >= least ) )
            continue;
        best.films = tried.films;
        best.threads = threads;
        least = time;
        if ( tried.films == sizes->films && threads == sizes->threads )
            break;
    }
    *sizes = best;
}

// Rounded up to KiB, so that it can be typed.
static size_t least_budget( RfRenderSizes sizes )
{
    sizes.threads = 1;
    sizes.films = sizes.paired ? sizes.films : 1;
    return ( needed_bytes( &sizes ) + 1023 ) / 1024 * 1024;
}

static int up( int a, int b ) { return ( a + b - 1 ) / b; }

static int batches_that_fit( size_t budget, const RfRenderSizes* s )
{
    int batches = batches_wanted( s );
    size_t room = budget - fixed_bytes( s );
    while ( batches > batches_needed( s ) && records_bytes( s, batches ) > room )
        batches -= 1;
    return batches;
}

static RfResult fail_least( size_t budget, size_t least, const RfRenderSizes* sizes, RfError* error )
{
    char text[RF_BYTES_TEXT_SIZE], moving[64] = "";
    rf_format_memory( budget, text );
    if ( sizes->worlds > 0 )
        snprintf( moving, sizeof moving, " and what moves in %d of them at once", sizes->worlds );
    return rf_advise( rf_fail( error, RF_ERROR_MEMORY, "a budget of %s is too small for frames of %dx%d%s", text, sizes->width,
                               sizes->height, moving ),
                      RF_REMEDY_MEMORY, least, error );
}

RfResult rf_fit_sizes( size_t budget, int frames, RfRenderSizes* sizes, RfMemoryFit* fit, RfError* error )
{
    int wanted = sizes->films;
    *fit = ( RfMemoryFit ){ .least = least_budget( *sizes ) };
    choose( budget, frames, sizes );
    if ( sizes->films == 0 )
        return fail_least( budget, fit->least, sizes, error );
    fit->threads = sizes->threads;
    fit->films = sizes->films;
    fit->sweeps = sizes->films == wanted ? 1 : up( frames, sizes->films );
    fit->batches = batches_that_fit( budget, sizes );
    fit->chunks = up( rf_batches_of_pass( sizes ), fit->batches );
    fit->bytes_films = rf_films_bytes( sizes ) + measured( sizes, walk_buffers ) + image_bytes( sizes );
    fit->bytes_hits = records_bytes( sizes, fit->batches );
    fit->bytes_lists = measured( sizes, walk_scratch ) + writer_bytes( sizes ) + sizes->moving;
    return RF_OK;
}

RfResult rf_fit_memory( const RfShot* shot, const RfRenderSettings* settings, RfMemoryFit* fit, RfError* error )
{
    if ( shot->frame_count < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "a render needs at least one frame" );
    RfGroupPlan plan = rf_plan_shots( shot->eyes, shot->eye_count, settings->group, settings->spp );
    RfRenderSizes sizes = rf_render_sizes( rf_tracer_scene( shot->tracer ), shot->eyes, &plan, shot->frame_count, settings );
    return rf_fit_sizes( settings->memory, shot->frame_count, &sizes, fit, error );
}
