// OpenEXR files, read and written by OpenEXRCore. Writing is atomic (temporary
// file in the same folder, fsync, rename, fsync of the folder): a file under its
// final name is complete.
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

// A channel in addition to R, G and B, such as { "depth.Z", values, 1, false }.
typedef struct RfExrChannel
{
    const char* name;
    const float* values; // pixel (x, y) is values[stride (y·width + x)]
    int stride;
    bool half; // 16-bit half float, clamped to ±65504; else 32-bit float
} RfExrChannel;

#define RF_EXR_MAX_CHANNELS 64 // R, G and B included

typedef struct RfExrOptions
{
    RfExrCompression compression;
    bool half;         // R, G, B as half floats, clamped to ±65504; else 32-bit floats
    int x, y;          // origin of the data window and the display window
    int fps_numerator; // framesPerSecond; numerator 0: not written
    unsigned int fps_denominator;
    bool has_camera;           // write the two matrices, for row vectors as in OpenEXR:
    float world_to_camera[16]; // p_camera = p_world · M, row-major
    float world_to_ndc[16];
    const RfExrString* strings;
    int string_count;
    const RfExrChannel* channels; // additional channels in any order, with distinct names
    int channel_count;
} RfExrOptions;

// ZIP compression, half floats, no attributes and no additional channels.
RfExrOptions rf_default_exr_options( void );

// Writes R, G, B and the additional channels of `options`. A failure neither creates
// nor changes a file of that name and leaves no temporary file.
RfResult rf_write_exr( const char* path, const RfImage* image, const RfExrOptions* options, RfError* error );

// Peak working memory of rf_write_exr in bytes, without the channels themselves and
// about 2 MiB of tables: several buffers of one chunk of scan lines. `pixel_bytes` is
// the size of a pixel over all channels: 2 for each half channel, 4 for each float.
size_t rf_exr_work_bytes( int width, int height, RfExrCompression compression, int pixel_bytes );

// Reads the data window of the first part: R, G, B, or Y copied to all three. The
// file may be scan-line or tiled, of half, float or uint channels. If all channels
// share one layer prefix, such as Blender's "ViewLayer.Combined.R", it is skipped.
RfResult rf_read_exr( const char* path, RfImage* image, RfError* error );

// A data window.
typedef struct RfExrWindow
{
    int x, y, width, height;
} RfExrWindow;

// Reads three channels, or one as grey, from the first part that has them, and its
// data window. `layer` is a layer ("ViewLayer.DiffDir": its R, G, B or X, Y, Z), the
// name of a part, a channel ("depth.Z") or three channels separated by commas. NULL
// selects the colour, matched as in rf_read_exr, in the first part that has colour;
// parts with three colour channels take precedence over parts with Y.
RfResult rf_read_exr_layer( const char* path, const char* layer, RfImage* image, RfExrWindow* window, RfError* error );

// Receives one string attribute.
typedef void RfExrStringFn( void* user, const char* name, const char* value );

// Calls `take` with each string attribute of the first part, in file order.
RfResult rf_list_exr_strings( const char* path, RfExrStringFn* take, void* user, RfError* error );

// Reads channels by their full names ("depth.Z", as found by rf_find_exr_name) from any
// part: `count` floats per pixel in the order of the names, rows from top to bottom. The
// names must be distinct; the channels must all exist, share one data window and not be
// subsampled. The caller frees *values.
RfResult rf_read_exr_channels( const char* path, const char* const* names, int count, RfExrWindow* window, float** values,
                               RfError* error );

// A channel of a file.
typedef struct RfExrName
{
    char* text;      // full name; in a multi-part file prefixed with the part: "beauty.depth.Z"
    const char* own; // name within its part: "depth.Z"
    int part;
    RfExrWindow window; // data window of the part
} RfExrName;

// The header of a file: windows, channels, camera.
typedef struct RfExrHeader
{
    int part;                 // the part with the colour; if none has any, the first readable part
    int x, y, width, height;  // its data window: origin and size
    int display_x, display_y; // display window
    int display_width, display_height;
    int fps_numerator; // framesPerSecond; 0: not in the file
    unsigned int fps_denominator;
    bool has_world_to_ndc;
    float world_to_ndc[16]; // as in RfExrOptions
    int channel_count;
    RfExrName* channels; // of all readable parts
} RfExrHeader;

// Reads the header of the part with `layer` (as in rf_read_exr_layer), or with the
// colour if `layer` is NULL or missing, and the channel names of all parts.
RfResult rf_read_exr_header( const char* path, const char* layer, RfExrHeader* header, RfError* error );

// Frees the channel names and clears the header.
void rf_destroy_exr_header( RfExrHeader* header );

// Finds the channel whose full name or, failing that, whose own name equals the first
// `length` characters of `name`; the part with the colour comes first. NULL: none.
const RfExrName* rf_find_exr_name( const RfExrHeader* header, const char* name, size_t length );

// Reads one string attribute into `value`, truncated to `size` bytes. Fails with
// RF_ERROR_IO if the file cannot be read, RF_ERROR_FORMAT if it lacks the attribute.
RfResult rf_read_exr_string( const char* path, const char* name, char* value, size_t size, RfError* error );

// The value of a string attribute that holds a number; NaN if there is none.
double rf_read_exr_number( const char* path, const char* name );

#endif
