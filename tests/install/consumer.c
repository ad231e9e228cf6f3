// Renders the first frame of a scene's first camera: consumer SCENE.glb OUT.exr
#include "image/exr.h"
#include "reframe/render.h"
#include "scene/camera.h"
#include "scene/gltf/gltf.h"

#include <stdio.h>

static RfResult write_frame( void* path, const RfFrameResult* frame, RfError* error )
{
    RfImage image = { frame->width, frame->height, (float*)frame->rgb };
    RfExrOptions options = rf_default_exr_options();
    return rf_write_exr( path, &image, &options, error );
}

int main( int argc, char** argv )
{
    RfScene scene = { 0 };
    RfTracer* tracer = NULL;
    RfEye eye;
    RfError error = { RF_OK, "usage: consumer SCENE.glb OUT.exr" };
    RfRenderSettings settings = rf_default_render_settings();
    RfRenderCallbacks callbacks = { argc > 2 ? argv[2] : NULL, write_frame, NULL };
    int failed = argc < 3 || rf_load_gltf( argv[1], &scene, NULL, &error ) != RF_OK ||
                 rf_scene_eye( &scene, 0, 0.0, 32, 18, &eye, &error ) != RF_OK ||
                 rf_create_tracer( &scene, &tracer, &error ) != RF_OK ||
                 rf_render( tracer, &eye, 1, &( int ){ 0 }, 1, &settings, &callbacks, NULL, &error ) != RF_OK;
    if ( failed )
        fprintf( stderr, "%s\n", error.text );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
    return failed;
}
