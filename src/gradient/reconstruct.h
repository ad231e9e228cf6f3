// What the library does with gradients besides reframe/reconstruct.h: the weights of the
// cross-fitted solve.
#ifndef REFRAME_GRADIENT_RECONSTRUCT_H
#define REFRAME_GRADIENT_RECONSTRUCT_H

#include "reframe/reconstruct.h"

// Turns estimates of variances into weights: `variance` (width·height floats) is averaged over 5x5
// pixels, cut at the border, and inverted. `columns` and `rows` are those that count: width − 1 for
// dx, height − 1 for dy. Averages are bounded from below by `floor`, > 0.
void rf_weights_of_variance( int width, int height, int columns, int rows, const float* variance, float floor, float* weights );

#endif
