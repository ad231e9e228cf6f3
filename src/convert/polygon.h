// Triangulates polygons in space.
#ifndef REFRAME_CONVERT_POLYGON_H
#define REFRAME_CONVERT_POLYGON_H

#include <stdint.h>

typedef enum RfCut
{
    RF_CUT_WHOLE,
    RF_CUT_CROSSED, // self-intersecting, no ear left: the rest became a fan
    RF_CUT_GIVEN_UP // ran out of steps
} RfCut;

// Triangulates a polygon of `count` ≥ 3 corners (indices into positions, 3 floats
// each) into count − 2 triangles of the same winding: as a fan if it is convex, else by
// ear clipping in the plane of its mean normal. Overwrites `corners`. Ear clipping takes
// up to count³ steps, which are subtracted from `*steps`; when these run out the
// triangles are invalid.
RfCut rf_cut_polygon( const float* positions, uint32_t* corners, uint32_t count, uint32_t* triangles, uint64_t* steps );

#endif
