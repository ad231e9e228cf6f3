// Re-projection of a hit to an eye: where on the film, and the film density
// J_k(x) there (src/reuse/estimators.md, notation). Branch-free, for loops over lanes.
#ifndef REFRAME_REUSE_PROJECT_H
#define REFRAME_REUSE_PROJECT_H

#include "scene/eye.h"

#include <stdint.h>

typedef struct RfProjection
{
    int32_t x, y;  // pixel; meaningless where not seen
    float density; // J_k(x) in px²/m², kept inside [RF_MIN_DENSITY, RF_MAX_DENSITY]
    int seen;      // in front of the eye, inside its film, on the side of the surface that faces it
} RfProjection;

// Ratios of densities must stay finite where a surface is seen edge-on or
// touches the eye.
#define RF_MIN_DENSITY 1e-18f
#define RF_MAX_DENSITY 1e18f

// x: the hit; ng: its unit geometric normal, on the side it was hit from.
// J = f² cosθx / (d² cos³θk); with v = x − o, cosθx = −v·ng/d and
// cosθk = v·forward/d that is f² (−v·ng) / (v·forward)³: no root needed.
static inline RfProjection rf_project( const RfEye* eye, RfVec3 x, RfVec3 ng )
{
    RfVec3 v = rf_sub( x, eye->origin );
    float depth = rf_dot( v, eye->forward );
    float facing = -rf_dot( v, ng );
    float scale = eye->focal / depth;
    float fx = 0.5f * (float)eye->width + rf_dot( v, eye->right ) * scale;
    float fy = 0.5f * (float)eye->height - rf_dot( v, eye->up ) * scale;
    float density = eye->focal * eye->focal * facing / ( depth * depth * depth );
    density = density > RF_MIN_DENSITY ? density : RF_MIN_DENSITY; // also where it is not a number
    density = density < RF_MAX_DENSITY ? density : RF_MAX_DENSITY;
    int seen = ( depth > 0.0f ) & ( facing > 0.0f ) & ( fx >= 0.0f ) & ( fx < (float)eye->width ) & ( fy >= 0.0f ) &
               ( fy < (float)eye->height );
    // converted inside the film only: elsewhere the value need not fit an integer
    return ( RfProjection ){ (int32_t)( seen ? fx : 0.0f ), (int32_t)( seen ? fy : 0.0f ), density, seen };
}

#endif
