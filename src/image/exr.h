// EXR by OpenEXRCore. Writing is atomic (temporary name in the same folder,
// fsync, rename, fsync of the folder): a file with its final name is whole.
#ifndef REFRAME_IMAGE_EXR_H
#define REFRAME_IMAGE_EXR_H

#include "image/image.h"

typedef enum RfExrCompression
{
    RF_EXR_NONE,
    RF_EXR_ZIP,
    RF_EXR_PIZ,
} RfExrCompression;

// A string attribute, such as { "reframe/group", "3" }.
typedef struct RfExrString
{
    const char* name;
    const char* value;
} RfExrString;

// A channel besides R G B, such as { "depth.Z", values, 1, false }.
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
    bool half;         // R G B as half floats, clamped to ±65504; else 32-bit floats
    int x, y;          // where the first pixel lies: data and display window begin there
    int fps_numerator; // framesPerSecond; numerator 0: not written
    unsigned int fps_denominator;
    bool has_camera;           // write the two matrices, row vectors as OpenEXR has them:
    float world_to_camera[16]; // p_camera = p_world · M, 16 floats row by row
    float world_to_ndc[16];
    const RfExrString* strings;
    int string_count;
    const RfExrChannel* channels; // further ones, in any order; their names differ
    int channel_count;
} RfExrOptions;

// zip, half floats, nothing else.
RfExrOptions rf_default_exr_options( void );

// Writes channels R G B and the options' own. On failure no file of that name is made or changed,
// and no temporary file is left.
RfResult rf_write_exr( const char* path, const RfImage* image, const RfExrOptions* options, RfError* error );

// Bytes that rf_write_exr holds at most besides the channels and about 2 MiB of
// tables, for channels of `pixel_bytes` together (2 for each half one, 4 for each
// other): the lines of one chunk, some times over.
size_t rf_exr_work_bytes( int width, int height, RfExrCompression compression, int pixel_bytes );

// Reads R, G, B (or Y, spread over the three) of the first part of any
// scan-line or tiled, half, float or uint EXR, the data window only. Channel
// names are matched by name; a file with a single layer prefix, such as
// Blender's "ViewLayer.Combined.R", is read through that prefix.
RfResult rf_read_exr( const char* path, RfImage* image, RfError* error );

// Where the pixels of a file lie: its data window.
typedef struct RfExrWindow
{
    int x, y, width, height;
} RfExrWindow;

// Reads three channels, or one as grey, of the first part that has them, and where
// they lie. `layer` is a layer ("ViewLayer.DiffDir": its R, G, B or X, Y, Z), the
// name of a part, a channel ("depth.Z") or three with commas between them; NULL:
// the colour, as rf_read_exr finds it, but in the first part that has any, and one with
// three channels before one with Y.
RfResult rf_read_exr_layer( const char* path, const char* layer, RfImage* image, RfExrWindow* window, RfError* error );

// Calls `take` with each string attribute of the first part, in the file's order.
typedef void RfExrStringFn( void* user, const char* name, const char* value );
RfResult rf_list_exr_strings( const char* path, RfExrStringFn* take, void* user, RfError* error );

// Reads channels by their full names ("depth.Z", as rf_find_exr_name has them) of any
// part, which must all be there, not be subsampled and have one data window: `count`
// floats per pixel, in the order of the names, which differ, rows from top to bottom.
// The caller frees *values.
RfResult rf_read_exr_channels( const char* path, const char* const* names, int count, RfExrWindow* window, float** values,
                               RfError* error );

// A channel of a file.
typedef struct RfExrName
{
    char* text;      // where the file has several parts behind its part's name: "beauty.depth.Z"
    const char* own; // as in its part: "depth.Z"
    int part;
    RfExrWindow window; // of the part's data
} RfExrName;

// What a file says of itself: the windows, the channels, the camera.
typedef struct RfExrHeader
{
    int part;                 // with the colour; where there is none, the first that can be read
    int x, y, width, height;  // its data window: the first pixel, the size
    int display_x, display_y; // display window
    int display_width, display_height;
    int fps_numerator; // framesPerSecond; 0: the file does not say
    unsigned int fps_denominator;
    bool has_world_to_ndc;
    float world_to_ndc[16]; // as in RfExrOptions
    int channel_count;
    RfExrName* channels; // of all parts that can be read
} RfExrHeader;

// Reads what is said of the part with the colour, or with `layer`, which may be missing
// (as for rf_read_exr_layer), and all channels' names; rf_destroy_exr_header frees it.
RfResult rf_read_exr_header( const char* path, const char* layer, RfExrHeader* header, RfError* error );
void rf_destroy_exr_header( RfExrHeader* header );

// The channel whose text or, failing that, whose own name is the first `length`
// characters of `name`, one of the colour's part before others; NULL: none.
const RfExrName* rf_find_exr_name( const RfExrHeader* header, const char* name, size_t length );

// Reads one string attribute into `value` (size bytes, truncated). Fails with
// RF_ERROR_IO or RF_ERROR_FORMAT where the file cannot be read or has none.
RfResult rf_read_exr_string( const char* path, const char* name, char* value, size_t size, RfError* error );

// A string attribute that is a number; NaN where there is none.
double rf_read_exr_number( const char* path, const char* name );

#endif
