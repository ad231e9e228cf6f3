// A tone-mapped 8-bit PNG, to look at. By libpng.
#ifndef REFRAME_IMAGE_PNG_H
#define REFRAME_IMAGE_PNG_H

#include "image/image.h"

// Multiplies by 2^exposure_stops, clips at 1, applies the sRGB curve. Written
// atomically like an EXR. NaN is written magenta, so that it shows.
RfResult rf_write_png( const char* path, const RfImage* image, float exposure_stops, RfError* error );

#endif
