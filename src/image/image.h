// An RGB image of floats, linear Rec. 709, rows from top to bottom, pixels
// interleaved: value of channel c at (x, y) is rgb[3 (y·width + x) + c].
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

// Allocates a black image. Fails (RF_ERROR_MEMORY) where there is no room.
RfResult rf_create_image( int width, int height, RfImage* image, RfError* error );
void rf_destroy_image( RfImage* image );

#endif
