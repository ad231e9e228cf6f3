// PNG and JPEG in memory, for pictures that are made again and again, and PNG by the curves of view transforms.
#ifndef REFRAME_IMAGE_ENCODE_H
#define REFRAME_IMAGE_ENCODE_H

#include "reframe/image.h"

// What rf_write_png writes at exposure 0, compressed less and in a small part of the time. The caller frees *bytes, NULL on
// failure; `name` begins the message. Fails with RF_ERROR_MEMORY.
RfResult rf_encode_png( const char* name, const RfImage* image, unsigned char** bytes, size_t* size, RfError* error );

// Replaces `count` colours of scene-linear light by what is displayed, encoded, 0 to 1.
typedef void RfShowFn( const void* view, float* rgb, int count );

// rf_write_png_alpha with another curve than sRGB's.
RfResult rf_write_png_shown( const char* path, const RfImage* image, const float* alpha, RfShowFn* show, const void* view,
                             RfError* error );

#define RF_JPEG_MAX_SIDE 65500 // limit of libjpeg

// Encodes 8-bit RGB, rows from top to bottom, pixels interleaved, without chroma subsampling;
// `quality` is 1 to 100. The caller frees *bytes. `name` begins the error message. Fails with
// RF_ERROR_USAGE if the size is out of bounds, or RF_ERROR_MEMORY.
RfResult rf_encode_jpeg( const unsigned char* rgb, int width, int height, int quality, const char* name, unsigned char** bytes,
                         size_t* size, RfError* error );

#endif
