// Inside of image/decode.c: one decoder per format, each in its own file. They
// are called with the format's first bytes already seen.
#ifndef REFRAME_IMAGE_DECODE_FORMATS_H
#define REFRAME_IMAGE_DECODE_FORMATS_H

#include "image/decode.h"

typedef struct RfEncoded
{
    const unsigned char* bytes;
    size_t size;
    const char* name; // for the error line
} RfEncoded;

// Fails where the sides of an image are out of bounds.
RfResult rf_check_sides( const RfEncoded* in, long long width, long long height, RfError* error );

// Checks the sizes and allocates the data of `out`, whose other members are
// set; width and height as the file has them.
RfResult rf_create_pixels( const RfEncoded* in, long long width, long long height, RfPixels* out, RfError* error );

RfResult rf_decode_png( const RfEncoded* in, RfPixels* out, RfError* error );
RfResult rf_decode_jpeg( const RfEncoded* in, RfPixels* out, RfError* error );
RfResult rf_decode_exr( const RfEncoded* in, RfPixels* out, RfError* error );
RfResult rf_decode_hdr( const RfEncoded* in, RfPixels* out, RfError* error );

#endif
