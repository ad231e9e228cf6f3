// What the library does with gradients besides reframe/reconstruct.h: the weights of the
// cross-fitted solve.
#ifndef REFRAME_GRADIENT_RECONSTRUCT_H
#define REFRAME_GRADIENT_RECONSTRUCT_H

#include "reframe/reconstruct.h"

// Weights of the primal (a) and of dx and dy (b_x, b_y) from the variances of a half: inverses of averages over
// 5x5 pixels, cut at the border, but of those much brighter, bounded from above, in a unit in which a typical one is 1. The
// last column of b_x and the last row of b_y are 0. `scratch` are two floats per pixel.
void rf_weights_of_half( const RfGradientHalf* half, float* const scratch[2], float* a, float* b_x, float* b_y );

#endif
