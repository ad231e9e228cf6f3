// Selection of a light, and a direction to the sky, for a single point.
#ifndef REFRAME_TESTS_SELECT_LIGHT_H
#define REFRAME_TESTS_SELECT_LIGHT_H

#include "light/light.h"

static inline RfLightSelection select_light( const RfLights* lights, RfLightSampling sampling, RfVec3 x, RfVec3 n,
                                             const uint32_t bits[2] )
{
    RfLightSelection selection;
    rf_select_lights( lights, sampling, 1, ( const float*[] ){ &x.x, &x.y, &x.z }, ( const float*[] ){ &n.x, &n.y, &n.z },
                      ( const uint32_t*[] ){ bits, bits + 1 }, &selection );
    return selection;
}

static inline RfSkySample sample_sky_direction_at( const RfSky* sky, RfVec3 n, const uint32_t bits[2], const float u[2] )
{
    RfSkySample sample = { .wi = n };
    const RfSkyLanes lane = { { &n.x, &n.y, &n.z },
                              { bits, bits + 1 },
                              { u, u + 1 },
                              { &sample.wi.x, &sample.wi.y, &sample.wi.z },
                              &sample.pdf_solid_angle };
    rf_sample_sky_directions( sky, 1, &lane );
    return sample;
}

#endif
