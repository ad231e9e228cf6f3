// Shared by reading and writing EXR: an OpenEXRCore context over our own file descriptor or over bytes in memory. Our callbacks record
// every system error, including those that the library drops (exr_finish reports success on a full disk), and capture its messages.
#ifndef REFRAME_IMAGE_EXR_STREAM_H
#define REFRAME_IMAGE_EXR_STREAM_H

#include "image/colour.h"
#include "reframe/image.h"

#include <openexr.h>

// Film scans at 16 K have 2^27 pixels in all; a longer side means a damaged header.
#define RF_EXR_MAX_SIDE ( 1 << 20 )

typedef struct RfExrStream
{
    const char* path;           // for messages
    int fd;                     // owned by the caller
    const unsigned char* bytes; // if not NULL, read from memory instead
    size_t size;
    int max_side;      // 0: RF_EXR_MAX_SIDE
    size_t max_bytes;  // of the decoded floats; 0: 3 GiB
    int io_error;      // first errno of a failed read or write, else 0
    char message[256]; // the library's first message, else empty
} RfExrStream;

// Between these two, contexts of the stream write, in this thread alone. The library's messages go to the stream.
void rf_begin_exr_write( RfExrStream* stream );
void rf_end_exr_write( void );

// The initializer of a context over the stream, which must outlive it.
exr_context_initializer_t rf_exr_initializer( RfExrStream* stream );

// exr_start_read by it, which fails also where the library would go on without what it had no memory for.
exr_result_t rf_start_exr( RfExrStream* stream, exr_context_t* context );

// The alloc_fn and free_fn of pipelines. Their large buffers are mapped directly from the system: malloc would keep some of them after
// they are freed, which the memory budget would not know of.
void* rf_alloc_exr_buffer( exr_transcoding_pipeline_buffer_id_t id, size_t bytes );
void rf_free_exr_buffer( exr_transcoding_pipeline_buffer_id_t id, void* buffer );

// Fails with a message for a library call that returned `code`.
RfResult rf_fail_exr( const RfExrStream* stream, exr_result_t code, const char* what, RfError* error );

// Opens a file for reading; after success the caller closes `fd`.
RfResult rf_open_exr_file( const char* path, RfExrStream* stream, RfError* error );

// Reads the image from the beginning of the stream, in the colours of the file; *conversion is that to Rec. 709.
RfResult rf_read_exr_stream( RfExrStream* stream, RfImage* image, RfColourConversion* conversion, RfError* error );

// A part of a file that is being read.
typedef struct RfExrPart
{
    RfExrStream* stream;
    int index, count; // index of the part, number of parts
    exr_context_t context;
    exr_attr_box2i_t window; // data window
    int width, height;       // of the data window
    bool tiled, dwa;
    const exr_attr_chlist_t* channels;
} RfExrPart;

// Opens a part from the beginning of the file and checks that its pixels can be read. Close it after success. On failure part->count is
// the number of parts, or 0 if unknown.
RfResult rf_open_exr_part( RfExrStream* stream, int index, RfExrPart* part, RfError* error );
void rf_close_exr_part( RfExrPart* part );

// The conversion of a part's colours to Rec. 709. Where the part lacks the attribute, another has it for all.
RfResult rf_read_exr_colours( const RfExrPart* part, RfColourConversion* conversion, RfError* error );

// The channels of a colour, or of a named layer.
typedef struct RfExrChannels
{
    const char* names[3]; // red, green and blue, or Y alone; owned by the context
    int count;            // 3, or 1 for Y
} RfExrChannels;

// Opens the first part of a file that has the colour, or the channels named by `layer` (NULL:
// the colour), and finds them. Close with rf_close_exr_part after success.
RfResult rf_open_exr_layer( RfExrStream* stream, const char* layer, RfExrPart* part, RfExrChannels* channels, RfError* error );

// Fails if a channel of this name is missing or subsampled.
RfResult rf_check_exr_channel( const RfExrStream* stream, const exr_attr_chlist_t* list, const char* name, RfError* error );

// Receives `count` values of a channel (an index into the names), starting at pixel (x, y) of
// the data window and going right.
typedef void RfExrLineFn( void* user, int channel, int x, int y, const float* values, int count );

// Reads all pixels of the named channels as floats, line by line in any order. The channels
// must exist and not be subsampled.
RfResult rf_read_exr_lines( const RfExrPart* part, const char* const* names, int count, RfExrLineFn* take, void* user,
                            RfError* error );

// The attribute of a part with a checksum of its pixels, rf_hash_bytes: of the samples, line by line, which another lossless
// compression leaves as they are; with DWA, where decoders may round differently, of its compressed chunks.
#define RF_EXR_CHECKSUM "reframe/checksum"
#define RF_EXR_SAMPLES_SUM "samples:"
#define RF_EXR_CHUNKS_SUM "chunks:"
#define RF_EXR_SUM_FORMAT "%016llx"
#define RF_EXR_SUM_SIZE 17

// The same, and decodes all other channels too; *same is false where the part has a checksum for its compression and other pixels.
RfResult rf_verify_exr_lines( const RfExrPart* part, const char* const* names, int count, RfExrLineFn* take, void* user,
                              bool* same, RfError* error );

// DWAA and DWAB.
bool rf_is_dwa( RfExrCompression compression );

// The largest size of a colour that DWA is given: it is off by RF_DWA_WORST at most, which then stays in the range of half floats.
#define RF_DWA_MOST 30000.0f

// What DWA compresses in place of a colour: v^(1/2.2) up to 1, 1 + ln v / 2.2 beyond, with the sign. Errors are bounded in this
// scale.
double rf_dwa_scale( double value );

// Bounds of the error in that scale. DWA turns R, G, B into Y', Cb, Cr (Rec. 709) and quantises DCT coefficient k of blocks of 8 by 8
// with an error of up to level / 1e5 times that of JPEG's table over the table's least. The root mean square of these errors
// over 64 coefficients is that over 64 pixels, as the transform is orthonormal: 6.71 and 5.31 level / 1e5 for luma and chroma,
// and in B, which is Y' + 1.8556 Cb, 16.6. `scale` is the root mean square of the colours themselves, which are rounded to half floats
// six times on the way.
double rf_dwa_error_bound( double level, double scale );

// A compress_fn for a part whose channel i may change where `may_change` says so. `level` is DWA's.
exr_result_t rf_compress_dwa_chunk( exr_encode_pipeline_t* pipeline, RfExrStream* stream, const bool* may_change, float level );

// A decompress_fn.
exr_result_t rf_decompress_dwa_chunk( exr_decode_pipeline_t* pipeline, RfExrStream* stream );

#endif
