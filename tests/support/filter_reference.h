// Pixel filters by their formulas, integrated numerically: the independent reference for those of the renderer.
#ifndef REFRAME_TESTS_FILTER_REFERENCE_H
#define REFRAME_TESTS_FILTER_REFERENCE_H

#include "reframe/render.h"

// The filter at x pixels from its centre, up to a factor.
double filter_value( RfFilter filter, double width, double x );

// Its integral from `from` to `to` pixels from its centre, by Simpson's rule, over that of the whole filter.
double filter_integral( RfFilter filter, double width, double from, double to );

// A picture of `times` as many pixels each way seen through the filter by a film of width x height pixels, 3 channels;
// at the film's border the filter is what is left of it there.
void filter_picture( RfFilter filter, double filter_width, const float* fine, int times, int width, int height, float* rgb );

#endif
