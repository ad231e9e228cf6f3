// How a render fits its budget, and its memory from its arena and back. sizes.c knows the sums.
#include "render/memory/memory.h"

#include "base/remedy.h"
#include "base/system.h"

#include <stdio.h>
#include <string.h>

#define SHARED "light paths"
#define WRITER "writer" // of files: allocated by OpenEXRCore while a frame is handed over
#define MOVING "moving" // what moves: allocated by render/worlds.h and Embree

static size_t film_pixels( const RfRenderSizes* s ) { return (size_t)s->width * (size_t)s->height; }

#define MATTES ( RF_CRYPTOMATTE_KINDS * RF_CRYPTOMATTE_LAYERS )
static size_t group_bytes( const RfRenderSizes* s ) { return film_pixels( s ) * 3 * sizeof( float ); }

// One frame on its way to the caller.
static RfResult alloc_buffer( const RfRenderSizes* s, RfRenderMemory* m, RfError* error )
{
    RfFrameBuffer* buffer = m->buffers + m->buffer_count;
    *buffer = ( RfFrameBuffer ){ 0 };
    m->buffer_count += 1;
    RfResult result = rf_arena_alloc( &m->arena, "image", film_pixels( s ) * 3 * sizeof( float ), (void**)&buffer->rgb, error );
    if ( result == RF_OK )
        result = rf_arena_alloc( &m->arena, "image", film_pixels( s ) * sizeof( float ), (void**)&buffer->weight, error );
    for ( int a = 0; a < RF_AOV_COUNT && result == RF_OK; ++a )
    {
        if ( rf_aov_image_bytes( s, a ) > 0 )
            result = rf_arena_alloc( &m->arena, "layer images", rf_aov_image_bytes( s, a ), (void**)&buffer->layers[a], error );
    }
    for ( int i = 0; i < MATTES && result == RF_OK; ++i )
    {
        size_t bytes = rf_matte_bytes( s, i / RF_CRYPTOMATTE_LAYERS );
        if ( bytes > 0 )
            result = rf_arena_alloc( &m->arena, "layer images", bytes, (void**)&buffer->mattes[i], error );
    }
    if ( rf_layer_list_bytes( s ) > 0 && result == RF_OK )
        result = rf_arena_alloc( &m->arena, "layer images", rf_layer_list_bytes( s ), (void**)&buffer->list, error );
    for ( int g = 0; g < s->group_films && result == RF_OK; ++g )
        result = rf_arena_alloc( &m->arena, "layer images", group_bytes( s ), (void**)&buffer->groups[g], error );
    return result;
}

static void free_buffer( const RfRenderSizes* s, RfRenderMemory* m, RfFrameBuffer* buffer )
{
    rf_arena_free( &m->arena, "image", buffer->rgb, film_pixels( s ) * 3 * sizeof( float ) );
    rf_arena_free( &m->arena, "image", buffer->weight, film_pixels( s ) * sizeof( float ) );
    for ( int a = 0; a < RF_AOV_COUNT; ++a )
        rf_arena_free( &m->arena, "layer images", buffer->layers[a], rf_aov_image_bytes( s, a ) );
    for ( int i = 0; i < MATTES; ++i )
        rf_arena_free( &m->arena, "layer images", buffer->mattes[i], rf_matte_bytes( s, i / RF_CRYPTOMATTE_LAYERS ) );
    rf_arena_free( &m->arena, "layer images", buffer->list, rf_layer_list_bytes( s ) );
    for ( int g = 0; g < s->group_films; ++g )
        rf_arena_free( &m->arena, "layer images", buffer->groups[g], group_bytes( s ) );
}

// The first buffer: at least one is needed.
static RfResult alloc_first_buffer( const RfRenderSizes* s, RfRenderMemory* m, RfError* error )
{
    size_t bytes = (size_t)s->ring * sizeof *m->buffers;
    RfResult result = rf_arena_alloc( &m->arena, "image", bytes, (void**)&m->buffers, error );
    return result == RF_OK ? alloc_buffer( s, m, error ) : result;
}

static RfResult alloc_aov_film( const RfRenderSizes* s, RfRenderMemory* m, RfAovFilm* aovs, RfError* error )
{
    RfResult result = RF_OK;
    for ( int a = 0; a < RF_AOV_COUNT && result == RF_OK; ++a )
    {
        void** where = a == RF_AOV_SAMPLES ? (void**)&aovs->landed : (void**)&aovs->mean[a];
        if ( rf_aov_film_bytes( s, a ) > 0 )
            result = rf_arena_alloc( &m->arena, "layers", rf_aov_film_bytes( s, a ), where, error );
    }
    return result;
}

static void free_aov_film( const RfRenderSizes* s, RfRenderMemory* m, const RfAovFilm* aovs )
{
    for ( int a = 0; a < RF_AOV_COUNT; ++a )
        rf_arena_free( &m->arena, "layers", aovs->mean[a], rf_aov_film_bytes( s, a ) );
    rf_arena_free( &m->arena, "layers", aovs->landed, rf_aov_film_bytes( s, RF_AOV_SAMPLES ) );
}

static RfResult alloc_film( const RfRenderSizes* s, RfRenderMemory* m, RfFilm* film, RfError* error )
{
    RfResult result = RF_OK;
    *film = ( RfFilm ){ .width = s->width, .height = s->height, .split = s->of_estimator.splits, .total_every = s->total_every };
    for ( int h = 0; h < 2 && result == RF_OK; ++h )
        result = rf_arena_alloc( &m->arena, "films", rf_half_bytes( s ), (void**)&film->half[h], error );
    for ( int h = 0; h < 2 && result == RF_OK && s->total_every > 0; ++h )
        result = rf_arena_alloc( &m->arena, "films", rf_totals_bytes( s ), (void**)&film->total[h], error );
    return result;
}

static size_t films_table_bytes( const RfRenderSizes* s ) { return (size_t)s->film_count * sizeof( RfFilm ); }

static RfResult alloc_live_film( const RfRenderSizes* s, RfRenderMemory* m, RfLiveFilm* live, RfError* error )
{
    RfResult result = RF_OK;
    live->frame = -1;
    result = rf_arena_alloc( &m->arena, "film table", films_table_bytes( s ), (void**)&live->films, error );
    if ( result == RF_OK )
        memset( live->films, 0, films_table_bytes( s ) );
    for ( int f = 0; f < s->film_count && result == RF_OK; ++f )
        result = alloc_film( s, m, live->films + f, error );
    for ( int h = 0; h < 2 && result == RF_OK && s->adaptive; ++h )
        result = rf_arena_alloc( &m->arena, "adaptive", rf_extra_bytes( s ), (void**)&live->films[0].extra[h], error );
    if ( s->adaptive && result == RF_OK )
        result = rf_arena_alloc( &m->arena, "adaptive", rf_need_bytes( s ), (void**)&live->need, error );
    if ( s->glints && result == RF_OK )
        result = rf_arena_alloc( &m->arena, "adaptive", rf_glints_bytes( s ), (void**)&live->glints, error );
    if ( s->of_estimator.pass_state > 0 && result == RF_OK )
        result = rf_arena_alloc( &m->arena, "landed cameras", s->of_estimator.pass_state, &live->pass_state, error );
    if ( s->covering && result == RF_OK )
        result = rf_arena_alloc( &m->arena, "surfaces", rf_covering_bytes( s ), (void**)&live->covering, error );
    if ( result == RF_OK )
        result = alloc_aov_film( s, m, &live->aovs, error );
    return result;
}

static RfResult alloc_films( const RfRenderSizes* s, RfRenderMemory* m, RfError* error )
{
    size_t bytes = (size_t)s->films * sizeof *m->films;
    RfResult result = rf_arena_alloc( &m->arena, "film table", bytes, (void**)&m->films, error );
    if ( result != RF_OK )
        return result;
    memset( m->films, 0, bytes );
    m->film_slots = s->films;
    if ( s->stopping )
        result = rf_arena_alloc( &m->arena, "film table", rf_noise_estimates_bytes( s ), (void**)&m->noise_estimates, error );
    if ( s->paired && result == RF_OK )
        result = rf_arena_alloc( &m->arena, "film table", rf_kept_errors_bytes( s ), (void**)&m->kept_errors, error );
    if ( s->materials > 0 && result == RF_OK )
        result = rf_arena_alloc( &m->arena, "adaptive", rf_material_noise_bytes( s ), (void**)&m->noise, error );
    for ( int i = 0; i < s->films && result == RF_OK; ++i )
        result = alloc_live_film( s, m, m->films + i, error );
    return result;
}

// Pieces clear their frames only where they are traced. What lands elsewhere is never looked at, but it must not be added to
// what the memory happens to hold.
static void clear_films( const RfRenderSizes* s, RfRenderMemory* m )
{
    for ( int i = 0; i < s->films * s->film_count; ++i )
        rf_clear_film( m->films[i / s->film_count].films + i % s->film_count );
}

// `count` blocks of `bytes` each, with a table of pointers to them.
static RfResult alloc_blocks( RfRenderMemory* m, const char* name, int count, size_t bytes, void*** blocks, RfError* error )
{
    size_t table = (size_t)count * sizeof **blocks;
    RfResult result = rf_arena_alloc( &m->arena, name, table, (void**)blocks, error );
    if ( result != RF_OK )
        return result;
    memset( *blocks, 0, table );
    for ( int i = 0; i < count && result == RF_OK; ++i )
        result = rf_arena_alloc( &m->arena, name, bytes, *blocks + i, error );
    return result;
}

static void free_blocks( RfRenderMemory* m, const char* name, int count, size_t bytes, void** blocks )
{
    for ( int i = 0; blocks != NULL && i < count; ++i )
        rf_arena_free( &m->arena, name, blocks[i], bytes );
    rf_arena_free( &m->arena, name, blocks, (size_t)count * sizeof *blocks );
}

static RfResult alloc_scratch( const RfEstimatorGroup* group, const RfRenderSizes* s, RfRenderMemory* m, RfError* error )
{
    RfResult result = alloc_blocks( m, "scratch", s->threads, s->of_estimator.trace_scratch, &m->trace_scratch, error );
    for ( int t = 0; t < s->threads && result == RF_OK; ++t )
        s->estimator->lay_out_scratch( group, m->trace_scratch[t] );
    if ( result == RF_OK )
        result = alloc_blocks( m, "scratch", s->threads, s->of_estimator.accumulate_scratch, &m->accumulate_scratch, error );
    m->landing_slots = rf_landings( s );
    if ( result == RF_OK && m->landing_slots > 0 )
        result = alloc_blocks( m, "scratch", m->landing_slots, s->of_estimator.landing, &m->landings, error );
    if ( result == RF_OK && s->of_estimator.finish_scratch > 0 )
        result = rf_arena_alloc( &m->arena, "scratch", s->of_estimator.finish_scratch, &m->finish_scratch, error );
    if ( result == RF_OK && s->of_estimator.shared > 0 )
        result = rf_arena_alloc( &m->arena, SHARED, s->of_estimator.shared, &m->shared, error );
    if ( result == RF_OK && s->of_estimator.shared > 0 )
        memset( m->shared, 0, s->of_estimator.shared );
    return result;
}

// As many batches at once as serve the threads and fit the budget, at least one.
static int batch_slots( const RfRenderSizes* s, const RfRenderMemory* m )
{
    int slots = rf_batches_wanted( s );
    size_t room = rf_arena_room( &m->arena );
    if ( s->of_estimator.whole_pass || rf_records_bytes( s, slots ) <= room )
        return slots;
    int fit = (int)( room / ( rf_records_bytes( s, slots ) / (size_t)slots ) ); // upper bound
    while ( fit > 1 && rf_records_bytes( s, fit ) > room )
        fit -= 1;
    return fit > 1 ? fit : 1;
}

// More buffers, as long as they leave room for all batches.
static RfResult alloc_more_buffers( const RfRenderSizes* s, RfRenderMemory* m, RfError* error )
{
    size_t batches = rf_records_bytes( s, batch_slots( s, m ) );
    RfResult result = RF_OK;
    while ( result == RF_OK && m->buffer_count < s->buffers && rf_arena_room( &m->arena ) > batches &&
            rf_arena_room( &m->arena ) - batches >= rf_image_bytes( s ) )
        result = alloc_buffer( s, m, error );
    return result;
}

static RfResult alloc_batches( const RfEstimatorGroup* group, const RfRenderSizes* s, RfRenderMemory* m, RfError* error )
{
    m->batch_slots = batch_slots( s, m );
    RfResult result = alloc_blocks( m, "hit records", m->batch_slots, s->of_estimator.batch, &m->batches, error );
    for ( int i = 0; i < m->batch_slots && result == RF_OK; ++i )
        s->estimator->lay_out_batch( group, m->batches[i] );
    return result;
}

// A process that goes beyond the limit of its control group is killed in the midst of its work.
static RfResult check_permitted( const RfRenderSizes* s, RfRenderMemory* m, RfError* error )
{
    size_t permitted = rf_permitted_memory();
    size_t needed = rf_films_bytes( s ) + rf_image_bytes( s ) + rf_scratch_bytes( s ) + rf_writer_bytes( s ) + s->moving +
                    rf_records_bytes( s, s->of_estimator.whole_pass ? rf_batches_wanted( s ) : 1 );
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
    if ( result == RF_OK && rf_writer_bytes( sizes ) > 0 )
        result = rf_arena_reserve( &memory->arena, WRITER, rf_writer_bytes( sizes ), error );
    memory->has_writer = rf_writer_bytes( sizes ) > 0 && result == RF_OK;
    if ( result == RF_OK && sizes->moving > 0 )
        result = rf_arena_reserve( &memory->arena, MOVING, sizes->moving, error );
    memory->has_moving = sizes->moving > 0 && result == RF_OK;
    if ( result == RF_OK )
        result = alloc_films( sizes, memory, error );
    if ( result == RF_OK && group->settings->pieces != NULL )
        clear_films( sizes, memory );
    if ( result == RF_OK )
        result = alloc_first_buffer( sizes, memory, error );
    if ( result == RF_OK )
        result = alloc_scratch( group, sizes, memory, error );
    if ( result == RF_OK )
        result = alloc_more_buffers( sizes, memory, error );
    if ( result == RF_OK )
        result = alloc_batches( group, sizes, memory, error );
    return result;
}

static void free_live_film( const RfRenderSizes* s, RfRenderMemory* m, RfLiveFilm* live )
{
    for ( int f = 0; f < s->film_count && live->films != NULL; ++f )
    {
        for ( int h = 0; h < 2; ++h )
        {
            rf_arena_free( &m->arena, "films", live->films[f].half[h], rf_half_bytes( s ) );
            rf_arena_free( &m->arena, "films", live->films[f].total[h], rf_totals_bytes( s ) );
        }
    }
    for ( int h = 0; h < 2 && live->films != NULL; ++h )
        rf_arena_free( &m->arena, "adaptive", live->films[0].extra[h], rf_extra_bytes( s ) );
    rf_arena_free( &m->arena, "film table", live->films, films_table_bytes( s ) );
    rf_arena_free( &m->arena, "adaptive", live->need, rf_need_bytes( s ) );
    rf_arena_free( &m->arena, "adaptive", live->glints, rf_glints_bytes( s ) );
    rf_arena_free( &m->arena, "landed cameras", live->pass_state, s->of_estimator.pass_state );
    rf_arena_free( &m->arena, "surfaces", live->covering, rf_covering_bytes( s ) );
    free_aov_film( s, m, &live->aovs );
}

void rf_free_render_memory( const RfRenderSizes* s, RfRenderMemory* m )
{
    if ( m->has_writer )
        rf_arena_release( &m->arena, WRITER, rf_writer_bytes( s ) );
    if ( m->has_moving )
        rf_arena_release( &m->arena, MOVING, s->moving );
    for ( int i = 0; i < m->film_slots; ++i )
        free_live_film( s, m, m->films + i );
    rf_arena_free( &m->arena, "adaptive", m->noise, rf_material_noise_bytes( s ) );
    rf_arena_free( &m->arena, "film table", m->kept_errors, rf_kept_errors_bytes( s ) );
    rf_arena_free( &m->arena, "film table", m->noise_estimates, rf_noise_estimates_bytes( s ) );
    rf_arena_free( &m->arena, "film table", m->films, (size_t)s->films * sizeof *m->films );
    for ( int i = 0; i < m->buffer_count; ++i )
        free_buffer( s, m, m->buffers + i );
    rf_arena_free( &m->arena, "image", m->buffers, (size_t)s->ring * sizeof *m->buffers );
    free_blocks( m, "scratch", s->threads, s->of_estimator.trace_scratch, m->trace_scratch );
    free_blocks( m, "scratch", s->threads, s->of_estimator.accumulate_scratch, m->accumulate_scratch );
    free_blocks( m, "scratch", m->landing_slots, s->of_estimator.landing, m->landings );
    rf_arena_free( &m->arena, "scratch", m->finish_scratch, s->of_estimator.finish_scratch );
    rf_arena_free( &m->arena, SHARED, m->shared, s->of_estimator.shared );
    free_blocks( m, "hit records", m->batch_slots, s->of_estimator.batch, m->batches );
}

// How a render fits its budget: first with fewer batches at once, then with fewer threads or with the films of fewer frames,
// whichever costs less time.

// Fewest batches that keep all threads busy.
static int batches_needed( const RfRenderSizes* s )
{
    int wanted = rf_batches_wanted( s );
    return s->of_estimator.whole_pass || wanted < s->threads ? wanted : s->threads;
}

static size_t needed_bytes( const RfRenderSizes* s ) { return rf_fixed_bytes( s ) + rf_records_bytes( s, batches_needed( s ) ); }

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
    int batches = rf_batches_wanted( s );
    size_t room = budget - rf_fixed_bytes( s );
    while ( batches > batches_needed( s ) && rf_records_bytes( s, batches ) > room )
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
    fit->bytes_films = rf_films_bytes( sizes ) + rf_ring_bytes( sizes ) + rf_image_bytes( sizes );
    fit->bytes_hits = rf_records_bytes( sizes, fit->batches );
    fit->bytes_lists = rf_scratch_bytes( sizes ) + rf_writer_bytes( sizes ) + sizes->moving;
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
