#include "image/decode.h"

#include "image/decode_formats.h"

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

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
    { "WEBP", 4, 8, NULL, "WebP" },
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

static size_t sample_size( const RfPixels* pixels )
{
    return pixels->type == RF_PIXELS_U8 ? 1 : pixels->type == RF_PIXELS_U16 ? 2 : sizeof( float );
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
    RfResult result = rf_check_sides( in, width, height, error );
    if ( result != RF_OK )
        return result;
    // at most 2^28 pixels of 16 bytes
    uint64_t bytes = (uint64_t)width * (uint64_t)height * (uint64_t)out->channels * sample_size( out );
    if ( bytes > RF_DECODE_MAX_BYTES )
        return rf_fail( error, RF_ERROR_UNSUPPORTED,
                        "%s: an image of %lldx%lld pixels takes %llu MiB, the limit is %llu: scale it down", in->name, width,
                        height, (unsigned long long)( bytes >> 20 ), (unsigned long long)( RF_DECODE_MAX_BYTES >> 20 ) );
    out->width = (int)width;
    out->height = (int)height;
    out->data = malloc( (size_t)bytes );
    if ( out->data == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: the system has no %llu MiB left to decode it into", in->name,
                        (unsigned long long)( bytes >> 20 ) );
    return RF_OK;
}

RfResult rf_decode_image( const void* bytes, size_t size, const char* name, RfPixels* out, RfError* error )
{
    memset( out, 0, sizeof *out );
    RfEncoded in = { bytes, size, name };
    for ( size_t i = 0; i < sizeof s_kinds / sizeof s_kinds[0]; ++i )
    {
        const Kind* kind = s_kinds + i;
        if ( size < kind->offset + kind->length || memcmp( in.bytes + kind->offset, kind->magic, kind->length ) != 0 )
            continue;
        if ( kind->decode == NULL )
            return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: %s images are not supported: store it as PNG, JPEG or EXR", name,
                            kind->name );
        RfResult result = kind->decode( &in, out, error );
        if ( result != RF_OK )
            rf_destroy_pixels( out );
        return result;
    }
    return rf_fail( error, RF_ERROR_FORMAT, "%s: not a PNG, JPEG, EXR or Radiance HDR image", name );
}
