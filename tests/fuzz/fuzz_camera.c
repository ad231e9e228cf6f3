// Camera-path files.
#include "fuzz/fuzz.h"

#include "reframe/camera.h"
#include "scene_file/scene_file.h"

#include <math.h>
#include <string.h>

static RfScene s_scene;

static void load_room( void )
{
    static bool is_loaded;
    RfError error = { 0 };
    if ( !is_loaded )
        fuzz_must( rf_load_scene( fuzz_file( "room.gltf", fuzz_room, strlen( fuzz_room ) ), &s_scene, NULL, &error ) == RF_OK );
    is_loaded = true;
}

int LLVMFuzzerTestOneInput( const uint8_t* data, size_t size )
{
    load_room();
    RfError error = { 0 };
    RfCameraPath path;
    RfPathOptions options = { .camera = fuzz_file( "input.json", data, size ), .fps = { 2, 1 }, .width = 32, .height = 18 };
    RfResult result = rf_create_camera_path( &s_scene, &options, &path, &error );
    fuzz_check( result, &error );
    for ( int i = 0; result == RF_OK && i < path.count; ++i ) // an eye that is accepted can be rendered
    {
        const RfEye* eye = path.eyes + i;
        fuzz_must( isfinite( eye->origin.x + eye->origin.y + eye->origin.z ) && isfinite( eye->forward.x + eye->up.y ) &&
                   eye->focal > 0.0f && isfinite( eye->focal ) );
    }
    rf_destroy_camera_path( &path );
    return 0;
}
