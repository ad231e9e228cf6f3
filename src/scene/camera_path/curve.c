#include "scene/camera_path/curve.h"

#include "math/spline.h"

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
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for a curve of %d keys", count );
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

static int find_segment( const RfCurve* curve, double time )
{
    int low = 0, high = curve->count - 2;
    while ( low < high )
    {
        int middle = low + ( high - low + 1 ) / 2;
        if ( curve->times[middle] <= time )
            low = middle;
        else
            high = middle - 1;
    }
    return low;
}

static void sample_segment( const RfCurve* curve, int segment, double time, double* value )
{
    double h = curve->times[segment + 1] - curve->times[segment];
    if ( curve->linear && !( time > curve->times[segment] ) ) // the key's own bits, so that equal keys give equal eyes
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
        sample_segment( curve, find_segment( curve, time ), time, value );
}
