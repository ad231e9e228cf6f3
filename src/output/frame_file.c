// A finished frame as an EXR file.
#include "reframe/output.h"

#include "output/frame_aovs.h"
#include "output/frame_attributes.h"
#include "scene/eye.h"
#include "scene/scene.h"

#define MAX_NAME 4096

RfFrameFiles rf_default_frame_files( void )
{
    return ( RfFrameFiles ){ .written = true, .half = true, .compression = RF_EXR_ZIP };
}

RfOutput rf_default_output( void ) { return ( RfOutput ){ .settings = rf_default_render_settings() }; }

// Frames of one run were rendered as one: there is no motion between them.
static bool has_same_eye( const RfCameraPath* path, int frame, int other )
{
    return path->run_of_frame != NULL && other >= 0 && other < path->count &&
           path->run_of_frame[frame] == path->run_of_frame[other];
}

RfResult rf_write_frame( const RfOutput* output, const RfFrameResult* frame, RfError* error )
{
    char name[MAX_NAME];
    if ( !output->settings.files.written )
        return rf_fail( error, RF_ERROR_USAGE, "settings.files is not set: start from rf_default_frame_files" );
    RfResult result =
        rf_sequence_name( output->pattern, rf_frame_number( output->path, frame->frame ), name, sizeof name, error );
    if ( result != RF_OK )
        return result;
    RfAttributes attributes;
    RfAovChannels aovs;
    rf_list_attributes( output, frame, &attributes );
    const bool still[2] = { has_same_eye( output->path, frame->frame, frame->frame - 1 ),
                            has_same_eye( output->path, frame->frame, frame->frame + 1 ) };
    rf_list_aov_channels( frame, output->settings.files.half, still, &aovs );
    RfExrOptions exr = rf_default_exr_options();
    exr.compression = output->settings.files.compression;
    exr.half = output->settings.files.half;
    exr.fps_numerator = output->path->fps.numerator;
    exr.fps_denominator = (unsigned int)output->path->fps.denominator;
    exr.has_camera = true;
    const RfEye* eye = output->path->eyes + frame->frame;
    exr.pixel_aspect = eye->focal / eye->focal_x;
    rf_eye_matrices_around( eye, output->path->origin, exr.world_to_camera, exr.world_to_ndc );
    exr.strings = attributes.strings;
    exr.string_count = attributes.count;
    exr.channels = aovs.channels;
    exr.channel_count = aovs.count;
    // The writer only reads the pixels; RfImage has no const flavour.
    RfImage image = { .width = frame->width, .height = frame->height, .rgb = (float*)frame->rgb };
    return rf_write_exr( name, &image, &exr, error );
}
