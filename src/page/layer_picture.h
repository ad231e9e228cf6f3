// Pictures of AOVs: values to light that the page shows through the sRGB curve.
#ifndef REFRAME_PAGE_LAYER_PICTURE_H
#define REFRAME_PAGE_LAYER_PICTURE_H

#include <stddef.h>

typedef enum RfLook
{
    RF_LOOK_LIGHT,     // three channels as they are
    RF_LOOK_DEVIATION, // three channels of variance: their square roots
    RF_LOOK_NORMAL,    // three channels: (1 + n) / 2; black where there is none
    RF_LOOK_DEPTH,     // one channel: near is white, far dark, by the logarithm; nothing is black
    RF_LOOK_MOTION,    // two channels: red to the right, green up, grey at rest
    RF_LOOK_SHARE,     // one channel: the part of `high`
} RfLook;

// What black and white stand for: depth from low to high, motion and shares up to high.
typedef struct RfLookRange
{
    float low, high;
} RfLookRange;

// Channels that a look takes: 1, 2 or 3.
int rf_look_channels( RfLook look );

// The range of `pixels` pixels of interleaved values, `stride` floats apart.
RfLookRange rf_look_range( RfLook look, const float* values, size_t stride, size_t pixels );

// Draws them; three floats for each pixel.
void rf_draw_look( RfLook look, RfLookRange range, const float* values, size_t stride, size_t pixels, float* rgb );

#endif
