#include "scene/camera_path/waypoints.h"

#include <math.h>
#include <stdlib.h>

// Pieces per segment, and the number of iterations to find a length within a piece: within
// 1/32 of a segment the speed of a cubic changes too little to need more.
#define PIECES 32
#define STEPS 40

static double speed_at( const RfWaypoints* walk, int segment, double knot )
{
    double point[3], d[3];
    rf_curve_at_knot( &walk->curve, segment, knot, point, d );
    return sqrt( d[0] * d[0] + d[1] * d[1] + d[2] * d[2] );
}

// Arc length between two knots of a segment, by Gauss-Legendre quadrature.
static double arc_length( const RfWaypoints* walk, int segment, double from, double to )
{
    static const double s_at[5] = { 0.0, 0.5384693101056831, -0.5384693101056831, 0.9061798459386640, -0.9061798459386640 };
    static const double s_weight[5] = { 0.5688888888888889, 0.4786286704993665, 0.4786286704993665, 0.2369268850561891,
                                        0.2369268850561891 };
    double middle = 0.5 * ( from + to ), half = 0.5 * ( to - from ), sum = 0.0;
    for ( int i = 0; i < 5; ++i )
        sum += s_weight[i] * speed_at( walk, segment, middle + half * s_at[i] );
    return half * sum;
}

static double piece_knot( const RfWaypoints* walk, int segment, int piece )
{
    double from = walk->curve.knots[segment], to = walk->curve.knots[segment + 1];
    return piece == PIECES ? to : from + ( to - from ) * (double)piece / PIECES;
}

static RfResult make_curve( RfWaypoints* walk, bool linear, int count, const double* points, RfError* error )
{
    double* times = malloc( (size_t)count * sizeof *times );
    if ( times == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for a walk of %d points", count );
    for ( int i = 0; i < count; ++i )
        times[i] = (double)i;
    RfResult result = rf_create_curve( RF_CURVE_POINT, linear, count, times, points, &walk->curve, error );
    free( times );
    return result;
}

RfResult rf_create_waypoints( bool linear, int count, const double* points, RfWaypoints* walk, RfError* error )
{
    *walk = ( RfWaypoints ){ 0 };
    RfResult result = make_curve( walk, linear, count, points, error );
    if ( result != RF_OK )
        return result;
    walk->piece_count = ( count - 1 ) * PIECES;
    walk->lengths = malloc( ( (size_t)walk->piece_count + 1 ) * sizeof *walk->lengths );
    if ( walk->lengths == NULL )
    {
        rf_destroy_waypoints( walk );
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for a walk of %d points", count );
    }
    for ( int i = 0; i < walk->piece_count; ++i )
    {
        int segment = i / PIECES, piece = i % PIECES;
        walk->lengths[i] = walk->length;
        walk->length += arc_length( walk, segment, piece_knot( walk, segment, piece ), piece_knot( walk, segment, piece + 1 ) );
    }
    walk->lengths[walk->piece_count] = walk->length;
    return RF_OK;
}

void rf_destroy_waypoints( RfWaypoints* walk )
{
    rf_destroy_curve( &walk->curve );
    free( walk->lengths );
    *walk = ( RfWaypoints ){ 0 };
}

static int find_piece( const RfWaypoints* walk, double length )
{
    int low = 0, high = walk->piece_count - 1;
    while ( low < high )
    {
        int middle = low + ( high - low + 1 ) / 2;
        if ( walk->lengths[middle] <= length )
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

// The knot at arc length `length` from the start of a piece: Newton's method, with bisection
// when it leaves the bracket.
static double find_knot( const RfWaypoints* walk, int segment, double from, double to, double length, double whole )
{
    double low = from, high = to;
    double knot = whole > 0.0 ? from + ( to - from ) * fmin( length / whole, 1.0 ) : from;
    for ( int i = 0; i < STEPS; ++i )
    {
        double excess = arc_length( walk, segment, from, knot ) - length;
        if ( fabs( excess ) <= 1e-12 * walk->length )
            break;
        if ( excess > 0.0 )
            high = knot;
        else
            low = knot;
        double speed = speed_at( walk, segment, knot );
        double next = speed > 0.0 ? knot - excess / speed : low;
        knot = next > low && next < high ? next : 0.5 * ( low + high );
    }
    return knot;
}

static void go_straight_on( const RfWaypoints* walk, int segment, double knot, double by, double point[3] )
{
    double d[3];
    rf_curve_at_knot( &walk->curve, segment, knot, point, d );
    double length = sqrt( d[0] * d[0] + d[1] * d[1] + d[2] * d[2] );
    for ( int i = 0; i < 3 && length > 0.0; ++i )
        point[i] += by * d[i] / length;
}

void rf_waypoint_position( const RfWaypoints* walk, double length, double point[3] )
{
    int last = walk->curve.count - 2;
    if ( !( length > 0.0 ) )
    {
        go_straight_on( walk, 0, walk->curve.knots[0], length, point );
        return;
    }
    if ( length >= walk->length )
    {
        go_straight_on( walk, last, walk->curve.knots[last + 1], length - walk->length, point );
        return;
    }
    int piece = find_piece( walk, length ), segment = piece / PIECES;
    double from = piece_knot( walk, segment, piece % PIECES ), to = piece_knot( walk, segment, piece % PIECES + 1 );
    double knot =
        find_knot( walk, segment, from, to, length - walk->lengths[piece], walk->lengths[piece + 1] - walk->lengths[piece] );
    double derivative[3];
    rf_curve_at_knot( &walk->curve, segment, knot, point, derivative );
}
