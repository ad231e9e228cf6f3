// An RGB image of floats, linear Rec. 709, rows from top to bottom, pixels interleaved:
// channel c at (x, y) is rgb[3 (y·width + x) + c].
#ifndef REFRAME_IMAGE_IMAGE_H
#define REFRAME_IMAGE_IMAGE_H

#include "reframe/error.h"

#include <stdbool.h>
#include <stddef.h>

typedef struct RfImage
{
    int width, height;
    float* rgb;
} RfImage;

// Allocates a black image. Fails with RF_ERROR_MEMORY.
RfResult rf_create_image( int width, int height, RfImage* image, RfError* error );

// Frees the pixels and clears the struct.
void rf_destroy_image( RfImage* image );

#endif
