// What a punctual light sends into a direction and to a distance (KHR_lights_punctual): for light samples and for emitted rays.
#ifndef REFRAME_LIGHT_PUNCTUAL_H
#define REFRAME_LIGHT_PUNCTUAL_H

#include "scene/scene.h"

// Cosine from where the cone of a spot ends to where it is full, above 0.
static inline float rf_spot_blend( const RfPunctual* p ) { return rf_maxf( p->cos_inner - p->cos_outer, 1e-4f ); }

// The part of a spot's intensity in a direction with this cosine to its axis; 1 for other kinds.
static inline float rf_spot_falloff( const RfPunctual* p, float cos_axis )
{
    if ( p->kind != RF_PUNCTUAL_SPOT )
        return 1.0f;
    float t = rf_clampf( ( cos_axis - p->cos_outer ) / rf_spot_blend( p ), 0.0f, 1.0f );
    return t * t;
}

// A direction in the frame of a lamp that is turned.
static inline RfVec3 rf_into_lamp( const RfPunctual* p, RfVec3 d )
{
    RfVec3 up = rf_cross( p->across, p->direction );
    return rf_vec3( rf_dot( p->across, d ), rf_dot( up, d ), -rf_dot( p->direction, d ) );
}

// What the intensity of a point or spot light is multiplied by in a unit direction.
static inline float rf_lamp_falloff( const RfPunctual* p, RfVec3 direction )
{
    float falloff = rf_spot_falloff( p, rf_dot( p->direction, direction ) );
    return p->profile == NULL ? falloff : falloff * rf_profile_value( p->profile, rf_into_lamp( p, direction ) );
}

// Attenuation by range, as the text of KHR_lights_punctual recommends.
static inline float rf_range_falloff( float distance2, float range )
{
    float ratio2 = distance2 / ( range * range );
    return rf_clampf( 1.0f - ratio2 * ratio2, 0.0f, 1.0f );
}

// The part of a ball's light, of the same radius and intensity, that a disc has at a point that it turns to.
static inline float rf_soft_falloff( const RfPunctual* p, RfVec3 at )
{
    RfVec3 way = rf_sub( at, p->position );
    float d2 = rf_dot( way, way );
    return d2 > 0.0f ? d2 / ( d2 + p->radius * p->radius ) : 0.0f;
}

// The radiance of a plane at a cosine to its axis, over that without a spread: the part that passes a grid of slats along either
// side of the normal, scaled so that the flux is the same.
static inline float rf_spread_falloff( const RfPunctual* p, float cosine )
{
    if ( !( p->tan_spread > 0.0f ) )
        return 1.0f;
    float tangent = sqrtf( rf_maxf( 1.0f - cosine * cosine, 0.0f ) ) / rf_maxf( cosine, 1e-6f );
    return rf_maxf( p->tan_spread - tangent, 0.0f ) * p->spread_scale;
}

// The size of a plane, m².
static inline double rf_plane_area( const RfPunctual* p )
{
    return ( p->ellipse ? 3.14159265358979324 : 4.0 ) * (double)p->half[0] * (double)p->half[1];
}

static inline RfVec3 rf_plane_up( const RfPunctual* p ) { return rf_cross( p->across, p->direction ); }

#endif
