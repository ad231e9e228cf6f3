// Depth of field and motion blur: a camera with a thin lens, and one that moves while its shutter is open,
// are means of pinholes (src/reuse/estimators.md, section 12).
#ifndef REFRAME_SCENE_LENS_H
#define REFRAME_SCENE_LENS_H

#include "scene/eye.h"

// A point of the lens and a moment of the shutter, three uniform numbers in [0, 1).
typedef struct RfLensSample
{
    float u, v, time;
} RfLensSample;

// A pinhole that stands still: the same for all samples.
static inline bool rf_is_sharp( const RfEye* eye ) { return eye->lens_radius <= 0.0f && !eye->moves; }

// Whether any of them has a lens, or moves while its shutter is open.
bool rf_any_blurred( const RfEye* eyes, int count );

// The point of the lens for two uniform numbers, in units of its radius, +x right, +y up: uniform over its area.
void rf_lens_point( const RfEye* eye, float u, float v, float point[2] );

// The pinhole at a point of the lens and a moment of the shutter: its film is sheared so that all of these see the points
// in focus in the same place.
RfEye rf_sample_eye( const RfEye* eye, RfLensSample sample );

#endif
