#include "reuse/render_internal.h"

#include "scene/textured.h"

#include <string.h>

#define BATCHES_PER_THREAD 16 // in a chunk: enough to share out, few enough to stay in the cache

static size_t film_pixels( const RenderSizes* s ) { return (size_t)s->width * (size_t)s->height; }

static size_t landed_bytes( const RenderSizes* s )
{
    return film_pixels( s ) * (size_t)rf_seen_words( s->shape.eyes ) * sizeof( uint32_t );
}

static bool has_kinds( const RfScene* scene, RfBsdfKind first, RfBsdfKind end )
{
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
    {
        RfBsdfKind kind = scene->materials[scene->triangles.material[i]].kind;
        if ( kind >= first && kind < end )
            return true;
    }
    return false;
}

static bool has_blended( const RfScene* scene )
{
    for ( uint32_t i = 0; i < scene->triangles.count; ++i )
    {
        if ( rf_is_blended( scene->materials + scene->triangles.material[i] ) )
            return true;
    }
    return false;
}

static RfBatchShape batch_shape( const RfScene* scene, int eyes, const RfRenderSettings* settings )
{
    return ( RfBatchShape ){
        .eyes = eyes,
        .light_samples = settings->light_samples,
        .tile_pixels = rf_tile_pixels( &settings->tile ),
        .glossy = has_kinds( scene, RF_BSDF_PHONG, RF_BSDF_FIRST_NATIVE ),
        .coated = has_kinds( scene, RF_BSDF_COATED, RF_BSDF_COATED + 1 ),
        .eq15 = settings->weights == RF_WEIGHTS_EQ15,
        .blended = has_blended( scene ),
        .natives = has_kinds( scene, RF_BSDF_FIRST_NATIVE, RF_BSDF_KIND_COUNT ) ||
                   rf_max_component( scene->environment.radiance ) > 0.0f,
    };
}

RenderSizes rf_render_sizes( const RfScene* scene, const RfEye* eyes, const RfGroupPlan* plan, int films,
                             const RfRenderSettings* settings )
{
    // as many landings in a pixel as eyes, and half of the passes in each half
    int total_every = rf_film_total_every( plan->eyes );
    int64_t most = ( rf_most_passes( plan ) + 1 ) / 2;
    return ( RenderSizes ){
        .total_every = rf_film_needs_total( most, total_every ) ? total_every : 0,
        .width = eyes->width,
        .height = eyes->height,
        .patches = rf_lay_out_patches( &settings->tile, eyes->width, eyes->height ),
        .threads = settings->threads,
        .films = films < plan->eyes ? films : plan->eyes,
        .layers = settings->layers,
        .buffers = settings->queue > films ? films : settings->queue > 1 ? settings->queue : 1,
        .shape = batch_shape( scene, plan->eyes, settings ),
    };
}

static size_t total_bytes( const RenderSizes* s )
{
    return s->total_every > 0 ? rf_film_total_bytes( s->width, s->height ) : 0;
}

// Of a layer, while it is rendered and when it is finished; 0 where not asked for.
static size_t layer_film_bytes( const RenderSizes* s, int layer )
{
    bool asked = ( s->layers & RF_LAYER_BIT( layer ) ) != 0;
    return asked ? film_pixels( s ) * (size_t)rf_layer_film_floats( (RfLayer)layer ) * sizeof( float ) : 0;
}

static size_t layer_image_bytes( const RenderSizes* s, int layer )
{
    bool asked = ( s->layers & RF_LAYER_BIT( layer ) ) != 0;
    return asked ? film_pixels( s ) * (size_t)rf_layer_channels( (RfLayer)layer ) * sizeof( float ) : 0;
}

static size_t buffer_bytes( const RenderSizes* s )
{
    size_t bytes = film_pixels( s ) * 4 * sizeof( float );
    for ( int l = 0; l < RF_LAYER_COUNT; ++l )
        bytes += layer_image_bytes( s, l );
    return bytes;
}

size_t rf_fixed_bytes( const RenderSizes* s )
{
    size_t half = rf_film_half_bytes( s->width, s->height ) + total_bytes( s );
    size_t film = 2 * half + ( s->shape.eq15 ? landed_bytes( s ) : 0 );
    for ( int l = 0; l < RF_LAYER_COUNT; ++l )
        film += layer_film_bytes( s, l );
    size_t scratch = rf_harvest_scratch_bytes( &s->shape ) + sizeof( RfComputeScratch );
    size_t tables = 1 << 16;
    return (size_t)s->films * film + buffer_bytes( s ) + (size_t)s->threads * scratch + tables;
}

// One frame on its way to the caller.
static RfResult alloc_buffer( const RenderSizes* s, RenderMemory* m, RfError* error )
{
    RfFrameBuffer* buffer = m->buffers + m->buffer_count;
    *buffer = ( RfFrameBuffer ){ 0 };
    m->buffer_count += 1;
    RfResult result = rf_arena_alloc( &m->arena, "image", film_pixels( s ) * 3 * sizeof( float ), (void**)&buffer->rgb, error );
    if ( result == RF_OK )
        result = rf_arena_alloc( &m->arena, "image", film_pixels( s ) * sizeof( float ), (void**)&buffer->weight, error );
    for ( int l = 0; l < RF_LAYER_COUNT && result == RF_OK; ++l )
    {
        if ( layer_image_bytes( s, l ) > 0 )
            result = rf_arena_alloc( &m->arena, "layer images", layer_image_bytes( s, l ), (void**)&buffer->layers[l], error );
    }
    return result;
}

static void free_buffer( const RenderSizes* s, RenderMemory* m, RfFrameBuffer* buffer )
{
    rf_arena_free( &m->arena, "image", buffer->rgb, film_pixels( s ) * 3 * sizeof( float ) );
    rf_arena_free( &m->arena, "image", buffer->weight, film_pixels( s ) * sizeof( float ) );
    for ( int l = 0; l < RF_LAYER_COUNT; ++l )
        rf_arena_free( &m->arena, "layer images", buffer->layers[l], layer_image_bytes( s, l ) );
}

// The first buffer, without which nothing can be finished.
static RfResult alloc_first_buffer( const RenderSizes* s, RenderMemory* m, RfError* error )
{
    size_t bytes = (size_t)s->buffers * sizeof *m->buffers;
    RfResult result = rf_arena_alloc( &m->arena, "image", bytes, (void**)&m->buffers, error );
    return result == RF_OK ? alloc_buffer( s, m, error ) : result;
}

static RfResult alloc_layer_film( const RenderSizes* s, RenderMemory* m, RfLayerFilm* layers, RfError* error )
{
    RfResult result = RF_OK;
    for ( int l = 0; l < RF_LAYER_COUNT && result == RF_OK; ++l )
    {
        void** where = l == RF_LAYER_SAMPLES ? (void**)&layers->landed : (void**)&layers->mean[l];
        if ( layer_film_bytes( s, l ) > 0 )
            result = rf_arena_alloc( &m->arena, "layers", layer_film_bytes( s, l ), where, error );
    }
    return result;
}

static void free_layer_film( const RenderSizes* s, RenderMemory* m, const RfLayerFilm* layers )
{
    for ( int l = 0; l < RF_LAYER_COUNT; ++l )
        rf_arena_free( &m->arena, "layers", layers->mean[l], layer_film_bytes( s, l ) );
    rf_arena_free( &m->arena, "layers", layers->landed, layer_film_bytes( s, RF_LAYER_SAMPLES ) );
}

static RfResult alloc_film( const RenderSizes* s, RenderMemory* m, LiveFilm* live, RfError* error )
{
    RfResult result = RF_OK;
    live->frame = -1;
    live->film.width = s->width;
    live->film.height = s->height;
    live->film.total_every = s->total_every;
    for ( int h = 0; h < 2 && result == RF_OK; ++h )
        result = rf_arena_alloc( &m->arena, "films", rf_film_half_bytes( s->width, s->height ), (void**)&live->film.half[h], error );
    for ( int h = 0; h < 2 && result == RF_OK && s->total_every > 0; ++h )
        result = rf_arena_alloc( &m->arena, "films", total_bytes( s ), (void**)&live->film.total[h], error );
    if ( s->shape.eq15 && result == RF_OK )
        result = rf_arena_alloc( &m->arena, "landed eyes", landed_bytes( s ), (void**)&live->landed_eyes, error );
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
    for ( int i = 0; i < s->films && result == RF_OK; ++i )
        result = alloc_film( s, m, m->films + i, error );
    return result;
}

static RfResult alloc_scratch( const RenderSizes* s, RenderMemory* m, RfError* error )
{
    size_t threads = (size_t)s->threads;
    RfResult result = rf_arena_alloc( &m->arena, "scratch", threads * sizeof *m->harvest_scratch, (void**)&m->harvest_scratch, error );
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

static size_t batch_slot_bytes( const RenderSizes* s ) { return rf_batch_bytes( &s->shape ) + sizeof( RfHitBatch ) + 64; }

// As many batches at once as serve the threads and fit the budget, at least
// one; the biased eq15 needs all of a pass.
static int batch_slots( const RenderSizes* s, const RenderMemory* m )
{
    int jobs = s->shape.eyes * s->patches.count;
    if ( s->shape.eq15 )
        return jobs;
    size_t room = rf_arena_room( &m->arena ) / batch_slot_bytes( s );
    int slots = s->threads * BATCHES_PER_THREAD;
    slots = slots < jobs ? slots : jobs;
    if ( (size_t)slots > room )
        slots = room > 1 ? (int)room : 1;
    return slots;
}

// Buffers beyond the first, as long as they take no batches away.
static RfResult alloc_more_buffers( const RenderSizes* s, RenderMemory* m, RfError* error )
{
    size_t batches = (size_t)batch_slots( s, m ) * batch_slot_bytes( s );
    RfResult result = RF_OK;
    while ( result == RF_OK && m->buffer_count < s->buffers &&
            rf_arena_room( &m->arena ) > batches && rf_arena_room( &m->arena ) - batches >= buffer_bytes( s ) + 512 )
        result = alloc_buffer( s, m, error );
    return result;
}

static RfResult alloc_batches( const RenderSizes* s, RenderMemory* m, RfError* error )
{
    m->batch_slots = batch_slots( s, m );
    RfResult result = rf_arena_alloc( &m->arena, "hit records", (size_t)m->batch_slots * sizeof *m->batches, (void**)&m->batches, error );
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
    RfResult result = alloc_films( sizes, memory, error );
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
            rf_arena_free( &m->arena, "films", m->films[i].film.total[h], total_bytes( s ) );
        }
        rf_arena_free( &m->arena, "landed eyes", m->films[i].landed_eyes, landed_bytes( s ) );
        free_layer_film( s, m, &m->films[i].layers );
    }
    rf_arena_free( &m->arena, "film table", m->films, (size_t)s->films * sizeof *m->films );
    for ( int i = 0; i < m->buffer_count; ++i )
        free_buffer( s, m, m->buffers + i );
    rf_arena_free( &m->arena, "image", m->buffers, (size_t)s->buffers * sizeof *m->buffers );
}

void rf_free_render_memory( const RenderSizes* s, RenderMemory* m )
{
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
