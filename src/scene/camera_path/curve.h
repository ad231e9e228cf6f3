// A smooth curve through keyframes of points, rotations or numbers.
//
// Smooth curves are Catmull-Rom splines with centripetal knots (spaced by the square root of
// the distance between keys; for rotations, of the angle). They pass through every key and
// neither loop nor overshoot between close keys. The knots determine the shape and the times
// the speed: a monotone cubic maps time to knot, so that the speed is continuous, however
// unevenly the keys are spaced. Numbers are interpolated by that monotone cubic directly and
// never leave the range of the neighbouring keys.
//
// Waypoints are a curve through points that is parametrised by arc length, for constant speed.
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
    int count;      // keys; 0: no curve
    double* times;  // increasing
    double* values; // kind × count
    double* knots;  // of a smooth curve, per key
    double* slopes; // derivative of the knot by time, per key
} RfCurve;

// Creates a curve from keys at increasing times; copies the values. Linear curves interpolate
// linearly (rotations by slerp). Fails only with RF_ERROR_MEMORY. Free with rf_destroy_curve.
RfResult rf_create_curve( RfCurveKind kind, bool linear, int count, const double* times, const double* values, RfCurve* curve,
                          RfError* error );

// Keys [first, first + count) as a curve of their own, which borrows the memory of `curve`; of no curve there is none.
RfCurve rf_part_of_curve( const RfCurve* curve, int first, int count );

// Gives keys [first, first + count) the shape that they have as a curve of their own.
void rf_part_curve( RfCurve* curve, int first, int count );

void rf_destroy_curve( RfCurve* curve );

// The last of the ascending values from the first to `last` that is not above `x`; the first where all are.
int rf_last_not_above( const double* values, int last, double x );

// The value at a time, clamped to the first and the last key.
void rf_sample_curve( const RfCurve* curve, double time, double* value );

// The point of a curve of points, and its derivative, at a knot in [knots[segment],
// knots[segment + 1]].
void rf_curve_at_knot( const RfCurve* curve, int segment, double knot, double value[3], double derivative[3] );

typedef struct RfWaypoints
{
    RfCurve curve;   // through the points; its times are unused
    int piece_count; // over all segments, which have equally many
    double* lengths; // arc length at the start of each piece, and at the end of the last
    double length;   // of the whole curve, m
} RfWaypoints;

// `points` holds 3 × count numbers, count ≥ 2, neighbours distinct. Fails only with
// RF_ERROR_MEMORY. Free with rf_destroy_waypoints.
RfResult rf_create_waypoints( bool linear, int count, const double* points, RfWaypoints* waypoints, RfError* error );

// Frees the curve and its lengths and clears the struct.
void rf_destroy_waypoints( RfWaypoints* waypoints );

// The point at arc length `length`, in metres; beyond the ends the curve is extended by
// straight lines.
void rf_waypoint_position( const RfWaypoints* waypoints, double length, double point[3] );

#endif
