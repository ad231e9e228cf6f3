// Internal to this folder: triangles that reach far beyond what is looked at, such as a ground of kilometres
// under a room. Embree's arithmetic in floats starts at vertex 0: hits have an error in proportion to their
// distance from it, unless the triangle is parallel to an axis plane. Where that is too much, hits are
// checked in doubles.
#ifndef REFRAME_TRACE_FAR_TRIANGLE_H
#define REFRAME_TRACE_FAR_TRIANGLE_H

#include "trace/trace.h"

// The largest coordinate of the median corner of a triangle, m: how far out most of the scene is.
float rf_median_reach( const RfTriangles* triangles );

// The error of hits, in scene units off the plane, beyond which a triangle is far: well above that of triangles
// within reach.
float rf_far_error( float reach );

// The scale of Embree's scene: its products of four lengths leave the range of floats below 1e-9 and above 1e9 m.
float rf_embree_scale( float reach );

// Whether hits on this triangle may have an error above far_error.
bool rf_is_far_triangle( const RfTriangles* triangles, uint32_t triangle, float far_error );

// The distance, in lengths of d, at which the ray crosses the plane of the triangle, in doubles; false if it
// runs parallel to it.
bool rf_cross_plane( const RfTriangleRecord* triangle, RfVec3 o, RfVec3 d, double* distance );

#endif
