// Frames of noise and of motion for the tests of flicker.
#ifndef REFRAME_TESTS_FLICKER_FRAMES_H
#define REFRAME_TESTS_FLICKER_FRAMES_H

#include "measure/flicker.h"
#include "support/image_support.h"

enum
{
    WIDTH = 64,
    HEIGHT = 48,
    PIXELS = WIDTH * HEIGHT,
    VALUES = 3 * PIXELS
};

// Black and finite, without layers.
RfFlickerFrame make_frame( int number );

// A layer of so many channels that has the value everywhere; to be given to a frame or freed.
float* make_layer( int channels, float value );

// The same motion everywhere, pixels, +y up.
void set_motion( RfFlickerFrame* frame, float x, float y );

// Independent normal values, mean 0, deviation `scale`.
void fill_noise( RfFlickerFrame* frame, uint32_t seed, float scale );

RfFlickerSums measure( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate, bool has_error );
RfFlickerMetrics measured( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate, bool has_error );

void check_near( double value, double wanted, double tolerance );

#endif
