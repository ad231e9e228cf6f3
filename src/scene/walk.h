// A curve through points, walked at constant speed: positions by arc length.
#ifndef REFRAME_SCENE_WALK_H
#define REFRAME_SCENE_WALK_H

#include "scene/curve.h"

typedef struct RfWalk
{
    RfCurve curve;   // of points; its times mean nothing
    int piece_count; // every segment is cut into as many pieces
    double* lengths; // of arc at the start of each piece, and at the end of all
    double length;   // of all, m
} RfWalk;

// `points` are 3 × count, count at least 2, neighbours apart. Fails for want of
// memory. Free with rf_destroy_walk.
RfResult rf_create_walk( bool linear, int count, const double* points, RfWalk* walk, RfError* error );
void rf_destroy_walk( RfWalk* walk );

// The point after `length` metres from the start; beyond the ends the walk goes
// straight on.
void rf_walk_at( const RfWalk* walk, double length, double point[3] );

#endif
