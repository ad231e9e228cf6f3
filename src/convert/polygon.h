// Triangulates polygons in space.
#ifndef REFRAME_CONVERT_POLYGON_H
#define REFRAME_CONVERT_POLYGON_H

#include <stddef.h>
#include <stdint.h>

typedef enum RfCut
{
    RF_CUT_WHOLE,
    RF_CUT_CROSSED,  // self-intersecting: some triangles overlap
    RF_CUT_GIVEN_UP, // ran out of steps
    RF_CUT_NO_MEMORY,
} RfCut;

// Room for polygons that are cut one after another, all zero at first, and the steps that are left for them.
typedef struct RfCutter
{
    uint64_t steps;
    uint32_t room; // corners
    void* memory;
} RfCutter;

// Steps enough for about a second, and what each corner adds, so that no number of ordinary polygons exhausts them.
#define RF_CUT_STEPS ( (uint64_t)1 << 28 )
#define RF_CUT_STEPS_PER_CORNER 64

// Cuts a polygon of `count` ≥ 3 corners, indices into positions of 3 floats each, into count − 2 triangles of the same winding: as
// a fan if it is convex, else by ear clipping in the plane of its mean normal. Holes may be joined to the border by edges that run
// there and back. Where the steps run out the triangles are invalid.
RfCut rf_cut_polygon( const float* positions, const uint32_t* corners, uint32_t count, uint32_t* triangles, RfCutter* cutter );
void rf_free_cutter( RfCutter* cutter );

#endif
