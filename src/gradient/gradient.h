// Gradient-domain path reusing as an estimator: tiles of pixels share their paths, and what the paths bring to
// neighbouring pixels differs little, so the differences of neighbours have little noise. The picture is
// reconstructed from the pixels and these differences (Bauszat, Petitjean, Eisemann, Gradient-Domain Path
// Reusing, 2017; Kettunen et al., Gradient-Domain Path Tracing, 2015). README.md has the details.
#ifndef REFRAME_GRADIENT_GRADIENT_H
#define REFRAME_GRADIENT_GRADIENT_H

#include "render/estimator.h"

extern const RfEstimator rf_gradient_estimator;

#endif
