// Conversion to 16-bit floats in integer arithmetic.
#ifndef REFRAME_IMAGE_HALF_H
#define REFRAME_IMAGE_HALF_H

#include "base/fault.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#define RF_HALF_MAX 65504.0f

// Clamps to ±65504. Infinity and NaN are kept, so that they can be detected.
static inline float rf_clamp_half( float value )
{
    uint32_t bits;
    memcpy( &bits, &value, sizeof bits );
    uint32_t size = bits & 0x7fffffffu;
    if ( size >= 0x7f800000u || size <= 0x477fe000u || RF_FAULT( half_clamp ) ) // not finite, or in the range
        return value;
    return bits >> 31 ? -RF_HALF_MAX : RF_HALF_MAX;
}

static inline float rf_half_to_float( uint16_t half )
{
    uint32_t exponent = half >> 10 & 31u, mantissa = half & 1023u;
    if ( exponent == 0 )
        return ( half & 0x8000u ? -0x1p-24f : 0x1p-24f ) * (float)mantissa;
    uint32_t quiet = exponent == 31 && mantissa != 0 ? 0x400000u : 0; // a signalling NaN of a file raises no flag later on
    uint32_t bits = ( half & 0x8000u ) << 16 | mantissa << 13 | ( exponent == 31 ? 255u : exponent + 112u ) << 23 | quiet;
    float value;
    memcpy( &value, &bits, sizeof value );
    return value;
}

// Drops the last `shift` bits, rounding to nearest, ties to even.
static inline uint32_t rf_shift_rounded( uint32_t bits, uint32_t shift )
{
    uint32_t half = 1u << ( shift - 1 );
    return ( bits + half - 1 + ( bits >> shift & 1u ) ) >> shift;
}

// The nearest half of a value that is clamped, infinite or NaN.
static inline uint16_t rf_float_to_half( float value )
{
    uint32_t bits;
    memcpy( &bits, &value, sizeof bits );
    uint32_t sign = bits >> 16 & 0x8000u, size = bits & 0x7fffffffu;
    uint32_t exponent = size >> 23;
    if ( exponent == 255 )
        return (uint16_t)( sign | ( size > 0x7f800000u ? 0x7e00u | ( size >> 13 & 0x3ffu ) : 0x7c00u ) );
    if ( exponent < 102 ) // less than half of the smallest subnormal
        return (uint16_t)sign;
    if ( exponent < 113 ) // subnormal: in units of 2^-24
        return (uint16_t)( sign | rf_shift_rounded( ( size & 0x7fffffu ) | 0x800000u, 126 - exponent ) );
    return (uint16_t)( sign | rf_shift_rounded( size - ( 112u << 23 ), 13 ) );
}

#endif
