// reframe info: what is in a scene, and which effects it calls for.
#include "cli/options/camera_options.h"
#include "cli/commands.h"
#include "cli/render/render_json.h"
#include "cli/options/render_options.h"
#include "cli/messages.h"
#include "light/light.h"
#include "scene/camera.h"
#include "scene/effects.h"
#include "scene/json/scene_file.h"

#include <stdlib.h>
#include <string.h>

static RfFps s_fps;
static bool s_fps_given;
static const char* s_json;
static const char* const s_files[] = { "SCENE" };
static bool s_quiet;

static const RfOption s_options[] = {
    { .name = "fps",
      .type = RF_OPTION_FPS,
      .value = &s_fps,
      .given = &s_fps_given,
      .meta = "R",
      .default_text = "the scene file's, else 24",
      .help = "frames per second, to count the cameras' frames" },
    { .name = "json",
      .writes = ".json",
      .type = RF_OPTION_STRING,
      .value = &s_json,
      .meta = "FILE",
      .help = "the result for programs; - is standard output" },
    { .name = "quiet", .type = RF_OPTION_BOOL, .value = &s_quiet, .help = "as of all commands; there is no progress to silence" },
};
static const RfCommandTable s_table = {
    .command = "info",
    .summary = "Tells what is in a scene (.glb, .gltf or scene file, .json) and which effects it calls for.",
    .files = s_files,
    .file_count = 1,
    .options = s_options,
    .option_count = sizeof s_options / sizeof s_options[0]
};

// What the scene struct does not say by itself.
typedef struct Facts
{
    uint32_t lights; // of all kinds: a sky is one
    uint32_t emitting_triangles;
    double light_area;
    bool sky;
    int* frames; // by camera
} Facts;

static RfResult gather( const RfScene* scene, Facts* facts, RfError* error )
{
    *facts = ( Facts ){ .frames = calloc( (size_t)scene->camera_count + 1, sizeof *facts->frames ) };
    if ( facts->frames == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for its cameras", scene->path );
    RfResult result = RF_OK;
    for ( int i = 0; i < scene->camera_count && result == RF_OK; ++i )
        result = rf_scene_frame_count( scene, scene->cameras + i, rf_fps_value( s_fps ), facts->frames + i, error );
    RfLights lights = { 0 };
    if ( result == RF_OK )
        result = rf_collect_lights( scene, &lights, error );
    if ( result != RF_OK )
        return result;
    facts->lights = lights.count;
    facts->emitting_triangles = lights.triangle_count;
    facts->sky = rf_has_sky( &lights );
    for ( uint32_t i = 0; i < lights.triangle_count; ++i )
        facts->light_area += lights.light[i].area;
    rf_destroy_lights( &lights );
    return RF_OK;
}

static void print_cameras( const RfScene* scene, const Facts* facts )
{
    printf( "cameras    %d\n", scene->camera_count );
    for ( int i = 0; i < scene->camera_count; ++i )
        printf( "  %s: %d frame%s at %g frames/s, %s\n", scene->cameras[i].name, facts->frames[i],
                facts->frames[i] == 1 ? "" : "s", rf_fps_value( s_fps ),
                scene->cameras[i].animated ? "animated" : "stands still" );
}

static void print_effects( const RfScene* scene )
{
    RfEffect effects[RF_MAX_EFFECTS];
    int count = rf_list_effects( scene, effects );
    printf( "effects\n" );
    for ( int i = 0; i < count; ++i )
        printf( "  %-3s  %-22s%s\n", effects[i].on ? "on" : "off", effects[i].name, effects[i].why );
}

static void print_info( const RfScene* scene, const Facts* facts )
{
    printf( "%s\n", scene->path );
    printf( "triangles  %u\n", scene->triangles.count );
    printf( "instances  %u\n", scene->instance_count );
    printf( "materials  %u\n", scene->material_count );
    printf( "lights     %u", facts->lights );
    if ( facts->lights > 0 )
        printf( " (emitting triangles %u, %.4g m2; lamps without size %d; sky %s)", facts->emitting_triangles, facts->light_area,
                scene->punctual_count, facts->sky ? "yes" : "no" );
    printf( "\n" );
    if ( scene->triangles.count > 0 )
        printf( "bounds     %.4g %.4g %.4g to %.4g %.4g %.4g\n", scene->bounds_min.x, scene->bounds_min.y, scene->bounds_min.z,
                scene->bounds_max.x, scene->bounds_max.y, scene->bounds_max.z );
    print_cameras( scene, facts );
    print_effects( scene );
}

static json_t* info_json( const RfScene* scene, const Facts* facts )
{
    json_t* cameras = json_array();
    for ( int i = 0; i < scene->camera_count; ++i )
        json_array_append_new( cameras, json_pack( "{s:o, s:i, s:b}", "name", rf_json_text( scene->cameras[i].name ), "frames",
                                                   facts->frames[i], "animated", scene->cameras[i].animated ) );
    return json_pack( "{s:I, s:I, s:I, s:I, s:o, s:o}", "triangles", (json_int_t)scene->triangles.count, "instances",
                      (json_int_t)scene->instance_count, "materials", (json_int_t)scene->material_count, "lights",
                      (json_int_t)facts->lights, "cameras", cameras, "effects", rf_effects_json( scene ) );
}

static RfResult load( const char* name, RfScene* scene, RfError* error )
{
    RfSceneFile file;
    RfLog log = rf_stderr_log( "info" );
    RfResult result = rf_open_scene_file( name, &file, error );
    if ( result != RF_OK )
        return result;
    RfRenderOptions options;
    RfField defaults = rf_scene_file_defaults( &file, error );
    result = rf_read_render_defaults( &defaults, &options );
    if ( !s_fps_given )
        s_fps = options.fps;
    if ( result == RF_OK )
        result = rf_load_scene_file( &file, scene, &log, error );
    rf_close_scene_file( &file );
    return result;
}

static RfResult tell( const char* name, RfError* error )
{
    RfScene scene = { 0 };
    Facts facts = { 0 };
    RfResult result = load( name, &scene, error );
    if ( result == RF_OK )
        result = gather( &scene, &facts, error );
    if ( result == RF_OK && ( s_json == NULL || strcmp( s_json, "-" ) != 0 ) )
    {
        print_info( &scene, &facts );
        result = rf_flush_output( error );
    }
    if ( result == RF_OK && s_json != NULL )
        result = rf_write_json( s_json, info_json( &scene, &facts ), error );
    free( facts.frames );
    rf_destroy_scene( &scene );
    return result;
}

int rf_command_info( int argc, char** argv )
{
    const char* files[1];
    bool help;
    RfError error;
    s_fps = RF_DEFAULT_FPS;
    s_fps_given = false;
    RfResult result = rf_parse_options( &s_table, argc, argv, files, &help, &error );
    if ( result == RF_OK && help )
    {
        rf_print_help( &s_table, stdout );
        result = rf_flush_output( &error );
    }
    else if ( result == RF_OK )
        result = tell( files[0], &error );
    return result == RF_OK ? 0 : rf_report_error( "info", &error );
}
