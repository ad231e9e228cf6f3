// Scene values of a frame, for the pixel probe of the page: linear, as half floats. Pictures
// (page/picture.h) are close to them, but not exact.
//
// Layout, little-endian: factor, columns, rows (16 bits each); then columns · rows values of red,
// green and blue as half floats, interleaved, rows from top to bottom. A value is the mean of a box
// of factor × factor pixels, cropped at the right and lower border.
#ifndef REFRAME_PAGE_VALUES_H
#define REFRAME_PAGE_VALUES_H

#include "reframe/image.h"

#define RF_VALUES_HEADER_BYTES 6
#define RF_VALUES_MAX_FACTOR 64

// Encodes the image; the caller frees *bytes. Values are clamped to ±65504; NaN and infinity stay.
// `name` begins the message. Fails with RF_ERROR_MEMORY.
RfResult rf_encode_values( const RfImage* image, int factor, const char* name, unsigned char** bytes, size_t* size,
                           RfError* error );

// The bytes that an image takes on the page, as base64.
double rf_values_page_bytes( int width, int height, int factor );

// The smallest factor whose values take no more than `most` bytes of the page; 0: none does.
int rf_values_factor( int width, int height, double most );

#endif
