// WebP by libwebp: lossy, lossless, with alpha. A build without the library refuses it.
#include "base/try.h"
#include "image/decode_formats.h"

#ifdef REFRAME_WEBP

#include <webp/decode.h>

bool rf_decodes_webp( void ) { return true; }

static RfResult fail_status( const RfEncoded* in, VP8StatusCode status, RfError* error )
{
    switch ( status )
    {
        case VP8_STATUS_OUT_OF_MEMORY:
            return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory decoding the WebP image", in->name );
        case VP8_STATUS_NOT_ENOUGH_DATA:
        case VP8_STATUS_SUSPENDED: return rf_fail( error, RF_ERROR_FORMAT, "%s: the WebP image is truncated", in->name );
        case VP8_STATUS_UNSUPPORTED_FEATURE:
            return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: libwebp does not read this kind of WebP: store it as PNG",
                            in->name );
        default: return rf_fail( error, RF_ERROR_FORMAT, "%s: damaged WebP data", in->name );
    }
}

RfResult rf_decode_webp( const RfEncoded* in, RfPixels* out, RfError* error )
{
    WebPDecoderConfig config;
    if ( !WebPInitDecoderConfig( &config ) )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: this libwebp is not the one that Reframe was built with", in->name );
    VP8StatusCode status = WebPGetFeatures( in->bytes, in->size, &config.input );
    if ( status != VP8_STATUS_OK )
        return fail_status( in, status, error );
    if ( config.input.has_animation )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: animated WebP is not supported: store one of its images", in->name );
    out->type = RF_PIXELS_U8;
    out->channels = config.input.has_alpha ? 4 : 3;
    RF_TRY( rf_create_pixels( in, config.input.width, config.input.height, out, error ) );
    config.output.colorspace = config.input.has_alpha ? MODE_RGBA : MODE_RGB;
    config.output.is_external_memory = 1;
    config.output.u.RGBA.rgba = out->data;
    config.output.u.RGBA.stride = out->width * out->channels;
    config.output.u.RGBA.size = rf_pixels_bytes( out );
    status = WebPDecode( in->bytes, in->size, &config );
    return status == VP8_STATUS_OK ? RF_OK : fail_status( in, status, error );
}

#else

bool rf_decodes_webp( void ) { return false; }

RfResult rf_decode_webp( const RfEncoded* in, RfPixels* out, RfError* error )
{
    (void)out;
    return rf_fail( error, RF_ERROR_UNSUPPORTED,
                    "%s: this Reframe was built without libwebp, so that it reads no WebP: store it as PNG, JPEG or EXR",
                    in->name );
}

#endif
