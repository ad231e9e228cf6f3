// An eye: a pinhole camera of one frame, in world space, with its film in
// pixels. Film coordinates: x to the right, y down, pixel (i, j) is the unit
// square [i, i+1) × [j, j+1).
#ifndef REFRAME_SCENE_EYE_H
#define REFRAME_SCENE_EYE_H

#include "math/vec3.h"

typedef struct RfEye
{
    RfVec3 origin;
    RfVec3 right, up, forward; // orthonormal
    float focal;               // f_k: focal length in pixels
    int width, height;         // film size in pixels
} RfEye;

// A right-handed eye that looks from `origin` along `forward`, with `up` made
// orthogonal to it; yfov in radians over the film's height. forward and up
// need not be unit but must not be parallel or zero.
static inline RfEye rf_make_eye( RfVec3 origin, RfVec3 forward, RfVec3 up, double yfov, int width, int height )
{
    RfEye eye;
    eye.origin = origin;
    eye.forward = rf_normalize( forward );
    eye.right = rf_normalize( rf_cross( eye.forward, up ) );
    eye.up = rf_cross( eye.right, eye.forward );
    eye.focal = (float)( 0.5 * (double)height / tan( 0.5 * yfov ) );
    eye.width = width;
    eye.height = height;
    return eye;
}

#endif
