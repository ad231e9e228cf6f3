// PNG by libpng: writing and decoding.
#include "base/try.h"
#include "image/encode.h"

#include "image/atomic_file.h"
#include "image/decode_formats.h"

#include <math.h>
#include <png.h>
#include <setjmp.h>
#include <stdlib.h>
#include <string.h>

// State that must survive libpng's longjmp on errors.
typedef struct Writer
{
    const char* name;
    RfAtomicFile file;
    bool fast; // into memory, at a small part of the time
    unsigned char* bytes;
    size_t size, room;
    RfResult result; // of the failed write
    RfError* error;
    png_structp png;
    png_infop info;
    png_bytep row;
    float exposure; // a factor
    RfShowFn* show; // NULL: by the sRGB curve
    const void* view;
    float* shown; // a row; NULL where `show` is
    jmp_buf out;
} Writer;

static void keep_write_error( png_structp png, png_const_charp message )
{
    Writer* writer = png_get_error_ptr( png );
    if ( writer->result == RF_OK ) // else the message is already set
        writer->result = rf_fail( writer->error, RF_ERROR_IO, "%s: cannot be written: libpng: %s", writer->name, message );
    longjmp( writer->out, 1 );
}

static void drop_warning( png_structp png, png_const_charp message )
{
    (void)png;
    (void)message;
}

static void keep_bytes( Writer* writer, const unsigned char* bytes, size_t size )
{
    if ( writer->size + size > writer->room )
    {
        size_t room = 2 * ( writer->size + size );
        unsigned char* larger = realloc( writer->bytes, room );
        if ( larger == NULL )
        {
            writer->result = rf_fail( writer->error, RF_ERROR_MEMORY, "%s: out of memory for its bytes", writer->name );
            return;
        }
        writer->bytes = larger;
        writer->room = room;
    }
    memcpy( writer->bytes + writer->size, bytes, size );
    writer->size += size;
}

static void write_bytes( png_structp png, png_bytep bytes, size_t size )
{
    Writer* writer = png_get_io_ptr( png );
    if ( writer->fast )
        keep_bytes( writer, bytes, size );
    else
        writer->result = rf_append_atomic_file( &writer->file, bytes, size, writer->error );
    if ( writer->result != RF_OK )
        png_error( png, "write" );
}

static void flush_bytes( png_structp png )
{
    (void)png; // no flush needed: the commit syncs
}

static float opacity( const float* alpha, int x )
{
    return alpha != NULL && !isnan( alpha[x] ) ? fminf( fmaxf( alpha[x], 0.0f ), 1.0f ) : 1.0f;
}

// A row by `show`, of colours that alpha divides.
static void show_row( Writer* writer, const float* rgb, const float* alpha, int width )
{
    for ( int i = 0; i < 3 * width; ++i )
    {
        float opaque = opacity( alpha, i / 3 );
        writer->shown[i] = opaque > 0.0f && !isnan( rgb[i] ) ? rgb[i] / opaque : 0.0f;
    }
    writer->show( writer->view, writer->shown, width );
}

// `alpha`: NULL for rows without.
static void encode_row( Writer* writer, const float* rgb, const float* alpha, int width )
{
    if ( writer->show != NULL )
        show_row( writer, rgb, alpha, width );
    for ( int x = 0; x < width; ++x )
    {
        const float* pixel = rgb + 3 * x;
        png_bytep out = writer->row + ( alpha != NULL ? 4 : 3 ) * x;
        bool is_nan = isnan( pixel[0] ) || isnan( pixel[1] ) || isnan( pixel[2] ) || ( alpha != NULL && isnan( alpha[x] ) );
        float opaque = is_nan ? 1.0f : opacity( alpha, x );
        float scale = opaque > 0.0f ? writer->exposure / opaque : 0.0f;
        for ( int c = 0; c < 3; ++c )
        {
            if ( is_nan )
                out[c] = c == 1 ? 0 : 255;
            else if ( writer->show != NULL )
                out[c] = (png_byte)( 255.0f * writer->shown[3 * x + c] + 0.5f );
            else
                out[c] = (png_byte)( 255.0f * rf_linear_to_srgb( scale * pixel[c] ) + 0.5f );
        }
        if ( alpha != NULL )
            out[3] = (png_byte)( 255.0f * opaque + 0.5f );
    }
}

// Runs under the setjmp of its caller; keeps no state in local variables across the longjmp.
static void write_rows( Writer* writer, const RfImage* image, const float* alpha )
{
    png_set_write_fn( writer->png, writer, write_bytes, flush_bytes );
    // libpng's default limit is a million pixels per side
    png_set_user_limits( writer->png, 0x7fffffff, 0x7fffffff );
    png_set_IHDR( writer->png, writer->info, (png_uint_32)image->width, (png_uint_32)image->height, 8,
                  alpha != NULL ? PNG_COLOR_TYPE_RGB_ALPHA : PNG_COLOR_TYPE_RGB, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT,
                  PNG_FILTER_TYPE_DEFAULT );
    if ( writer->fast )
    {
        png_set_compression_level( writer->png, 1 );
        png_set_filter( writer->png, PNG_FILTER_TYPE_BASE, PNG_FILTER_SUB );
    }
    png_set_sRGB( writer->png, writer->info, PNG_sRGB_INTENT_PERCEPTUAL );
    png_write_info( writer->png, writer->info );
    for ( int y = 0; y < image->height; ++y )
    {
        size_t first = (size_t)image->width * (size_t)y;
        encode_row( writer, image->rgb + 3 * first, alpha != NULL ? alpha + first : NULL, image->width );
        png_write_row( writer->png, writer->row );
    }
    png_write_end( writer->png, NULL );
}

static RfResult write_image( Writer* writer, const RfImage* image, const float* alpha )
{
    writer->row = malloc( 4 * (size_t)image->width );
    if ( writer->show != NULL )
        writer->shown = malloc( 3 * (size_t)image->width * sizeof *writer->shown );
    if ( writer->row == NULL || ( writer->show != NULL && writer->shown == NULL ) )
        return rf_fail( writer->error, RF_ERROR_MEMORY, "%s: out of memory for a row", writer->name );
    // libpng reports failures of these two by NULL or through keep_write_error
    if ( setjmp( writer->out ) != 0 )
        return writer->result;
    writer->png = png_create_write_struct( PNG_LIBPNG_VER_STRING, writer, keep_write_error, drop_warning );
    writer->info = writer->png != NULL ? png_create_info_struct( writer->png ) : NULL;
    if ( writer->info == NULL )
        return rf_fail( writer->error, RF_ERROR_MEMORY, "%s: out of memory for libpng", writer->name );
    write_rows( writer, image, alpha );
    return RF_OK;
}

RfResult rf_write_png( const char* path, const RfImage* image, float exposure_stops, RfError* error )
{
    return rf_write_png_alpha( path, image, NULL, exposure_stops, error );
}

static void destroy_writer( Writer* writer )
{
    free( writer->row );
    free( writer->shown );
    free( writer );
}

static RfResult write_file( const Writer* settings, const RfImage* image, const float* alpha )
{
    const char* path = settings->name;
    RfError* error = settings->error;
    if ( image->rgb == NULL || image->width < 1 || image->height < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "%s: an image without pixels cannot be written", path );
    Writer* writer = malloc( sizeof *writer );
    if ( writer == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory writing it", path );
    *writer = *settings;
    RfResult result = rf_open_atomic_file( path, &writer->file, error );
    if ( result == RF_OK )
    {
        result = write_image( writer, image, alpha );
        png_destroy_write_struct( &writer->png, &writer->info );
        result = rf_end_atomic_file( &writer->file, result, error );
    }
    destroy_writer( writer );
    return result;
}

RfResult rf_write_png_alpha( const char* path, const RfImage* image, const float* alpha, float exposure_stops, RfError* error )
{
    Writer settings = { .name = path, .error = error, .exposure = exp2f( exposure_stops ) };
    if ( !isfinite( settings.exposure ) )
        return rf_fail( error, RF_ERROR_USAGE, "%s: an exposure of %g stops is not possible", path, (double)exposure_stops );
    return write_file( &settings, image, alpha );
}

RfResult rf_write_png_shown( const char* path, const RfImage* image, const float* alpha, RfShowFn* show, const void* view,
                             RfError* error )
{
    Writer settings = { .name = path, .error = error, .exposure = 1.0f, .show = show, .view = view };
    return write_file( &settings, image, alpha );
}

RfResult rf_encode_png( const char* name, const RfImage* image, unsigned char** bytes, size_t* size, RfError* error )
{
    Writer* writer = calloc( 1, sizeof *writer );
    if ( writer == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory writing it", name );
    writer->name = name;
    writer->fast = true;
    writer->error = error;
    writer->exposure = 1.0f;
    RfResult result = write_image( writer, image, NULL );
    png_destroy_write_struct( &writer->png, &writer->info );
    if ( result != RF_OK )
        free( writer->bytes );
    *bytes = result == RF_OK ? writer->bytes : NULL;
    *size = writer->size;
    destroy_writer( writer );
    return result;
}

// PNG by libpng's full interface. The simplified one applies the gamma of the file and
// premultiplies 16-bit alpha, but glTF needs the stored values.

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

static void read_bytes( png_structp png, png_bytep bytes, size_t size )
{
    Reader* reader = png_get_io_ptr( png );
    if ( size > reader->in->size - reader->at )
        png_error( png, "truncated" );
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
    RF_TRY( rf_check_sides( reader->in, png_get_image_width( png, reader->info ), png_get_image_height( png, reader->info ),
                            reader->error ) );
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
        return rf_fail( reader->error, RF_ERROR_MEMORY, "%s: out of memory for libpng", reader->in->name );
    reader->result = read_header( reader );
    if ( reader->result == RF_OK )
        read_rows( reader );
    return reader->result;
}

RfResult rf_decode_png( const RfEncoded* in, RfPixels* out, RfError* error )
{
    Reader* reader = calloc( 1, sizeof *reader );
    if ( reader == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for libpng", in->name );
    reader->in = in;
    reader->out = out;
    reader->error = error;
    RfResult result = read_image( reader );
    png_destroy_read_struct( &reader->png, &reader->info, NULL );
    free( reader );
    return result;
}
