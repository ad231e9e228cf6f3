// A curve through points, walked at constant speed: positions by arc length.
#ifndef REFRAME_SCENE_CAMERA_PATH_WAYPOINTS_H
#define REFRAME_SCENE_CAMERA_PATH_WAYPOINTS_H

#include "scene/camera_path/curve.h"

typedef struct RfWaypoints
{
    RfCurve curve;   // of points; its times mean nothing
    int piece_count; // every segment is cut into as many pieces
    double* lengths; // of arc at the start of each piece, and at the end of all
    double length;   // of all, m
} RfWaypoints;

// `points` are 3 × count, count at least 2, neighbours apart. Fails for want of
// memory. Free with rf_destroy_waypoints.
RfResult rf_create_waypoints( bool linear, int count, const double* points, RfWaypoints* walk, RfError* error );
void rf_destroy_waypoints( RfWaypoints* walk );

// The point after `length` metres from the start; beyond the ends the walk goes
// straight on.
void rf_waypoint_position( const RfWaypoints* walk, double length, double point[3] );

#endif
