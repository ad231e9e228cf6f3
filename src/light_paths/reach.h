// How far connections reach in what steers a chain: an ellipse around its start.
#ifndef REFRAME_LIGHT_PATHS_REACH_H
#define REFRAME_LIGHT_PATHS_REACH_H

#include "light/emission.h"

// In the plane of rf_basis of the direction: chords of the sphere of directions, or metres.
typedef struct RfReach
{
    float axis[2];       // unit, of `along`
    float along, across; // half the axes
} RfReach;

static inline float rf_reach_area( const RfReach* reach ) { return RF_PI * reach->along * reach->across; }

// The squared distance from its middle; 1: the edge.
static inline float rf_reach_squared( const RfReach* reach, float x, float y )
{
    float a = ( x * reach->axis[0] + y * reach->axis[1] ) / reach->along,
          b = ( y * reach->axis[0] - x * reach->axis[1] ) / reach->across;
    return a * a + b * b;
}

static inline RfReach rf_scaled_reach( const RfReach* reach, float scale )
{
    return ( RfReach ){ { reach->axis[0], reach->axis[1] }, scale * reach->along, scale * reach->across };
}

// The squared distance of a start from the middle. Of directions by Lambert's projection, which keeps areas.
static inline float rf_reach_to( const RfReach* reach, const RfEmission* middle, const RfEmission* e )
{
    RfVec3 t, b, apart = e->infinite ? rf_sub( e->position, middle->position ) : rf_sub( e->direction, middle->direction );
    rf_basis( middle->direction, &t, &b );
    float x = rf_dot( apart, t ), y = rf_dot( apart, b ), flat = sqrtf( x * x + y * y );
    float scale = e->infinite || !( flat > 0.0f ) ? 1.0f : rf_length( apart ) / flat;
    return rf_reach_squared( reach, scale * x, scale * y );
}

// A point of the ellipse, evenly for u and v from [0, 1): the chord from the middle, and its unit direction.
static inline RfVec3 rf_sample_reach( const RfReach* reach, RfVec3 direction, float u, float v, float* chord )
{
    RfVec3 t, b;
    float phi = 2.0f * RF_PI * v, a = reach->along * sqrtf( u ) * cosf( phi ), c = reach->across * sqrtf( u ) * sinf( phi );
    float x = a * reach->axis[0] - c * reach->axis[1], y = a * reach->axis[1] + c * reach->axis[0];
    *chord = sqrtf( a * a + c * c );
    float inverse = *chord > 0.0f ? 1.0f / *chord : 0.0f;
    rf_basis( direction, &t, &b );
    return rf_add( rf_scale( t, x * inverse ), rf_scale( b, y * inverse ) );
}

#endif
