// All rows of the list of effects: those that the scene decides (scene/scene_effects.c), then path and settings.
#include "render/render_effects.h"

#include "film/pixel_filter.h"
#include "light/changing.h"
#include "render/settings.h"
#include "render/sizes.h"
#include "scene/leave_out.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>

// What the rows are made of.
typedef struct Source
{
    const RfScene* scene;
    const RfRenderSettings* settings;
    RfSceneTraits traits; // that run
    int eye_count;
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

// The first reason for chains that is on.
static const RfEffect* chain_reason( const Source* from )
{
    static const RfEffectId reasons[] = { RF_EFFECT_MIRRORS, RF_EFFECT_TRANSMISSION, RF_EFFECT_SMOOTH_METALS };
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
    bool on = rf_wants_light_paths( t, s );
    if ( s->light_paths == RF_LIGHT_PATHS_OFF && t->emitters.connected > 0 )
        set( from, RF_EFFECT_LIGHT_PATHS, false,
             "not enabled, although mirrors, clear glass or smooth metals carry the light of %u small emitter%s",
             t->emitters.connected, t->emitters.connected == 1 ? "" : "s" );
    else if ( s->light_paths == RF_LIGHT_PATHS_OFF )
        set( from, RF_EFFECT_LIGHT_PATHS, false, "off in the settings" );
    else if ( on && s->light_paths == RF_LIGHT_PATHS_AUTO )
        set( from, RF_EFFECT_LIGHT_PATHS, true,
             "%u triangles of mirrors, clear glass or smooth metals; %u of %u emitters are small",
             t->chain_triangles + t->plate_triangles, t->emitters.connected, t->emitters.all );
    else if ( on )
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
             : s->estimator->prepare == NULL
                 ? "the estimator does not support them"
                 : "mirrors and glass carry the light of large emitters only, which BSDF sampling finds" );
}

static void set_reuse( const Source* from )
{
    const RfRenderSettings* s = from->settings;
    char tile[RF_TILE_NAME_SIZE];
    bool tiles = tile_pixels( &s->tile ) > 1, groups = s->group != 0 && from->eye_count != 1;
    rf_tile_name( &s->tile, tile );
    if ( s->group == RF_GROUP_AUTO && groups )
        set( from, RF_EFFECT_FRAME_GROUPS, true, "of the size that the plan chooses" );
    else
        set( from, RF_EFFECT_FRAME_GROUPS, groups, groups ? "of up to %d frames" : "no frame reuse", 2 * s->group + 1 );
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

// To explain: whether light paths would help is found by settings that ask for "auto", even if they are off.
static RfSceneTraits traits_of( const RfScene* scene, const RfEye* eyes, int eye_count, RfRenderSettings settings, bool explain )
{
    if ( explain )
        settings.light_paths = RF_LIGHT_PATHS_AUTO;
    return rf_running_traits( scene, rf_scene_traits( scene, eyes, eye_count, &settings ) );
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
                    .traits = traits_of( scene, eyes, eye_count, *settings, explain ),
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
