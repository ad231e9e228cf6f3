// Three-component float vectors as plain structs, passed by value. Lengths are in scene units
// (metres) unless noted otherwise.
#ifndef REFRAME_MATH_VEC3_H
#define REFRAME_MATH_VEC3_H

#include "base/fault.h"
#include "reframe/types.h"

#include <math.h>
#include <stddef.h>
#include <stdint.h>

#define RF_PI 3.14159265358979f
#define RF_INV_PI 0.318309886183791f

static inline RfVec3 rf_vec3( float x, float y, float z ) { return ( RfVec3 ){ x, y, z }; }
static inline RfVec3 rf_load_vec3( const float* array, uint32_t index )
{
    return rf_vec3( array[3 * (size_t)index], array[3 * (size_t)index + 1], array[3 * (size_t)index + 2] );
}

// Of doubles, times a number.
static inline RfVec3 rf_vec3_of( const double v[3], double scale )
{
    return rf_vec3( (float)( v[0] * scale ), (float)( v[1] * scale ), (float)( v[2] * scale ) );
}

// Element i of three arrays, or of three pointers to arrays: they are evaluated three times.
#define RF_GET3( arrays, i ) rf_vec3( ( arrays )[0][i], ( arrays )[1][i], ( arrays )[2][i] )
#define RF_PUT3( arrays, i, ... )                                                                                                \
    do                                                                                                                           \
    {                                                                                                                            \
        RfVec3 put = __VA_ARGS__;                                                                                                \
        ( arrays )[0][i] = put.x;                                                                                                \
        ( arrays )[1][i] = put.y;                                                                                                \
        ( arrays )[2][i] = put.z;                                                                                                \
    } while ( 0 )

static inline RfVec3 rf_add( RfVec3 a, RfVec3 b ) { return rf_vec3( a.x + b.x, a.y + b.y, a.z + b.z ); }
static inline RfVec3 rf_sub( RfVec3 a, RfVec3 b ) { return rf_vec3( a.x - b.x, a.y - b.y, a.z - b.z ); }
static inline RfVec3 rf_mul( RfVec3 a, RfVec3 b ) { return rf_vec3( a.x * b.x, a.y * b.y, a.z * b.z ); }
static inline RfVec3 rf_scale( RfVec3 a, float s ) { return rf_vec3( a.x * s, a.y * s, a.z * s ); }
static inline RfVec3 rf_madd( RfVec3 a, RfVec3 b, float s ) { return rf_add( a, rf_scale( b, s ) ); }
static inline float rf_dot( RfVec3 a, RfVec3 b ) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static inline RfVec3 rf_cross( RfVec3 a, RfVec3 b )
{
    return rf_vec3( a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x );
}
static inline float rf_length( RfVec3 a ) { return sqrtf( rf_dot( a, a ) ); }
// A zero vector stays zero.
static inline RfVec3 rf_normalize( RfVec3 a )
{
    float l2 = rf_dot( a, a );
    return l2 > 0.0f ? rf_scale( a, 1.0f / sqrtf( l2 ) ) : a;
}
static inline float rf_maxf( float a, float b ) { return a > b ? a : b; }
static inline float rf_minf( float a, float b ) { return a < b ? a : b; }
static inline float rf_clampf( float a, float low, float high ) { return rf_minf( rf_maxf( a, low ), high ); }
static inline float rf_max_component( RfVec3 a ) { return rf_maxf( a.x, rf_maxf( a.y, a.z ) ); }
// Rec. 709 luminance of linear RGB.
static inline float rf_luminance( RfVec3 c ) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

// Two unit vectors that form a right-handed frame with the unit vector n (Duff et al.,
// Building an Orthonormal Basis, Revisited, JCGT 2017).
static inline void rf_basis( RfVec3 n, RfVec3* t, RfVec3* b )
{
    float sign = copysignf( 1.0f, n.z );
    float a = -1.0f / ( sign + n.z );
    float c = n.x * n.y * a;
    *t = rf_vec3( 1.0f + sign * n.x * n.x * a, sign * c, -sign * n.x );
    *b = rf_vec3( c, sign + n.y * n.y * a, -n.y );
}

// The normalised cross product and its original length, 0 for parallel vectors. In doubles:
// products of the edges of tiny and huge triangles leave the range of floats.
static inline RfVec3 rf_unit_cross( RfVec3 a, RfVec3 b, double* length )
{
    double x = (double)a.y * (double)b.z - (double)a.z * (double)b.y;
    double y = (double)a.z * (double)b.x - (double)a.x * (double)b.z;
    double z = (double)a.x * (double)b.y - (double)a.y * (double)b.x;
    *length = sqrt( x * x + y * y + z * z );
    double scale = *length > 0.0 || RF_FAULT( unit_cross_0 ) ? 1.0 / *length : 0.0;
    return rf_vec3( (float)( x * scale ), (float)( y * scale ), (float)( z * scale ) );
}

#endif
