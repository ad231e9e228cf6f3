// Internal to this folder: triangles that reach far beyond what is looked at, such as a ground of kilometres under a room.
// Embree's arithmetic in floats starts at vertex 0, and hits have an error in proportion to their distance from it, unless the
// triangle is parallel to an axis plane. Where that is too much, hits are checked in doubles.
#ifndef REFRAME_TRACE_FAR_H
#define REFRAME_TRACE_FAR_H

#include "scene/placement.h"
#include "trace/trace.h"

// Embree takes the edges, their cross product N, and N·(p0 − o): at most 8 roundings of 2⁻²⁴ each.
#define RF_EMBREE_ERROR 5e-7f

// How far off its plane Embree may find a triangle that it starts `way` from vertex 0: the products in
// N·way, without their signs, over the length of N.
float rf_embree_error( RfVec3 e1, RfVec3 e2, RfVec3 way );

// Whether hits on this triangle may have an error above far_error. Of a mesh that is placed any of such an extent may have: what its
// corners add to the error where the matrix turns it is not known.
static inline bool rf_is_far_triangle( const RfTriangles* t, uint32_t triangle, float far_error, bool placed )
{
    RfVec3 p0 = rf_corner( t, triangle, 0 );
    RfVec3 e1 = rf_sub( rf_corner( t, triangle, 1 ), p0 ), e2 = rf_sub( rf_corner( t, triangle, 2 ), p0 );
    RfVec3 extent = { rf_maxf( fabsf( e1.x ), fabsf( e2.x ) ), rf_maxf( fabsf( e1.y ), fabsf( e2.y ) ),
                      rf_maxf( fabsf( e1.z ), fabsf( e2.z ) ) };
    // slivers have a large bound, but their area is small
    return rf_largest_coordinate( extent ) * 3.0f * RF_EMBREE_ERROR > far_error &&
           ( placed || rf_embree_error( e1, e2, extent ) > far_error );
}

// The distance, in lengths of d, at which the ray crosses the plane of the triangle, in doubles; false if it
// runs parallel to it.
bool rf_cross_plane( const RfTriangleRecord* t, RfVec3 o, RfVec3 d, double* distance );

#endif
