// Checks of what a reconstruction is given.
#ifndef REFRAME_GRADIENT_CHECK_H
#define REFRAME_GRADIENT_CHECK_H

#include "reframe/reconstruct.h"

// Fails with RF_ERROR_USAGE where options are out of range, or do not go with the weights.
RfResult rf_check_reconstruct_options( const RfReconstructOptions* options, bool has_weights, RfError* error );

// Fails with RF_ERROR_USAGE where a weight is negative or not finite, or data that count are not finite.
// *scale is the power of two that brings the largest of the data near 1.
RfResult rf_check_gradients( const RfGradientImages* in, const RfGradientWeights* weights, float* scale, RfError* error );

// Fails with RF_ERROR_USAGE where one of width·height floats is negative or not finite; pixels of the last
// `skip_x` columns and `skip_y` rows do not count. `what` is for the message.
RfResult rf_check_plane( const float* plane, int width, int height, int skip_x, int skip_y, const char* what, RfError* error );

#endif
