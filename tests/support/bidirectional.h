// A plain bidirectional path tracer (Veach 1997), one path at a time: eye paths and light paths, one of each for each pixel
// and pass, connected in all ways, light paths with the eye too, with balance weights. A baseline for measurements, and a referee that
// shares only the points of surfaces with the tracers it is compared with.
#ifndef REFRAME_TESTS_BIDIRECTIONAL_H
#define REFRAME_TESTS_BIDIRECTIONAL_H

#include "scene/eye.h"
#include "trace/trace.h"

#include <stdint.h>

typedef struct BidirectionalSettings
{
    int spp;
    int max_depth; // surfaces on a path, the emitter's among them
    uint64_t seed;
} BidirectionalSettings;

// NULL, or what the scene has that is not dealt with: lights other than triangles, thin or rough glass, eyes with lenses and the like.
const char* bidirectional_lacks( const RfTracer* tracer, const RfEye* eye );

// The whole image by a box filter, 3 floats per pixel.
void bidirectional_image( const RfTracer* tracer, const RfEye* eye, const BidirectionalSettings* settings, float* rgb );

#endif
