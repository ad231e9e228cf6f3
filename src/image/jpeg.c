// JPEG in memory by libjpeg; its error handler jumps back here, so that a malformed file is only an error.
#include "base/try.h"
#include "image/encode.h"

#include "image/decode_formats.h"

#include <setjmp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// wants stdio.h before it
#include <jpeglib.h>
#include <jerror.h>

// State that must survive libjpeg's longjmp on errors.
typedef struct Writer
{
    struct jpeg_compress_struct jpeg; // first member: callbacks cast its address
    struct jpeg_error_mgr handlers;
    const char* name;
    unsigned char* bytes;
    unsigned long size;
    RfError* error;
    RfResult result;
    jmp_buf back;
} Writer;

static void stop_writing( j_common_ptr jpeg )
{
    Writer* writer = (Writer*)jpeg;
    char message[JMSG_LENGTH_MAX] = "";
    jpeg->err->format_message( jpeg, message );
    bool memory = jpeg->err->msg_code == JERR_OUT_OF_MEMORY;
    writer->result =
        rf_fail( writer->error, memory ? RF_ERROR_MEMORY : RF_ERROR_IO, "%s: JPEG encoding failed: %s", writer->name, message );
    longjmp( writer->back, 1 );
}

static void drop_message( j_common_ptr jpeg ) { (void)jpeg; }

// Runs under the setjmp of its caller; keeps no state in local variables across the longjmp.
static void write_rows( Writer* writer, const unsigned char* rgb, int width, int height, int quality )
{
    struct jpeg_compress_struct* jpeg = &writer->jpeg;
    jpeg_create_compress( jpeg );
    jpeg_mem_dest( jpeg, &writer->bytes, &writer->size );
    jpeg->image_width = (JDIMENSION)width;
    jpeg->image_height = (JDIMENSION)height;
    jpeg->input_components = 3;
    jpeg->in_color_space = JCS_RGB;
    jpeg_set_defaults( jpeg );
    jpeg_set_quality( jpeg, quality, TRUE );
    jpeg->comp_info[0].h_samp_factor = jpeg->comp_info[0].v_samp_factor = 1;
    jpeg->optimize_coding = TRUE;
    jpeg_start_compress( jpeg, TRUE );
    while ( jpeg->next_scanline < jpeg->image_height )
    {
        JSAMPROW row = (JSAMPROW)( rgb + 3 * (size_t)jpeg->next_scanline * (size_t)width ); // libjpeg does not modify it
        jpeg_write_scanlines( jpeg, &row, 1 );
    }
    jpeg_finish_compress( jpeg );
}

RfResult rf_encode_jpeg( const unsigned char* rgb, int width, int height, int quality, const char* name, unsigned char** bytes,
                         size_t* size, RfError* error )
{
    *bytes = NULL;
    *size = 0;
    if ( width < 1 || height < 1 || width > RF_JPEG_MAX_SIDE || height > RF_JPEG_MAX_SIDE )
        return rf_fail( error, RF_ERROR_USAGE, "%s: %dx%d pixels are not possible for a JPEG: a side has 1 to %d", name, width,
                        height, RF_JPEG_MAX_SIDE );
    Writer* writer = calloc( 1, sizeof *writer ); // on the heap, so that a longjmp leaves it intact
    if ( writer == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for a JPEG", name );
    writer->name = name;
    writer->error = error;
    writer->jpeg.err = jpeg_std_error( &writer->handlers );
    writer->handlers.error_exit = stop_writing;
    writer->handlers.output_message = drop_message;
    if ( setjmp( writer->back ) == 0 )
        write_rows( writer, rgb, width, height, quality );
    jpeg_destroy_compress( &writer->jpeg );
    RfResult result = writer->result;
    if ( result == RF_OK )
    {
        *bytes = writer->bytes;
        *size = writer->size;
    }
    else
        free( writer->bytes );
    free( writer );
    return result;
}

// JPEG by libjpeg(-turbo). Its own error handler calls exit, so ours uses longjmp. Warnings
// about damaged data, for which libjpeg fills in grey, are treated as errors.

// A progressive file of a few bytes may claim any number of scans, each of which processes the
// whole image.
#define MAX_SCANS 200

// A block of 8×8 pixels takes at least one bit: a file that claims more pixels for its size is
// truncated, and not worth the memory.
#define MAX_PIXELS_PER_BYTE 1024

typedef struct Reader
{
    struct jpeg_decompress_struct jpeg; // first member: callbacks cast its address
    struct jpeg_error_mgr handlers;
    struct jpeg_progress_mgr progress;
    const RfEncoded* in;
    RfPixels* out;
    RfResult result;
    RfError* error;
    jmp_buf back;
} Reader;

static void stop( j_common_ptr jpeg )
{
    Reader* reader = (Reader*)jpeg;
    char message[JMSG_LENGTH_MAX] = "";
    jpeg->err->format_message( jpeg, message );
    bool memory = jpeg->err->msg_code == JERR_OUT_OF_MEMORY;
    if ( reader->result == RF_OK ) // else the message is already set
        reader->result = rf_fail( reader->error, memory ? RF_ERROR_MEMORY : RF_ERROR_FORMAT, "%s: damaged JPEG: %s",
                                  reader->in->name, message );
    longjmp( reader->back, 1 );
}

// Level −1 warns of damaged data; some of these warnings are harmless.
static void on_message( j_common_ptr jpeg, int level )
{
    int code = jpeg->err->msg_code;
    if ( level < 0 && ( code == JWRN_JPEG_EOF || code == JWRN_HIT_MARKER || code == JWRN_HUFF_BAD_CODE ||
                        code == JWRN_MUST_RESYNC || code == JWRN_ARITH_BAD_CODE ) )
        stop( jpeg );
}

static void on_progress( j_common_ptr jpeg )
{
    Reader* reader = (Reader*)jpeg;
    if ( reader->jpeg.input_scan_number <= MAX_SCANS )
        return;
    reader->result = rf_fail( reader->error, RF_ERROR_UNSUPPORTED, "%s: a JPEG of more than %d scans: encode it again",
                              reader->in->name, MAX_SCANS );
    longjmp( reader->back, 1 );
}

static RfResult read_header( Reader* reader )
{
    struct jpeg_decompress_struct* jpeg = &reader->jpeg;
    jpeg_create_decompress( jpeg );
    reader->progress.progress_monitor = on_progress;
    jpeg->progress = &reader->progress;
    jpeg_mem_src( jpeg, reader->in->bytes, (unsigned long)reader->in->size );
    jpeg_read_header( jpeg, TRUE );
    if ( jpeg->jpeg_color_space == JCS_CMYK || jpeg->jpeg_color_space == JCS_YCCK )
        return rf_fail( reader->error, RF_ERROR_UNSUPPORTED, "%s: a JPEG in CMYK, for print: store it as RGB", reader->in->name );
    bool grey = jpeg->jpeg_color_space == JCS_GRAYSCALE;
    jpeg->out_color_space = grey ? JCS_GRAYSCALE : JCS_RGB;
    jpeg->dct_method = JDCT_ISLOW;
    reader->out->type = RF_PIXELS_U8;
    reader->out->channels = grey ? 1 : 3;
    RF_TRY( rf_check_sides( reader->in, jpeg->image_width, jpeg->image_height, reader->error ) );
    if ( (size_t)jpeg->image_width * jpeg->image_height / MAX_PIXELS_PER_BYTE > reader->in->size )
        return rf_fail( reader->error, RF_ERROR_FORMAT, "%s: damaged JPEG: truncated", reader->in->name );
    return rf_create_pixels( reader->in, jpeg->image_width, jpeg->image_height, reader->out, reader->error );
}

static void read_rows( Reader* reader )
{
    struct jpeg_decompress_struct* jpeg = &reader->jpeg;
    RfPixels* out = reader->out;
    jpeg_start_decompress( jpeg );
    while ( jpeg->output_scanline < jpeg->output_height )
    {
        JSAMPROW row = (JSAMPROW)out->data + (size_t)jpeg->output_scanline * (size_t)out->width * (size_t)out->channels;
        jpeg_read_scanlines( jpeg, &row, 1 );
    }
    jpeg_finish_decompress( jpeg );
}

// Keeps no state in local variables across the longjmp.
static RfResult read_image( Reader* reader )
{
    reader->jpeg.err = jpeg_std_error( &reader->handlers );
    reader->handlers.error_exit = stop;
    reader->handlers.emit_message = on_message;
    reader->handlers.output_message = drop_message;
    if ( setjmp( reader->back ) != 0 )
        return reader->result;
    reader->result = read_header( reader );
    if ( reader->result == RF_OK )
        read_rows( reader );
    return reader->result;
}

RfResult rf_decode_jpeg( const RfEncoded* in, RfPixels* out, RfError* error )
{
    Reader* reader = calloc( 1, sizeof *reader );
    if ( reader == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for libjpeg", in->name );
    reader->in = in;
    reader->out = out;
    reader->error = error;
    RfResult result = read_image( reader );
    jpeg_destroy_decompress( &reader->jpeg );
    free( reader );
    return result;
}
