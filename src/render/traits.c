// What a scene and its camera's path call for, and what runs.
#include "render/traits.h"

#include "base/remedy.h"
#include "film/pixel_filter.h"
#include "light/changing.h"
#include "light/small_emitters.h"
#include "render/estimator.h"
#include "render/settings.h"
#include "scene/leave_out.h"
#include "scene/light_groups.h"
#include "scene/mirrors.h"
#include "scene/placement.h"
#include "scene/textured.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

static void add_triangles( const RfScene* scene, RfTriangleList list, RfSceneTraits* traits )
{
    const uint32_t* number = list.triangles->material;
    for ( uint32_t i = 0; i < list.triangles->count && list.uses > 0; ++i )
    {
        const RfMaterial* material = scene->materials + number[i];
        traits->chain_triangles += rf_is_chain_surface( material ) ? list.uses : 0;
        traits->plate_triangles += scene->punctual_count > 0 && rf_is_plate( material ) ? list.uses : 0;
        traits->most_lights += rf_max_component( material->emission ) > 0.0f ? list.uses : 0;
        if ( i > 0 && number[i] == number[i - 1] )
            continue;
        traits->kinds |= 1u << material->kind | (unsigned)rf_is_frosted( material ) << RF_BSDF_FROSTED;
        traits->blended = traits->blended || rf_is_blended( material );
        traits->panes = traits->panes || rf_may_be_pane( material );
        traits->smooth = traits->smooth || rf_may_be_smooth( material );
        traits->without_caustics = traits->without_caustics || rf_may_throw_caustics( material );
        traits->unlit = traits->unlit || material->unlit;
        traits->sharp = traits->sharp || rf_may_be_sharp( material );
    }
}

static int count_dimmable( const RfScene* scene )
{
    int count = scene->environment.changes;
    for ( int i = 0; i < scene->punctual_count; ++i )
        count += scene->punctuals[i].changes;
    for ( uint32_t i = 0; i < scene->material_count; ++i )
        count += scene->materials[i].dims;
    return count < RF_DIMMED_MOST ? count : RF_DIMMED_MOST;
}

// The lamps without size, and the sky, that may be other than dimmed; none where anything else moves.
static int count_lamps_alone( const RfScene* scene )
{
    int count = scene->environment.changes;
    for ( int i = 0; i < scene->punctual_count; ++i )
        count += scene->punctuals[i].changes;
    return scene->placement_count == scene->still_placement_count ? count : 0;
}

// Settings that ask for none that there are have been refused.
static int count_light_groups( const RfScene* scene, const RfRenderSettings* settings )
{
    RfLightGroups groups;
    if ( settings->light_groups == NULL || rf_find_light_groups( scene, settings->light_groups, &groups, NULL ) != RF_OK )
        return 0;
    int count = groups.count;
    rf_destroy_light_groups( &groups );
    return count;
}

RfResult rf_check_light_groups( const RfScene* scene, const RfRenderSettings* settings, RfError* error )
{
    RfLightGroups groups;
    if ( settings->light_groups == NULL )
        return RF_OK;
    RfResult result = rf_find_light_groups( scene, settings->light_groups, &groups, error );
    if ( result != RF_OK )
        return result;
    rf_destroy_light_groups( &groups );
    if ( !settings->estimator->splits_light )
        return rf_advise(
            rf_fail( error, RF_ERROR_USAGE, "the estimator '%s' cannot split light by groups", settings->estimator->name ),
            RF_REMEDY_ESTIMATOR, 0, error );
    if ( settings->light_paths == RF_LIGHT_PATHS_ON )
        return rf_fail( error, RF_ERROR_USAGE, "light paths cannot split light by groups: --light-paths off" );
    if ( rf_is_left_out( scene, RF_EFFECT_CAUSTICS ) )
        return rf_fail( error, RF_ERROR_USAGE,
                        "caustics cannot be left out of light groups: keep them, or render without light groups" );
    return RF_OK;
}

bool rf_may_move( const RfScene* scene ) { return rf_calls_for( scene->movement != NULL, RF_EFFECT_MOVING ); }

RfSceneTraits rf_scene_traits( const RfScene* scene, const RfEye* eyes, int eye_count, const RfRenderSettings* settings )
{
    RfSceneTraits traits = { .sky = rf_may_have_sky( scene ) };
    for ( int k = 0; k < rf_triangle_list_count( scene ); ++k )
        add_triangles( scene, rf_triangle_list( scene, k ), &traits );
    traits.without_caustics = traits.without_caustics && rf_is_left_out( scene, RF_EFFECT_CAUSTICS );
    traits.chains = traits.smooth || rf_has_specular( traits.kinds );
    RfMirrors mirrors;
    if ( rf_find_mirrors( scene, &mirrors, NULL ) == RF_OK )
        traits.mirrors = mirrors.count > 0;
    rf_destroy_mirrors( &mirrors );
    for ( int i = 0; i < eye_count; ++i )
    {
        traits.lens = traits.lens || eyes[i].lens_radius > 0.0f;
        bool blurs = rf_may_move( scene ) && eyes[i].blur_steps > traits.blur_steps;
        traits.blur_steps = blurs ? (int)eyes[i].blur_steps : traits.blur_steps;
        traits.shutter = traits.shutter || eyes[i].moves || traits.blur_steps > 0;
    }
    traits.grouped_chains = traits.mirrors || traits.smooth || traits.panes;
    traits.scattered = traits.lens || traits.shutter;
    traits.moves = rf_may_move( scene );
    traits.dimmable = traits.moves ? count_dimmable( scene ) : 0;
    traits.lamps_alone = traits.moves ? count_lamps_alone( scene ) : 0;
    traits.light_groups = count_light_groups( scene, settings );
    traits.most_lights += (uint32_t)scene->punctual_count + 1;
    traits.moving_lights = traits.moves && rf_count_moving_emitters( scene ) > 0;
    return traits;
}

bool rf_wants_light_paths( const RfSceneTraits* traits, const RfRenderSettings* settings )
{
    return rf_calls_for( settings->light_paths == RF_LIGHT_PATHS_ON && settings->estimator->prepare != NULL &&
                             settings->weights == RF_WEIGHTS_EXACT && traits->chain_triangles + traits->plate_triangles > 0 &&
                             !traits->blended && !( traits->moves && settings->group != 0 ) && traits->blur_steps == 0 &&
                             !traits->without_caustics && traits->light_groups == 0,
                         RF_EFFECT_LIGHT_PATHS );
}

RfResult rf_check_moving( const RfSceneTraits* traits, const RfRenderSettings* settings, RfError* error )
{
    if ( traits->blur_steps > 0 && settings->light_paths == RF_LIGHT_PATHS_ON )
        return rf_fail( error, RF_ERROR_USAGE,
                        "light paths are of one moment, but something moves while the shutter is open: --shutter 0, or "
                        "--light-paths off" );
    if ( !traits->moves || settings->group == 0 )
        return RF_OK;
    if ( settings->weights != RF_WEIGHTS_EXACT )
        return rf_fail( error, RF_ERROR_USAGE,
                        "the biased weights cannot tell what moves in a group of frames: exact weights, or a group of 0" );
    if ( settings->light_paths == RF_LIGHT_PATHS_ON )
        return rf_fail( error, RF_ERROR_USAGE,
                        "light paths cannot be shared by frames in which something moves: --group 0, or --light-paths off" );
    return RF_OK;
}

RfResult rf_check_caustics( const RfSceneTraits* traits, const RfRenderSettings* settings, RfError* error )
{
    if ( !traits->without_caustics )
        return RF_OK;
    if ( !settings->estimator->clamps )
        return rf_advise(
            rf_fail( error, RF_ERROR_USAGE, "the estimator '%s' cannot leave caustics out", settings->estimator->name ),
            RF_REMEDY_ESTIMATOR, 0, error );
    if ( settings->weights != RF_WEIGHTS_EXACT )
        return rf_fail( error, RF_ERROR_USAGE, "the biased weights cannot leave caustics out: exact weights" );
    if ( settings->light_paths == RF_LIGHT_PATHS_ON )
        return rf_fail( error, RF_ERROR_USAGE, "light paths bring caustics, which are left out: --light-paths off" );
    if ( traits->moves && settings->group != 0 )
        return rf_fail( error, RF_ERROR_USAGE,
                        "caustics cannot be left out of groups of frames in which something moves: --group 0, or keep them" );
    return RF_OK;
}

bool rf_wants_chains( const RfSceneTraits* traits, const RfRenderSettings* settings, int tile_pixels )
{
    bool grouped = settings->group != 0 && traits->grouped_chains;
    return traits->chains && settings->weights == RF_WEIGHTS_EXACT &&
           ( tile_pixels > 1 || grouped || traits->unlit || rf_wants_light_paths( traits, settings ) ||
             ( settings->aovs & RF_PASS_AOVS ) != 0 ); // which tell what is seen by them
}

// The models that materials with forced effects scatter by.
static unsigned forced_kinds( const RfScene* scene )
{
    unsigned kinds = 0;
    for ( int k = 0; k < RF_BSDF_KIND_COUNT; ++k )
    {
        uint64_t forced = scene->effects_forced & ~RF_EFFECTS_NOT_BUILT & rf_bsdf_model( (RfBsdfKind)k )->forced_by;
        kinds |= forced != 0 ? 1u << k : 0;
    }
    return kinds;
}

RfSceneTraits rf_running_traits( const RfScene* scene, RfSceneTraits called )
{
    RfSceneTraits traits = called;
    traits.kinds |= forced_kinds( scene );
#define RF_TRAIT_RUNS( flag, effect ) traits.flag = rf_runs( scene, called.flag, RF_EFFECT_##effect );
    RF_TRAIT_LIST( RF_TRAIT_RUNS )
#undef RF_TRAIT_RUNS
    bool grouped = ( called.mirrors && traits.mirrors ) || called.smooth || ( called.panes && traits.panes );
    traits.grouped_chains = called.chains ? grouped : traits.chains;
    traits.scattered = ( called.lens && traits.lens ) || ( called.shutter && traits.shutter );
    return traits;
}

// All rows of the list of effects: those that the scene decides (scene/scene_effects.c), then path and settings.

// What the rows are made of.
typedef struct Source
{
    const RfScene* scene;
    const RfRenderSettings* settings;
    RfSceneTraits traits; // that run
    int eye_count;
    bool explain;   // reasons are shown, and found even where that takes time
    RfEffect* rows; // by id
} Source;

__attribute__( ( format( printf, 4, 5 ) ) ) static void set( const Source* from, RfEffectId id, bool on, const char* format, ... )
{
    RfEffect* row = from->rows + id;
    va_list args;
    va_start( args, format );
    *row = ( RfEffect ){ .id = id, .on = on, .by_render = id >= RF_EFFECT_CHAINS };
    vsnprintf( row->why, sizeof row->why, format, args );
    va_end( args );
    rf_finish_effect( from->scene, row );
}

// The path's cameras decide in the place of the scene's cameras; with options they may have a lens that no camera has.
static void set_path( const Source* from, const RfEye* eyes )
{
    int lens = 0, shutter = 0, moving = 0;
    for ( int i = 0; i < from->eye_count; ++i )
    {
        const RfEye *e = eyes + i, *f = eyes;
        RfVec3 step = rf_sub( e->origin, f->origin ), turn = rf_sub( e->forward, f->forward );
        lens += e->lens_radius > 0.0f;
        shutter += e->moves != 0 || e->blur_steps > 0;
        moving += rf_dot( step, step ) + rf_dot( turn, turn ) + fabsf( e->focal - f->focal ) > 0.0f;
    }
    int all = from->eye_count;
    set( from, RF_EFFECT_CAMERA_ANIMATION, moving > 0, moving > 0 ? "the camera moves in %d frames" : "the camera is static",
         all );
    if ( !from->rows[RF_EFFECT_DEPTH_OF_FIELD].left_out )
        set( from, RF_EFFECT_DEPTH_OF_FIELD, lens > 0,
             lens > 0 ? "the camera has a lens in %d of %d frames" : "the camera is a pinhole", lens, all );
    if ( !from->rows[RF_EFFECT_MOTION_BLUR].left_out )
        set( from, RF_EFFECT_MOTION_BLUR, shutter > 0,
             shutter > 0 ? "something moves while the shutter is open in %d of %d frames"
                         : "nothing moves while the shutter is open",
             shutter, all );
}

static bool emits( const RfScene* scene, uint32_t triangle )
{
    return rf_max_component( scene->materials[scene->triangles.material[triangle]].emission ) > 0.0f;
}

static void set_light_tree( const Source* from )
{
    const RfScene* scene = from->scene;
    uint32_t lights = (uint32_t)scene->punctual_count + from->traits.sky;
    for ( uint32_t i = 0; i < scene->triangles.count && lights <= RF_FEW_LIGHTS; ++i )
        lights += emits( scene, i );
    lights += rf_count_moving_emitters( scene );
    if ( from->settings->light_sampling == RF_LIGHTS_BY_POWER )
        set( from, RF_EFFECT_LIGHT_TREE, false, "off in the settings: lights are sampled by power" );
    else
        set( from, RF_EFFECT_LIGHT_TREE, lights > RF_FEW_LIGHTS,
             lights > RF_FEW_LIGHTS ? "more than %d lights" : "up to %d lights are sampled by power", RF_FEW_LIGHTS );
}

static const RfEffect* chain_reason( const Source* from )
{
    static const RfEffectId reasons[] = { RF_EFFECT_MIRRORS, RF_EFFECT_TRANSMISSION, RF_EFFECT_SMOOTH_GLOSS };
    for ( size_t i = 0; i < sizeof reasons / sizeof reasons[0]; ++i )
    {
        if ( from->rows[reasons[i]].on )
            return from->rows + reasons[i];
    }
    return NULL;
}

static int tile_pixels( const RfTile* tile )
{
    switch ( tile->kind )
    {
        case RF_TILE_BLOCK: return tile->width * tile->height;
        case RF_TILE_ROOKS: return tile->width;
        case RF_TILE_AUTO: return RF_MAX_TILE_PIXELS;
        default: return 1;
    }
}

static void set_chains( const Source* from )
{
    const RfEffect* reason = chain_reason( from );
    const RfRenderSettings* s = from->settings;
    RfSceneTraits called = from->traits;
    called.chains = reason != NULL;
    if ( reason == NULL )
        set( from, RF_EFFECT_CHAINS, false, "no mirror, no glass, no GGX lobe that is almost a mirror" );
    else if ( !rf_wants_chains( &called, s, tile_pixels( &s->tile ) ) )
        set( from, RF_EFFECT_CHAINS, false, "neither tiles nor other frames would use them" );
    else
        set( from, RF_EFFECT_CHAINS, true, "%s: %.120s", reason->name, reason->why );
}

static void set_light_paths( const Source* from )
{
    const RfSceneTraits* t = &from->traits;
    const RfRenderSettings* s = from->settings;
    bool carried = t->chain_triangles + t->plate_triangles > 0 && !t->blended;
    uint32_t small =
        s->light_paths == RF_LIGHT_PATHS_OFF && from->explain && carried ? rf_count_small_emitters( from->scene ) : 0;
    if ( small > 0 )
        set( from, RF_EFFECT_LIGHT_PATHS, false,
             "not enabled, although mirrors, clear glass or smooth metals carry the light of %u small emitter%s", small,
             small == 1 ? "" : "s" );
    else if ( s->light_paths == RF_LIGHT_PATHS_OFF )
        set( from, RF_EFFECT_LIGHT_PATHS, false, "off in the settings" );
    else if ( rf_wants_light_paths( t, s ) )
        set( from, RF_EFFECT_LIGHT_PATHS, true, "%u triangles of mirrors, clear glass or smooth metals",
             t->chain_triangles + t->plate_triangles );
    else
        set( from, RF_EFFECT_LIGHT_PATHS, false, "%s",
             t->chain_triangles + t->plate_triangles == 0
                 ? "no perfect mirror, no smooth solid glass, no smooth metal under lamps without size"
             : t->without_caustics            ? "caustics are left out"
             : t->light_groups > 0            ? "light is split by groups"
             : t->blended                     ? "surfaces are partly transparent, which light paths do not pass"
             : s->weights != RF_WEIGHTS_EXACT ? "they need exact weights"
             : t->moves && s->group != 0      ? "where something moves they want groups of one frame"
             : t->blur_steps > 0              ? "something moves while the shutter is open: they are of one moment"
                                              : "the estimator does not support them" );
}

static void set_reuse( const Source* from )
{
    const RfRenderSettings* s = from->settings;
    char tile[RF_TILE_NAME_SIZE];
    bool chosen = s->tile.kind == RF_TILE_AUTO, tiles = chosen || tile_pixels( &s->tile ) > 1,
         groups = s->group != 0 && from->eye_count != 1;
    rf_tile_name( &s->tile, tile );
    if ( s->group == RF_GROUP_AUTO && groups )
        set( from, RF_EFFECT_FRAME_GROUPS, true, "of the size that the plan chooses" );
    else
        set( from, RF_EFFECT_FRAME_GROUPS, groups, groups ? "of up to %d frames" : "no frame reuse", 2 * s->group + 1 );
    if ( chosen )
        set( from, RF_EFFECT_TILE_CONNECTIONS, true, "of the size that the plan chooses" );
    else
        set( from, RF_EFFECT_TILE_CONNECTIONS, tiles, tiles ? "tiles of %s pixels" : "no tiles", tile );
    bool adaptive = s->adaptive == RF_ADAPTIVE_ON || ( s->adaptive == RF_ADAPTIVE_AUTO && groups );
    set( from, RF_EFFECT_ADAPTIVE, adaptive, "%s",
         s->adaptive == RF_ADAPTIVE_ON ? "on in the settings"
         : adaptive                    ? "in frames where it pays off"
                                       : "off in the settings, or no frame reuse" );
    if ( rf_is_stopping( s ) )
        set( from, RF_EFFECT_STOP_RULE, true, "frames stop at a target %s",
             s->noise > 0.0     ? "noise"
             : s->flicker > 0.0 ? "flicker"
                                : "time" );
    else
        set( from, RF_EFFECT_STOP_RULE, false, "fixed number of samples" );
}

static void set_projection( const Source* from, const RfEye* eyes )
{
    const RfScene* scene = from->scene;
    int others = 0, all = from->eye_count > 0 ? from->eye_count : scene->camera_count;
    for ( int i = 0; i < all; ++i )
        others += ( from->eye_count > 0 ? (int)eyes[i].projection : scene->cameras[i].projection ) != RF_PERSPECTIVE;
    set( from, RF_EFFECT_OTHER_PROJECTION, others > 0, others > 0 ? "not in perspective: %d of %d %s" : "all in perspective",
         others, all, from->eye_count > 0 ? "frames" : "cameras" );
}

static void set_film( const Source* from )
{
    const RfRenderSettings* s = from->settings;
    bool filtered = !rf_is_plain_filter( s ), gradients = s->estimator->has_gradients;
    set( from, RF_EFFECT_PIXEL_FILTER, filtered, filtered ? "%s" : "box of one pixel", rf_filter_words[s->filter] );
    set( from, RF_EFFECT_GRADIENTS, gradients, gradients ? "on in the settings" : "off in the settings" );
}

// `explain`: the reasons are shown to users, so that they are found even where that takes time.
static int list_effects( const RfScene* scene, const RfEye* eyes, int eye_count, const RfRenderSettings* settings, bool explain,
                         RfEffect effects[RF_MAX_EFFECTS] )
{
    RfEffect of_scene[RF_MAX_EFFECTS];
    int count = rf_list_effects( scene, of_scene );
    for ( int i = 0; i < count; ++i )
        effects[of_scene[i].id] = of_scene[i];
    Source from = { .scene = scene,
                    .settings = settings,
                    .traits = rf_running_traits( scene, rf_scene_traits( scene, eyes, eye_count, settings ) ),
                    .explain = explain,
                    .eye_count = eye_count,
                    .rows = effects };
    if ( eye_count > 0 )
        set_path( &from, eyes );
    set_light_tree( &from );
    set_chains( &from );
    set_light_paths( &from );
    set_reuse( &from );
    set_projection( &from, eyes );
    set_film( &from );
    return RF_EFFECT_COUNT;
}

int rf_list_render_effects( const RfScene* scene, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                            RfEffect effects[RF_MAX_EFFECTS] )
{
    return list_effects( scene, eyes, eye_count, settings, true, effects );
}

// For programs: without the search for reasons.
static int list_of_shot( const RfShot* shot, const RfRenderSettings* settings, RfEffect effects[RF_MAX_EFFECTS] )
{
    return list_effects( rf_tracer_scene( shot->tracer ), shot->eyes, shot->eye_count, settings, false, effects );
}

void rf_name_effects( const RfShot* shot, const RfRenderSettings* settings, char text[RF_EFFECTS_TEXT_SIZE] )
{
    RfEffect effects[RF_MAX_EFFECTS];
    uint64_t on = 0;
    int count = list_of_shot( shot, settings, effects );
    for ( int i = 0; i < count; ++i )
        on |= effects[i].on ? RF_EFFECT_BIT( effects[i].id ) : 0;
    rf_format_effects( on, text, RF_EFFECTS_TEXT_SIZE );
}

RfResult rf_check_built( const RfShot* shot, const RfRenderSettings* settings, RfError* error )
{
    RfEffect effects[RF_MAX_EFFECTS];
    if ( RF_EFFECTS_NOT_BUILT == 0 )
        return RF_OK;
    int count = list_of_shot( shot, settings, effects );
    for ( int i = 0; i < count; ++i )
    {
        if ( effects[i].on && !rf_is_built( effects[i].id ) )
            return rf_fail( error, RF_ERROR_UNSUPPORTED,
                            "this build of Reframe lacks the effect %s, which is called for: %s: leave it out, or build with it",
                            effects[i].name, effects[i].why );
    }
    return RF_OK;
}
