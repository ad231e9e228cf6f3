// Open Image Denoise (www.openimagedenoise.org) by the functions of its C interface, from a library that is loaded when it is wanted.
#ifndef REFRAME_DENOISE_OIDN_H
#define REFRAME_DENOISE_OIDN_H

#include "reframe/denoise.h"

// A picture to be denoised, 3 floats per pixel; albedo and normal may be NULL, the second only where the first is.
typedef struct RfOidnImages
{
    int width, height;
    const float *colour, *albedo, *normal;
    float scale; // of the colour, to about the brightness that the network was trained for
} RfOidnImages;

// Denoises `images` into `clean`.
RfResult rf_run_oidn( RfDenoiser* denoiser, const RfOidnImages* images, float* clean, RfError* error );

#endif
