// PNG by libpng's full interface. The simplified one applies the gamma of the file and
// premultiplies 16-bit alpha, but glTF needs the stored values.
#include "image/decode_formats.h"

#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

// State that must survive libpng's longjmp on errors.
typedef struct Reader
{
    const RfEncoded* in;
    size_t at;
    RfPixels* out;
    RfResult result;
    RfError* error;
    png_structp png;
    png_infop info;
    jmp_buf back;
} Reader;

static void keep_error( png_structp png, png_const_charp message )
{
    Reader* reader = png_get_error_ptr( png );
    if ( reader->result == RF_OK ) // else the message is already set
        reader->result = rf_fail( reader->error, RF_ERROR_FORMAT, "%s: damaged PNG: %s", reader->in->name, message );
    longjmp( reader->back, 1 );
}

static void drop_warning( png_structp png, png_const_charp message )
{
    (void)png;
    (void)message;
}

static void read_bytes( png_structp png, png_bytep bytes, size_t size )
{
    Reader* reader = png_get_io_ptr( png );
    if ( size > reader->in->size - reader->at )
        png_error( png, "it is cut off" );
    memcpy( bytes, reader->in->bytes + reader->at, size );
    reader->at += size;
}

static RfResult read_header( Reader* reader )
{
    png_structp png = reader->png;
    png_set_read_fn( png, reader, read_bytes );
    // our own check of the size has a better message than libpng's
    png_set_user_limits( png, 0x7fffffff, 0x7fffffff );
    png_read_info( png, reader->info );
    RfResult result = rf_check_sides( reader->in, png_get_image_width( png, reader->info ),
                                      png_get_image_height( png, reader->info ), reader->error );
    if ( result != RF_OK )
        return result;
    png_set_expand( png ); // palettes and tRNS to RGB and alpha, fewer than 8 bits to 8
    int depth = png_get_bit_depth( png, reader->info );
    if ( depth == 16 )
        png_set_swap( png ); // PNG is big-endian
    png_set_interlace_handling( png );
    png_read_update_info( png, reader->info );
    reader->out->type = depth == 16 ? RF_PIXELS_U16 : RF_PIXELS_U8;
    reader->out->channels = png_get_channels( png, reader->info );
    return rf_create_pixels( reader->in, png_get_image_width( png, reader->info ), png_get_image_height( png, reader->info ),
                             reader->out, reader->error );
}

static void read_rows( Reader* reader )
{
    png_structp png = reader->png;
    RfPixels* out = reader->out;
    size_t row = png_get_rowbytes( png, reader->info );
    size_t expected = (size_t)out->width * (size_t)out->channels * ( out->type == RF_PIXELS_U16 ? 2 : 1 );
    if ( row != expected )
        png_error( png, "its rows have an unexpected size" );
    int passes = png_get_interlace_type( png, reader->info ) == PNG_INTERLACE_ADAM7 ? 7 : 1;
    for ( int pass = 0; pass < passes; ++pass )
    {
        for ( int y = 0; y < out->height; ++y )
            png_read_row( png, (png_bytep)out->data + row * (size_t)y, NULL );
    }
    png_read_end( png, NULL );
}

// Keeps no state in local variables across the longjmp.
static RfResult read_image( Reader* reader )
{
    if ( setjmp( reader->back ) != 0 )
        return reader->result;
    reader->png = png_create_read_struct( PNG_LIBPNG_VER_STRING, reader, keep_error, drop_warning );
    reader->info = reader->png != NULL ? png_create_info_struct( reader->png ) : NULL;
    if ( reader->info == NULL )
        return rf_fail( reader->error, RF_ERROR_MEMORY, "%s: no memory left for libpng", reader->in->name );
    reader->result = read_header( reader );
    if ( reader->result == RF_OK )
        read_rows( reader );
    return reader->result;
}

RfResult rf_decode_png( const RfEncoded* in, RfPixels* out, RfError* error )
{
    Reader* reader = calloc( 1, sizeof *reader );
    if ( reader == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for libpng", in->name );
    reader->in = in;
    reader->out = out;
    reader->error = error;
    RfResult result = read_image( reader );
    png_destroy_read_struct( &reader->png, &reader->info, NULL );
    free( reader );
    return result;
}
