// Eyes (reframe/camera.h) and the arithmetic in doubles that makes them.
#ifndef REFRAME_SCENE_EYE_H
#define REFRAME_SCENE_EYE_H

#include "math/vec3.h"
#include "reframe/camera.h"

static inline void rf_cross3( const double a[3], const double b[3], double out[3] )
{
    out[0] = a[1] * b[2] - a[2] * b[1];
    out[1] = a[2] * b[0] - a[0] * b[2];
    out[2] = a[0] * b[1] - a[1] * b[0];
}

static inline void rf_unit3( double v[3] )
{
    double length = sqrt( v[0] * v[0] + v[1] * v[1] + v[2] * v[2] );
    for ( int i = 0; i < 3; ++i )
        v[i] = length > 0.0 ? v[i] / length : v[i];
}

#endif
