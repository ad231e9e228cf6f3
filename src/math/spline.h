// One segment of a Catmull-Rom spline with arbitrary knots: between keys 1 and 2 of four.
#ifndef REFRAME_MATH_SPLINE_H
#define REFRAME_MATH_SPLINE_H

#include "math/quat.h"

typedef struct RfSplineSpan
{
    double key[4][4]; // points or rotations; knots increase
    double knot[4];
} RfSplineSpan;

// A point and its derivative at knot `at` in [k[1], k[2]], by the recursive evaluation of
// Barry and Goldman (1988).
static inline void rf_point_spline( const RfSplineSpan* span, double at, double value[3], double derivative[3] )
{
    const double* k = span->knot;
    for ( int c = 0; c < 3; ++c )
    {
        double a[3], da[3], b[2], db[2];
        for ( int i = 0; i < 3; ++i )
        {
            double h = k[i + 1] - k[i], t = ( at - k[i] ) / h;
            a[i] = ( 1.0 - t ) * span->key[i][c] + t * span->key[i + 1][c];
            da[i] = ( span->key[i + 1][c] - span->key[i][c] ) / h;
        }
        for ( int i = 0; i < 2; ++i )
        {
            double h = k[i + 2] - k[i], t = ( at - k[i] ) / h;
            b[i] = ( 1.0 - t ) * a[i] + t * a[i + 1];
            db[i] = ( a[i + 1] - a[i] ) / h + ( 1.0 - t ) * da[i] + t * da[i + 1];
        }
        double h = k[2] - k[1], t = ( at - k[1] ) / h;
        value[c] = ( 1.0 - t ) * b[0] + t * b[1];
        derivative[c] = ( b[1] - b[0] ) / h + ( 1.0 - t ) * db[0] + t * db[1];
    }
}

// Angular velocity: the rotation vector from a to b, divided by the knot step.
static inline void rf_angular_velocity( const double a[4], const double b[4], double step, double rate[3] )
{
    double q[4];
    rf_quat_between( a, b, q );
    rf_quat_log( q, rate );
    for ( int i = 0; i < 3; ++i )
        rate[i] /= step;
}

// out = q · exp( scale · v )
static inline void rf_rotate_by( const double q[4], const double v[3], double scale, double out[4] )
{
    double scaled[3] = { scale * v[0], scale * v[1], scale * v[2] }, e[4];
    rf_quat_exp( scaled, e );
    rf_quat_mul( q, e, out );
}

// A rotation at knot `at`: a cumulative Bézier curve of quaternions (Kim, Kim, Shin 1995)
// whose angular velocities at the keys are those of Catmull-Rom. A pyramid of slerps would be
// discontinuous where two of its rotations are half a turn apart.
static inline void rf_rotation_spline( const RfSplineSpan* span, double at, double value[4] )
{
    const double* k = span->knot;
    double h[3] = { k[1] - k[0], k[2] - k[1], k[3] - k[2] }, d[3][3], first[3], middle[3], last[3];
    for ( int i = 0; i < 3; ++i )
        rf_angular_velocity( span->key[i], span->key[i + 1], h[i], d[i] );
    for ( int i = 0; i < 3; ++i )
    {
        first[i] = ( h[1] * d[0][i] + h[0] * d[1][i] ) / ( h[0] + h[1] ) * h[1] / 3.0;
        last[i] = ( h[2] * d[1][i] + h[1] * d[2][i] ) / ( h[1] + h[2] ) * h[1] / 3.0;
    }
    double r[4], back[3] = { -first[0], -first[1], -first[2] }, e[4], rest[4];
    rf_quat_between( span->key[1], span->key[2], r );
    rf_quat_exp( back, e );
    rf_quat_mul( e, r, rest );
    rf_rotate_by( rest, last, -1.0, r );
    rf_quat_log( r, middle );

    double t = ( at - k[1] ) / h[1], u = 1.0 - t;
    rf_rotate_by( span->key[1], first, 1.0 - u * u * u, value );
    rf_rotate_by( value, middle, t * t * ( 3.0 - 2.0 * t ), rest );
    rf_rotate_by( rest, last, t * t * t, value );
    rf_quat_normalize( value );
}

#endif
