// Images: OpenEXR files, PNG files to look at, and the names of image sequences.
//
//     RfImage image;
//     if ( rf_read_exr( "frame.0001.exr", &image, &error ) == RF_OK )
//         result = rf_write_png( "frame.0001.png", &image, 0.0f, &error );
//     rf_destroy_image( &image );
//
// Writing is atomic: bytes go to a temporary name in the same folder, which is renamed once all
// of them are on the disk. A file under its final name is complete.
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

// Linear colour in files: ITU-R BT.709 with the white D65, or ACEScg, the primaries AP1 with the white of ACES.
typedef enum RfColourSpace
{
    RF_REC709,
    RF_ACESCG,
} RfColourSpace;

// What a channel holds.
typedef enum RfExrMeaning
{
    RF_EXR_DATA,
    RF_EXR_COLOUR,   // red, green or blue of a colour
    RF_EXR_VARIANCE, // or of its variance
} RfExrMeaning;

typedef enum RfExrCompression
{
    RF_EXR_NONE,
    RF_EXR_ZIP, // 16 lines at a time
    RF_EXR_PIZ,
    RF_EXR_ZIPS, // line by line
    RF_EXR_DWAA, // 32 lines at a time; changes channels that are `lossy`, all others are kept
    RF_EXR_DWAB, // 256 lines at a time
} RfExrCompression;

// A string attribute, such as { "owner", "me" }.
typedef struct RfExrString
{
    const char* name;
    const char* value;
} RfExrString;

typedef enum RfExrAttributeType
{
    RF_EXR_FLOAT,
    RF_EXR_M44F,
    RF_EXR_TIMECODE,
} RfExrAttributeType;

// An attribute that is no string.
typedef struct RfExrAttribute
{
    const char* name;
    RfExrAttributeType type;
    float values[16];     // of a float the first, of a matrix all, row-major
    uint32_t timecode[2]; // time and flags, user data, packed as in SMPTE 12M for television at 60 fields
} RfExrAttribute;

// A channel in addition to R, G and B, such as { .name = "depth.Z", .values = values, .stride = 1 }.
typedef struct RfExrChannel
{
    const char* name;    // at most 255 bytes
    const float* values; // pixel (x, y) is values[stride (y·width + x)]
    int stride;
    bool half;        // 16-bit half float, clamped to ±65504; else 32-bit float
    bool negated;     // the file has the values with the opposite sign
    bool lossy;       // a colour, which DWA may change: R, G or B of a layer of which all three may
    const char* part; // the part of the file that it is in; NULL: the first, with R, G and B
    // Of a colour or its variance: the file has it in options->colour_space. `values` is then number `component` of three floats that
    // lie together, of red, green and blue in Rec. 709. Of a variance the root is converted as a colour.
    RfExrMeaning meaning;
    int component;
} RfExrChannel;

#define RF_EXR_DWA_LEVEL 45.0f // by default
#define RF_EXR_MAX_DWA_LEVEL 250.0f

#define RF_EXR_MAX_CHANNELS 256 // R, G and B included

// A window of pixels, such as the data window: where the pixels of a file lie.
typedef struct RfExrWindow
{
    int x, y, width, height;
} RfExrWindow;

typedef struct RfExrOptions
{
    RfExrCompression compression;
    float dwa_level;            // 0 to RF_EXR_MAX_DWA_LEVEL: the more, the smaller the file and the larger the error
    RfColourSpace colour_space; // of the file, which the image in Rec. 709 is converted to
    bool half;                  // R, G, B as half floats, clamped to ±65504; else 32-bit floats
    const char* layer;          // whose channels R, G, B are, such as "ViewLayer.Combined"; NULL: of none
    const char* part;           // the name of the part with R, G, B where there are several; NULL: "rgba"
    int x, y;                   // origin of the data window
    RfExrWindow display;        // window; without pixels: the data window
    int fps_numerator;          // framesPerSecond; numerator 0: not written
    unsigned int fps_denominator;
    float pixel_aspect;         // width of a pixel over its height; 0 stands for 1
    bool has_camera;            // write the two matrices (rf_eye_matrices)
    float world_to_camera[16];  // for row vectors: p_camera = p_world · M, row-major
    float world_to_ndc[16];     // all zeros: not written
    const RfExrString* strings; // string_count of them
    int string_count;
    const RfExrAttribute* attributes; // attribute_count of them
    int attribute_count;
    const RfExrChannel* channels; // additional channels in any order, with distinct names within a part
    int channel_count;
    const char*
        like; // a file whose attributes the parts of the same name, or the first, have as well, unless these say otherwise
} RfExrOptions;

// ZIP compression, half floats, no attributes and no additional channels.
RfExrOptions rf_default_exr_options( void );

// Whether this build can read and write DWA: it needs OpenEXR's C++ library.
bool rf_has_dwa( void );

// With DWA, R, G, B and `lossy` channels are changed by errors whose root mean square is at most 16.6e-5 dwa_level, in the
// scale of v^(1/2.2) up to 1 and 1 + ln v / 2.2 beyond, and by roundings to half floats; they are clamped to ±30000. A part
// without such channels is compressed by ZIP.
//
// Writes R, G, B and the additional channels of `options`, and in each part a checksum of its pixels, the string "reframe/checksum". A file of several parts begins with that of R, G and B, then come the
// others in the order of their first channels; the strings, the camera, the frames per second and the attributes are in the
// first, a time code in all. A failure (RF_ERROR_IO, RF_ERROR_MEMORY,
// RF_ERROR_USAGE) neither creates nor changes a file of that name and leaves no temporary file.
RfResult rf_write_exr( const char* path, const RfImage* image, const RfExrOptions* options, RfError* error );

// Reading converts colours to Rec. 709 from what the attribute `chromaticities` says (none: Rec. 709), with Bradford's adaptation to
// its white: channels R, G and B of a layer that are read together. Cryptomattes and single channels stay as they are, variances (a
// layer of this name) are converted as RfExrChannel has it. Chromaticities that are no colour space are RF_ERROR_FORMAT.

// Reads the data window of the first part: R, G, B, or Y copied to all three. The file may be
// scan-line or tiled, of half, float or uint channels. If all channels share one layer prefix, such as
// Blender's "ViewLayer.Combined.R", it is skipped. On failure the image is empty. Free with
// rf_destroy_image.
RfResult rf_read_exr( const char* path, RfImage* image, RfError* error );

// Reads three channels, or one as grey, from the first part that has them, and its data window.
// `layer` is a layer ("ViewLayer.DiffDir": its R, G, B or X, Y, Z), the name of a part, a channel
// ("depth.Z") or three channels separated by commas. NULL selects the colour, matched as in
// rf_read_exr, in the first part that has colour; parts with three colour channels take precedence
// over parts with Y.
RfResult rf_read_exr_layer( const char* path, const char* layer, RfImage* image, RfExrWindow* window, RfError* error );

// Reads channels by their full names ("depth.Z") from any part: `count` floats per pixel in the order
// of the names, rows from top to bottom. The names must be distinct; the channels must all exist,
// share one data window and not be subsampled. The caller frees *values.
RfResult rf_read_exr_channels( const char* path, const char* const* names, int count, RfExrWindow* window, float** values,
                               RfError* error );

// Reads a string attribute into `value`, truncated to `size` bytes. Fails with RF_ERROR_IO if the
// file cannot be read, RF_ERROR_FORMAT if it lacks the attribute.
RfResult rf_read_exr_string( const char* path, const char* name, char* value, size_t size, RfError* error );

// The value of a string attribute that holds a number; NaN if there is none.
double rf_read_exr_number( const char* path, const char* name );

// Receives one string attribute.
typedef void RfExrStringFn( void* user, const char* name, const char* value );

// Calls `take` with each string attribute of the first part, in file order.
RfResult rf_list_exr_strings( const char* path, RfExrStringFn* take, void* user, RfError* error );

// Writes an 8-bit PNG for viewing: multiplies by 2^exposure_stops, clips at 1 and applies the sRGB
// curve. NaN becomes magenta, so that it is noticed.
RfResult rf_write_png( const char* path, const RfImage* image, float exposure_stops, RfError* error );

// The same with alpha, a float per pixel. The colour is premultiplied, as in EXR files; PNG wants it straight, so it
// is divided by alpha, which is clipped to 0 to 1. NULL: no alpha.
RfResult rf_write_png_alpha( const char* path, const RfImage* image, const float* alpha, float exposure_stops, RfError* error );

// Sequences: in a pattern such as "out/frame.####.exr" the run of '#' stands for the frame number,
// zero-padded to the length of the run (longer numbers take more digits); a minus goes before that: out/frame.-0003.exr.
// "out/frame.%04d.exr" is the same, and %d is "#".

// True if the last path component has a run of '#' or a %04d. Several runs, or one in the name of a folder,
// are errors that rf_sequence_name reports.
bool rf_is_sequence( const char* pattern );

// Writes the file name of frame `number` into `name` (size bytes). A pattern without one is copied.
// Fails with RF_ERROR_USAGE.
RfResult rf_sequence_name( const char* pattern, int number, char* name, size_t size, RfError* error );

// Lists the numbers of all existing frames in ascending order in *numbers, which the caller frees.
// Fails with RF_ERROR_IO if there are none.
RfResult rf_sequence_frames( const char* pattern, int** numbers, int* count, RfError* error );

RF_API_END

#endif
