// Research: the biased weightings of the literature, for comparison (--weights eq15 and unweighted), in the place of the exact
// ones of rf_reuse_estimator. Both count a hit once in each frame in which it lands, instead of with the weight of (E1).
// `unweighted` divides the light of glossy hits by the density of their own camera, `eq15` by the mean density over the cameras
// whose hits landed in the pixel (Méndez Feliu, Sbert, Szirmay-Kalos, Reusing Frames in Camera Animation, WSCG 2006, equation
// 15).
#ifndef REFRAME_REUSE_BIASED_WEIGHTS_H
#define REFRAME_REUSE_BIASED_WEIGHTS_H

#include "render/estimator.h"

extern const RfEstimator rf_biased_estimator;

#endif
