// Images made by others, from bytes in memory: textures and environment maps.
// PNG by libpng, JPEG by libjpeg, EXR by OpenEXRCore, Radiance HDR by stb_image.
// What an image is says its first bytes, never its name.
#ifndef REFRAME_IMAGE_DECODE_H
#define REFRAME_IMAGE_DECODE_H

#include "reframe/error.h"

#include <stdbool.h>
#include <stddef.h>

// What is larger is refused before anything is allocated.
#define RF_DECODE_MAX_SIDE 16384
#define RF_DECODE_MAX_BYTES ( (size_t)1 << 31 )

// Rows from top to bottom, pixels interleaved: channel c at (x, y) is number
// channels (y·width + x) + c. 1 channel is grey, 2 grey and alpha, 3 RGB, 4
// RGB and alpha (not premultiplied). U8 and U16 are as in the file, whatever
// gamma or profile it names; FLOAT (EXR, HDR) is linear and may hold anything.
typedef struct RfPixels
{
    int width, height, channels;
    enum
    {
        RF_PIXELS_U8,
        RF_PIXELS_U16,
        RF_PIXELS_FLOAT
    } type;
    void* data; // of malloc
} RfPixels;

// Decodes a whole image. `name` begins the error line. Fails with
// RF_ERROR_FORMAT where the bytes are cut off or damaged, RF_ERROR_UNSUPPORTED
// for kinds that are not read (WebP, KTX2, …) and for images out of bounds,
// RF_ERROR_MEMORY. EXR gives its RGB alone.
RfResult rf_decode_image( const void* bytes, size_t size, const char* name, RfPixels* out, RfError* error );

// Frees the data and clears the struct.
void rf_destroy_pixels( RfPixels* pixels );

// The sRGB curve undone, for values of 0 to 1.
float rf_srgb_to_linear( float encoded );

// Reads a file of a lat-long image into linear RGB, 3 floats per pixel, freed
// by the caller with free(): EXR and HDR as they are, PNG and JPEG as sRGB.
// Values that are negative or not finite are refused with their pixel.
RfResult rf_load_environment_map( const char* path, int* width, int* height, float** rgb, RfError* error );

#endif
