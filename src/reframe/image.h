// Images: OpenEXR files, PNG files to look at, and the names of image sequences.
//
//     RfImage image;
//     if ( rf_read_exr( "frame.0001.exr", &image, &error ) == RF_OK )
//         result = rf_write_png( "frame.0001.png", &image, 0.0f, &error );
//     rf_destroy_image( &image );
//
// Writing is atomic: bytes go to a temporary name in the same folder, which is renamed once all
// of them are on the disk. A file with its final name is whole.
#ifndef REFRAME_IMAGE_H
#define REFRAME_IMAGE_H

#include "reframe/error.h"
#include "reframe/types.h"

RF_API_BEGIN

// An RGB image of floats, linear Rec. 709, rows from top to bottom, pixels interleaved: channel c
// at (x, y) is rgb[3 (y·width + x) + c].
typedef struct RfImage
{
    int width, height;
    float* rgb;
} RfImage;

// Allocates a black image. Fails with RF_ERROR_MEMORY.
RfResult rf_create_image( int width, int height, RfImage* image, RfError* error );

// Frees the pixels and empties the struct.
void rf_destroy_image( RfImage* image );

typedef enum RfExrCompression
{
    RF_EXR_NONE,
    RF_EXR_ZIP,
    RF_EXR_PIZ,
} RfExrCompression;

// A string attribute, such as { "owner", "me" }.
typedef struct RfExrString
{
    const char* name;
    const char* value;
} RfExrString;

// A channel besides R, G and B, such as { "depth.Z", values, 1, false }.
typedef struct RfExrChannel
{
    const char* name;
    const float* values; // of pixel (x, y): values[stride (y·width + x)]
    int stride;
    bool half; // 16 bits, clamped to ±65504; else 32
} RfExrChannel;

#define RF_EXR_MAX_CHANNELS 64 // R, G and B included

typedef struct RfExrOptions
{
    RfExrCompression compression;
    bool half;         // R, G, B as 16-bit floats, clamped to ±65504; else 32-bit floats
    int x, y;          // where the first pixel lies: data and display window begin there
    int fps_numerator; // framesPerSecond; numerator 0: not written
    unsigned int fps_denominator;
    bool has_camera;           // write the two matrices (rf_eye_matrices)
    float world_to_camera[16]; // row vectors: p_camera = p_world · M, row by row
    float world_to_ndc[16];
    const RfExrString* strings; // string_count of them
    int string_count;
    const RfExrChannel* channels; // further ones, in any order; their names differ
    int channel_count;
} RfExrOptions;

// ZIP, 16-bit floats, nothing else.
RfExrOptions rf_default_exr_options( void );

// Writes channels R, G, B and the options' own. On failure no file of that name is made or
// changed, and no temporary file is left: RF_ERROR_IO, RF_ERROR_MEMORY, RF_ERROR_USAGE.
RfResult rf_write_exr( const char* path, const RfImage* image, const RfExrOptions* options, RfError* error );

// Where the pixels of a file lie: its data window.
typedef struct RfExrWindow
{
    int x, y, width, height;
} RfExrWindow;

// Reads R, G, B (or Y, spread over the three) of the first part of any scan-line or tiled EXR,
// the data window only. A file with a single layer prefix, such as Blender's "ViewLayer.Combined.R",
// is read through that prefix. On failure the image is empty. Free with rf_destroy_image.
RfResult rf_read_exr( const char* path, RfImage* image, RfError* error );

// Reads three channels, or one as grey, of the first part that has them, and where they lie.
// `layer` is a layer ("ViewLayer.DiffDir": its R, G, B or X, Y, Z), the name of a part, a channel
// ("depth.Z") or three with commas between them; NULL: the colour, as rf_read_exr finds it, but in
// the first part that has any, and one with three channels before one with Y.
RfResult rf_read_exr_layer( const char* path, const char* layer, RfImage* image, RfExrWindow* window, RfError* error );

// Reads channels by their full names ("depth.Z") of any part, which must all be there, not be
// subsampled and have one data window: `count` floats per pixel, in the order of the names, which
// differ; rows from top to bottom. The caller frees *values.
RfResult rf_read_exr_channels( const char* path, const char* const* names, int count, RfExrWindow* window, float** values,
                               RfError* error );

// Reads a string attribute into `value` (size bytes, truncated). Fails with RF_ERROR_IO or
// RF_ERROR_FORMAT where the file cannot be read or has none of that name.
RfResult rf_read_exr_string( const char* path, const char* name, char* value, size_t size, RfError* error );

// A string attribute that is a number; NaN where there is none.
double rf_read_exr_number( const char* path, const char* name );

// Calls `take` with each string attribute of the first part, in the file's order.
typedef void RfExrStringFn( void* user, const char* name, const char* value );
RfResult rf_list_exr_strings( const char* path, RfExrStringFn* take, void* user, RfError* error );

// Writes an 8-bit PNG: multiplies by 2^exposure_stops, clips at 1, applies the sRGB curve. NaN is
// written magenta, so that it shows.
RfResult rf_write_png( const char* path, const RfImage* image, float exposure_stops, RfError* error );

// Sequences: in a pattern such as "out/frame.####.exr" the run of '#' stands for the frame's
// number, from 1, padded with zeros to as many digits (more where the number needs them).

// Has a run of '#' in its last path component. More than one run, or one in a folder's name, is an
// error that rf_sequence_name reports.
bool rf_is_sequence( const char* pattern );

// The file name of frame `number` (from 1) in `name` (size bytes). A pattern without '#' is copied
// as it is. Fails with RF_ERROR_USAGE.
RfResult rf_sequence_name( const char* pattern, int number, char* name, size_t size, RfError* error );

// The numbers for which a file exists, ascending, in *numbers (the caller frees them), *count of
// them. Fails with RF_ERROR_IO where there are none.
RfResult rf_sequence_frames( const char* pattern, int** numbers, int* count, RfError* error );

RF_API_END

#endif
