// Internal to image/decode.c: one decoder per format, each in its own file. They are called
// after the format has been recognised.
#ifndef REFRAME_IMAGE_DECODE_FORMATS_H
#define REFRAME_IMAGE_DECODE_FORMATS_H

#include "image/decode.h"

typedef struct RfEncoded
{
    const unsigned char* bytes;
    size_t size;
    const char* name;  // for messages
    bool header_alone; // rf_create_pixels ends the decoding with RF_ERROR_INTERRUPTED
} RfEncoded;

// Fails if the size of an image is out of bounds.
RfResult rf_check_sides( const RfEncoded* in, long long width, long long height, RfError* error );

// Checks the size (width and height as in the file) and allocates the data of `out`, whose
// other members are set.
RfResult rf_create_pixels( const RfEncoded* in, long long width, long long height, RfPixels* out, RfError* error );

RfResult rf_decode_png( const RfEncoded* in, RfPixels* out, RfError* error );
RfResult rf_decode_jpeg( const RfEncoded* in, RfPixels* out, RfError* error );
RfResult rf_decode_webp( const RfEncoded* in, RfPixels* out, RfError* error );
RfResult rf_decode_exr( const RfEncoded* in, RfPixels* out, RfError* error );
RfResult rf_decode_hdr( const RfEncoded* in, RfPixels* out, RfError* error );

#endif
