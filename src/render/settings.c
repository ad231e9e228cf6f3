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

// A number that must be one of the words of a list, or in a range.
typedef struct Limit
{
    const char* what;
    double value, low, high;
} Limit;

static bool is_within( const Limit* l ) { return l->value >= l->low && l->value <= l->high; }

#define CHOICE( what, value, last )                                                                                              \
    {                                                                                                                            \
        what, (double)(int)( value ), 0, last                                                                                    \
    }

static RfResult check_choices( const RfRenderSettings* s, RfError* error )
{
    const Limit choices[] = {
        CHOICE( "weighting", s->weights, RF_WEIGHTS_UNWEIGHTED ),
        CHOICE( "normalisation", s->normalize, RF_NORMALIZE_NONE ),
        CHOICE( "light sampling", s->light_sampling, RF_LIGHTS_BY_POWER ),
        CHOICE( "use of light paths", s->light_paths, RF_LIGHT_PATHS_OFF ),
        CHOICE( "normalisation of kernels", s->kernel_normalization, RF_KERNEL_DENSITY ),
        CHOICE( "reconstruction", s->reconstruction, RF_RECONSTRUCTION_NONE ),
        CHOICE( "guiding", s->guide, RF_GUIDE_OFF ),
        CHOICE( "adaptive sampling", s->adaptive, RF_ADAPTIVE_OFF ),
        CHOICE( "compression", s->files.compression, RF_EXR_DWAB ),
    };
    for ( size_t i = 0; i < sizeof choices / sizeof choices[0]; ++i )
    {
        if ( !is_within( choices + i ) )
            return rf_fail( error, RF_ERROR_USAGE, "there is no %s %g", choices[i].what, choices[i].value );
    }
    if ( !rf_is_filter( s->filter ) )
        return rf_fail( error, RF_ERROR_USAGE, "there is no pixel filter %d", (int)s->filter );
    return check_dwa( &s->files, error );
}

static RfResult check_settings( const RfRenderSettings* s, RfError* error )
{
    const Limit limits[] = {
        { "samples per pixel", s->spp, 1, RF_MAX_SPP },
        { "the relMSE wanted", s->noise, 0, RF_MAX_NOISE },
        { "the flicker wanted", s->flicker, 0, RF_MAX_FLICKER },
        { "the clamp", s->clamp == RF_CLAMP_AUTO ? 0.0 : s->clamp, 0, RF_MAX_CLAMP },
        { "the clamp of chains", s->clamp_chains, 0, RF_MAX_CLAMP },
        { "the seconds for a frame", s->time, 0, RF_MAX_TIME },
        { "group", s->group == RF_GROUP_AUTO ? 0 : s->group, 0, RF_MAX_GROUP },
        { "depth", s->max_depth, 1, RF_MAX_DEPTH },
        { "light samples", s->light_samples, 1, RF_MAX_LIGHT_SAMPLES },
        { "the frames of the queue", s->queue, 0, RF_MAX_QUEUE },
        { "threads", s->threads > 0 ? s->threads : 0, 0, RF_MAX_THREADS },
        { "the width of a pixel filter", s->filter_width == 0.0 ? RF_MIN_FILTER_WIDTH : s->filter_width, RF_MIN_FILTER_WIDTH,
          RF_MAX_FILTER_WIDTH },
    };
    for ( size_t i = 0; i < sizeof limits / sizeof limits[0]; ++i )
    {
        if ( !is_within( limits + i ) )
            return rf_fail( error, RF_ERROR_USAGE, "%s must be %.10g to %.10g, got %.10g", limits[i].what, limits[i].low,
                            limits[i].high, limits[i].value );
    }
    if ( s->clamp_chains > 0.0 && s->clamp == 0.0 )
        return rf_fail( error, RF_ERROR_USAGE, "a clamp of chains needs a clamp of paths as well" );
    if ( ( s->aovs & ~( RF_ALL_AOVS | RF_AOV_BIT( RF_AOV_ALPHA ) ) ) != 0 )
        return rf_fail( error, RF_ERROR_USAGE, "there are no such AOVs: %#x", s->aovs );
    if ( ( s->cryptomatte & ~( RF_CRYPTOMATTE_OBJECT | RF_CRYPTOMATTE_MATERIAL | RF_CRYPTOMATTE_ASSET ) ) != 0 )
        return rf_fail( error, RF_ERROR_USAGE, "there are no such kinds of Cryptomatte: %#x", s->cryptomatte );
    return check_choices( s, error );
}

bool rf_can_render_pieces( const RfRenderSettings* s ) { return s->estimator->is_traced != NULL && s->estimator->finish == NULL; }

bool rf_has_groups( const RfEstimator* estimator ) { return estimator->count_reuse != NULL; }

int rf_usual_passes( const RfRenderSettings* s ) { return s->estimator->usual_passes > 2 ? s->estimator->usual_passes : 2; }

// What an estimator has not got.
typedef struct Lack
{
    bool missing;
    const char* what;
} Lack;

static RfResult check_estimator( const RfRenderSettings* s, RfError* error )
{
    const RfEstimator* e = s->estimator;
    if ( e == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "settings without an estimator: start from rf_default_render_settings" );
    if ( e->films < 1 || e->films > RF_MAX_FILMS )
        return rf_fail( error, RF_ERROR_USAGE, "the estimator '%s' asks for %d films, 1 to %d can be had", e->name, e->films,
                        RF_MAX_FILMS );
    if ( s->adaptive == RF_ADAPTIVE_ON && e->biased )
        return rf_fail( error, RF_ERROR_USAGE, "adaptive samples need exact weights" );
    const Lack lacks[] = {
        { !rf_is_plain_filter( s ) && !e->filters, "pixel filter but a box of one pixel" },
        { s->adaptive == RF_ADAPTIVE_ON && !can_adapt( s ), "adaptive sampling" },
        { ( s->aovs & RF_FIRST_HIT_AOVS ) != 0 && e->first_hits == NULL, "AOVs of first hits" },
        { ( s->aovs & RF_DENOISE_AOVS ) != 0 && !e->has_features, "AOVs for denoisers" },
        { ( s->aovs & RF_AOV_BIT( RF_AOV_HALF ) ) != 0 && e->finish != NULL, "half AOV: its halves weigh each other" },
        { ( s->aovs & RF_AOV_BIT( RF_AOV_VARIANCE ) ) != 0 && e->finish != NULL && !e->has_variance, "variance AOV" },
        // the halves of the pictures that it makes are not in the films
        { s->flicker > 0.0 && e->finish != NULL, "estimate of flicker to stop at" },
        { ( s->aovs & RF_GRADIENT_AOVS ) != 0 && !e->has_gradients, "gradients" },
        { ( s->aovs & RF_PASS_AOVS ) != 0 && !e->splits_light, "passes of its light" },
        { ( s->aovs & RF_AOV_BIT( RF_AOV_ALPHA ) ) != 0 && !e->has_alpha, "alpha" },
        { rf_wants_covering( s ) && !e->has_covering, "Cryptomatte and no index AOVs" },
        { s->clamp != 0.0 && !e->clamps, "clamp" },
        { s->guide == RF_GUIDE_ON && !e->guides, "guiding" },
    };
    for ( size_t i = 0; i < sizeof lacks / sizeof lacks[0]; ++i )
    {
        if ( lacks[i].missing )
            return rf_advise( rf_fail( error, RF_ERROR_USAGE, "the estimator '%s' has no %s", e->name, lacks[i].what ),
                              RF_REMEDY_ESTIMATOR, 0, error );
    }
    if ( s->pieces != NULL && !rf_can_render_pieces( s ) )
        return rf_fail( error, RF_ERROR_USAGE, "the estimator '%s' cannot render pieces", e->name );
    if ( s->pieces != NULL && ( rf_is_stopping( s ) || s->adaptive != RF_ADAPTIVE_OFF ) )
        return rf_fail( error, RF_ERROR_USAGE,
                        "pieces are rendered without a noise, a flicker or a time to stop at, and without extra samples" );
    return e->check != NULL ? e->check( s, error ) : RF_OK;
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
    if ( resolved->tile.kind == RF_TILE_AUTO )
        resolved->tile = resolved->estimator->tile;
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
