// The weights of the cross-fitted solve.
#ifndef REFRAME_GRADIENT_RECONSTRUCT_INTERNAL_H
#define REFRAME_GRADIENT_RECONSTRUCT_INTERNAL_H

#include "reframe/reconstruct.h"

// Weights of the primal (a), dx and dy (b_x, b_y) from the variances of a half: inverse averages over 5x5 pixels
// without much brighter ones, bounded from above, in units of a typical one. The last column of b_x and the last
// row of b_y are 0. `scratch` are two floats per pixel.
void rf_weights_of_half( const RfGradientHalf* half, float* const scratch[2], float* a, float* b_x, float* b_y );

#endif
