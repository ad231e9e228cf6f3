// Reframe: renders camera animations and reuses paths between frames and pixels.
// This header includes all others; each can also be included by itself.
//
//     #include <reframe/reframe.h>
//
//     static RfResult write( void* output, const RfFrameResult* frame, RfError* error )
//     {
//         return rf_write_frame( (const RfOutput*)output, frame, error );
//     }
//
//     RfError error;
//     RfScene* scene = NULL;
//     RfTracer* tracer = NULL;
//     RfCameraPath path = rf_empty_camera_path();
//     RfPathOptions asked = { .fps = { 24, 1 }, .width = 960, .height = 540 };
//     RfOutput output = rf_default_output();
//     RfRenderSettings settings = rf_default_render_settings();
//     RfRenderCallbacks callbacks = { .user = &output, .frame = write };
//     int frames[3] = { 0, 1, 2 };
//     RfShot shot;
//
//     settings.files = rf_default_frame_files();
//     if ( rf_open_scene( "room.glb", &scene, NULL, &error ) != RF_OK ||
//          rf_create_camera_path( scene, &asked, &path, &error ) != RF_OK ||
//          rf_create_tracer( scene, &tracer, &error ) != RF_OK )
//         return print( error.text );
//     shot = ( RfShot ){ tracer, path.eyes, path.count, frames, 3 };
//     if ( rf_resolve_settings( &shot, &settings, &output.settings, &error ) != RF_OK )
//         return print( error.text );
//     output.pattern = "out/frame.####.exr";
//     output.tracer = tracer;
//     output.path = &path;
//     if ( rf_prepare_output_folder( output.pattern, &error ) != RF_OK ||
//          rf_render( &shot, &output.settings, &callbacks, NULL, &error ) != RF_OK )
//         return print( error.text );
//     rf_destroy_tracer( tracer );
//     rf_destroy_camera_path( &path );
//     rf_close_scene( scene );
//
// Rules that hold everywhere:
//   - A call that can fail returns RfResult and says what is wrong in an RfError, which may be NULL.
//   - Structs that hold settings come from rf_default_...(): set what differs.
//   - What rf_create_... and rf_open_... make is freed by rf_destroy_... and rf_close_..., which take
//     NULL and emptied structs. Other pointers that the caller must free() are documented as such.
//   - Frames are counted from 0 in the API and from 1 in file names and messages.
//   - Nothing is printed and nothing exits. Different scenes may be used from different threads;
//     one scene may be rendered by one thread at a time (which uses all cores by itself).
//   - Threads that wait do so as OpenMP has it: with GCC's libgomp they spin, unless the environment has
//     OMP_WAIT_POLICY=passive when the process starts. Set it where other work runs on the machine.
#ifndef REFRAME_REFRAME_H
#define REFRAME_REFRAME_H

#include "reframe/aov.h"
#include "reframe/camera.h"
#include "reframe/convert.h"
#include "reframe/denoise.h"
#include "reframe/effects.h"
#include "reframe/error.h"
#include "reframe/image.h"
#include "reframe/measure.h"
#include "reframe/output.h"
#include "reframe/plan.h"
#include "reframe/reconstruct.h"
#include "reframe/render.h"
#include "reframe/render_settings.h"
#include "reframe/scene.h"
#include "reframe/types.h"

#endif
