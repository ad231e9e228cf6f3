// What the library does with EXR files besides reframe/image.h, by OpenEXRCore.
#ifndef REFRAME_IMAGE_EXR_H
#define REFRAME_IMAGE_EXR_H

#include "reframe/image.h"

// Bytes that rf_write_exr holds at most besides the channels and about 2 MiB of
// tables, for channels of `pixel_bytes` together (2 for each half one, 4 for each
// other): the lines of one chunk, some times over.
size_t rf_exr_work_bytes( int width, int height, RfExrCompression compression, int pixel_bytes );

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

#endif
