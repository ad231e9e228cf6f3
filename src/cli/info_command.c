// reframe info: the content of a scene, what moves and changes in it, and the effects it calls for.
#include "base/try.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/render_options.h"
#include "cli/options/shared_options.h"
#include "cli/render/render_json.h"
#include "film/cryptomatte.h"
#include "light/changing.h"
#include "reframe/scene.h"
#include "scene/pose.h"
#include "scene_file/scene_file.h"

#include <limits.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static RfFps s_fps;
static bool s_fps_given;
static const char* s_json;
static const char* const s_files[] = { "SCENE" };
static bool s_quiet;
static RfRenderOptions s_render; // effects, movement and group alone
static bool s_effects_given, s_group_given;

#define MAX_MOVING 30          // that are listed
#define MAX_LIGHTS 12          // that are listed of a light group
#define MAX_CHANGING 64        // lights and materials named: of more no share is known, and materials are not named
#define MUCH_OWN 0.5           // of the light
#define MOST_TRIANGLES 4000000 // that a BVH is built of in about two seconds
#define MOST_CHOICE 2e6        // triangles and lights for which a group is chosen in about three seconds

static const RfOption s_options[] = {
    RF_FPS_OPTION( "fps", &s_fps, "R", "frames per second, for the frame counts of the cameras", .given = &s_fps_given,
                   .default_text = "the scene's, else 24" ),
    RF_CHOICE_OPTION( "effects", &s_render.effects, rf_effects_words, "list the effects as with render --effects",
                      .given = &s_effects_given ),
    RF_TEXT_OPTION( "no-effect", &s_render.no_effect, "NAME[,...]", "list the effects as with render --no-effect",
                    .default_text = "none" ),
    RF_MOVEMENT_OPTIONS( s_render ),
    RF_INT_OPTION( "group", &s_render.settings.group, 0, RF_MAX_GROUP, "N|auto",
                   "say how light that changes is shared in groups of 2N+1 frames, as render --group", .given = &s_group_given,
                   .keyword = "auto", .keyword_value = RF_GROUP_AUTO ),
    RF_TEXT_OPTION( "json", &s_json, "FILE", "write the result as JSON; - for standard output", .writes = ".json" ),
    RF_FLAG_OPTION( "quiet", &s_quiet, "accepted for consistency; there is no progress" ),
};
static const RfCommandTable s_table = {
    .command = "info",
    .summary = "Lists what is in a scene (.glb, .gltf or .json scene file), what moves and changes, and which effects it uses.",
    RF_TABLE_ROWS( s_files, s_options )
};

// What is printed.
typedef struct Facts
{
    RfSceneInfo scene;
    RfCameraInfo* cameras;
    RfRenderOptions render; // the scene file's defaults
    RfSceneFile file;       // which strings of these point into
    json_t* changes;        // rf_add_changes
    RfError unknown;        // why it is not known how light is shared
    double beyond_depth;    // share of the light; NaN: not known
} Facts;

// How a render with the file's defaults shares light, and how much its limit of depth takes. Where there is nothing to render, that
// is not known.
static RfResult gather_light( const RfScene* scene, Facts* facts, RfError* error )
{
    RfRenderOptions* options = &facts->render;
    RfTracer* tracer = NULL;
    RfLens lens;
    RfCameraPath path = rf_empty_camera_path();
    RfPathOptions asked;
    RfResult result = rf_parse_path_options( options, &lens, &asked, error );
    asked.fps = s_fps;
    if ( result == RF_OK )
        result = rf_create_camera_path( scene, &asked, &path, error );
    if ( result == RF_OK )
        result = rf_create_tracer( scene, &tracer, error );
    if ( result == RF_OK )
    {
        RfRenderSettings settings = options->settings;
        options->fps = s_fps;
        options->size = ( RfSize ){ path.eyes[0].width, path.eyes[0].height };
        RfShot shot = { .tracer = tracer, .eyes = path.runs, .eye_count = path.run_count };
        if ( options->settings.group != RF_GROUP_AUTO ) // whose light is shared the same with any tile: none is to be chosen
            options->settings.tile = ( RfTile ){ RF_TILE_NONE, 1, 1 };
        RfRenderSettings given = options->settings;
        result = rf_resolve_settings( &shot, &given, &options->settings, error );
        if ( result == RF_OK )
            result = rf_find_light_beyond_depth( &shot, &options->settings, &facts->beyond_depth, error );
        if ( result == RF_OK )
            result = rf_add_changes( scene, scene->movement != NULL ? tracer : NULL, options, facts->changes, error );
        options->settings = settings;
    }
    rf_destroy_tracer( tracer );
    rf_destroy_camera_path( &path );
    return result;
}

// What choosing a group takes: some 50 frames are posed, and in as many groups, of up to 33 frames, 450 are lit.
static double work_of_choice( const RfScene* scene )
{
    return 50.0 * (double)rf_pose_parts( scene ).triangles + 450.0 * (double)rf_count_moving_emitters( scene );
}

static RfResult gather_changes( const RfScene* scene, Facts* facts, RfError* error )
{
    bool renders = facts->scene.unrendered_count == 0 || facts->scene.frozen;
    facts->changes = json_object();
    bool cuts = facts->render.settings.max_depth < RF_MAX_DEPTH;
    bool looks = ( scene->movement != NULL || cuts ) && renders && facts->scene.cameras > 0;
    facts->beyond_depth = cuts ? (double)NAN : 0.0;
    if ( looks && facts->scene.stored_triangles > MOST_TRIANGLES )
        rf_fail( &facts->unknown, RF_ERROR_UNSUPPORTED, "more than %d triangles: the JSON of a render says it", MOST_TRIANGLES );
    else if ( looks && scene->movement != NULL && facts->render.settings.group == RF_GROUP_AUTO &&
              work_of_choice( scene ) > MOST_CHOICE )
        rf_fail( &facts->unknown, RF_ERROR_UNSUPPORTED,
                 "so much deforms and shines that choosing a group takes long: give --group N" );
    else if ( looks && gather_light( scene, facts, &facts->unknown ) == RF_OK )
        return RF_OK;
    if ( scene->movement == NULL )
        facts->unknown = ( RfError ){ .code = RF_OK };
    return rf_add_changes( scene, NULL, &facts->render, facts->changes, error );
}

static RfResult gather( const RfScene* scene, Facts* facts, RfError* error )
{
    RF_TRY( rf_scene_info( scene, &facts->scene, error ) );
    if ( s_fps.numerator == 0 )
        s_fps = rf_scene_fps( scene );
    facts->cameras = calloc( (size_t)facts->scene.cameras + 1, sizeof *facts->cameras );
    if ( facts->cameras == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its cameras", facts->scene.path );
    RfResult result = RF_OK;
    for ( int i = 0; i < facts->scene.cameras && result == RF_OK; ++i )
        result = rf_scene_camera( scene, i, s_fps, facts->cameras + i, error );
    return result == RF_OK ? gather_changes( scene, facts, error ) : result;
}

// " (101 to 110)", or nothing where they are called 1, 2, 3.
static void name_frames( const RfCameraInfo* camera, char* text, size_t size )
{
    int last = camera->first + ( camera->frames - 1 ) * camera->step;
    text[0] = '\0';
    if ( camera->step > 1 )
        snprintf( text, size, " (%d to %d in steps of %d)", camera->first, last, camera->step );
    else if ( camera->first != 1 )
        snprintf( text, size, " (%d to %d)", camera->first, last );
}

static void print_film( const RfSceneInfo* scene )
{
    if ( scene->width > 0 )
        rf_print( "size       %dx%d%s\n", scene->width, scene->height, scene->alpha ? ", with alpha" : "" );
}

// A heading with their number, and a line for each, at most so many of them; nothing where there are none.
static void print_list( const char* heading, const char* words, const char* const* names, int count, int most )
{
    if ( count > 0 )
        rf_print( "%-10s %d%s\n", heading, count, words );
    for ( int i = 0; i < count && i < most; ++i )
        rf_print( "  %s\n", names[i] );
    if ( count > most )
        rf_print( "  and %d more\n", count - most );
}

// "light 'Desk'"
static void print_changes( const Facts* facts )
{
    const json_t *list = json_object_get( facts->changes, "changing" ), *sharing = json_object_get( facts->changes, "sharing" );
    const json_t* change;
    size_t i;
    char text[RF_CHANGE_TEXT];
    if ( json_array_size( list ) > 0 )
        rf_print( "changing   %zu\n", json_array_size( list ) );
    json_array_foreach( list, i, change )
    {
        const char* kind = json_string_value( json_object_get( change, "kind" ) );
        if ( i >= MAX_CHANGING && strcmp( kind, "light" ) != 0 ) // lights come first, and all of them
            break;
        const char* name = json_string_value( json_object_get( change, "name" ) );
        rf_format_change( change, sharing, text );
        if ( strcmp( kind, "sky" ) == 0 )
            rf_print( "  sky: %s\n", text );
        else
            rf_print( "  %s '%s': %s\n", kind, name, text );
    }
    if ( i < json_array_size( list ) )
        rf_print( "  and %zu more\n", json_array_size( list ) - i );
    double group = rf_json_number_of( sharing, "group" ), own = rf_json_number_of( sharing, "own_frame" ); // NaN: not known
    bool much = isfinite( group ) && group > 0.0 && isfinite( own ) && own > MUCH_OWN;
    rf_format_sharing( sharing, text );
    if ( text[0] != '\0' )
        rf_print( "sharing    %s%s\n", text, much ? ": a smaller group may be as fast (reframe tune)" : "" );
    else if ( facts->unknown.code != RF_OK )
        rf_print( "sharing    not known: %s\n", facts->unknown.text );
}

static void print_unrendered( const RfSceneInfo* scene )
{
    if ( scene->unrendered_count > 0 )
        rf_print( "%s\n", scene->frozen ? "frozen as well" : "not rendered: an error, unless --freeze is given" );
    for ( int i = 0; i < scene->unrendered_count; ++i )
        rf_print( "  %s: %s\n", scene->unrendered[i].what, scene->unrendered[i].why );
}

// "  key: lamp 'Desk', material 'bulb'": what shines in a light group; −1: in none, the layer of which is "rest".
static void print_light_group( const RfScene* scene, const char* name, int group )
{
    RfLightInfo light;
    int count = 0;
    for ( int i = 0; rf_scene_light( scene, i, &light ); ++i )
    {
        bool listed = light.shines && light.group == group;
        if ( listed && count < MAX_LIGHTS )
            rf_print( "%s%s%s %s '%s'", count > 0 ? "" : "  ", count > 0 ? "" : name, count > 0 ? "," : ":", light.kind,
                      light.name );
        count += listed;
    }
    if ( count > MAX_LIGHTS )
        rf_print( " and %d more", count - MAX_LIGHTS );
    if ( count == 0 && group >= 0 )
        rf_print( "  %s: nothing shines", name );
    if ( count > 0 || group >= 0 )
        rf_print( "\n" );
}

static void print_light_groups( const RfScene* scene, const RfSceneInfo* info )
{
    if ( info->light_group_count == 0 )
        return;
    rf_print( "light groups %d\n", info->light_group_count );
    for ( int i = 0; i < info->light_group_count; ++i )
        print_light_group( scene, info->light_groups[i], i );
    print_light_group( scene, "rest, in none", -1 );
}

static json_t* light_groups_json( const RfScene* scene, const RfSceneInfo* info )
{
    json_t* groups = json_array();
    for ( int g = 0; g < info->light_group_count; ++g )
    {
        json_t* lights = json_array();
        RfLightInfo light;
        for ( int i = 0; rf_scene_light( scene, i, &light ); ++i )
        {
            if ( light.shines && light.group == g )
                json_array_append_new( lights,
                                       json_pack( "{s:s, s:o}", "kind", light.kind, "name", rf_json_text( light.name ) ) );
        }
        json_array_append_new( groups,
                               json_pack( "{s:o, s:o}", "name", rf_json_text( info->light_groups[g] ), "lights", lights ) );
    }
    return groups;
}

static void print_cameras( const Facts* facts )
{
    rf_print( "cameras    %d\n", facts->scene.cameras );
    for ( int i = 0; i < facts->scene.cameras; ++i )
    {
        const RfCameraInfo* c = facts->cameras + i;
        char numbers[80];
        name_frames( c, numbers, sizeof numbers );
        bool plain = strcmp( c->projection, "perspective" ) == 0;
        char shots[32] = "";
        if ( c->shots > 1 )
            snprintf( shots, sizeof shots, ", %d shots", c->shots );
        rf_print( "  %s: %d frame%s%s at %g frames/s, %s%s%s%s\n", c->name, c->frames, c->frames == 1 ? "" : "s", numbers,
                  (double)s_fps.numerator / (double)s_fps.denominator, c->animated ? "animated" : "static", plain ? "" : ", ",
                  plain ? "" : c->projection, shots );
    }
}

static void print_depth( const Facts* facts )
{
    int depth = facts->render.settings.max_depth;
    const char* whose = facts->render.depth_of_scene ? ", from the glTF" : "";
    if ( depth < RF_MAX_DEPTH && isfinite( facts->beyond_depth ) )
        rf_print( "max depth  %d%s: about %.2g %% of the light is beyond and missing\n", depth, whose,
                  100.0 * facts->beyond_depth );
    else if ( depth < RF_MAX_DEPTH )
        rf_print( "max depth  %d%s: the light beyond is missing\n", depth, whose );
}

static const char* state_of( const RfEffect* effect )
{
    return effect->on ? "on" : effect->left_out ? "out" : effect->forced ? "run" : "off";
}

// "run": the code runs although nothing calls for it.
static void print_effects( const RfScene* scene, const RfRenderSettings* settings )
{
    RfEffect effects[RF_MAX_EFFECTS];
    int count = rf_list_render_effects( scene, NULL, 0, settings, effects );
    rf_print( "effects\n" );
    for ( int i = 0; i < count; ++i )
    {
        const char* option = rf_effect_option( effects[i].id );
        rf_print( "  %-3s  %-22s%s%s%s%s\n", state_of( effects + i ), effects[i].name, effects[i].why, option != NULL ? " (" : "",
                  option != NULL ? option : "", option != NULL ? ")" : "" );
    }
}

static void print_info( const RfScene* scene, const Facts* facts )
{
    const RfSceneInfo* s = &facts->scene;
    rf_print( "%s\n", s->path );
    if ( s->export_loss_count > 0 )
        rf_print( "LOST       by the export, %d: movements stand still, or the light of the picture is another\n",
                  s->export_loss_count );
    for ( int i = 0; i < s->export_loss_count; ++i )
        rf_print( "  %s\n", s->export_losses[i] );
    rf_print( "triangles  %u", s->triangles );
    if ( s->stored_triangles < s->triangles )
        rf_print( " (%u in memory: instances share them)", s->stored_triangles );
    rf_print( "\n" );
    rf_print( "instances  %u\n", s->instances );
    rf_print( "materials  %u\n", s->materials );
    rf_print( "lights     %u", s->lights );
    if ( s->lights > 0 )
        rf_print( " (emissive triangles %u, %.4g m2; punctual lights %d; sky %s)", s->emitting_triangles, s->emitting_area,
                  s->punctual_lights, s->has_sky ? "yes" : "no" );
    rf_print( "\n" );
    if ( s->triangles > 0 )
        rf_print( "bounds     %.4g %.4g %.4g to %.4g %.4g %.4g\n", s->bounds_min.x, s->bounds_min.y, s->bounds_min.z,
                  s->bounds_max.x, s->bounds_max.y, s->bounds_max.z );
    print_light_groups( scene, s );
    print_film( s );
    print_list( "variants", "", s->variants, s->variant_count, INT_MAX );
    print_list( s->frozen ? "frozen" : "moving", s->moving_count == 1 ? " object" : " objects", s->moving, s->moving_count,
                MAX_MOVING );
    print_changes( facts );
    print_unrendered( s );
    print_depth( facts );
    print_cameras( facts );
    print_effects( scene, &facts->render.settings );
    print_list( "warnings", " from the export", s->export_warnings, s->export_warning_count, INT_MAX );
}

static json_t* info_json( const RfScene* scene, const Facts* facts )
{
    const RfSceneInfo* s = &facts->scene;
    json_t* cameras = json_array();
    for ( int i = 0; i < s->cameras; ++i )
    {
        const RfCameraInfo* c = facts->cameras + i;
        json_t* camera = json_pack( "{s:o, s:i, s:i, s:i, s:i, s:b}", "name", rf_json_text( c->name ), "frames", c->frames,
                                    "first", c->first, "step", c->step, "shots", c->shots, "animated", c->animated );
        if ( strcmp( c->projection, "perspective" ) != 0 )
            json_object_set_new( camera, "projection", json_string( c->projection ) );
        json_array_append_new( cameras, camera );
    }
    json_t* unrendered = json_array();
    for ( int i = 0; i < s->unrendered_count; ++i )
        json_array_append_new( unrendered, json_pack( "{s:o, s:o}", "what", rf_json_text( s->unrendered[i].what ), "why",
                                                      rf_json_text( s->unrendered[i].why ) ) );
    json_t* size = s->width > 0 ? json_pack( "[i, i]", s->width, s->height ) : json_null();
    json_t* json = json_pack(
        "{s:I, s:I, s:I, s:I, s:I, s:o, s:o, s:b, s:o, s:o, s:f, s:o}", "triangles", (json_int_t)s->triangles, "stored_triangles",
        (json_int_t)s->stored_triangles, "instances", (json_int_t)s->instances, "materials", (json_int_t)s->materials, "lights",
        (json_int_t)s->lights, "cameras", cameras, "effects", rf_effects_json( scene, &facts->render.settings ), "frozen",
        s->frozen, "unrendered", unrendered, "size", size, "fps", (double)s_fps.numerator / (double)s_fps.denominator,
        "export_warnings", rf_json_texts( s->export_warnings, s->export_warning_count ) );
    rf_json_add( json, "{s:b, s:o, s:o, s:o, s:o, s:o}", "alpha", s->alpha, "losses", rf_json_texts( s->losses, s->loss_count ),
                 "export_losses", rf_json_texts( s->export_losses, s->export_loss_count ), "variants",
                 rf_json_texts( s->variants, s->variant_count ), "light_groups", light_groups_json( scene, s ),
                 "beyond_depth_share", rf_json_number( facts->beyond_depth ) );
    json_object_update( json, facts->changes );
    return json;
}

// The command line goes before the scene file.
static void take_given( RfRenderOptions* options )
{
    if ( s_render.no_effect != NULL )
        options->no_effect = s_render.no_effect;
    if ( s_effects_given )
        options->effects = s_render.effects;
    if ( s_render.movement.animation != NULL )
        options->movement.animation = s_render.movement.animation;
    if ( s_render.movement.variant != NULL )
        options->movement.variant = s_render.movement.variant;
    if ( s_group_given )
        options->settings.group = s_render.settings.group;
    options->movement.accept_losses = s_render.movement.accept_losses;
    options->movement.freeze = options->movement.freeze || s_render.movement.freeze;
}

static RfResult load( const char* name, RfSceneFile* file, RfScene* scene, RfRenderOptions* options, RfError* error )
{
    RfLog log = rf_stderr_log( "info" );
    RF_TRY( rf_open_scene_file( name, file, error ) );
    RfField defaults = rf_scene_file_defaults( file, error );
    RfResult result = rf_read_render_defaults( &defaults, options );
    rf_settle_filter( options );
    take_given( options );
    if ( !s_fps_given )
        s_fps = options->fps;
    if ( result == RF_OK )
        result = rf_load_scene_file( file, &options->movement, scene, &log, error );
    if ( result == RF_OK )
        result = rf_check_file_light_groups( options, file, scene, error );
    if ( result == RF_OK )
        rf_warn_of_equal_ids( scene, RF_CRYPTOMATTE_OBJECT | RF_CRYPTOMATTE_MATERIAL | RF_CRYPTOMATTE_ASSET, &log );
    rf_take_scene_depth( options, scene );
    return result == RF_OK ? rf_take_effect_options( options, scene, &log, error ) : result;
}

static RfResult report_result( void* user, RfError* error )
{
    const char* const name = *(const char* const*)user;
    RfScene scene = { 0 };
    Facts facts = { 0 };
    RfResult result = load( name, &facts.file, &scene, &facts.render, error );
    if ( result == RF_OK )
        result = gather( &scene, &facts, error );
    if ( result == RF_OK && rf_prints_text( s_json ) )
    {
        print_info( &scene, &facts );
        result = rf_flush_output( error );
    }
    if ( result == RF_OK && s_json != NULL )
        result = rf_write_json( s_json, info_json( &scene, &facts ), error );
    free( facts.cameras );
    json_decref( facts.changes );
    rf_destroy_scene( &scene );
    rf_close_scene_file( &facts.file );
    return result;
}

int rf_command_info( int argc, char** argv )
{
    const char* files[1];
    s_fps = ( RfFps ){ 0, 0 };
    s_fps_given = s_effects_given = s_group_given = false;
    s_render = rf_default_render_options();
    return rf_run_command( &s_table, argc, argv, files, report_result, files );
}
