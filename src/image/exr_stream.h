// What reading and writing an EXR share: an OpenEXRCore context over a file
// descriptor of ours, or over bytes in memory. Our own read and write functions
// see every failure of the system, also those that the library forgets
// (exr_finish reports success after a full disk), and its messages come to us
// instead of standard error.
#ifndef REFRAME_IMAGE_EXR_STREAM_H
#define REFRAME_IMAGE_EXR_STREAM_H

#include "reframe/image.h"

#include <openexr.h>

// A frame of film at 16 K has 2^27 pixels; what is larger is a damaged header.
#define RF_EXR_MAX_SIDE ( 1 << 20 )

typedef struct RfExrStream
{
    const char* path;           // for messages
    int fd;                     // stays the caller's
    const unsigned char* bytes; // read from these instead, where not NULL
    size_t size;
    int max_side;      // 0: RF_EXR_MAX_SIDE
    size_t max_bytes;  // of the image's floats; 0: 3 GiB
    int io_error;      // first errno of a failed read or write, else 0
    char message[256]; // the library's first message, else empty
} RfExrStream;

// The initializer of a context over the stream, which must outlive it.
exr_context_initializer_t rf_exr_initializer( RfExrStream* stream );

// For the alloc_fn and free_fn of a pipeline: its buffers, which are large, straight from the system
// and back to it. malloc would keep some of them once they are freed, and a budget counts what is held.
void* rf_alloc_exr_buffer( exr_transcoding_pipeline_buffer_id_t id, size_t bytes );
void rf_free_exr_buffer( exr_transcoding_pipeline_buffer_id_t id, void* buffer );

// The error line for a library call that returned `code`.
RfResult rf_fail_exr( const RfExrStream* stream, exr_result_t code, const char* what, RfError* error );

// Opens a file for reading; `fd` is the caller's to close where it succeeded.
RfResult rf_open_exr_file( const char* path, RfExrStream* stream, RfError* error );

// Reads the image from the beginning of the stream.
RfResult rf_read_exr_stream( RfExrStream* stream, RfImage* image, RfError* error );

// A part of a file that is being read.
typedef struct RfExrPart
{
    RfExrStream* stream;
    int index, count; // which part it is of how many
    exr_context_t context;
    exr_attr_box2i_t window; // of the data
    int width, height;       // of it
    bool tiled;
    const exr_attr_chlist_t* channels;
} RfExrPart;

// Opens the file from its beginning and checks that its pixels can be read.
// Closing is needed where it succeeded. On failure part->count is how many parts
// there are, 0 where that is not known.
RfResult rf_open_exr_part( RfExrStream* stream, int index, RfExrPart* part, RfError* error );
void rf_close_exr_part( RfExrPart* part );

// Takes `count` values of a channel (an index into the names), from pixel
// (x, y) of the data window on to the right.
typedef void RfExrLineFn( void* user, int channel, int x, int y, const float* values, int count );

// Reads all pixels of the named channels, which must be there and not be
// subsampled, as floats, line by line in any order.
RfResult rf_read_exr_lines( const RfExrPart* part, const char* const* names, int count, RfExrLineFn* take, void* user,
                            RfError* error );

#endif
