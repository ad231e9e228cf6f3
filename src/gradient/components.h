// Pixels without any primal weight, whose level no gradient ties to a pixel that has some.
#ifndef REFRAME_GRADIENT_COMPONENTS_H
#define REFRAME_GRADIENT_COMPONENTS_H

#include "gradient/system.h"

#include <stdint.h>

// True if some pixel has no primal weight.
bool rf_lacks_primal( const RfGradientSystem* system );

// Labels pixels that gradients of weight > 0 connect: labels[i] is the first pixel of the component of i.
void rf_label_components( const RfGradientSystem* system, uint32_t* labels );

// Moves each component that has no primal weight, and whose level is thus not determined, so that the mean of u
// is that of `start`. `sums` are two doubles per pixel.
void rf_level_components( const RfGradientSystem* system, const uint32_t* labels, const float* start, float* u, double* sums );

#endif
