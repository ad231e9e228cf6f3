// Decodes images from memory: textures and environment maps, whose format is recognised by the first bytes.
#ifndef REFRAME_IMAGE_DECODE_H
#define REFRAME_IMAGE_DECODE_H

#include "image/colour.h"
#include "reframe/error.h"

// Larger images are rejected before anything is allocated.
#define RF_DECODE_MAX_SIDE 16384
#define RF_DECODE_MAX_BYTES ( (size_t)1 << 31 )

// Rows from top to bottom, pixels interleaved: channel c at (x, y) is element channels
// (y·width + x) + c. 1 channel is grey, 2 grey and alpha, 3 RGB, 4 RGB and alpha (not
// premultiplied). U8 and U16 hold the encoded values of the file; gamma and colour profiles
// are not applied. FLOAT (EXR, HDR) is linear and may hold any value, including NaN.
typedef struct RfPixels
{
    int width, height, channels;
    enum
    {
        RF_PIXELS_U8,
        RF_PIXELS_U16,
        RF_PIXELS_FLOAT
    } type;
    void* data;                    // allocated by malloc
    RfColourConversion conversion; // of colours to Rec. 709, which the user makes: normals and the like are none
} RfPixels;

// Decodes a whole image. `name` begins the error message. Fails with RF_ERROR_FORMAT if the
// data is truncated or damaged, RF_ERROR_UNSUPPORTED for formats that are not supported (KTX2,
// …) and for images that are too large, or RF_ERROR_MEMORY. Only RGB is read from EXR.
RfResult rf_decode_image( const void* bytes, size_t size, const char* name, RfPixels* out, RfError* error );

// Finds size and type of an image by its header alone: `out` has no data.
RfResult rf_measure_image( const void* bytes, size_t size, const char* name, RfPixels* out, RfError* error );

// Was this build made with libwebp?
bool rf_decodes_webp( void );

// Bytes of the values of an image.
size_t rf_pixels_bytes( const RfPixels* pixels );

void rf_destroy_pixels( RfPixels* pixels );

// Decodes and encodes an sRGB value, 0 to 1; light beyond is cut.
float rf_srgb_to_linear( float encoded );
float rf_linear_to_srgb( float light );

// Loads an equirectangular environment map as linear RGB, 3 floats per pixel, which the caller
// frees with free(). EXR and HDR are linear, all else is decoded from sRGB. Negative,
// infinite or NaN values are rejected; the message gives the pixel. What an EXR has in other primaries is converted to Rec. 709;
// *outside is the share of its light that is beyond these and lost.
RfResult rf_load_environment_map( const char* path, int* width, int* height, float** rgb, double* outside, RfError* error );

// The same from the bytes of a file; `name` begins the message.
RfResult rf_decode_environment_map( const void* bytes, size_t size, const char* name, int* width, int* height, float** rgb,
                                    double* outside, RfError* error );

#endif
