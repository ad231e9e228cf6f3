#include "scene/camera_path/waypoints.h"

#include <math.h>
#include <stdlib.h>

// Pieces per segment, and the number of iterations to find a length within a piece: within
// 1/32 of a segment the speed of a cubic changes too little to need more.
#define PIECES 32
#define STEPS 40

static double speed_at( const RfWaypoints* waypoints, int segment, double knot )
{
    double point[3], d[3];
    rf_curve_at_knot( &waypoints->curve, segment, knot, point, d );
    return sqrt( d[0] * d[0] + d[1] * d[1] + d[2] * d[2] );
}

// Arc length between two knots of a segment, by Gauss-Legendre quadrature.
static double arc_length( const RfWaypoints* waypoints, int segment, double from, double to )
{
    static const double s_at[5] = { 0.0, 0.5384693101056831, -0.5384693101056831, 0.9061798459386640, -0.9061798459386640 };
    static const double s_weight[5] = { 0.5688888888888889, 0.4786286704993665, 0.4786286704993665, 0.2369268850561891,
                                        0.2369268850561891 };
    double middle = 0.5 * ( from + to ), half = 0.5 * ( to - from ), sum = 0.0;
    for ( int i = 0; i < 5; ++i )
        sum += s_weight[i] * speed_at( waypoints, segment, middle + half * s_at[i] );
    return half * sum;
}

static double piece_knot( const RfWaypoints* waypoints, int segment, int piece )
{
    double from = waypoints->curve.knots[segment], to = waypoints->curve.knots[segment + 1];
    return piece == PIECES ? to : from + ( to - from ) * (double)piece / PIECES;
}

static RfResult make_curve( RfWaypoints* waypoints, bool linear, int count, const double* points, RfError* error )
{
    double* times = malloc( (size_t)count * sizeof *times );
    if ( times == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for a walk of %d points", count );
    for ( int i = 0; i < count; ++i )
        times[i] = (double)i;
    RfResult result = rf_create_curve( RF_CURVE_POINT, linear, count, times, points, &waypoints->curve, error );
    free( times );
    return result;
}

RfResult rf_create_waypoints( bool linear, int count, const double* points, RfWaypoints* waypoints, RfError* error )
{
    *waypoints = ( RfWaypoints ){ 0 };
    RfResult result = make_curve( waypoints, linear, count, points, error );
    if ( result != RF_OK )
        return result;
    waypoints->piece_count = ( count - 1 ) * PIECES;
    waypoints->lengths = malloc( ( (size_t)waypoints->piece_count + 1 ) * sizeof *waypoints->lengths );
    if ( waypoints->lengths == NULL )
    {
        rf_destroy_waypoints( waypoints );
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for a walk of %d points", count );
    }
    for ( int i = 0; i < waypoints->piece_count; ++i )
    {
        int segment = i / PIECES, piece = i % PIECES;
        waypoints->lengths[i] = waypoints->length;
        waypoints->length += arc_length( waypoints, segment, piece_knot( waypoints, segment, piece ),
                                         piece_knot( waypoints, segment, piece + 1 ) );
    }
    waypoints->lengths[waypoints->piece_count] = waypoints->length;
    return RF_OK;
}

void rf_destroy_waypoints( RfWaypoints* waypoints )
{
    rf_destroy_curve( &waypoints->curve );
    free( waypoints->lengths );
    *waypoints = ( RfWaypoints ){ 0 };
}

static int find_piece( const RfWaypoints* waypoints, double length )
{
    int low = 0, high = waypoints->piece_count - 1;
    while ( low < high )
    {
        int middle = low + ( high - low + 1 ) / 2;
        if ( waypoints->lengths[middle] <= length )
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

// The knot at arc length `length` from the start of a piece: Newton's method, with bisection
// when it leaves the bracket.
static double find_knot( const RfWaypoints* waypoints, int segment, double from, double to, double length, double whole )
{
    double low = from, high = to;
    double knot = whole > 0.0 ? from + ( to - from ) * fmin( length / whole, 1.0 ) : from;
    for ( int i = 0; i < STEPS; ++i )
    {
        double excess = arc_length( waypoints, segment, from, knot ) - length;
        if ( fabs( excess ) <= 1e-12 * waypoints->length )
            break;
        if ( excess > 0.0 )
            high = knot;
        else
            low = knot;
        double speed = speed_at( waypoints, segment, knot );
        double next = speed > 0.0 ? knot - excess / speed : low;
        knot = next > low && next < high ? next : 0.5 * ( low + high );
    }
    return knot;
}

static void extrapolate( const RfWaypoints* waypoints, int segment, double knot, double by, double point[3] )
{
    double d[3];
    rf_curve_at_knot( &waypoints->curve, segment, knot, point, d );
    double length = sqrt( d[0] * d[0] + d[1] * d[1] + d[2] * d[2] );
    for ( int i = 0; i < 3 && length > 0.0; ++i )
        point[i] += by * d[i] / length;
}

void rf_waypoint_position( const RfWaypoints* waypoints, double length, double point[3] )
{
    int last = waypoints->curve.count - 2;
    if ( !( length > 0.0 ) )
    {
        extrapolate( waypoints, 0, waypoints->curve.knots[0], length, point );
        return;
    }
    if ( length >= waypoints->length )
    {
        extrapolate( waypoints, last, waypoints->curve.knots[last + 1], length - waypoints->length, point );
        return;
    }
    int piece = find_piece( waypoints, length ), segment = piece / PIECES;
    double from = piece_knot( waypoints, segment, piece % PIECES ), to = piece_knot( waypoints, segment, piece % PIECES + 1 );
    double knot = find_knot( waypoints, segment, from, to, length - waypoints->lengths[piece],
                             waypoints->lengths[piece + 1] - waypoints->lengths[piece] );
    double derivative[3];
    rf_curve_at_knot( &waypoints->curve, segment, knot, point, derivative );
}
