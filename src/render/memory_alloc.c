// A render's memory from its arena, and back. memory_sizes.c knows the sums.
#include "render/render_internal.h"

#include <string.h>

#define WRITER "writer" // of files: allocated by OpenEXRCore while a frame is handed over

static size_t film_pixels( const RenderSizes* s ) { return (size_t)s->width * (size_t)s->height; }

// One frame on its way to the caller.
static RfResult alloc_buffer( const RenderSizes* s, RenderMemory* m, RfError* error )
{
    RfFrameBuffer* buffer = m->buffers + m->buffer_count;
    *buffer = ( RfFrameBuffer ){ 0 };
    m->buffer_count += 1;
    RfResult result = rf_arena_alloc( &m->arena, "image", film_pixels( s ) * 3 * sizeof( float ), (void**)&buffer->rgb, error );
    if ( result == RF_OK )
        result = rf_arena_alloc( &m->arena, "image", film_pixels( s ) * sizeof( float ), (void**)&buffer->weight, error );
    for ( int l = 0; l < RF_AOV_COUNT && result == RF_OK; ++l )
    {
        if ( rf_aov_image_bytes( s, l ) > 0 )
            result = rf_arena_alloc( &m->arena, "layer images", rf_aov_image_bytes( s, l ), (void**)&buffer->layers[l], error );
    }
    return result;
}

static void free_buffer( const RenderSizes* s, RenderMemory* m, RfFrameBuffer* buffer )
{
    rf_arena_free( &m->arena, "image", buffer->rgb, film_pixels( s ) * 3 * sizeof( float ) );
    rf_arena_free( &m->arena, "image", buffer->weight, film_pixels( s ) * sizeof( float ) );
    for ( int l = 0; l < RF_AOV_COUNT; ++l )
        rf_arena_free( &m->arena, "layer images", buffer->layers[l], rf_aov_image_bytes( s, l ) );
}

// The first buffer, without which nothing can be finished.
static RfResult alloc_first_buffer( const RenderSizes* s, RenderMemory* m, RfError* error )
{
    size_t bytes = (size_t)s->buffers * sizeof *m->buffers;
    RfResult result = rf_arena_alloc( &m->arena, "image", bytes, (void**)&m->buffers, error );
    return result == RF_OK ? alloc_buffer( s, m, error ) : result;
}

static RfResult alloc_layer_film( const RenderSizes* s, RenderMemory* m, RfAovFilm* layers, RfError* error )
{
    RfResult result = RF_OK;
    for ( int l = 0; l < RF_AOV_COUNT && result == RF_OK; ++l )
    {
        void** where = l == RF_AOV_SAMPLES ? (void**)&layers->landed : (void**)&layers->mean[l];
        if ( rf_aov_film_bytes( s, l ) > 0 )
            result = rf_arena_alloc( &m->arena, "layers", rf_aov_film_bytes( s, l ), where, error );
    }
    return result;
}

static void free_layer_film( const RenderSizes* s, RenderMemory* m, const RfAovFilm* layers )
{
    for ( int l = 0; l < RF_AOV_COUNT; ++l )
        rf_arena_free( &m->arena, "layers", layers->mean[l], rf_aov_film_bytes( s, l ) );
    rf_arena_free( &m->arena, "layers", layers->landed, rf_aov_film_bytes( s, RF_AOV_SAMPLES ) );
}

static RfResult alloc_film( const RenderSizes* s, RenderMemory* m, LiveFilm* live, RfError* error )
{
    RfResult result = RF_OK;
    live->frame = -1;
    live->film.width = s->width;
    live->film.height = s->height;
    live->film.total_every = s->total_every;
    for ( int h = 0; h < 2 && result == RF_OK; ++h )
        result =
            rf_arena_alloc( &m->arena, "films", rf_film_half_bytes( s->width, s->height ), (void**)&live->film.half[h], error );
    for ( int h = 0; h < 2 && result == RF_OK && s->total_every > 0; ++h )
        result = rf_arena_alloc( &m->arena, "films", rf_totals_bytes( s ), (void**)&live->film.total[h], error );
    for ( int h = 0; h < 2 && result == RF_OK && s->adaptive; ++h )
        result = rf_arena_alloc( &m->arena, "adaptive", rf_extra_bytes( s ), (void**)&live->film.extra[h], error );
    if ( s->adaptive && result == RF_OK )
        result = rf_arena_alloc( &m->arena, "adaptive", rf_need_bytes( s ), (void**)&live->need, error );
    if ( s->shape.eq15 && result == RF_OK )
        result = rf_arena_alloc( &m->arena, "landed eyes", rf_landed_bytes( s ), (void**)&live->landed_eyes, error );
    if ( result == RF_OK )
        result = alloc_layer_film( s, m, &live->layers, error );
    return result;
}

static RfResult alloc_films( const RenderSizes* s, RenderMemory* m, RfError* error )
{
    size_t bytes = (size_t)s->films * sizeof *m->films;
    RfResult result = rf_arena_alloc( &m->arena, "film table", bytes, (void**)&m->films, error );
    if ( result != RF_OK )
        return result;
    memset( m->films, 0, bytes );
    m->film_slots = s->films;
    if ( s->stopping )
        result = rf_arena_alloc( &m->arena, "film table", rf_noise_estimates_bytes( s ), (void**)&m->looks, error );
    for ( int i = 0; i < s->films && result == RF_OK; ++i )
        result = alloc_film( s, m, m->films + i, error );
    return result;
}

static RfResult alloc_scratch( const RenderSizes* s, RenderMemory* m, RfError* error )
{
    size_t threads = (size_t)s->threads;
    RfResult result =
        rf_arena_alloc( &m->arena, "scratch", threads * sizeof *m->harvest_scratch, (void**)&m->harvest_scratch, error );
    if ( result != RF_OK )
        return result;
    memset( m->harvest_scratch, 0, threads * sizeof *m->harvest_scratch );
    for ( size_t t = 0; t < threads; ++t )
    {
        void* memory = NULL;
        result = rf_arena_alloc( &m->arena, "scratch", rf_harvest_scratch_bytes( &s->shape ), &memory, error );
        if ( result != RF_OK )
            return result;
        m->harvest_scratch[t] = rf_lay_out_harvest_scratch( &s->shape, memory );
    }
    return rf_arena_alloc( &m->arena, "scratch", threads * sizeof *m->compute_scratch, (void**)&m->compute_scratch, error );
}

// Held records come later.
static size_t room_for_batches( const RenderSizes* s, const RenderMemory* m )
{
    size_t room = rf_arena_room( &m->arena );
    return room > s->held ? room - s->held : 0;
}

// As many batches at once as serve the threads and fit the budget, at least one.
static int batch_slots( const RenderSizes* s, const RenderMemory* m )
{
    int slots = rf_batches_wanted( s );
    size_t room = room_for_batches( s, m );
    if ( s->shape.eq15 || rf_records_bytes( s, slots ) <= room )
        return slots;
    int fit = (int)( room / ( rf_records_bytes( s, slots ) / (size_t)slots ) ); // no more than that many
    while ( fit > 1 && rf_records_bytes( s, fit ) > room )
        fit -= 1;
    return fit > 1 ? fit : 1;
}

// Buffers beyond the first, as long as they take no batches away.
static RfResult alloc_more_buffers( const RenderSizes* s, RenderMemory* m, RfError* error )
{
    size_t batches = rf_records_bytes( s, batch_slots( s, m ) );
    RfResult result = RF_OK;
    while ( result == RF_OK && m->buffer_count < s->buffers && room_for_batches( s, m ) > batches &&
            room_for_batches( s, m ) - batches >= rf_image_bytes( s ) )
        result = alloc_buffer( s, m, error );
    return result;
}

static RfResult alloc_batches( const RenderSizes* s, RenderMemory* m, RfError* error )
{
    m->batch_slots = batch_slots( s, m );
    RfResult result =
        rf_arena_alloc( &m->arena, "hit records", (size_t)m->batch_slots * sizeof *m->batches, (void**)&m->batches, error );
    for ( int i = 0; i < m->batch_slots && result == RF_OK; ++i )
    {
        void* memory = NULL;
        result = rf_arena_alloc( &m->arena, "hit records", rf_batch_bytes( &s->shape ), &memory, error );
        if ( result == RF_OK )
        {
            m->batches[i] = rf_lay_out_batch( &s->shape, memory );
            m->batches_laid_out = i + 1;
        }
    }
    return result;
}

RfResult rf_alloc_render_memory( const RenderSizes* sizes, RenderMemory* memory, RfError* error )
{
    RfResult result = RF_OK;
    if ( rf_writer_bytes( sizes ) > 0 )
        result = rf_arena_reserve( &memory->arena, WRITER, rf_writer_bytes( sizes ), error );
    memory->has_writer = rf_writer_bytes( sizes ) > 0 && result == RF_OK;
    if ( result == RF_OK )
        result = alloc_films( sizes, memory, error );
    if ( result == RF_OK )
        result = alloc_first_buffer( sizes, memory, error );
    if ( result == RF_OK )
        result = alloc_scratch( sizes, memory, error );
    if ( result == RF_OK )
        result = alloc_more_buffers( sizes, memory, error );
    if ( result == RF_OK )
        result = alloc_batches( sizes, memory, error );
    return result;
}

static void free_films( const RenderSizes* s, RenderMemory* m )
{
    for ( int i = 0; i < m->film_slots; ++i )
    {
        for ( int h = 0; h < 2; ++h )
        {
            rf_arena_free( &m->arena, "films", m->films[i].film.half[h], rf_film_half_bytes( s->width, s->height ) );
            rf_arena_free( &m->arena, "films", m->films[i].film.total[h], rf_totals_bytes( s ) );
            rf_arena_free( &m->arena, "adaptive", m->films[i].film.extra[h], rf_extra_bytes( s ) );
        }
        rf_arena_free( &m->arena, "adaptive", m->films[i].need, rf_need_bytes( s ) );
        rf_arena_free( &m->arena, "landed eyes", m->films[i].landed_eyes, rf_landed_bytes( s ) );
        free_layer_film( s, m, &m->films[i].layers );
    }
    rf_arena_free( &m->arena, "film table", m->looks, rf_noise_estimates_bytes( s ) );
    rf_arena_free( &m->arena, "film table", m->films, (size_t)s->films * sizeof *m->films );
    for ( int i = 0; i < m->buffer_count; ++i )
        free_buffer( s, m, m->buffers + i );
    rf_arena_free( &m->arena, "image", m->buffers, (size_t)s->buffers * sizeof *m->buffers );
}

void rf_free_render_memory( const RenderSizes* s, RenderMemory* m )
{
    if ( m->has_writer )
        rf_arena_release( &m->arena, WRITER, rf_writer_bytes( s ) );
    free_films( s, m );
    size_t threads = (size_t)s->threads;
    for ( size_t t = 0; m->harvest_scratch != NULL && t < threads; ++t )
        rf_arena_free( &m->arena, "scratch", m->harvest_scratch[t], rf_harvest_scratch_bytes( &s->shape ) );
    rf_arena_free( &m->arena, "scratch", m->harvest_scratch, threads * sizeof *m->harvest_scratch );
    rf_arena_free( &m->arena, "scratch", m->compute_scratch, threads * sizeof *m->compute_scratch );
    // a batch's first array is where its memory begins
    for ( int i = 0; i < m->batches_laid_out; ++i )
        rf_arena_free( &m->arena, "hit records", m->batches[i].p[0], rf_batch_bytes( &s->shape ) );
    rf_arena_free( &m->arena, "hit records", m->batches, (size_t)m->batch_slots * sizeof *m->batches );
}
