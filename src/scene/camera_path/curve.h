// A smooth curve through keys in time: of points, of rotations, or of numbers.
//
// Smooth curves are Catmull-Rom splines with centripetal knots (the square root
// of the distance between keys, of rotations of the angle): they pass through
// every key and neither loop nor overshoot where keys lie close together. What
// the knots say of the shape, the times say of the pace: a monotone cubic leads
// from time to knot, so that the speed has no jumps, however unevenly the keys
// lie in time and space. Numbers are that monotone cubic itself and never leave
// the range of the keys beside them.
#ifndef REFRAME_SCENE_CAMERA_PATH_CURVE_H
#define REFRAME_SCENE_CAMERA_PATH_CURVE_H

#include "reframe/error.h"

#include <stdbool.h>

typedef enum RfCurveKind
{
    RF_CURVE_NUMBER = 1,
    RF_CURVE_POINT = 3,
    RF_CURVE_ROTATION = 4, // unit quaternions x y z w
} RfCurveKind;             // = numbers per key

typedef struct RfCurve
{
    RfCurveKind kind;
    bool linear;
    int count;      // keys; 0: there is no curve
    double* times;  // increasing
    double* values; // kind × count
    double* knots;  // of the smooth curve, by key
    double* slopes; // of the knots over time, by key
} RfCurve;

// Keys at increasing times. The values are copied; linear curves run straight
// (rotations by slerp) from key to key. Fails only for want of memory. Free
// with rf_destroy_curve.
RfResult rf_create_curve( RfCurveKind kind, bool linear, int count, const double* times, const double* values, RfCurve* curve,
                          RfError* error );
void rf_destroy_curve( RfCurve* curve );

// The value at a time; before the first and after the last key it stands still.
void rf_sample_curve( const RfCurve* curve, double time, double* value );

// The point, and its derivative, of a smooth or linear curve of points at a
// knot in [knots[segment], knots[segment + 1]].
void rf_curve_at_knot( const RfCurve* curve, int segment, double knot, double value[3], double derivative[3] );

#endif
