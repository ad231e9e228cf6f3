#include "image/jpeg.h"

#include <setjmp.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>

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

static void stop( j_common_ptr jpeg )
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
        return rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for a JPEG", name );
    writer->name = name;
    writer->error = error;
    writer->jpeg.err = jpeg_std_error( &writer->handlers );
    writer->handlers.error_exit = stop;
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
