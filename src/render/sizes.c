// What the sizes of all buffers of a render depend on, so that the memory budget can be checked in advance.
#include "render/sizes.h"

#include "image/exr.h"
#include "render/adaptive/adaptive.h"
#include "render/adaptive/glint_pilot.h"
#include "render/memory/memory.h"
#include "render/settings.h"
#include "render/worlds.h"

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

int rf_matte_kinds( const RfRenderSizes* s )
{
    int kinds = 0;
    for ( int k = 0; k < RF_CRYPTOMATTE_KINDS; ++k )
        kinds += ( s->cryptomatte & 1u << k ) != 0;
    return kinds;
}

int rf_landings( const RfRenderSizes* s )
{
    if ( s->of_estimator.landing == 0 || s->threads == 1 || s->films == 0 ) // no films: none fits
        return 0;
    int each = ( s->threads * LANDINGS_PER_THREAD + s->films - 1 ) / s->films, batches = rf_batches_wanted( s );
    return s->films * ( each < batches ? each : batches );
}

size_t rf_writer_bytes( const RfRenderSizes* s )
{
    int pixel_bytes =
        ( 1 + s->group_films ) * ( s->files.half ? 3 * 2 : 3 * 4 ) + rf_matte_kinds( s ) * RF_CRYPTOMATTE_LAYERS * 4 * 4;
    for ( int a = 0; a < RF_AOV_COUNT; ++a )
    {
        if ( ( s->aovs & RF_AOV_BIT( a ) ) != 0 )
            pixel_bytes += rf_aov_channels( (RfAov)a ) * ( s->files.half && rf_aov_is_half( (RfAov)a ) ? 2 : 4 );
    }
    return s->files.written ? rf_exr_work_bytes( s->width, s->height, s->files.compression, pixel_bytes ) : 0;
}

int rf_batches_wanted( const RfRenderSizes* s )
{
    int jobs = rf_batches_of_pass( s ), wanted = s->threads * BATCHES_PER_THREAD;
    int64_t all = (int64_t)jobs * ( s->threads > 1 ? s->passes : 1 );
    return all < wanted ? (int)all : wanted;
}
