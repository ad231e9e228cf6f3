// Selection of a light for a single point.
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

#endif
