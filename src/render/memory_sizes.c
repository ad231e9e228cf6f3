// What a render will allocate, by the byte: the same sums as memory_alloc.c makes.
#include "render/render_internal.h"

#include "render/adaptive.h"
#include "scene/textured.h"

#define BATCHES_PER_THREAD 16 // in a chunk: enough to share out, few enough to stay in the cache

static size_t film_pixels( const RenderSizes* s ) { return (size_t)s->width * (size_t)s->height; }

size_t rf_landed_bytes( const RenderSizes* s )
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
        .glossy = has_kinds( scene, RF_BSDF_PHONG, RF_BSDF_FIRST_UNEVALUABLE ),
        .coated = has_kinds( scene, RF_BSDF_COATED, RF_BSDF_COATED + 1 ),
        .eq15 = settings->weights == RF_WEIGHTS_EQ15,
        .blended = has_blended( scene ),
        .natives = has_kinds( scene, RF_BSDF_FIRST_UNEVALUABLE, RF_BSDF_KIND_COUNT ) ||
                   rf_max_component( scene->environment.radiance ) > 0.0f,
    };
}

RenderSizes rf_render_sizes( const RfScene* scene, const RfEye* eyes, const RfGroupPlan* plan, int films,
                             const RfRenderSettings* settings )
{
    // as many landings in a pixel as eyes, and half of the passes in each half
    int total_every = rf_film_total_every( plan->eyes + ( settings->adaptive ? RF_MOST_EXTRA : 0 ) );
    int64_t most = ( rf_most_passes( plan ) + 1 ) / 2;
    return ( RenderSizes ){
        .total_every = rf_film_needs_total( most, total_every ) ? total_every : 0,
        .width = eyes->width,
        .height = eyes->height,
        .patches = rf_lay_out_patches( &settings->tile, eyes->width, eyes->height ),
        .threads = settings->threads,
        .films = films < plan->eyes ? films : plan->eyes,
        .layers = settings->layers,
        .stopping = rf_is_stopping( settings ),
        .adaptive = settings->adaptive,
        .files = settings->files,
        .buffers = settings->queue > films ? films
                   : settings->queue > 1   ? settings->queue
                                           : 1,
        .shape = batch_shape( scene, plan->eyes, settings ),
    };
}

size_t rf_totals_bytes( const RenderSizes* s ) { return s->total_every > 0 ? rf_film_total_bytes( s->width, s->height ) : 0; }

size_t rf_noise_estimates_bytes( const RenderSizes* s ) { return s->stopping ? (size_t)s->films * sizeof( RfFrameNoise ) : 0; }

size_t rf_need_bytes( const RenderSizes* s ) { return s->adaptive ? film_pixels( s ) * sizeof( float ) : 0; }

size_t rf_extra_bytes( const RenderSizes* s ) { return s->adaptive ? rf_film_extra_bytes( s->width, s->height ) : 0; }

size_t rf_aov_film_bytes( const RenderSizes* s, int layer )
{
    bool asked = ( s->layers & RF_AOV_BIT( layer ) ) != 0;
    return asked ? film_pixels( s ) * (size_t)rf_aov_film_floats( (RfAov)layer ) * sizeof( float ) : 0;
}

size_t rf_aov_image_bytes( const RenderSizes* s, int layer )
{
    bool asked = ( s->layers & RF_AOV_BIT( layer ) ) != 0;
    return asked ? film_pixels( s ) * (size_t)rf_aov_channels( (RfAov)layer ) * sizeof( float ) : 0;
}

static size_t optional( size_t bytes ) { return bytes > 0 ? rf_arena_size( bytes ) : 0; }

size_t rf_films_bytes( const RenderSizes* s )
{
    size_t film = 2 * rf_arena_size( rf_film_half_bytes( s->width, s->height ) ) + 2 * optional( rf_totals_bytes( s ) );
    film += optional( rf_need_bytes( s ) ) + 2 * optional( rf_extra_bytes( s ) );
    film += s->shape.eq15 ? rf_arena_size( rf_landed_bytes( s ) ) : 0;
    for ( int l = 0; l < RF_AOV_COUNT; ++l )
        film += optional( rf_aov_film_bytes( s, l ) );
    return rf_arena_size( (size_t)s->films * sizeof( LiveFilm ) ) + optional( rf_noise_estimates_bytes( s ) ) +
           (size_t)s->films * film;
}

size_t rf_image_bytes( const RenderSizes* s )
{
    size_t bytes = rf_arena_size( film_pixels( s ) * 3 * sizeof( float ) ) + rf_arena_size( film_pixels( s ) * sizeof( float ) );
    for ( int l = 0; l < RF_AOV_COUNT; ++l )
        bytes += optional( rf_aov_image_bytes( s, l ) );
    return bytes;
}

size_t rf_scratch_bytes( const RenderSizes* s )
{
    size_t threads = (size_t)s->threads;
    return rf_arena_size( threads * sizeof( RfHarvestScratch* ) ) + rf_arena_size( threads * sizeof( RfAccumulateScratch ) ) +
           threads * rf_arena_size( rf_harvest_scratch_bytes( &s->shape ) );
}

size_t rf_writer_bytes( const RenderSizes* s )
{
    int pixel_bytes = s->files.half ? 3 * 2 : 3 * 4;
    for ( int l = 0; l < RF_AOV_COUNT; ++l )
    {
        if ( ( s->layers & RF_AOV_BIT( l ) ) != 0 )
            pixel_bytes += rf_aov_channels( (RfAov)l ) * ( s->files.half && rf_aov_is_half( (RfAov)l ) ? 2 : 4 );
    }
    return s->files.written ? rf_exr_work_bytes( s->width, s->height, s->files.compression, pixel_bytes ) : 0;
}

size_t rf_records_bytes( const RenderSizes* s, int batches )
{
    return rf_arena_size( (size_t)batches * sizeof( RfHitBatch ) ) +
           (size_t)batches * rf_arena_size( rf_batch_bytes( &s->shape ) );
}

// The biased eq15 needs all of a pass.
int rf_batches_wanted( const RenderSizes* s )
{
    int jobs = s->shape.eyes * s->patches.count, wanted = s->threads * BATCHES_PER_THREAD;
    return s->shape.eq15 || jobs < wanted ? jobs : wanted;
}

size_t rf_fixed_bytes( const RenderSizes* s )
{
    size_t ring = rf_arena_size( (size_t)s->buffers * sizeof( RfFrameBuffer ) );
    return rf_films_bytes( s ) + ring + rf_image_bytes( s ) + rf_scratch_bytes( s ) + optional( rf_writer_bytes( s ) ) + s->held;
}
