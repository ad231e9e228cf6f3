// Light samples from lights that are no triangles: without size, and the sky.
#ifndef REFRAME_PATH_PUNCTUAL_ENVIRONMENT_H
#define REFRAME_PATH_PUNCTUAL_ENVIRONMENT_H

#include "path/lanes.h"

// A light sample from a light that is no triangle: the direction to it, what
// arrives unless something is in the way, and the segment to test. A punctual
// light has all its density in one direction.
typedef struct RfPunctualEnvironmentSample
{
    RfVec3 wi, radiance;
    float pdf_solid_angle;
    float distance;
} RfPunctualEnvironmentSample;

// From the light picked at `from`; it must be no triangle. `place`: the numbers
// of the two dimensions after `dimension`, whose twins the sky draws besides.
RfPunctualEnvironmentSample rf_sample_punctual_environment( const RfLights* lights, RfLightSelection pick, RfRandomKey key,
                                                            uint32_t dimension, const float place[2], RfVec3 from );

#endif
