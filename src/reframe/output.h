// A finished frame as an EXR file: R, G, B, the AOVs, the camera's matrices, and
// attributes that say how it was made ("reframe/spp", "reframe/seed" and so on). One of them is
// the fingerprint of the frame, by which an interrupted render is resumed. RfRenderSettings.files has their
// format; the program's is rf_default_frame_files().
//
//     static RfResult write( void* output, const RfFrameResult* frame, RfError* error )
//     {
//         return rf_write_frame( (const RfOutput*)output, frame, error );
//     }
//
//     RfOutput output = rf_default_output();
//     output.pattern = "out/frame.####.exr";
//     output.tracer = tracer;
//     output.path = &path;
//     output.settings = settings; // as rf_resolve_settings made them
//     RfRenderCallbacks callbacks = { .user = &output, .frame = write };
#ifndef REFRAME_OUTPUT_H
#define REFRAME_OUTPUT_H

#include "reframe/camera.h"
#include "reframe/error.h"
#include "reframe/render.h"
#include "reframe/scene.h"
#include "reframe/types.h"

RF_API_BEGIN

// What is rendered and where it goes; everything that it points to stays the caller's.
typedef struct RfOutput
{
    const char* pattern; // file names: "out/frame.####.exr", or one file
    const RfTracer* tracer;
    const RfCameraPath* path;
    RfRenderSettings settings; // resolved, the same as for rf_render; `files` has the format of the files
    const char* calls_for;     // for the header of the files, by rf_name_effects; NULL: not reported
    double beyond_depth;       // likewise, rf_find_light_beyond_depth; 0: not reported
} RfOutput;

// No names, the settings of rf_default_render_settings.
RfOutput rf_default_output( void );

// Makes the folder of the pattern's files where it is missing (its last part only: a mistyped
// path should not leave a tree behind) and checks that files can be made in it. Fails with
// RF_ERROR_IO, or RF_ERROR_USAGE for a pattern that is none.
RfResult rf_prepare_output_folder( const char* pattern, RfError* error );

// Whether a path has a time code that starts with files.time_code. NULL is right at all rates; where these have no time code,
// files have none. Fails with RF_ERROR_USAGE for what is none, or none at the path's frames per second.
RfResult rf_check_time_code( const RfOutput* output, RfError* error );

// Removes temporary files from the folder of the pattern's files that renders which were killed have left
// there; those that another process is writing stay.
void rf_clean_output_folder( const char* pattern );

// Writes a finished frame, for RfRenderCallbacks.frame: it may be called from the thread of the queue.
// Fails as rf_write_exr and rf_check_time_code do, and with RF_ERROR_USAGE where settings.files was not set.
RfResult rf_write_frame( const RfOutput* output, const RfFrameResult* frame, RfError* error );

// A frame that has been denoised: the picture, passes that split its light, and light groups; the picture before is the layer "noisy".
typedef struct RfDenoisedFrame
{
    RfFrameResult frame;
    RfDenoised denoised;
    RfLayer* layers;
    float* pixels;
} RfDenoisedFrame;

// Denoises a frame for rf_write_frame (rf_denoise): with RF_DENOISE_AOVS where the frame has them, and with RF_AOV_HALF, without
// which the error is not known. `sums` may be NULL. Free it with rf_free_denoised_frame in any case.
RfResult rf_denoise_frame( RfDenoiser* denoiser, const RfFrameResult* frame, RfDenoisedSums* sums, RfDenoisedFrame* denoised,
                           RfError* error );
void rf_free_denoised_frame( RfDenoisedFrame* frame );

#define RF_FINGERPRINT_SIZE 17

// What decides the colour and the AOVs of frame `frame` (from 0), as 16 hexadecimal digits: scene,
// camera path, settings, version of the library, names of the channels, time code and colour space of the files; not threads,
// memory, or how files are stored.
void rf_frame_fingerprint( const RfOutput* output, int frame, char text[RF_FINGERPRINT_SIZE] );

typedef enum RfFrameFileState
{
    RF_FRAME_FILE_MISSING,
    RF_FRAME_FILE_SAME,       // the very frame, all of its pixels whole: it need not be rendered again
    RF_FRAME_FILE_OTHER,      // a frame of another scene, path, version or settings, or another format of file
    RF_FRAME_FILE_DAMAGED,    // the very frame, but its pixels are cut off or changed; `error` says where
    RF_FRAME_FILE_UNREADABLE, // no frame of a render; `error` says what is wrong with it
} RfFrameFileState;

// Looks at the file that frame `frame` (from 0) is written to, and reads all of it. Fails with RF_ERROR_USAGE for a
// pattern that is none, with RF_ERROR_IO for a name that cannot be looked at or is a folder.
RfResult rf_check_frame_file( const RfOutput* output, int frame, RfFrameFileState* state, RfError* error );

RF_API_END

#endif
