// Polygons in space as triangles.
#ifndef REFRAME_CONVERT_POLYGON_H
#define REFRAME_CONVERT_POLYGON_H

#include <stdbool.h>
#include <stdint.h>

// Cuts the polygon of `count` ≥ 3 corners (numbers of positions, 3 floats each)
// into count − 2 triangles, 3 corners each, of the same sense: a fan where it
// is convex, else ear by ear, seen along its mean normal. `corners` is used up.
// False where no ear is left (it crosses itself): the rest becomes a fan then.
bool rf_cut_polygon( const float* positions, uint32_t* corners, uint32_t count, uint32_t* triangles );

#endif
