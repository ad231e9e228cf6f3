// Light samples of punctual lights and of the environment.
#ifndef REFRAME_PATH_PUNCTUAL_ENVIRONMENT_H
#define REFRAME_PATH_PUNCTUAL_ENVIRONMENT_H

#include "path/lanes.h"

// The direction to the light, the unoccluded radiance, and the length of the shadow
// segment. A punctual light is a delta: its density is RF_DELTA_PDF, and its radiance has the same factor. Both are
// smaller by another factor where the radiance would exceed RF_MAX_PUNCTUAL_RADIANCE, which leaves room among the
// floats for scattering models and throughputs.
#define RF_MAX_PUNCTUAL_RADIANCE 1e32f

typedef struct RfPunctualEnvironmentSample
{
    RfVec3 wi, radiance; // of the sky: 1, to be looked up where nothing is in the way
    float pdf_solid_angle;
    float distance;
    bool sky;
} RfPunctualEnvironmentSample;

// Samples the light selected at `from`, which must not be a triangle. `u`: the
// numbers of the two dimensions after `dimension`; the sky uses their twins too.
RfPunctualEnvironmentSample rf_sample_punctual_environment( const RfLights* lights, RfLightSelection selection, RfRandomKey key,
                                                            uint32_t dimension, const float u[2], RfVec3 from );

#endif
