// Writes 8-bit PNGs for viewing, by libpng.
#ifndef REFRAME_IMAGE_PNG_H
#define REFRAME_IMAGE_PNG_H

#include "image/image.h"

// Multiplies by 2^exposure_stops, clips at 1 and applies the sRGB curve. NaN becomes magenta,
// so that it is noticed. Written atomically.
RfResult rf_write_png( const char* path, const RfImage* image, float exposure_stops, RfError* error );

#endif
