#include "support/flicker_frames.h"

#include <math.h>

RfFlickerFrame make_frame( int number )
{
    RfFlickerFrame frame = { .number = number, .is_finite = true };
    assert_int_equal( rf_create_image( WIDTH, HEIGHT, &frame.signal, NULL ), RF_OK );
    return frame;
}

float* make_layer( int channels, float value )
{
    float* layer = malloc( (size_t)( channels * PIXELS ) * sizeof( float ) );
    assert_non_null( layer );
    for ( int i = 0; i < channels * PIXELS; ++i )
        layer[i] = value;
    return layer;
}

void set_motion( RfFlickerFrame* frame, float x, float y )
{
    if ( frame->motion == NULL )
        frame->motion = make_layer( 2, 0.0f );
    for ( int i = 0; i < PIXELS; ++i )
    {
        frame->motion[2 * i] = x;
        frame->motion[2 * i + 1] = y;
    }
}

// Mean 0, variance 1 (sum of twelve uniforms).
static float normal( uint32_t* seed )
{
    double sum = -6.0;
    for ( int i = 0; i < 12; ++i )
        sum += next_random( seed ) * 0x1p-32;
    return (float)sum;
}

void fill_noise( RfFlickerFrame* frame, uint32_t seed, float scale )
{
    for ( int i = 0; i < 100; ++i ) // neighbouring seeds begin alike
        next_random( &seed );
    for ( int i = 0; i < VALUES; ++i )
        frame->signal.rgb[i] = scale * normal( &seed );
}

RfFlickerSums measure( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate, bool has_error )
{
    RfFlickerSums sums;
    RfError error = { 0 };
    if ( rf_measure_flicker( now, before, compensate, has_error, &sums, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return sums;
}

RfFlickerMetrics measured( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate, bool has_error )
{
    RfFlickerSums sums = measure( now, before, compensate, has_error );
    return rf_flicker_metrics( &sums );
}

void check_near( double value, double wanted, double tolerance )
{
    if ( !( fabs( value - wanted ) <= tolerance ) )
        fail_msg( "%.17g, not %.17g within %g", value, wanted, tolerance );
}
