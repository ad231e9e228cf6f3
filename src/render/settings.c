// Validates render settings and resolves those that are automatic, without tracing a ray.
#include "render/settings.h"

#include "base/fault.h"
#include "base/remedy.h"
#include "base/system.h"
#include "film/pixel_filter.h"
#include "math/vec3.h"
#include "render/estimator.h"
#include "scene/leave_out.h"
#include "scene/projection.h"

#include <math.h>

static bool can_adapt( const RfRenderSettings* s )
{
    const RfEstimator* e = s->estimator;
    return e->add_own_shares != NULL && e->count_samples != NULL && e->films == 1;
}

static RfResult check_dwa( const RfFrameFiles* files, RfError* error )
{
    if ( files->compression != RF_EXR_DWAA && files->compression != RF_EXR_DWAB )
        return RF_OK;
    if ( !rf_has_dwa() )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "this build of reframe lacks DWA: choose another compression" );
    if ( !( files->dwa_level >= 0.0f && files->dwa_level <= RF_EXR_MAX_DWA_LEVEL ) )
        return rf_fail( error, RF_ERROR_USAGE, "a level of DWA is 0 to %g, not %g", (double)RF_EXR_MAX_DWA_LEVEL,
                        (double)files->dwa_level );
    if ( !files->half && files->parts == RF_PARTS_ONE )
        return rf_fail(
            error, RF_ERROR_USAGE, // else it would take all channels of 32 bits for colours
            "DWA compresses colours of 32 bits in parts of their own only: ask for 16 bits, or for a part for each pass" );
    return RF_OK;
}

static RfResult check_choices( const RfRenderSettings* s, RfError* error )
{
    if ( (unsigned)s->weights > RF_WEIGHTS_UNWEIGHTED || (unsigned)s->normalize > RF_NORMALIZE_NONE )
        return rf_fail( error, RF_ERROR_USAGE, "there is no weighting %d, or no normalisation %d", (int)s->weights,
                        (int)s->normalize );
    if ( !rf_is_filter( s->filter ) )
        return rf_fail( error, RF_ERROR_USAGE, "there is no pixel filter %d", (int)s->filter );
    if ( s->filter_width != 0.0 && !( s->filter_width >= RF_MIN_FILTER_WIDTH && s->filter_width <= RF_MAX_FILTER_WIDTH ) )
        return rf_fail( error, RF_ERROR_USAGE, "the width of a pixel filter must be %g to %g, got %g", RF_MIN_FILTER_WIDTH,
                        RF_MAX_FILTER_WIDTH, s->filter_width );
    if ( (unsigned)s->light_sampling > RF_LIGHTS_BY_POWER )
        return rf_fail( error, RF_ERROR_USAGE, "there is no light sampling %d", (int)s->light_sampling );
    if ( (unsigned)s->light_paths > RF_LIGHT_PATHS_OFF || (unsigned)s->kernel_normalization > RF_KERNEL_DENSITY )
        return rf_fail( error, RF_ERROR_USAGE, "there is no use of light paths %d, or no normalisation of kernels %d",
                        (int)s->light_paths, (int)s->kernel_normalization );
    if ( (unsigned)s->reconstruction > RF_RECONSTRUCTION_NONE )
        return rf_fail( error, RF_ERROR_USAGE, "there is no reconstruction %d", (int)s->reconstruction );
    if ( (unsigned)s->adaptive > RF_ADAPTIVE_OFF )
        return rf_fail( error, RF_ERROR_USAGE, "there is no adaptive sampling %d", (int)s->adaptive );
    if ( (unsigned)s->files.compression > RF_EXR_DWAB )
        return rf_fail( error, RF_ERROR_USAGE, "there is no compression %d", (int)s->files.compression );
    return check_dwa( &s->files, error );
}

static RfResult check_settings( const RfRenderSettings* s, RfError* error )
{
    if ( s->spp < 1 || s->spp > RF_MAX_SPP )
        return rf_fail( error, RF_ERROR_USAGE, "samples per pixel must be 1 to %d, got %d", RF_MAX_SPP, s->spp );
    if ( !( s->noise >= 0.0 && s->noise <= RF_MAX_NOISE ) )
        return rf_fail( error, RF_ERROR_USAGE, "the relMSE wanted must be 0 to %g, got %g", RF_MAX_NOISE, s->noise );
    if ( !( s->flicker >= 0.0 && s->flicker <= RF_MAX_FLICKER ) )
        return rf_fail( error, RF_ERROR_USAGE, "the flicker wanted must be 0 to %g, got %g", RF_MAX_FLICKER, s->flicker );
    if ( s->clamp != RF_CLAMP_AUTO && !( s->clamp >= 0.0 && s->clamp <= RF_MAX_CLAMP ) )
        return rf_fail( error, RF_ERROR_USAGE, "the clamp must be 0 to %g, got %g", RF_MAX_CLAMP, s->clamp );
    if ( !( s->clamp_chains >= 0.0 && s->clamp_chains <= RF_MAX_CLAMP ) )
        return rf_fail( error, RF_ERROR_USAGE, "the clamp of chains must be 0 to %g, got %g", RF_MAX_CLAMP, s->clamp_chains );
    if ( s->clamp_chains > 0.0 && s->clamp == 0.0 )
        return rf_fail( error, RF_ERROR_USAGE, "a clamp of chains needs a clamp of paths as well" );
    if ( !( s->time >= 0.0 && s->time <= RF_MAX_TIME ) )
        return rf_fail( error, RF_ERROR_USAGE, "the seconds for a frame must be 0 to %g, got %g", RF_MAX_TIME, s->time );
    if ( s->group < RF_GROUP_AUTO || s->group > RF_MAX_GROUP )
        return rf_fail( error, RF_ERROR_USAGE, "group must be 0 to %d, got %d", RF_MAX_GROUP, s->group );
    if ( s->max_depth < 1 || s->max_depth > RF_MAX_DEPTH )
        return rf_fail( error, RF_ERROR_USAGE, "depth must be 1 to %d, got %d", RF_MAX_DEPTH, s->max_depth );
    if ( s->light_samples < 1 || s->light_samples > RF_MAX_LIGHT_SAMPLES )
        return rf_fail( error, RF_ERROR_USAGE, "light samples must be 1 to %d, got %d", RF_MAX_LIGHT_SAMPLES, s->light_samples );
    if ( ( s->aovs & ~( RF_ALL_AOVS | RF_AOV_BIT( RF_AOV_ALPHA ) ) ) != 0 )
        return rf_fail( error, RF_ERROR_USAGE, "there are no such AOVs: %#x", s->aovs );
    if ( ( s->cryptomatte & ~( RF_CRYPTOMATTE_OBJECT | RF_CRYPTOMATTE_MATERIAL | RF_CRYPTOMATTE_ASSET ) ) != 0 )
        return rf_fail( error, RF_ERROR_USAGE, "there are no such kinds of Cryptomatte: %#x", s->cryptomatte );
    if ( s->queue < 0 || s->queue > RF_MAX_QUEUE )
        return rf_fail( error, RF_ERROR_USAGE, "the queue must be 0 to %d frames, got %d", RF_MAX_QUEUE, s->queue );
    if ( s->threads > RF_MAX_THREADS )
        return rf_fail( error, RF_ERROR_USAGE, "threads must be at most %d, got %d", RF_MAX_THREADS, s->threads );
    return check_choices( s, error );
}

bool rf_can_render_pieces( const RfRenderSettings* s ) { return s->estimator->is_traced != NULL && s->estimator->finish == NULL; }

bool rf_has_groups( const RfEstimator* estimator ) { return estimator->count_reuse != NULL; }

int rf_usual_passes( const RfRenderSettings* s ) { return s->estimator->usual_passes > 2 ? s->estimator->usual_passes : 2; }

// What an estimator has not got.
static RfResult lacks( const RfEstimator* estimator, const char* what, RfError* error )
{
    RfResult result = rf_fail( error, RF_ERROR_USAGE, "the estimator '%s' has no %s", estimator->name, what );
    return rf_advise( result, RF_REMEDY_ESTIMATOR, 0, error );
}

static RfResult check_estimator( const RfRenderSettings* s, RfError* error )
{
    const RfEstimator* estimator = s->estimator;
    if ( estimator == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "settings without an estimator: start from rf_default_render_settings" );
    if ( estimator->films < 1 || estimator->films > RF_MAX_FILMS )
        return rf_fail( error, RF_ERROR_USAGE, "the estimator '%s' asks for %d films, 1 to %d can be had", estimator->name,
                        estimator->films, RF_MAX_FILMS );
    if ( !rf_is_plain_filter( s ) && !estimator->filters )
        return lacks( estimator, "pixel filter but a box of one pixel", error );
    if ( s->adaptive == RF_ADAPTIVE_ON && estimator->biased )
        return rf_fail( error, RF_ERROR_USAGE, "adaptive samples need exact weights" );
    if ( s->adaptive == RF_ADAPTIVE_ON &&
         ( estimator->add_own_shares == NULL || estimator->count_samples == NULL || estimator->films > 1 ) )
        return lacks( estimator, "adaptive sampling", error );
    if ( ( s->aovs & RF_FIRST_HIT_AOVS ) != 0 && estimator->first_hits == NULL )
        return lacks( estimator, "AOVs of first hits", error );
    if ( ( s->aovs & RF_DENOISE_AOVS ) != 0 && !estimator->has_features )
        return lacks( estimator, "AOVs for denoisers", error );
    if ( ( s->aovs & RF_AOV_BIT( RF_AOV_VARIANCE ) ) != 0 && estimator->finish != NULL && !estimator->has_variance )
        return lacks( estimator, "variance AOV", error );
    if ( s->flicker > 0.0 && estimator->finish != NULL ) // the halves of its pictures are not in the films
        return lacks( estimator, "estimate of flicker to stop at", error );
    if ( ( s->aovs & RF_GRADIENT_AOVS ) != 0 && !estimator->has_gradients )
        return lacks( estimator, "gradients", error );
    if ( ( s->aovs & RF_PASS_AOVS ) != 0 && !estimator->splits_light )
        return lacks( estimator, "passes of its light", error );
    if ( ( s->aovs & RF_AOV_BIT( RF_AOV_ALPHA ) ) != 0 && !estimator->has_alpha )
        return lacks( estimator, "alpha", error );
    if ( rf_wants_covering( s ) && !estimator->has_covering )
        return lacks( estimator, "Cryptomatte and no index AOVs", error );
    if ( s->clamp != 0.0 && !estimator->clamps )
        return lacks( estimator, "clamp", error );
    if ( s->pieces != NULL && !rf_can_render_pieces( s ) )
        return rf_fail( error, RF_ERROR_USAGE, "the estimator '%s' cannot render pieces", estimator->name );
    if ( s->pieces != NULL && ( rf_is_stopping( s ) || s->adaptive != RF_ADAPTIVE_OFF ) )
        return rf_fail( error, RF_ERROR_USAGE,
                        "pieces are rendered without a noise, a flicker or a time to stop at, and without extra samples" );
    return estimator->check != NULL ? estimator->check( s, error ) : RF_OK;
}

static bool is_finite3( RfVec3 v ) { return isfinite( v.x ) && isfinite( v.y ) && isfinite( v.z ); }

// Unit vectors at right angles; not so where a direction was zero, no number, or parallel to up.
static bool is_perpendicular( RfVec3 a, RfVec3 b )
{
    return fabsf( rf_dot( a, a ) - 1.0f ) < 1e-3f && fabsf( rf_dot( b, b ) - 1.0f ) < 1e-3f && fabsf( rf_dot( a, b ) ) < 1e-3f;
}

static bool is_usable_pose( const RfPose* p )
{
    return is_finite3( p->origin ) && is_perpendicular( p->forward, p->up ) && p->focal > 0.0f && isfinite( p->focal ) &&
           isfinite( p->axis_x ) && isfinite( p->axis_y );
}

static bool has_usable_moments( const RfEye* e )
{
    return e->blur_steps == 0 || ( e->blur_steps > 0 && e->blur_steps <= RF_MAX_BLUR_STEPS && e->opens <= e->closes &&
                                   isfinite( e->opens ) && isfinite( e->closes ) );
}

// Camera rays that are no numbers end the process in Embree. The last line is the shear of the film by the lens.
static bool is_usable( const RfEye* e )
{
    RfPose own = { e->origin, e->forward, e->up, e->focal, e->axis_x, e->axis_y };
    return e->projection >= 0 && e->projection < RF_PROJECTION_COUNT && is_usable_pose( &own ) &&
           is_perpendicular( e->right, e->forward ) && e->focal_x > 0.0f && isfinite( e->focal_x ) && has_usable_moments( e ) &&
           ( !e->moves || ( is_usable_pose( &e->open ) && is_usable_pose( &e->close ) ) ) &&
           ( ( e->lens_radius <= 0.0f && !RF_FAULT( lens_sharp ) ) ||
             ( e->focus != 0.0f && isfinite( rf_maxf( e->focal, e->focal_x ) * e->lens_radius / e->focus ) ) );
}

static RfResult check_eyes( const RfEye* eyes, int count, RfError* error )
{
    if ( count < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "a render needs at least one frame" );
    for ( int k = 0; k < count; ++k )
    {
        if ( eyes[k].width < 1 || eyes[k].height < 1 || eyes[k].width > RF_MAX_IMAGE_SIDE || eyes[k].height > RF_MAX_IMAGE_SIDE )
            return rf_fail( error, RF_ERROR_USAGE, "the image must be 1x1 to %dx%d pixels, got %dx%d", RF_MAX_IMAGE_SIDE,
                            RF_MAX_IMAGE_SIDE, eyes[k].width, eyes[k].height );
        if ( eyes[k].width != eyes[0].width || eyes[k].height != eyes[0].height )
            return rf_fail( error, RF_ERROR_USAGE, "all frames of a path must have the same size" );
        if ( k > 0 && eyes[k].shot < eyes[k - 1].shot )
            return rf_fail( error, RF_ERROR_USAGE, "frame %d of the path is of an earlier shot than the one before it", k );
        if ( !is_usable( eyes + k ) && !RF_FAULT( usable_eyes ) )
            return rf_fail(
                error, RF_ERROR_USAGE,
                "the camera of frame %d of the path cannot be used: all of it must be finite, its axes unit vectors at "
                "right angles, its focal length and, with a lens, its focus above 0",
                k );
    }
    return RF_OK;
}

// A single frame is a group of its own.
static RfResult check_moving( const RfShot* shot, const RfRenderSettings* settings, RfError* error )
{
    const RfScene* scene = rf_tracer_scene( shot->tracer );
    RfSceneTraits traits = { .moves = rf_may_move( scene ) && shot->eye_count > 1 };
    for ( int i = 0; i < shot->eye_count; ++i )
        traits.blur_steps = rf_may_move( scene ) && shot->eyes[i].blur_steps > 0 ? 1 : traits.blur_steps;
    return rf_check_moving( &traits, settings, error );
}

bool rf_keeps_removed( const RfScene* scene, const RfRenderSettings* s )
{
    return s->clamp != 0.0 || rf_is_left_out( scene, RF_EFFECT_CAUSTICS );
}

static RfResult check_removed( const RfShot* shot, const RfRenderSettings* s, RfError* error )
{
    const RfScene* scene = rf_tracer_scene( shot->tracer );
    if ( !rf_keeps_removed( scene, s ) && ( s->aovs & RF_AOV_BIT( RF_AOV_REMOVED ) ) != 0 )
        return rf_fail( error, RF_ERROR_USAGE,
                        "the AOV removed needs a clamp, or caustics left out: nothing is removed without" );
    if ( !rf_is_left_out( scene, RF_EFFECT_CAUSTICS ) )
        return RF_OK;
    RfSceneTraits traits = rf_scene_traits( scene, NULL, 0, s );
    traits.moves = traits.moves && shot->eye_count > 1;
    return rf_check_caustics( &traits, s, error );
}

static RfResult check_passes( const RfShot* shot, const RfRenderSettings* s, RfError* error )
{
    if ( ( s->aovs & RF_PASS_AOVS ) == 0 || !rf_is_left_out( rf_tracer_scene( shot->tracer ), RF_EFFECT_CHAINS ) )
        return RF_OK;
    return rf_fail( error, RF_ERROR_USAGE,
                    "chains are left out, which tell passes what mirrors and glass show: keep chains, or leave out the passes" );
}

RfResult rf_resolve_common( const RfShot* shot, const RfRenderSettings* settings, RfRenderSettings* resolved, RfError* error )
{
    *resolved = *settings;
    const RfEstimator* given = settings->estimator;
    if ( given != NULL && given->other_weights != NULL && given->biased != ( settings->weights != RF_WEIGHTS_EXACT ) )
        resolved->estimator = given->other_weights;
    RfResult result = check_settings( resolved, error );
    if ( result == RF_OK )
        result = check_estimator( resolved, error );
    if ( result == RF_OK )
        result = check_eyes( shot->eyes, shot->eye_count, error );
    if ( result != RF_OK )
        return result;
    if ( resolved->group == RF_GROUP_AUTO && !rf_has_groups( resolved->estimator ) ) // its frames share nothing
        resolved->group = 0;
    if ( resolved->tile.kind == RF_TILE_NONE ) // its size does not matter
        resolved->tile.width = resolved->tile.height = 1;
    if ( resolved->threads < 1 )
        resolved->threads = rf_core_count();
    if ( resolved->memory == 0 )
        resolved->memory = ( rf_free_memory() / 2 ) >> 20 << 20; // whole MiB, as it is reported
    if ( resolved->filter_width == 0.0 )
        resolved->filter_width = rf_default_filter_width( resolved->filter );
    // the biased weightings count hits, whose expectation is unknown: only the ratio makes sense
    if ( resolved->estimator->biased )
        resolved->normalize = RF_NORMALIZE_RATIO;
    if ( resolved->adaptive == RF_ADAPTIVE_AUTO && !can_adapt( resolved ) )
        resolved->adaptive = RF_ADAPTIVE_OFF;
    result = rf_check_surface_numbers( rf_tracer_scene( shot->tracer ), rf_surface_kinds( resolved ), error );
    if ( result == RF_OK )
        result = check_removed( shot, resolved, error );
    if ( result == RF_OK )
        result = check_passes( shot, resolved, error );
    if ( result == RF_OK )
        result = rf_check_light_groups( rf_tracer_scene( shot->tracer ), resolved, error );
    return result == RF_OK ? check_moving( shot, resolved, error ) : result;
}

RfGroupPlan rf_plan_samples( const RfShot* shot, int half_width, int spp )
{
    RfGroupPlan plan = rf_plan_shots( shot->eyes, shot->eye_count, half_width, spp );
    int most = RF_MAX_SPP / plan.eyes * plan.eyes;
    return plan.spp > RF_MAX_SPP ? rf_plan_shots( shot->eyes, shot->eye_count, half_width, most ) : plan;
}
