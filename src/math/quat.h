// Unit quaternions of doubles, x y z w as in glTF.
#ifndef REFRAME_MATH_QUAT_H
#define REFRAME_MATH_QUAT_H

#include <math.h>

// Above this cosine, linear interpolation differs from the arc by less than 1e-8, and the sine
// of the angle is too small to divide by.
#define RF_SLERP_LINEAR_COSINE 0.9999

// Normalises q; if it has no direction it becomes the identity.
static inline void rf_quat_normalize( double q[4] )
{
    double largest = 0.0;
    for ( int i = 0; i < 4; ++i )
        largest = fmax( largest, fabs( q[i] ) );
    if ( largest > 0.0 && isfinite( largest ) )
    {
        double sum = 0.0;
        for ( int i = 0; i < 4; ++i )
        {
            q[i] /= largest;
            sum += q[i] * q[i];
        }
        double scale = 1.0 / sqrt( sum );
        for ( int i = 0; i < 4; ++i )
            q[i] *= scale;
        return;
    }
    q[0] = q[1] = q[2] = 0.0;
    q[3] = 1.0;
}

// Spherical linear interpolation from a (t = 0) to b (t = 1) along the shorter arc; t may be
// outside [0, 1].
static inline void rf_quat_slerp( const double a[4], const double b[4], double t, double out[4] )
{
    double cosine = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    // q and −q are the same rotation: choose the nearer one
    double sign = cosine < 0.0 ? -1.0 : 1.0;
    cosine *= sign;
    double weight_a = 1.0 - t, weight_b = t;
    if ( cosine < RF_SLERP_LINEAR_COSINE )
    {
        double angle = acos( cosine );
        weight_a = sin( ( 1.0 - t ) * angle ) / sin( angle );
        weight_b = sin( t * angle ) / sin( angle );
    }
    for ( int i = 0; i < 4; ++i )
        out[i] = weight_a * a[i] + sign * weight_b * b[i];
}

// out = a · b: the rotation b, then a.
static inline void rf_quat_mul( const double a[4], const double b[4], double out[4] )
{
    out[0] = a[3] * b[0] + a[0] * b[3] + a[1] * b[2] - a[2] * b[1];
    out[1] = a[3] * b[1] - a[0] * b[2] + a[1] * b[3] + a[2] * b[0];
    out[2] = a[3] * b[2] + a[0] * b[1] - a[1] * b[0] + a[2] * b[3];
    out[3] = a[3] * b[3] - a[0] * b[0] - a[1] * b[1] - a[2] * b[2];
}

// out = a⁻¹ · b, with the sign of the shorter rotation.
static inline void rf_quat_between( const double a[4], const double b[4], double out[4] )
{
    double inverse[4] = { -a[0], -a[1], -a[2], a[3] };
    rf_quat_mul( inverse, b, out );
    double sign = out[3] < 0.0 ? -1.0 : 1.0;
    for ( int i = 0; i < 4; ++i )
        out[i] *= sign;
}

// Logarithm: the rotation vector (axis times angle) of q, with an angle below 2π.
static inline void rf_quat_log( const double q[4], double v[3] )
{
    double sine = sqrt( q[0] * q[0] + q[1] * q[1] + q[2] * q[2] );
    double scale = sine > 0.0 ? 2.0 * atan2( sine, q[3] ) / sine : 0.0;
    for ( int i = 0; i < 3; ++i )
        v[i] = scale * q[i];
}

// Exponential: the unit quaternion of a rotation vector.
static inline void rf_quat_exp( const double v[3], double q[4] )
{
    double angle = sqrt( v[0] * v[0] + v[1] * v[1] + v[2] * v[2] );
    double scale = angle > 1e-9 ? sin( 0.5 * angle ) / angle : 0.5;
    for ( int i = 0; i < 3; ++i )
        q[i] = scale * v[i];
    q[3] = cos( 0.5 * angle );
}

// The rotated axes x, y, z, 3 numbers each: the columns of the rotation matrix.
static inline void rf_quat_axes( const double q[4], double axes[9] )
{
    double x = q[0], y = q[1], z = q[2], w = q[3];
    double r[9] = {
        1 - 2 * ( y * y + z * z ), 2 * ( x * y + z * w ),     2 * ( x * z - y * w ),
        2 * ( x * y - z * w ),     1 - 2 * ( x * x + z * z ), 2 * ( y * z + x * w ),
        2 * ( x * z + y * w ),     2 * ( y * z - x * w ),     1 - 2 * ( x * x + y * y ),
    };
    for ( int i = 0; i < 9; ++i )
        axes[i] = r[i];
}

#endif
