// What light.c shares with light/group_lights.c. Internal to this folder.
#ifndef REFRAME_LIGHT_COLLECT_H
#define REFRAME_LIGHT_COLLECT_H

#include "light/changing.h"

// Sets the shape of a triangle light, by its corners.
void rf_shape_light( RfVec3 a, RfVec3 b, RfVec3 c, RfLight* light );

// Vose's alias table of `powers`, which sum to `total`. Fails with RF_ERROR_MEMORY.
RfResult rf_build_alias( RfLights* lights, const double* powers, double total, RfError* error );

// The radiance that the tables of a sky are made for.
static inline RfVec3 rf_sky_reference( const RfEnvironment* e )
{
    return rf_max_component( e->radiance ) > 0.0f ? e->radiance : rf_vec3( 1, 1, 1 );
}

#endif
