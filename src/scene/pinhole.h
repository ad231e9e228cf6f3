// The pinhole camera model: rays through the film, projection onto it, and the film
// density J of a surface point (src/reuse/estimators.md, notation). Everything that
// knows how a camera maps points to pixels is here. Branch-free, for loops over lanes.
#ifndef REFRAME_SCENE_PINHOLE_H
#define REFRAME_SCENE_PINHOLE_H

#include "base/fault.h"
#include "scene/eye.h"

#include <float.h>
#include <stdint.h>

// Where all rays of a camera start.
static inline RfVec3 rf_pinhole_origin( const RfEye* eye ) { return eye->origin; }

// Distance of x from the camera along the viewing direction, metres; negative behind it.
static inline float rf_pinhole_depth( const RfEye* eye, RfVec3 x )
{
    return rf_dot( rf_sub( x, rf_pinhole_origin( eye ) ), eye->forward );
}

// Unit direction of the camera ray through film position (column + u, row + v), with u to the
// right and v down in [0, 1). `inverse` is 1 / eye->focal_x and 1 / eye->focal.
static inline RfVec3 rf_pinhole_ray( const RfEye* eye, const float inverse[2], int column, int row, float u, float v )
{
    float fx = ( (float)column + u - eye->axis_x ) * inverse[0];
    float fy = ( eye->axis_y - (float)row - v ) * inverse[1];
    RfVec3 d = rf_madd( rf_madd( eye->forward, eye->right, fx ), eye->up, fy );
    return rf_scale( d, 1.0f / sqrtf( rf_dot( d, d ) ) );
}

// A divisor that is not 0. What lies in the plane of the camera is not seen, whatever the quotient.
static inline float rf_pinhole_divisor( float depth, float instead )
{
    return depth != 0.0f || RF_FAULT( density_divisor ) ? depth : instead;
}

// Where a direction from the camera (any length) meets the film: pixels from its centre, +x right, +y up.
// Returns its part along the viewing direction; the position means nothing unless that is above 0.
static inline float rf_pinhole_position( const RfEye* eye, RfVec3 direction, float at[2] )
{
    float depth = rf_dot( direction, eye->forward ), ahead = rf_pinhole_divisor( depth, 1.0f );
    at[0] = rf_dot( direction, eye->right ) * ( eye->focal_x / ahead ) + ( eye->axis_x - 0.5f * (float)eye->width );
    at[1] = rf_dot( direction, eye->up ) * ( eye->focal / ahead ) + ( 0.5f * (float)eye->height - eye->axis_y );
    return depth;
}

typedef struct RfProjection
{
    int32_t x, y;  // pixel; meaningless unless inside
    float density; // J_k(x) in px²/m², clamped to [RF_MIN_DENSITY, RF_MAX_DENSITY]
    float u, v;    // place in it, 0 to 1
    int seen;      // in front of the camera, inside its film, on the side of the surface that faces it
} RfProjection;

// Ratios of densities must stay finite where a surface is seen edge-on or
// touches the camera: at 1e-15 focal lengths, which rooms of 1e-12 m do not reach.
#define RF_MIN_DENSITY 1e-24f // 1e-12 of it, left behind blended surfaces, is above 0 as well
#define RF_MAX_DENSITY 1e30f

// Projects the hit x with unit geometric normal ng, on the side it was hit from.
// J = f² cosθx / (d² cos³θk), where f² is the product of both focal lengths of a film whose pixels are
// not square; with v = x − o, cosθx = −v·ng/d and cosθk = v·forward/d that is
// f² (−v·ng) / (v·forward)³: no root needed. A shifted lens changes nothing of it.
static inline RfProjection rf_project( const RfEye* eye, RfVec3 x, RfVec3 ng )
{
    RfVec3 v = rf_sub( x, rf_pinhole_origin( eye ) );
    float depth = rf_dot( v, eye->forward ), facing = -rf_dot( v, ng );
    depth = RF_FAULT( behind_the_eye ) ? fabsf( depth ) : depth;
    facing = RF_FAULT( sides ) ? fabsf( facing ) : facing;
    float ahead = rf_pinhole_divisor( depth, 1.0f );
    float fx = eye->axis_x + rf_dot( v, eye->right ) * ( eye->focal_x / ahead );
    float fy = eye->axis_y - rf_dot( v, eye->up ) * ( eye->focal / ahead );
    float depth2 = RF_FAULT( cubed_cosine ) ? rf_dot( v, v ) : depth * depth;
    float density = eye->focal_x * eye->focal * facing / rf_pinhole_divisor( depth2 * depth, FLT_MIN );
    density = density > RF_MIN_DENSITY || RF_FAULT( least_density ) ? density : RF_MIN_DENSITY;
    density = density < RF_MAX_DENSITY || RF_FAULT( largest_density ) ? density : RF_MAX_DENSITY;
    int on_film = ( fx >= 0.0f ) & ( fx < (float)eye->width ) & ( fy >= 0.0f ) & ( fy < (float)eye->height );
    int seen = ( depth > 0.0f ) & ( facing > 0.0f ) & ( on_film | RF_FAULT( film_place ) );
    // converted inside the film only: outside, the value may not fit an integer
    int32_t column = (int32_t)( seen ? fx : 0.0f ), row = (int32_t)( seen ? fy : 0.0f );
    return ( RfProjection ){ column, row, density, fx - (float)column, fy - (float)row, seen };
}

#endif
