// The files of a render: their names, what is there already, what is written
// into them.
#ifndef REFRAME_CLI_RENDER_RENDER_OUTPUT_H
#define REFRAME_CLI_RENDER_RENDER_OUTPUT_H

#include "cli/options/camera_options.h"
#include "cli/options/render_options.h"
#include "trace/trace.h"

// What a render is of; everything here is the caller's.
typedef struct RfRenderSubject
{
    const RfRenderOptions* options;
    const RfScene* scene;
    const RfCameraPath* path;
} RfRenderSubject;

// Checks, before anything is rendered, that the pattern fits `count` frames
// (indices from 0), that the folder is there (its last part is made where it is
// missing) and can be written, and that no frame is in the way: an error
// without --resume or --overwrite. With --resume moves the frames that are there
// and of this very render from the list to `kept`, which has room for them all;
// one that is not of it is an error, or stays in the list with --overwrite.
RfResult rf_prepare_output( const RfRenderSubject* subject, int* frames, int* count, int* kept, RfError* error );

// What decides the picture and the layers of one frame, as 16 hexadecimal digits: scene,
// camera path, settings, program version; not threads, memory or file format.
void rf_frame_fingerprint( const RfRenderSubject* subject, int frame, char text[17] );

// Writes a finished frame. `device` is rf_tracer_device's.
RfResult rf_write_frame( const RfRenderSubject* subject, const RfFrameResult* result, const char* device, RfError* error );

// OpenEXR's matrices of an eye, row vectors (p' = p · M), 16 floats row by row.
// Camera space: metres, the eye at the origin, +x right, +y up, looking along
// −z. NDC: after the division by w the film is x and y in [−1, 1], +y up; z is
// −1 at 1 cm before the eye and 1 infinitely far away.
void rf_eye_matrices( const RfEye* eye, float world_to_camera[16], float world_to_ndc[16] );

#endif
