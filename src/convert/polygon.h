// Polygons in space as triangles.
#ifndef REFRAME_CONVERT_POLYGON_H
#define REFRAME_CONVERT_POLYGON_H

#include <stdint.h>

typedef enum RfCut
{
    RF_CUT_WHOLE,
    RF_CUT_CROSSED, // no ear was left, as it crosses itself: the rest is a fan
    RF_CUT_GIVEN_UP // no steps are left
} RfCut;

// Cuts the polygon of `count` ≥ 3 corners (numbers of positions, 3 floats each)
// into count − 2 triangles, 3 corners each, of the same sense: a fan where it
// is convex, else ear by ear, seen along its mean normal. `corners` is used up.
// Ears are found by trying, up to count³ steps: they are taken from `*steps`,
// and without any left the triangles are not to be used.
RfCut rf_cut_polygon( const float* positions, uint32_t* corners, uint32_t count, uint32_t* triangles, uint64_t* steps );

#endif
