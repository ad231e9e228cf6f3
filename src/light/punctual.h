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

// Attenuation by range, as the text of KHR_lights_punctual recommends.
static inline float rf_range_falloff( float distance2, float range )
{
    float ratio2 = distance2 / ( range * range );
    return rf_clampf( 1.0f - ratio2 * ratio2, 0.0f, 1.0f );
}

#endif
