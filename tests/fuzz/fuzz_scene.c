// JSON scene files: environment, materials, films, objects, camera, and the defaults of `render`, over a glTF that is whole.
#include "fuzz/fuzz.h"

#include "cli/options/render_options.h"
#include "reframe/camera.h"
#include "scene/movement.h"
#include "scene/pose.h"
#include "scene_file/scene_file.h"

#include <string.h>

// As the command line does it.
static void read_defaults( const RfSceneFile* file )
{
    static char words[][16] = { "render", "scene.json", "-o", "f.####.exr" };
    char* argv[] = { words[0], words[1], words[2], words[3], NULL };
    RfRenderOptions options;
    bool help;
    RfError error = { 0 };
    fuzz_must( rf_parse_render_options( 4, argv, &options, &help, &error ) == RF_OK );
    RfField defaults = rf_scene_file_defaults( file, &error );
    if ( defaults.json != NULL )
        fuzz_check( rf_parse_render_options_over( &defaults, 4, argv, &options, &error ), &error );
}

static void sample_camera( const RfScene* scene )
{
    RfError error = { 0 };
    RfCameraPath path;
    RfPathOptions options = { .fps = { 2, 1 }, .width = 32, .height = 18 };
    RfResult result = rf_create_camera_path( scene, &options, &path, &error );
    fuzz_check( result, &error );
    rf_destroy_camera_path( &path );
}

// What moves and changes, at its first and last moment and between them.
static void pose_movement( const RfScene* scene )
{
    RfError error = { 0 };
    for ( int k = 0; scene->movement != NULL && k < 3; ++k )
    {
        RfPosedScene pose = { 0 };
        double start = scene->movement->start, end = scene->movement->end;
        fuzz_check( rf_pose_scene( scene, start + 0.5 * k * ( end - start ), &pose, &error ), &error );
        rf_destroy_pose( &pose );
    }
}

static void write_files( void )
{
    static const char s_pixel[] = "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n\x80\x40\x20\x81";
    fuzz_file( "room.gltf", fuzz_room, strlen( fuzz_room ) );
    fuzz_file( "film.00.hdr", s_pixel, sizeof s_pixel - 1 );
    fuzz_file( "film.01.hdr", s_pixel, sizeof s_pixel - 1 );
}

int LLVMFuzzerTestOneInput( const uint8_t* data, size_t size )
{
    static bool has_room;
    if ( !has_room )
        write_files();
    has_room = true;
    RfError error = { 0 };
    RfSceneFile file;
    RfScene scene;
    RfLog log = { 0 };
    RfResult result = rf_open_scene_file( fuzz_file( "input.json", data, size ), &file, &error );
    fuzz_check( result, &error );
    if ( result != RF_OK )
        return 0;
    read_defaults( &file );
    result = rf_load_scene_file( &file, &( RfSceneOptions ){ 0 }, &scene, &log, &error );
    fuzz_check( result, &error );
    if ( result == RF_OK )
    {
        sample_camera( &scene );
        pose_movement( &scene );
    }
    rf_destroy_scene( &scene );
    rf_close_scene_file( &file );
    return 0;
}
