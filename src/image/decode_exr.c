// EXR from memory, by the reader for files (exr_read.c).
#include "image/decode_formats.h"
#include "image/exr_stream.h"

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
    RfResult result = rf_read_exr_stream( &stream, &image, error );
    if ( result != RF_OK )
        return result;
    *out =
        ( RfPixels ){ .width = image.width, .height = image.height, .channels = 3, .type = RF_PIXELS_FLOAT, .data = image.rgb };
    return RF_OK;
}
