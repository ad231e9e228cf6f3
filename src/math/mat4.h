// 4×4 matrices of doubles, column-major as in glTF: element (row r, column c)
// is m[4c + r], and a point is transformed as M · (x, y, z, 1).
#ifndef REFRAME_MATH_MAT4_H
#define REFRAME_MATH_MAT4_H

#include "math/quat.h"

typedef struct RfMat4
{
    double m[16];
} RfMat4;

static inline RfMat4 rf_mat4_identity( void ) { return ( RfMat4 ){ { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 } }; }

static inline RfMat4 rf_mat4_mul( const RfMat4* a, const RfMat4* b )
{
    RfMat4 out;
    for ( int c = 0; c < 4; ++c )
    {
        for ( int r = 0; r < 4; ++r )
        {
            double sum = 0.0;
            for ( int k = 0; k < 4; ++k )
                sum += a->m[4 * k + r] * b->m[4 * c + k];
            out.m[4 * c + r] = sum;
        }
    }
    return out;
}

// The matrix that scales by s, then rotates by the unit quaternion q (x y z w), then
// translates by t.
static inline RfMat4 rf_mat4_from_trs( const double t[3], const double q[4], const double s[3] )
{
    double r[9];
    rf_quat_axes( q, r );
    RfMat4 out = rf_mat4_identity();
    for ( int c = 0; c < 3; ++c )
    {
        for ( int row = 0; row < 3; ++row )
            out.m[4 * c + row] = r[3 * c + row] * s[c];
        out.m[12 + c] = t[c];
    }
    return out;
}

// out = M · (p, w): w 1 for points, 0 for directions.
static inline void rf_mat4_apply( const RfMat4* a, const double p[3], double w, double out[3] )
{
    for ( int r = 0; r < 3; ++r )
        out[r] = a->m[r] * p[0] + a->m[4 + r] * p[1] + a->m[8 + r] * p[2] + a->m[12 + r] * w;
}

// Determinant of the upper-left 3×3; negative if the transform mirrors.
static inline double rf_mat4_det3( const RfMat4* a )
{
    const double* m = a->m;
    return m[0] * ( m[5] * m[10] - m[9] * m[6] ) - m[4] * ( m[1] * m[10] - m[9] * m[2] ) + m[8] * ( m[1] * m[6] - m[5] * m[2] );
}

// out = cofactor matrix of the upper-left 3×3 · n. Transforms normals up to their length, also
// under non-uniform scale; it is the inverse transpose times the determinant.
static inline void rf_mat4_apply_cofactor( const RfMat4* a, const double n[3], double out[3] )
{
    const double* m = a->m;
    out[0] = ( m[5] * m[10] - m[9] * m[6] ) * n[0] + ( m[2] * m[9] - m[1] * m[10] ) * n[1] + ( m[1] * m[6] - m[2] * m[5] ) * n[2];
    out[1] = ( m[8] * m[6] - m[4] * m[10] ) * n[0] + ( m[0] * m[10] - m[2] * m[8] ) * n[1] + ( m[2] * m[4] - m[0] * m[6] ) * n[2];
    out[2] = ( m[4] * m[9] - m[8] * m[5] ) * n[0] + ( m[1] * m[8] - m[0] * m[9] ) * n[1] + ( m[0] * m[5] - m[1] * m[4] ) * n[2];
}

#endif
