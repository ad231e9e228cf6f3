// Eyes (reframe/camera.h) and the arithmetic in doubles that makes them.
#ifndef REFRAME_SCENE_EYE_H
#define REFRAME_SCENE_EYE_H

#include "base/fault.h"
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

// rf_eye_matrices of an eye that is relative to an origin.
void rf_eye_matrices_around( const RfEye* eye, const double origin[3], float world_to_camera[16], float world_to_ndc[16] );

// Adds pixels to the film, x on the left and the right and y above and below: the same camera sees more. Below 0 they are
// taken off.
void rf_widen_eye( RfEye* eye, int x, int y );

// A length in pixels over what it spans. An eye whose extent is 0 or no number gets a focal length of 0, which renders refuse.
static inline float rf_pixels_over( double pixels, double extent )
{
    return extent < 0.0 || extent > 0.0 ? (float)( pixels / extent ) : 0.0f;
}

// What rf_cross3 would be in floats, for a fault of base/fault.h.
static inline void rf_cross3_in_floats( const double a[3], const double b[3], double out[3] )
{
    RfVec3 c = rf_cross( rf_vec3( (float)a[0], (float)a[1], (float)a[2] ), rf_vec3( (float)b[0], (float)b[1], (float)b[2] ) );
    out[0] = (double)c.x;
    out[1] = (double)c.y;
    out[2] = (double)c.z;
}

// rf_make_eye for camera.c, inline: as a plain call gcc 12 gives eyes that differ in the last bits, and
// all pictures rest on these.
static inline RfEye rf_make_eye_inline( RfVec3 origin, RfVec3 forward, RfVec3 up, double yfov, int width, int height )
{
    RfEye eye = { 0 };
    eye.origin = origin;
    double f[3] = { (double)forward.x, (double)forward.y, (double)forward.z };
    double u[3] = { (double)up.x, (double)up.y, (double)up.z }, r[3];
    rf_unit3( f );
    rf_cross3( f, u, r ); // in doubles: up may be nearly parallel to forward
    if ( RF_FAULT( eye_in_doubles ) )
        rf_cross3_in_floats( f, u, r );
    rf_unit3( r );
    rf_cross3( r, f, u );
    eye.forward = rf_vec3( (float)f[0], (float)f[1], (float)f[2] );
    eye.right = rf_vec3( (float)r[0], (float)r[1], (float)r[2] );
    eye.up = rf_vec3( (float)u[0], (float)u[1], (float)u[2] );
    eye.focal = eye.focal_x = rf_pixels_over( 0.5 * (double)height, tan( 0.5 * yfov ) );
    eye.axis_x = 0.5f * (float)width;
    eye.axis_y = 0.5f * (float)height;
    eye.width = width;
    eye.height = height;
    return eye;
}

#endif
