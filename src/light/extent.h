// Punctual lights with size, as seen from a point: a light sample draws where the light comes from anew. They remain deltas for
// MIS, since no ray hits them: what is drawn is one of a family of lights without size, whose mean is the light.
#ifndef REFRAME_LIGHT_EXTENT_H
#define REFRAME_LIGHT_EXTENT_H

#include "scene/scene.h"

typedef struct RfExtentSample
{
    RfVec3 wi;      // unit, towards the light
    float distance; // m, of the point of it; of a sun unset
    float weight;   // irradiance of a surface that faces it, over the intensity of the lamp, 1/m²; of a sun, over its
                    // irradiance. Cones of spots and ranges are left to the caller. 0: there is no light
} RfExtentSample;

// A point or a spot with a radius: of uniform radiance in all that is seen of a ball, or of a disc that faces `from`, which
// is drawn uniformly by solid angle. Within the ball it shines from all sides.
RfExtentSample rf_sample_ball( const RfPunctual* lamp, RfVec3 from, const float u[2] );

// A plane: its front has one radiance, times rf_spread_falloff. Uniform by solid angle in the part of the rectangle from which
// light arrives; of an ellipse, in the rectangle around it (Ureña, Fajardo and King, An area-preserving parametrization for
// spherical rectangles, 2013).
RfExtentSample rf_sample_plane( const RfPunctual* lamp, RfVec3 from, const float u[2] );

// A directional light with a radius: uniform by solid angle.
RfExtentSample rf_sample_sun( const RfPunctual* lamp, const float u[2] );

#endif
