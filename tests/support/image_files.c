#include "support/image_files.h"
#include "support/test.h"

#include "base/file.h"
#include "image/exr.h"

#include <openexr.h>
#include <png.h>
#include <stdio.h>
#include <unistd.h>

#include <jpeglib.h> // which needs stdio.h

static void must( int ok )
{
    if ( !ok )
        abort();
}

static uint8_t* write_png( png_uint_32 format, int width, int height, const void* pixels, size_t* size )
{
    png_image image = {
        .version = PNG_IMAGE_VERSION, .width = (png_uint_32)width, .height = (png_uint_32)height, .format = format
    };
    png_alloc_size_t bytes = 0;
    must( png_image_write_to_memory( &image, NULL, &bytes, 0, pixels, 0, NULL ) );
    uint8_t* out = malloc( bytes );
    must( out != NULL && png_image_write_to_memory( &image, out, &bytes, 0, pixels, 0, NULL ) );
    *size = bytes;
    return out;
}

uint8_t* encode_png( int width, int height, int channels, const uint8_t* pixels, size_t* size )
{
    static const png_uint_32 formats[] = { PNG_FORMAT_GRAY, PNG_FORMAT_GA, PNG_FORMAT_RGB, PNG_FORMAT_RGBA };
    return write_png( formats[channels - 1], width, height, pixels, size );
}

uint8_t* encode_png16( int width, int height, int channels, const uint16_t* pixels, size_t* size )
{
    return write_png( channels == 1 ? PNG_FORMAT_LINEAR_Y : PNG_FORMAT_LINEAR_RGB, width, height, pixels, size );
}

uint8_t* encode_jpeg( int width, int height, int channels, const uint8_t* pixels, size_t* size )
{
    struct jpeg_compress_struct jpeg;
    struct jpeg_error_mgr handlers;
    jpeg.err = jpeg_std_error( &handlers );
    jpeg_create_compress( &jpeg );
    uint8_t* out = NULL;
    unsigned long bytes = 0;
    jpeg_mem_dest( &jpeg, &out, &bytes );
    jpeg.image_width = (JDIMENSION)width;
    jpeg.image_height = (JDIMENSION)height;
    jpeg.input_components = channels;
    jpeg.in_color_space = channels == 1 ? JCS_GRAYSCALE : channels == 3 ? JCS_RGB : JCS_CMYK;
    jpeg_set_defaults( &jpeg );
    jpeg_set_quality( &jpeg, 100, TRUE );
    jpeg.comp_info[0].h_samp_factor = jpeg.comp_info[0].v_samp_factor = 1;
    jpeg_start_compress( &jpeg, TRUE );
    for ( int y = 0; y < height; ++y )
    {
        JSAMPROW row = (JSAMPROW)( pixels + (size_t)y * (size_t)width * (size_t)channels );
        jpeg_write_scanlines( &jpeg, &row, 1 );
    }
    jpeg_finish_compress( &jpeg );
    jpeg_destroy_compress( &jpeg );
    *size = bytes;
    return out;
}

#ifdef REFRAME_WEBP

#include <webp/encode.h>

uint8_t* encode_webp( int width, int height, int channels, bool lossy, const uint8_t* pixels, size_t* size )
{
    int stride = width * channels;
    uint8_t* coded = NULL;
    if ( lossy )
        *size = channels == 3 ? WebPEncodeRGB( pixels, width, height, stride, 100.0f, &coded )
                              : WebPEncodeRGBA( pixels, width, height, stride, 100.0f, &coded );
    else
        *size = channels == 3 ? WebPEncodeLosslessRGB( pixels, width, height, stride, &coded )
                              : WebPEncodeLosslessRGBA( pixels, width, height, stride, &coded );
    uint8_t* out = malloc( *size + 1 );
    must( *size > 0 && out != NULL );
    memcpy( out, coded, *size );
    WebPFree( coded );
    return out;
}

#endif

uint8_t* encode_hdr( int width, int height, const uint8_t* rgbe, size_t* size )
{
    size_t room = 128 + (size_t)height * ( 4 + 6 * (size_t)width );
    uint8_t* out = malloc( room );
    must( out != NULL );
    size_t at = (size_t)sprintf( (char*)out, "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y %d +X %d\n", height, width );
    for ( int y = 0; y < height; ++y, rgbe += 4 * width )
    {
        if ( width < 8 )
        {
            memcpy( out + at, rgbe, 4 * (size_t)width );
            at += 4 * (size_t)width;
            continue;
        }
        uint8_t head[4] = { 2, 2, (uint8_t)( width >> 8 ), (uint8_t)width };
        memcpy( out + at, head, 4 );
        at += 4;
        for ( int c = 0; c < 4; ++c )
        {
            for ( int x = 0; x < width; ++x )
            {
                if ( x % 100 == 0 )
                    out[at++] = (uint8_t)( width - x < 100 ? width - x : 100 );
                out[at++] = rgbe[4 * x + c];
            }
        }
    }
    *size = at;
    return out;
}

uint8_t* encode_exr( int width, int height, float* rgb, size_t* size )
{
    char path[] = "/tmp/reframe-exr-XXXXXX";
    int file = mkstemp( path );
    must( file >= 0 );
    close( file );
    RfImage image = { width, height, rgb };
    RfExrOptions options = rf_default_exr_options();
    options.half = false;
    uint8_t* bytes = NULL;
    must( rf_write_exr( path, &image, &options, NULL ) == RF_OK && rf_read_file( path, 1 << 20, &bytes, size, NULL ) == RF_OK );
    unlink( path );
    return bytes;
}

size_t promise_png( uint8_t bytes[64], uint32_t width, uint32_t height )
{
    memcpy( bytes, "\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16 );
    for ( int i = 0; i < 4; ++i )
    {
        bytes[16 + i] = (uint8_t)( width >> ( 24 - 8 * i ) );
        bytes[20 + i] = (uint8_t)( height >> ( 24 - 8 * i ) );
    }
    memcpy( bytes + 24, "\x08\x06\0\0", 5 );
    uint32_t crc = 0xffffffffu;
    for ( int i = 12; i < 29; ++i )
    {
        crc ^= bytes[i];
        for ( int k = 0; k < 8; ++k )
            crc = crc >> 1 ^ ( crc & 1 ? 0xedb88320u : 0 );
    }
    crc = ~crc;
    for ( int i = 0; i < 4; ++i )
        bytes[29 + i] = (uint8_t)( crc >> ( 24 - 8 * i ) );
    memcpy( bytes + 33, "\0\0\0\x10IDAT\x78\x9c", 10 );
    return 43;
}

// ---- foreign exr ----

static void encode( exr_context_t context, int part, const Foreign* foreign, const exr_chunk_info_t* chunk )
{
    exr_encode_pipeline_t pipeline = EXR_ENCODE_PIPELINE_INITIALIZER;
    assert_int_equal( exr_encoding_initialize( context, part, chunk, &pipeline ), EXR_ERR_SUCCESS );
    static float lines[6][1024];
    for ( int c = 0; c < pipeline.channel_count; ++c )
    {
        assert_in_range( pipeline.channels[c].width * pipeline.channels[c].height, 1, 1024 );
        for ( int i = 0; i < 1024; ++i )
            lines[c][i] = foreign->values[c];
        pipeline.channels[c].encode_from_ptr = (const uint8_t*)lines[c];
        pipeline.channels[c].user_data_type = EXR_PIXEL_FLOAT;
        pipeline.channels[c].user_bytes_per_element = 4;
        pipeline.channels[c].user_pixel_stride = 4;
        pipeline.channels[c].user_line_stride = 4 * pipeline.channels[c].width;
    }
    assert_int_equal( exr_encoding_choose_default_routines( context, part, &pipeline ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_encoding_run( context, part, &pipeline ), EXR_ERR_SUCCESS );
    exr_encoding_destroy( context, &pipeline );
}

static void add_part( exr_context_t context, const Foreign* foreign )
{
    int index;
    const exr_attr_v2f_t center = { .x = 0.0f, .y = 0.0f };
    const exr_attr_box2i_t display = { .min = { .x = 0, .y = 0 }, .max = { .x = 63, .y = 63 } };
    const exr_attr_box2i_t data = { .min = { .x = foreign->x, .y = foreign->y },
                                    .max = { .x = foreign->x + foreign->width - 1, .y = foreign->y + foreign->height - 1 } };
    const char* name = foreign->part != NULL ? foreign->part : "one";
    assert_int_equal( exr_add_part( context, name, EXR_STORAGE_SCANLINE, &index ), EXR_ERR_SUCCESS );
    assert_int_equal( exr_initialize_required_attr( context, index, &display, &data, 1.0f, &center, 1.0f,
                                                    EXR_LINEORDER_INCREASING_Y, EXR_COMPRESSION_ZIP ),
                      EXR_ERR_SUCCESS );
    for ( int c = 0; c < 6 && foreign->names[c] != NULL; ++c )
        assert_int_equal( exr_add_channel( context, index, foreign->names[c], foreign->half ? EXR_PIXEL_HALF : EXR_PIXEL_FLOAT,
                                           EXR_PERCEPTUALLY_LINEAR, 1, 1 ),
                          EXR_ERR_SUCCESS );
}

void write_foreign_exr( const char* path, const Foreign* parts, int count )
{
    exr_context_t context = NULL;
    assert_int_equal( exr_start_write( &context, path, EXR_WRITE_FILE_DIRECTLY, NULL ), EXR_ERR_SUCCESS );
    for ( int i = 0; i < count; ++i )
        add_part( context, parts + i );
    assert_int_equal( exr_write_header( context ), EXR_ERR_SUCCESS );
    for ( int i = 0; i < count; ++i )
    {
        int lines;
        assert_int_equal( exr_get_scanlines_per_chunk( context, i, &lines ), EXR_ERR_SUCCESS );
        for ( int y = 0; y < parts[i].height; y += lines )
        {
            exr_chunk_info_t chunk;
            assert_int_equal( exr_write_scanline_chunk_info( context, i, parts[i].y + y, &chunk ), EXR_ERR_SUCCESS );
            encode( context, i, parts + i, &chunk );
        }
    }
    assert_int_equal( exr_finish( &context ), EXR_ERR_SUCCESS );
}
