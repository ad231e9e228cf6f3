// glTF as .glb and as .gltf, the scene's path by its cameras, and the tracer's view of it.
#include "fuzz/fuzz.h"
#include "gltf/gltf.h"
#include "scene/movement.h"
#include "scene/pose.h"

#include "reframe/camera.h"

static void sample_cameras( const RfScene* scene )
{
    RfError error = { 0 };
    RfSceneInfo info;
    fuzz_check( rf_scene_info( scene, &info, &error ), &error );
    for ( int i = 0; i < info.cameras && i < 4; ++i )
    {
        RfCameraInfo camera;
        RfFps fps = { 2, 1 };
        RfCameraPath path;
        RfResult result = rf_scene_camera( scene, i, fps, &camera, &error );
        fuzz_check( result, &error );
        if ( result != RF_OK || camera.frames > 10000 ) // long paths are slow, not wrong
            continue;
        RfPathOptions options = { .camera = camera.name, .fps = fps, .width = 32, .height = 18 };
        result = rf_create_camera_path( scene, &options, &path, &error );
        fuzz_check( result, &error );
        rf_destroy_camera_path( &path );
    }
}

// What moves, at its first and last moment and between them.
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

static void freeze( const char* path )
{
    RfError error = { 0 };
    RfScene scene;
    RfGltfOptions options = { .freeze = true };
    fuzz_check( rf_load_gltf_with( path, &options, &scene, NULL, &error ), &error );
    rf_destroy_scene( &scene );
}

int LLVMFuzzerTestOneInput( const uint8_t* data, size_t size )
{
    RfError error = { 0 };
    RfScene scene;
    RfLog log = { 0 };
    const char* path = fuzz_file( "input.glb", data, size );
    RfResult result = rf_load_gltf( path, &scene, &log, &error );
    fuzz_check( result, &error );
    if ( result == RF_OK )
    {
        sample_cameras( &scene );
        pose_movement( &scene );
    }
    rf_destroy_scene( &scene );
    freeze( path );
    return 0;
}
