// JPEG into memory, by libjpeg(-turbo).
#ifndef REFRAME_IMAGE_JPEG_H
#define REFRAME_IMAGE_JPEG_H

#include "reframe/error.h"

#include <stddef.h>

#define RF_JPEG_MAX_SIDE 65500 // of the format, as libjpeg has it

// Encodes 8-bit RGB, rows from top to bottom, pixels interleaved, with the chroma at
// full size. `quality` goes from 1 to 100. The caller frees *bytes. `name` begins
// the error line. Fails with RF_ERROR_USAGE where a side is out of bounds,
// RF_ERROR_MEMORY.
RfResult rf_encode_jpeg( const unsigned char* rgb, int width, int height, int quality, const char* name, unsigned char** bytes,
                         size_t* size, RfError* error );

#endif
