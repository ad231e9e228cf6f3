// Encodes JPEG in memory, by libjpeg(-turbo).
#ifndef REFRAME_IMAGE_JPEG_H
#define REFRAME_IMAGE_JPEG_H

#include "reframe/error.h"

#define RF_JPEG_MAX_SIDE 65500 // limit of libjpeg

// Encodes 8-bit RGB, rows from top to bottom, pixels interleaved, without chroma subsampling;
// `quality` is 1 to 100. The caller frees *bytes. `name` begins the error message. Fails with
// RF_ERROR_USAGE if the size is out of bounds, or RF_ERROR_MEMORY.
RfResult rf_encode_jpeg( const unsigned char* rgb, int width, int height, int quality, const char* name, unsigned char** bytes,
                         size_t* size, RfError* error );

#endif
