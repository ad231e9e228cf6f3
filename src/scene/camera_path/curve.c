// Interpolates keys by centripetal Catmull-Rom splines, rotations as quaternions; waypoints by arc length.
#include "scene/camera_path/curve.h"

#include "base/try.h"
#include "math/spline.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const double* key_of( const RfCurve* curve, int key ) { return curve->values + (size_t)key * (size_t)curve->kind; }

// The distance between two keys: a length, or half the angle between rotations.
static double distance( RfCurveKind kind, const double* a, const double* b )
{
    double sum = 0.0;
    if ( kind == RF_CURVE_ROTATION )
    {
        double minus = 0.0; // the chord is accurate for small angles, an arc cosine is not
        for ( int i = 0; i < 4; ++i )
        {
            minus += ( a[i] - b[i] ) * ( a[i] - b[i] );
            sum += ( a[i] + b[i] ) * ( a[i] + b[i] );
        }
        return 2.0 * asin( fmin( 0.5 * sqrt( fmin( minus, sum ) ), 1.0 ) );
    }
    for ( int i = 0; i < 3; ++i )
        sum += ( a[i] - b[i] ) * ( a[i] - b[i] );
    return sqrt( sum );
}

// The shortest step that counts; the direction of shorter ones is rounding error.
static double least_step( RfCurveKind kind, const double* a, const double* b )
{
    if ( kind == RF_CURVE_ROTATION )
        return 1e-9;
    double largest = 0.0;
    for ( int i = 0; i < 3; ++i )
        largest = fmax( largest, fmax( fabs( a[i] ), fabs( b[i] ) ) );
    return 1e-12 * largest + 1e-100;
}

static void make_knots( RfCurve* curve )
{
    for ( int i = 0; i < curve->count; ++i )
    {
        if ( curve->kind == RF_CURVE_NUMBER )
        {
            curve->knots[i] = curve->values[i];
            continue;
        }
        curve->knots[i] = i > 0 ? curve->knots[i - 1] : 0.0;
        if ( i == 0 )
            continue;
        const double *a = key_of( curve, i - 1 ), *b = key_of( curve, i );
        double step = distance( curve->kind, a, b );
        if ( step > least_step( curve->kind, a, b ) )
            curve->knots[i] += curve->linear ? step : sqrt( step );
    }
}

// The slope at an end: the three-point formula, limited to stay monotone.
static double end_slope( double h0, double h1, double d0, double d1 )
{
    double slope = ( ( 2.0 * h0 + h1 ) * d0 - h0 * d1 ) / ( h0 + h1 );
    if ( slope * d0 <= 0.0 )
        return 0.0;
    return d0 * d1 < 0.0 && fabs( slope ) > 3.0 * fabs( d0 ) ? 3.0 * d0 : slope;
}

// Slopes of a monotone cubic (Fritsch, Butland 1984): the harmonic mean of the slopes on both
// sides of a key, zero if they differ in sign.
static void make_slopes( RfCurve* curve )
{
    int n = curve->count;
    const double *t = curve->times, *y = curve->knots;
    curve->slopes[0] = n > 1 ? ( y[1] - y[0] ) / ( t[1] - t[0] ) : 0.0;
    if ( n > 1 )
        curve->slopes[n - 1] = ( y[n - 1] - y[n - 2] ) / ( t[n - 1] - t[n - 2] );
    for ( int i = 1; i + 1 < n; ++i )
    {
        double h0 = t[i] - t[i - 1], h1 = t[i + 1] - t[i];
        double d0 = ( y[i] - y[i - 1] ) / h0, d1 = ( y[i + 1] - y[i] ) / h1;
        double w0 = 2.0 * h1 + h0, w1 = h1 + 2.0 * h0;
        curve->slopes[i] = d0 * d1 > 0.0 ? ( w0 + w1 ) / ( w0 / d0 + w1 / d1 ) : 0.0;
        if ( i == 1 )
            curve->slopes[0] = end_slope( h0, h1, d0, d1 );
        if ( i + 2 == n )
            curve->slopes[n - 1] = end_slope( h1, h0, d1, d0 );
    }
}

RfResult rf_create_curve( RfCurveKind kind, bool linear, int count, const double* times, const double* values, RfCurve* curve,
                          RfError* error )
{
    size_t n = (size_t)count;
    *curve = ( RfCurve ){ .kind = kind, .linear = linear, .count = count };
    double* memory = malloc( n * ( 3 + (size_t)kind ) * sizeof *memory );
    if ( memory == NULL )
    {
        *curve = ( RfCurve ){ 0 };
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for a curve of %d keys", count );
    }
    curve->times = memory;
    curve->knots = memory + n;
    curve->slopes = memory + 2 * n;
    curve->values = memory + 3 * n;
    memcpy( curve->times, times, n * sizeof *times );
    memcpy( curve->values, values, n * (size_t)kind * sizeof *values );
    make_knots( curve );
    make_slopes( curve );
    return RF_OK;
}

RfCurve rf_part_of_curve( const RfCurve* curve, int first, int count )
{
    RfCurve part = *curve;
    if ( curve->count == 0 )
        return part;
    part.count = count;
    part.times += first;
    part.knots += first;
    part.slopes += first;
    part.values += (size_t)first * (size_t)curve->kind;
    return part;
}

void rf_part_curve( RfCurve* curve, int first, int count )
{
    RfCurve part = rf_part_of_curve( curve, first, count );
    if ( part.count == 0 )
        return;
    make_knots( &part );
    make_slopes( &part );
}

void rf_destroy_curve( RfCurve* curve )
{
    free( curve->times ); // a single block holds all arrays
    *curve = ( RfCurve ){ 0 };
}

// Interpolates linearly (slerp for rotations) from a to b.
static void blend( RfCurveKind kind, const double* a, const double* b, double t, double* out )
{
    if ( kind == RF_CURVE_ROTATION )
    {
        rf_quat_slerp( a, b, t, out );
        rf_quat_normalize( out );
        return;
    }
    for ( int i = 0; i < (int)kind; ++i )
        out[i] = ( 1.0 - t ) * a[i] + t * b[i];
}

// The four keys and knots around a segment. At the ends of the curve, and next to a segment
// where it stands still, the missing key is extrapolated by reflection.
static void load_span( const RfCurve* curve, int segment, RfSplineSpan* span )
{
    int kind = (int)curve->kind;
    const double* knots = curve->knots;
    size_t bytes = (size_t)kind * sizeof( double );
    memcpy( span->key[1], key_of( curve, segment ), bytes );
    memcpy( span->key[2], key_of( curve, segment + 1 ), bytes );
    span->knot[1] = knots[segment];
    span->knot[2] = knots[segment + 1];
    double width = span->knot[2] - span->knot[1];
    if ( segment > 0 && knots[segment - 1] < span->knot[1] )
    {
        memcpy( span->key[0], key_of( curve, segment - 1 ), bytes );
        span->knot[0] = knots[segment - 1];
    }
    else
    {
        blend( curve->kind, span->key[2], span->key[1], 2.0, span->key[0] );
        span->knot[0] = span->knot[1] - width;
    }
    if ( segment + 2 < curve->count && knots[segment + 2] > span->knot[2] )
    {
        memcpy( span->key[3], key_of( curve, segment + 2 ), bytes );
        span->knot[3] = knots[segment + 2];
    }
    else
    {
        blend( curve->kind, span->key[1], span->key[2], 2.0, span->key[3] );
        span->knot[3] = span->knot[2] + width;
    }
}

void rf_curve_at_knot( const RfCurve* curve, int segment, double knot, double value[3], double derivative[3] )
{
    const double *a = key_of( curve, segment ), *b = key_of( curve, segment + 1 );
    double width = curve->knots[segment + 1] - curve->knots[segment];
    if ( !( width > 0.0 ) ) // the curve stands still in this segment
    {
        memcpy( value, a, 3 * sizeof *a );
        memset( derivative, 0, 3 * sizeof *derivative );
    }
    else if ( curve->linear )
    {
        blend( RF_CURVE_POINT, a, b, ( knot - curve->knots[segment] ) / width, value );
        for ( int i = 0; i < 3; ++i )
            derivative[i] = ( b[i] - a[i] ) / width;
    }
    else
    {
        RfSplineSpan span;
        load_span( curve, segment, &span );
        rf_point_spline( &span, knot, value, derivative );
    }
}

// Cubic Hermite interpolation of the knot within one time step.
static double knot_at( const RfCurve* curve, int segment, double time )
{
    double h = curve->times[segment + 1] - curve->times[segment], t = ( time - curve->times[segment] ) / h;
    double y0 = curve->knots[segment], y1 = curve->knots[segment + 1], t2 = t * t, t3 = t2 * t;
    double y = ( 2.0 * t3 - 3.0 * t2 + 1.0 ) * y0 + ( 3.0 * t2 - 2.0 * t3 ) * y1 +
               h * ( ( t3 - 2.0 * t2 + t ) * curve->slopes[segment] + ( t3 - t2 ) * curve->slopes[segment + 1] );
    return fmin( fmax( y, fmin( y0, y1 ) ), fmax( y0, y1 ) ); // rounding must not leave the segment
}

int rf_last_not_above( const double* values, int last, double x )
{
    int low = 0;
    while ( low < last )
    {
        int middle = low + ( last - low + 1 ) / 2;
        if ( values[middle] <= x )
            low = middle;
        else
            last = middle - 1;
    }
    return low;
}

static void sample_segment( const RfCurve* curve, int segment, double time, double* value )
{
    double h = curve->times[segment + 1] - curve->times[segment];
    if ( curve->linear && !( time > curve->times[segment] ) ) // the key's own bits, so that equal keys give equal cameras
    {
        memcpy( value, key_of( curve, segment ), (size_t)curve->kind * sizeof *value );
        return;
    }
    if ( curve->linear )
    {
        blend( curve->kind, key_of( curve, segment ), key_of( curve, segment + 1 ), ( time - curve->times[segment] ) / h, value );
        return;
    }
    double knot = knot_at( curve, segment, time );
    if ( curve->kind == RF_CURVE_NUMBER )
    {
        value[0] = knot;
        return;
    }
    if ( !( curve->knots[segment + 1] > curve->knots[segment] ) )
    {
        memcpy( value, key_of( curve, segment ), (size_t)curve->kind * sizeof *value );
        return;
    }
    RfSplineSpan span;
    load_span( curve, segment, &span );
    double derivative[3];
    if ( curve->kind == RF_CURVE_POINT )
        rf_point_spline( &span, knot, value, derivative );
    else
        rf_rotation_spline( &span, knot, value );
}

void rf_sample_curve( const RfCurve* curve, double time, double* value )
{
    int last = curve->count - 1;
    int key = time >= curve->times[last] ? last : time > curve->times[0] ? -1 : 0; // NaN selects the first
    if ( key >= 0 )
        memcpy( value, key_of( curve, key ), (size_t)curve->kind * sizeof *value );
    else
        sample_segment( curve, rf_last_not_above( curve->times, last - 1, time ), time, value );
}

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
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for a walk of %d points", count );
    for ( int i = 0; i < count; ++i )
        times[i] = (double)i;
    RfResult result = rf_create_curve( RF_CURVE_POINT, linear, count, times, points, &waypoints->curve, error );
    free( times );
    return result;
}

RfResult rf_create_waypoints( bool linear, int count, const double* points, RfWaypoints* waypoints, RfError* error )
{
    *waypoints = ( RfWaypoints ){ 0 };
    RF_TRY( make_curve( waypoints, linear, count, points, error ) );
    waypoints->piece_count = ( count - 1 ) * PIECES;
    waypoints->lengths = malloc( ( (size_t)waypoints->piece_count + 1 ) * sizeof *waypoints->lengths );
    if ( waypoints->lengths == NULL )
    {
        rf_destroy_waypoints( waypoints );
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for a walk of %d points", count );
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
    int piece = rf_last_not_above( waypoints->lengths, waypoints->piece_count - 1, length ), segment = piece / PIECES;
    double from = piece_knot( waypoints, segment, piece % PIECES ), to = piece_knot( waypoints, segment, piece % PIECES + 1 );
    double knot = find_knot( waypoints, segment, from, to, length - waypoints->lengths[piece],
                             waypoints->lengths[piece + 1] - waypoints->lengths[piece] );
    double derivative[3];
    rf_curve_at_knot( &waypoints->curve, segment, knot, point, derivative );
}
