// What the tests of hard cases share: renders in many modes, and a check that the result
// is a picture.
#ifndef REFRAME_TESTS_HARD_CASES_H
#define REFRAME_TESTS_HARD_CASES_H

#include "support/render_support.h"
#include "support/scene_builder.h"

RfRenderSettings small_settings( int group, int spp );

// Renders the path with groups of one and of several frames, all weightings
// and normalisations. Fails where a pixel is NaN or infinite, or negative
// where the estimator cannot be (E2 can: it subtracts what the other half
// found, so it may only be negative where reuse is on). The scene is the
// caller's. Returns the mean radiance of plain path tracing.
double check_sane( const char* what, const RfScene* scene, const RfEye* eyes, int eye_count );

// The same with these settings, once.
double check_sane_settings( const char* what, const RfTracer* tracer, const RfEye* eyes, int eye_count,
                            const RfRenderSettings* settings );

#endif
