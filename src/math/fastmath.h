// Elementary functions that compilers can vectorise: no branches, tables or calls, so a loop
// over them runs eight lanes at a time, and the result does not depend on the lane. The
// polynomials are minimax fits of the relative error (Remez exchange with 40 digits); the
// stated errors are measured for the whole function in float and tested in
// tests/math/test_fastmath_accuracy.c.
#ifndef REFRAME_MATH_FASTMATH_H
#define REFRAME_MATH_FASTMATH_H

#include "base/fault.h"

#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

static inline int32_t rf_float_bits( float x )
{
    int32_t bits;
    memcpy( &bits, &x, sizeof( bits ) );
    return bits;
}

static inline float rf_bits_float( int32_t bits )
{
    float x;
    memcpy( &x, &bits, sizeof( x ) );
    return x;
}

// a b + c for polynomials: one rounding, and half the latency on machines with FMA (where fmaf
// compiles to the instruction). Explicit instead of by compiler contraction, so that results
// do not depend on the compiler.
static inline float rf_fused( float a, float b, float c )
{
#if defined( __FMA__ )
    return fmaf( a, b, c );
#else
    return a * b + c;
#endif
}

// Cubic polynomial in two steps (Estrin): loops over these functions are bound by latency, so
// short dependency chains beat few operations.
#define RF_CUBIC( x, x2, c0, c1, c2, c3 ) rf_fused( rf_fused( c3, x, c2 ), x2, rf_fused( c1, x, c0 ) )

// Base-2 logarithm of a positive normal float, relative error < 2e-7, also near 1. Zero and
// subnormal numbers give about −127.
//
// x = 2^e (1 + f) with 1 + f in [√½, √2): e is 0 around 1, so nothing cancels there. log2(1 +
// f) = f P(f), error of the fit 2.7e-8.
static inline float rf_log2( float x )
{
    const uint32_t sqrt_half = 0x3f3504f3u;
    int32_t offset = (int32_t)( (uint32_t)rf_float_bits( x ) - sqrt_half );
    float e = (float)( offset >> 23 );
    float f = rf_bits_float( ( offset & 0x7fffff ) + (int32_t)sqrt_half ) - 1.0f;
    float f2 = f * f;
    float low = RF_CUBIC( f, f2, -0.721347347f, 0.4809106411f, -0.3607036645f, 0.2879162959f );
    float high = RF_CUBIC( f, f2, -0.238945217f, 0.2157155256f, -0.2072672824f, 0.1258344434f );
    float p = rf_fused( f, rf_fused( f2 * f2, high, low ), 1.442695004f );
    return rf_fused( f, p, e );
}

// 2^y = scale (1 + part), |part| < 0.42, as two factors from which 2^y − 1 can be computed
// without cancellation. y is clamped to [−126, 127].
typedef struct RfExp2
{
    float scale, part;
} RfExp2;

static inline RfExp2 rf_split_exp2( float y )
{
    // Adding 1.5 · 2²³ rounds to the nearest integer, which is then in the low bits of the sum;
    // unlike rounding instructions, additions exist on every machine.
    const float shift = 12582912.0f;
    y = y > -126.0f ? y : -126.0f;
    y = y < 127.0f ? y : 127.0f;
    float shifted = y + shift;
    float r = y - ( shifted - shift );
    int32_t e = rf_float_bits( shifted ) - rf_float_bits( shift );
    float r2 = r * r;
    float tail = RF_CUBIC( r, r2, 0.05550357433f, 0.009618237478f, 0.001339073563f, 0.0001540351967f );
    float p = rf_fused( r2, tail, rf_fused( r, 0.2402264979f, 0.6931471879f ) );
    return ( RfExp2 ){ rf_bits_float( ( e + 127 ) * ( 1 << 23 ) ), r * p };
}

// 2^y, relative error < 2e-7 for y in [−126, 127]; 0 below (where the result would be
// subnormal), 2^127 above.
static inline float rf_exp2( float y )
{
    RfExp2 split = rf_split_exp2( y );
    float value = rf_fused( split.scale, split.part, split.scale );
    return y < -126.0f ? 0.0f : value;
}

// 1 − 2^y for y in [−126, 0], relative error < 3e-7, also near 0.
static inline float rf_one_minus_exp2( float y )
{
    RfExp2 split = rf_split_exp2( y );
    return rf_fused( -split.scale, split.part, 1.0f - split.scale );
}

// x^n for x in [0, 1], n ≥ 0; 0^0 = 1, 0^n = 0 (a subnormal x counts as 0). Relative error <
// 3e-7 (1 + |log2 x^n|/2): the exponent is a single float, so results around 2^−100 lose some
// bits, which does not matter here.
static inline float rf_pow( float x, float n )
{
    float value = rf_exp2( n * rf_log2( x ) );
    float at_zero = n > 0.0f ? 0.0f : 1.0f;
    return x >= FLT_MIN ? value : at_zero;
}

// (1 − d)^n for d in [0, 1], n ≥ 0, relative error < 4e-7 (1 + …), even if d is far below the
// spacing of floats near 1: the rounding error of the subtraction is known exactly (for d ≤ ½;
// above, it does not matter) and corrects the logarithm.
static inline float rf_pow_one_minus( float d, float n )
{
    float x = 1.0f - d;
    float lost = RF_FAULT( pow_one_minus ) ? 0.0f : ( 1.0f - x ) - d;
    float value = rf_exp2( n * rf_fused( lost, 1.442695041f, rf_log2( x ) ) );
    float at_zero = n > 0.0f ? 0.0f : 1.0f;
    return x >= FLT_MIN ? value : at_zero;
}

// sin 2πu and cos 2πu for u in [0, 1], relative error < 2e-7 each, also near their zeros.
//
// 4u = k + r with |r| ≤ ½: both follow from sin and cos of r π/2 (errors of the fits 3.3e-9
// and 3.9e-8) by the quadrant k.
static inline void rf_sincos_2pi( float u, float* s, float* c )
{
    float t = 4.0f * u;
    int32_t k = (int32_t)( t + 0.5f );
    float r = t - (float)k;
    float q = r * r;
    float sine = r * RF_CUBIC( q, q * q, 1.570796322f, -0.6459634602f, 0.07968003283f, -0.00460165802f );
    float cosine = rf_fused( q, rf_fused( q, rf_fused( q, -0.02041728346f, 0.2536032113f ), -1.233697706f ), 1.0f );
    float s0 = ( k & 1 ) != 0 ? cosine : sine;
    float c0 = ( k & 1 ) != 0 ? sine : cosine;
    *s = ( k & 2 ) != 0 ? -s0 : s0;
    *c = ( ( k + 1 ) & 2 ) != 0 ? -c0 : c0;
}

#endif
