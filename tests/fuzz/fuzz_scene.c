// JSON scene files: environment, materials, camera, and the defaults of `render`, over a glTF that is whole.
#include "fuzz/fuzz.h"

#include "cli/options/render_options.h"
#include "reframe/camera.h"
#include "scene/json/scene_file.h"

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

int LLVMFuzzerTestOneInput( const uint8_t* data, size_t size )
{
    static bool has_room;
    if ( !has_room )
        fuzz_file( "room.gltf", fuzz_room, strlen( fuzz_room ) );
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
        sample_camera( &scene );
    rf_destroy_scene( &scene );
    rf_close_scene_file( &file );
    return 0;
}
