// A curve through waypoints, parametrised by arc length for constant speed.
#ifndef REFRAME_SCENE_CAMERA_PATH_WAYPOINTS_H
#define REFRAME_SCENE_CAMERA_PATH_WAYPOINTS_H

#include "scene/camera_path/curve.h"

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
