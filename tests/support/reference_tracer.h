// A plain path tracer, one path at a time, that knows nothing of wavefronts,
// groups, records or weights over eyes: the independent reference of the
// statistical tests, and what `--group 0` must equal bit for bit.
#ifndef REFRAME_TESTS_REFERENCE_TRACER_H
#define REFRAME_TESTS_REFERENCE_TRACER_H

#include "scene/eye.h"
#include "trace/trace.h"

#include <stdint.h>

typedef struct ReferenceSettings
{
    int spp;
    int max_depth;
    int light_samples;
    uint64_t seed;
    int frame; // of the path: it goes into the random numbers
    RfLightSampling light_sampling;
    bool panes_are_vertices; // thin panes scatter by their delta lobes and stop light samples, as other glass does
} ReferenceSettings;

// Mean radiance of one path through a pixel of one pass: frame, pass and pixel
// choose the random numbers as the renderer does without groups.
RfVec3 reference_sample( const RfTracer* tracer, const RfEye* eye, const ReferenceSettings* settings, int pass, int x, int y );

// The whole image, 3 floats per pixel: passes summed in two halves (even and
// odd ones), as the film does.
void reference_image( const RfTracer* tracer, const RfEye* eye, const ReferenceSettings* settings, float* rgb );

#endif
