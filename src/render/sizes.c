// Bytes of every buffer of a render, so that the memory budget can be checked in advance.
#include "render/sizes.h"

#include "image/exr.h"
#include "render/adaptive/adaptive.h"
#include "render/adaptive/glints.h"
#include "render/memory/memory.h"
#include "render/settings.h"
#include "render/worlds.h"

#define BATCHES_PER_THREAD 16 // in a chunk: enough to share out, few enough to stay in the cache
#define LANDINGS_PER_THREAD 4 // likewise

static size_t film_pixels( const RfRenderSizes* s ) { return (size_t)s->width * (size_t)s->height; }

// First hits go to AOVs when they are traced, light paths and pieces are those of a pass, and a goal is looked at after each.
static int passes_at_once( const RfEstimatorSizes* sizes, const RfGroupPlan* plan, const RfRenderSettings* settings )
{
    bool whole = sizes->shared > 0 || sizes->pass_state > 0 || settings->pieces != NULL || rf_is_stopping( settings );
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
    // as many additions to a pixel as the group has frames, and half of the passes in each half
    bool adaptive = may_adapt( settings, plan->eyes );
    int materials = adaptive && rf_noise_differs( &called ) ? (int)scene->material_count : 0;
    bool glints = adaptive && called.sharp && settings->estimator->add_glints != NULL &&
                  ( settings->adaptive == RF_ADAPTIVE_ON || settings->spp >= RF_LEAST_GLINT_SPP );
    int total_every = rf_film_total_every( plan->eyes * rf_filter_pixels( settings ) +
                                           ( adaptive ? rf_most_extra( materials > 0 ) : 0 ) + ( glints ? RF_MOST_GLINTS : 0 ) );
    int64_t most = ( rf_most_passes( plan ) + 1 ) / 2;
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
        .total_every = rf_film_needs_total( most, total_every ) ? total_every : 0,
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

size_t rf_half_bytes( const RfRenderSizes* s ) { return rf_film_half_bytes( s->width, s->height, s->of_estimator.splits ); }

size_t rf_totals_bytes( const RfRenderSizes* s )
{
    return s->total_every > 0 ? rf_film_total_bytes( s->width, s->height, s->of_estimator.splits ) : 0;
}

size_t rf_noise_estimates_bytes( const RfRenderSizes* s ) { return s->stopping ? (size_t)s->films * sizeof( RfFrameNoise ) : 0; }

size_t rf_kept_errors_bytes( const RfRenderSizes* s ) { return s->paired ? film_pixels( s ) * 3 * sizeof( float ) : 0; }

size_t rf_need_bytes( const RfRenderSizes* s ) { return s->adaptive ? film_pixels( s ) * sizeof( float ) : 0; }

size_t rf_glints_bytes( const RfRenderSizes* s ) { return s->glints ? film_pixels( s ) * sizeof( float ) : 0; }

size_t rf_extra_bytes( const RfRenderSizes* s ) { return s->adaptive ? rf_film_extra_bytes( s->width, s->height ) : 0; }

// One more for the materials that are alike.
size_t rf_material_noise_bytes( const RfRenderSizes* s )
{
    return s->materials > 0 ? ( (size_t)s->materials + 1 ) * sizeof( RfMaterialNoise ) : 0;
}

size_t rf_covering_bytes( const RfRenderSizes* s ) { return s->covering ? film_pixels( s ) * sizeof( RfCovering ) : 0; }

size_t rf_aov_film_bytes( const RfRenderSizes* s, int aov )
{
    bool asked = ( s->aovs & RF_AOV_BIT( aov ) ) != 0;
    return asked ? film_pixels( s ) * (size_t)rf_aov_film_floats( (RfAov)aov, s->filtered ) * sizeof( float ) : 0;
}

size_t rf_aov_image_bytes( const RfRenderSizes* s, int aov )
{
    bool asked = ( s->aovs & RF_AOV_BIT( aov ) ) != 0;
    return asked ? film_pixels( s ) * (size_t)rf_aov_channels( (RfAov)aov ) * sizeof( float ) : 0;
}

size_t rf_matte_bytes( const RfRenderSizes* s, int kind )
{
    return ( s->cryptomatte & 1u << kind ) != 0 ? film_pixels( s ) * 4 * sizeof( float ) : 0;
}

static int matte_kinds( const RfRenderSizes* s )
{
    int kinds = 0;
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
        kinds += ( s->cryptomatte & 1u << k ) != 0;
    return kinds;
}

size_t rf_layer_list_bytes( const RfRenderSizes* s )
{
    return (size_t)( matte_kinds( s ) * RF_CRYPTOMATTE_LAYERS + s->group_films ) * sizeof( RfLayer );
}

static size_t optional( size_t bytes ) { return bytes > 0 ? rf_arena_size( bytes ) : 0; }

size_t rf_films_bytes( const RfRenderSizes* s )
{
    size_t film = 2 * rf_arena_size( rf_half_bytes( s ) ) + 2 * optional( rf_totals_bytes( s ) );
    size_t frame = (size_t)s->film_count * film + optional( rf_need_bytes( s ) ) + optional( rf_glints_bytes( s ) ) +
                   2 * optional( rf_extra_bytes( s ) );
    frame += optional( s->of_estimator.pass_state ) + optional( rf_covering_bytes( s ) );
    for ( int a = 0; a < RF_AOV_COUNT; ++a )
        frame += optional( rf_aov_film_bytes( s, a ) );
    frame += rf_arena_size( (size_t)s->film_count * sizeof( RfFilm ) );
    return rf_arena_size( (size_t)s->films * sizeof( RfLiveFilm ) ) + optional( rf_noise_estimates_bytes( s ) ) +
           optional( rf_kept_errors_bytes( s ) ) + optional( rf_material_noise_bytes( s ) ) + (size_t)s->films * frame;
}

size_t rf_image_bytes( const RfRenderSizes* s )
{
    size_t bytes = rf_arena_size( film_pixels( s ) * 3 * sizeof( float ) ) + rf_arena_size( film_pixels( s ) * sizeof( float ) );
    for ( int a = 0; a < RF_AOV_COUNT; ++a )
        bytes += optional( rf_aov_image_bytes( s, a ) );
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
        bytes += RF_CRYPTOMATTE_LAYERS * optional( rf_matte_bytes( s, k ) );
    bytes += (size_t)s->group_films * rf_arena_size( film_pixels( s ) * 3 * sizeof( float ) );
    return bytes + optional( rf_layer_list_bytes( s ) );
}

int rf_landings( const RfRenderSizes* s )
{
    int each = ( s->threads * LANDINGS_PER_THREAD + s->films - 1 ) / s->films, batches = rf_batches_wanted( s );
    return s->of_estimator.landing > 0 && s->threads > 1 ? s->films * ( each < batches ? each : batches ) : 0;
}

static size_t landings_bytes( const RfRenderSizes* s )
{
    size_t count = (size_t)rf_landings( s );
    return count > 0 ? rf_arena_size( count * sizeof( void* ) ) + count * rf_arena_size( s->of_estimator.landing ) : 0;
}

size_t rf_scratch_bytes( const RfRenderSizes* s )
{
    size_t threads = (size_t)s->threads;
    return 2 * rf_arena_size( threads * sizeof( void* ) ) + optional( s->of_estimator.finish_scratch ) +
           optional( s->of_estimator.shared ) + landings_bytes( s ) +
           threads * ( rf_arena_size( s->of_estimator.trace_scratch ) + rf_arena_size( s->of_estimator.accumulate_scratch ) );
}

size_t rf_writer_bytes( const RfRenderSizes* s )
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

size_t rf_records_bytes( const RfRenderSizes* s, int batches )
{
    return rf_arena_size( (size_t)batches * sizeof( void* ) ) + (size_t)batches * rf_arena_size( s->of_estimator.batch );
}

int rf_batches_wanted( const RfRenderSizes* s )
{
    int jobs = rf_batches_of_pass( s ), wanted = s->threads * BATCHES_PER_THREAD;
    int64_t all = (int64_t)jobs * ( s->threads > 1 ? s->passes : 1 );
    return s->of_estimator.whole_pass ? jobs : all < wanted ? (int)all : wanted;
}

size_t rf_ring_bytes( const RfRenderSizes* s ) { return rf_arena_size( (size_t)s->ring * sizeof( RfFrameBuffer ) ); }

size_t rf_fixed_bytes( const RfRenderSizes* s )
{
    return rf_films_bytes( s ) + rf_ring_bytes( s ) + rf_image_bytes( s ) + rf_scratch_bytes( s ) +
           optional( rf_writer_bytes( s ) ) + optional( s->moving );
}
