// Recognises image formats by their first bytes and decodes them to 8-bit or float pixels.
#include "image/decode.h"

#include "base/file.h"
#include "base/try.h"
#include "image/decode_formats.h"
#include "image/exr_stream.h"
#include "reframe/image.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static RfResult measure_exr( const RfEncoded* in, RfExrStream* stream, RfPixels* out, RfError* error )
{
    RfExrPart part;
    RF_TRY( rf_open_exr_part( stream, 0, &part, error ) );
    int width = part.width, height = part.height;
    rf_close_exr_part( &part );
    out->type = RF_PIXELS_FLOAT;
    out->channels = 3;
    return rf_create_pixels( in, width, height, out, error );
}

RfResult rf_decode_exr( const RfEncoded* in, RfPixels* out, RfError* error )
{
    RfExrStream stream = {
        .path = in->name,
        .fd = -1,
        .bytes = in->bytes,
        .size = in->size,
        .max_side = RF_DECODE_MAX_SIDE,
        .max_bytes = RF_DECODE_MAX_BYTES,
    };
    RfImage image;
    RfColourConversion conversion;
    if ( in->header_alone )
        return measure_exr( in, &stream, out, error );
    RF_TRY( rf_read_exr_stream( &stream, &image, &conversion, error ) );
    *out = ( RfPixels ){ .width = image.width,
                         .height = image.height,
                         .channels = 3,
                         .type = RF_PIXELS_FLOAT,
                         .data = image.rgb,
                         .conversion = conversion };
    return RF_OK;
}

typedef struct Kind
{
    const char* magic;
    size_t length, offset;
    RfResult ( *decode )( const RfEncoded* in, RfPixels* out, RfError* error ); // NULL: not supported
    const char* name;
} Kind;

static const Kind s_kinds[] = {
    { "\x89PNG\r\n\x1a\n", 8, 0, rf_decode_png, "PNG" },
    { "\xff\xd8\xff", 3, 0, rf_decode_jpeg, "JPEG" },
    { "\x76\x2f\x31\x01", 4, 0, rf_decode_exr, "EXR" },
    { "#?RADIANCE", 10, 0, rf_decode_hdr, "Radiance HDR" },
    { "#?RGBE", 6, 0, rf_decode_hdr, "Radiance HDR" },
    { "WEBP", 4, 8, rf_decode_webp, "WebP" },
    { "\xabKTX 20", 7, 0, NULL, "KTX2" },
    { "\xabKTX 11", 7, 0, NULL, "KTX" },
    { "DDS ", 4, 0, NULL, "DDS" },
    { "GIF8", 4, 0, NULL, "GIF" },
    { "II*\0", 4, 0, NULL, "TIFF" },
    { "MM\0*", 4, 0, NULL, "TIFF" },
    { "ftypavif", 8, 4, NULL, "AVIF" },
    { "BM", 2, 0, NULL, "BMP" },
};

void rf_destroy_pixels( RfPixels* pixels )
{
    free( pixels->data );
    memset( pixels, 0, sizeof *pixels );
}

size_t rf_pixels_bytes( const RfPixels* pixels )
{
    size_t sample = pixels->type == RF_PIXELS_U8 ? 1 : pixels->type == RF_PIXELS_U16 ? 2 : sizeof( float );
    return (size_t)pixels->width * (size_t)pixels->height * (size_t)pixels->channels * sample;
}

RfResult rf_check_sides( const RfEncoded* in, long long width, long long height, RfError* error )
{
    if ( width < 1 || height < 1 )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: an image of %lldx%lld pixels is not possible", in->name, width, height );
    if ( width > RF_DECODE_MAX_SIDE || height > RF_DECODE_MAX_SIDE )
        return rf_fail( error, RF_ERROR_UNSUPPORTED,
                        "%s: an image of %lldx%lld pixels is too large, the limit is %d per side: scale it down", in->name, width,
                        height, RF_DECODE_MAX_SIDE );
    return RF_OK;
}

RfResult rf_create_pixels( const RfEncoded* in, long long width, long long height, RfPixels* out, RfError* error )
{
    RF_TRY( rf_check_sides( in, width, height, error ) );
    out->width = (int)width;
    out->height = (int)height;
    uint64_t bytes = rf_pixels_bytes( out ); // at most 2^28 pixels of 16 bytes
    if ( bytes > RF_DECODE_MAX_BYTES )
        return rf_fail( error, RF_ERROR_UNSUPPORTED,
                        "%s: an image of %lldx%lld pixels takes %llu MiB, the limit is %llu: scale it down", in->name, width,
                        height, (unsigned long long)( bytes >> 20 ), (unsigned long long)( RF_DECODE_MAX_BYTES >> 20 ) );
    if ( in->header_alone )
        return RF_ERROR_INTERRUPTED;
    out->data = malloc( (size_t)bytes );
    if ( out->data == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory decoding it into %llu MiB", in->name,
                        (unsigned long long)( bytes >> 20 ) );
    return RF_OK;
}

static RfResult decode( RfEncoded in, RfPixels* out, RfError* error )
{
    const char* name = in.name;
    memset( out, 0, sizeof *out );
    for ( size_t i = 0; i < sizeof s_kinds / sizeof s_kinds[0]; ++i )
    {
        const Kind* kind = s_kinds + i;
        if ( in.size < kind->offset + kind->length || memcmp( in.bytes + kind->offset, kind->magic, kind->length ) != 0 )
            continue;
        if ( kind->decode == NULL )
            return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: %s images are not supported: store it as PNG, JPEG or EXR", name,
                            kind->name );
        RfResult result = kind->decode( &in, out, error );
        if ( result != RF_OK && !in.header_alone )
            rf_destroy_pixels( out );
        return result;
    }
    return rf_fail( error, RF_ERROR_FORMAT, "%s: not a PNG, JPEG, WebP, EXR or Radiance HDR image", name );
}

RfResult rf_decode_image( const void* bytes, size_t size, const char* name, RfPixels* out, RfError* error )
{
    return decode( ( RfEncoded ){ bytes, size, name, false }, out, error );
}

RfResult rf_measure_image( const void* bytes, size_t size, const char* name, RfPixels* out, RfError* error )
{
    RfResult result = decode( ( RfEncoded ){ bytes, size, name, true }, out, error );
    return result == RF_ERROR_INTERRUPTED ? RF_OK : result;
}

#define MAX_FILE_BYTES ( (uint64_t)2 << 30 )

float rf_srgb_to_linear( float encoded )
{
    return encoded <= 0.04045f ? encoded / 12.92f : powf( ( encoded + 0.055f ) / 1.055f, 2.4f );
}

float rf_linear_to_srgb( float light )
{
    float l = fminf( fmaxf( light, 0.0f ), 1.0f ); // NaN is 0
    return l <= 0.0031308f ? 12.92f * l : 1.055f * powf( l, 1.0f / 2.4f ) - 0.055f;
}

static float value_at( const RfPixels* pixels, size_t i )
{
    if ( pixels->type == RF_PIXELS_FLOAT )
        return ( (const float*)pixels->data )[i];
    return rf_srgb_to_linear( pixels->type == RF_PIXELS_U8 ? (float)( (const uint8_t*)pixels->data )[i] / 255.0f
                                                           : (float)( (const uint16_t*)pixels->data )[i] / 65535.0f );
}

#define MAX_RADIANCE 1e15f

static RfResult fill( const RfPixels* pixels, const char* path, float* rgb, RfError* error )
{
    bool grey = pixels->channels < 3;
    size_t width = (size_t)pixels->width, count = width * (size_t)pixels->height, channels = (size_t)pixels->channels;
    for ( size_t i = 0; i < count; ++i )
    {
        for ( size_t c = 0; c < 3; ++c )
        {
            float value = value_at( pixels, i * channels + ( grey ? 0 : c ) );
            // written so that NaN fails; brighter values would overflow floats in later products
            if ( !( value >= 0.0f && value <= MAX_RADIANCE ) )
                return rf_fail( error, RF_ERROR_FORMAT,
                                "%s: pixel (%zu, %zu) is %g, but light must be a number from 0 to %g: repair the image", path,
                                i % width, i / width, (double)value, (double)MAX_RADIANCE );
            rgb[3 * i + c] = value;
        }
    }
    return RF_OK;
}

// Converts to linear floats; takes ownership of the pixels.
static RfResult convert( RfPixels* pixels, const char* path, float** rgb, RfError* error )
{
    size_t count = (size_t)pixels->width * (size_t)pixels->height;
    *rgb = malloc( count * 3 * sizeof **rgb );
    RfResult result =
        *rgb != NULL ? fill( pixels, path, *rgb, error )
                     : rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for its pixels, %zu MiB", path, count * 12 >> 20 );
    if ( result == RF_OK )
        return RF_OK;
    free( *rgb );
    *rgb = NULL;
    return result;
}

RfResult rf_decode_environment_map( const void* bytes, size_t size, const char* name, int* width, int* height, float** rgb,
                                    double* outside, RfError* error )
{
    *outside = 0.0;
    *width = *height = 0;
    *rgb = NULL;
    RfPixels pixels;
    RF_TRY( rf_decode_image( bytes, size, name, &pixels, error ) );
    RfResult result = convert( &pixels, name, rgb, error );
    if ( result == RF_OK )
    {
        *width = pixels.width;
        *height = pixels.height;
        *outside = rf_convert_light( &pixels.conversion, *rgb, (size_t)pixels.width * (size_t)pixels.height, 3 );
    }
    rf_destroy_pixels( &pixels );
    return result;
}

RfResult rf_load_environment_map( const char* path, int* width, int* height, float** rgb, double* outside, RfError* error )
{
    *outside = 0.0;
    *width = *height = 0;
    *rgb = NULL;
    uint8_t* bytes;
    size_t size;
    RF_TRY( rf_read_file( path, MAX_FILE_BYTES, &bytes, &size, error ) );
    RfResult result = rf_decode_environment_map( bytes, size, path, width, height, rgb, outside, error );
    free( bytes );
    return result;
}

RfResult rf_create_image( int width, int height, RfImage* image, RfError* error )
{
    *image = ( RfImage ){ 0 };
    if ( width < 1 || height < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "an image of %dx%d pixels is not possible: width and height must be at least 1",
                        width, height );
    size_t pixels = (size_t)width * (size_t)height;
    float* rgb = pixels <= SIZE_MAX / ( 3 * sizeof( float ) ) ? calloc( pixels, 3 * sizeof( float ) ) : NULL;
    if ( rgb == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "an image of %dx%d pixels: out of memory, %.1f MiB more are needed", width,
                        height, 12.0 * (double)pixels / 1048576.0 );
    *image = ( RfImage ){ .width = width, .height = height, .rgb = rgb };
    return RF_OK;
}

void rf_destroy_image( RfImage* image )
{
    if ( image == NULL )
        return;
    free( image->rgb );
    *image = ( RfImage ){ 0 };
}
