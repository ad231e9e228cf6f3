// What the library does with EXR files besides reframe/image.h, by OpenEXRCore.
#ifndef REFRAME_IMAGE_EXR_H
#define REFRAME_IMAGE_EXR_H

#include "reframe/image.h"

// The names of compressions, as users write them, in the order of RfExrCompression, with NULL at the end.
extern const char* const rf_compression_words[];

// Peak working memory of rf_write_exr in bytes, without the channels themselves and
// about 2 MiB of tables: several buffers of one chunk of scan lines. `pixel_bytes` is
// the size of a pixel over all channels: 2 for each half channel, 4 for each float.
size_t rf_exr_work_bytes( int width, int height, RfExrCompression compression, int pixel_bytes );

// Whether a file is whole: decodes all pixels of all parts, and compares them with the checksums that rf_write_exr puts into the
// header, where there are any. Fails where that is not possible; *same is false, and `error` filled, where the pixels are not those
// that were written. RF_ERROR_UNSUPPORTED: all that can be read is whole.
RfResult rf_verify_exr( const char* path, bool* same, RfError* error );

// How many pixels have a value beyond the range of their channel in a file written with these options, which clamps it there:
// ±65504 of half floats, ±30000 of colours that DWA changes. `clipped`: which channels, R, G and B first, then those of the options.
size_t rf_count_clipped( const RfImage* image, const RfExrOptions* options, bool clipped[RF_EXR_MAX_CHANNELS] );

// rf_read_exr_layer and rf_read_exr_channels; *clipped: pixels with ±65504 or infinity in a channel of half floats, which is where
// larger values end.
RfResult rf_read_exr_picture( const char* path, const char* layer, RfImage* image, RfExrWindow* window, size_t* clipped,
                              RfError* error );
RfResult rf_read_exr_values( const char* path, const char* const* names, int count, RfExrWindow* window, float** values,
                             size_t* clipped, RfError* error );

// A channel of a file.
typedef struct RfExrName
{
    char* text;      // full name; in a multi-part file prefixed with the part, "beauty.depth.Z", unless that is its layer
    const char* own; // name within its part: "depth.Z"
    int part;
    bool half, whole;   // 16 bits; whole numbers
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

void rf_destroy_exr_header( RfExrHeader* header );

// A file that is to be written again with other colours: all that rf_write_exr needs for it.
typedef struct RfExrCopy
{
    RfExrOptions
        options; // with the file's windows, parts, channels but R, G and B, and attributes; channels, attributes and strings of
                 // other names may be appended or replaced
    RfExrChannel channels[RF_EXR_MAX_CHANNELS]; // of the options
    RfExrHeader header;
    float* values;              // of all channels, header.channel_count per pixel, as they are in the file
    char layer[256], part[256]; // of R, G and B
    char ( *parts )[256];       // of the channels
} RfExrCopy;

// Reads all of a file. Fails with RF_ERROR_UNSUPPORTED for what cannot be written again as it is: channels of whole numbers, parts of
// different windows, or another colour space than those of RfColourSpace. Free it in any case.
RfResult rf_read_exr_copy( const char* path, RfExrCopy* copy, RfError* error );
void rf_free_exr_copy( RfExrCopy* copy );

// Finds the channel whose full name or, failing that, whose own name equals the first
// `length` characters of `name`; the part with the colour comes first. NULL: none.
const RfExrName* rf_find_exr_name( const RfExrHeader* header, const char* name, size_t length );

#endif
