// Frame and tile reuse as an estimator: first hits are traced for all frames of a
// group, re-projected to the other cameras with a visibility test, and combined by
// multiple importance sampling (Méndez Feliu, Sbert, Szirmay-Kalos, Reusing Frames in
// Camera Animation, WSCG 2006), on top of sharing paths in tiles (Bekaert, Sbert, Halton,
// Accelerating Path Tracing by Re-Using Paths, EGWR 2002). The mathematics:
// src/reuse/estimators.md.
#ifndef REFRAME_REUSE_REUSE_H
#define REFRAME_REUSE_REUSE_H

#include "render/estimator.h"

extern const RfEstimator rf_reuse_estimator;

#endif
