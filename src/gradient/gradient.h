// Gradient-domain path reusing as an estimator: the pixels of a tile share paths, which bring similar light to
// neighbours, so the differences of neighbours have little noise. The image is reconstructed from pixels and
// differences (Bauszat, Petitjean, Eisemann, Gradient-Domain Path Reusing, 2017; Kettunen et al., Gradient-Domain
// Path Tracing, 2015). README.md has the details.
#ifndef REFRAME_GRADIENT_GRADIENT_H
#define REFRAME_GRADIENT_GRADIENT_H

#include "render/estimator.h"

extern const RfEstimator rf_gradient_estimator;

#endif
