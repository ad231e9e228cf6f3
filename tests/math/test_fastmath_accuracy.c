// Accuracy of math/fastmath.h against libm in double precision.
#include "support/test.h"
#include "math/fastmath.h"

#include "base/random.h"

#ifdef REFRAME_SANITIZED
#define COUNT 200000
#else
#define COUNT 4000000
#endif

static const double s_pi = 3.14159265358979323846;

static double random_double( int i, uint32_t dimension )
{
    return rf_random( rf_pixel_key( rf_pass_key( 7, 0, 0, 0 ), (uint32_t)i ), dimension );
}

static double relative_error( double value, double reference )
{
    if ( reference == 0.0 )
        return fabs( value );
    return fabs( value - reference ) / fabs( reference );
}

static void assert_error_below( const char* name, double error, double limit )
{
    print_message( "%s: relative error %.2e\n", name, error );
    assert_true( error < limit );
}

TEST( test_log2_is_accurate )
{
    double near_one = 0.0, anywhere = 0.0;
    for ( int i = 0; i < COUNT; ++i )
    {
        float x = (float)( 0.5 + 1.5 * random_double( i, 0 ) );
        float small = 1.0f + ( x - 1.0f ) * 1e-4f;
        near_one = fmax( near_one, relative_error( rf_log2( x ), log2( (double)x ) ) );
        near_one = fmax( near_one, relative_error( rf_log2( small ), log2( (double)small ) ) );
        float y = ldexpf( x, (int)( 250.0 * random_double( i, 1 ) ) - 125 );
        anywhere = fmax( anywhere, relative_error( rf_log2( y ), log2( (double)y ) ) );
    }
    assert_error_below( "log2 in [0.5, 2]", near_one, 2e-7 );
    assert_error_below( "log2", anywhere, 2e-7 );
    assert_true( rf_log2( 1.0f ) == 0.0f );
    assert_true( rf_log2( 0.0f ) < -126.0f );
}

TEST( test_exp2_is_accurate )
{
    double value = 0.0, difference = 0.0;
    for ( int i = 0; i < COUNT; ++i )
    {
        float y = (float)( -126.0 + 253.0 * random_double( i, 0 ) );
        value = fmax( value, relative_error( rf_exp2( y ), exp2( (double)y ) ) );
        float z = (float)-exp2( -25.0 + 31.0 * random_double( i, 1 ) );
        difference = fmax( difference, relative_error( rf_one_minus_exp2( z ), -expm1( (double)z * log( 2.0 ) ) ) );
    }
    assert_error_below( "exp2", value, 2e-7 );
    assert_error_below( "1 - exp2", difference, 3e-7 );
    assert_true( rf_exp2( 0.0f ) == 1.0f );
    assert_true( rf_exp2( -126.5f ) == 0.0f );
    assert_true( rf_exp2( -1e30f ) == 0.0f );
    assert_true( rf_exp2( 1e30f ) == 0x1p127f );
    assert_true( rf_one_minus_exp2( 0.0f ) == 0.0f );
}

// The bound of the comment in fastmath.h, as a multiple of itself.
static double power_error( double value, double log2_reference )
{
    if ( log2_reference < -125.9 )
        return value < 1e-37 ? 0.0 : 1.0;
    return relative_error( value, exp2( log2_reference ) ) / ( 1.0 + 0.5 * fabs( log2_reference ) );
}

TEST( test_pow_is_accurate )
{
    double plain = 0.0, one_minus = 0.0;
    for ( int i = 0; i < COUNT; ++i )
    {
        float n = (float)( exp2( 22.0 * random_double( i, 0 ) ) - 1.0 );
        float x = (float)( 1.0 - exp2( -24.0 * random_double( i, 1 ) ) );
        if ( x > 0.0f )
            plain = fmax( plain, power_error( rf_pow( x, n ), n * log2( (double)x ) ) );
        float d = (float)exp2( -30.0 * random_double( i, 2 ) );
        if ( d < 0.9999f )
            one_minus = fmax( one_minus, power_error( rf_pow_one_minus( d, n ), n * log1p( -(double)d ) / log( 2.0 ) ) );
    }
    assert_error_below( "pow, over its bound", plain, 3e-7 );
    assert_error_below( "pow of 1 - d, over its bound", one_minus, 4e-7 );
}

TEST( test_pow_at_the_ends )
{
    const float exponents[] = { 0.0f, 1e-30f, 0.5f, 1.0f, 100.0f, 1e6f };
    for ( int i = 0; i < 6; ++i )
    {
        float n = exponents[i];
        float at_zero = n > 0.0f ? 0.0f : 1.0f;
        assert_true( rf_pow( 1.0f, n ) == 1.0f && rf_pow_one_minus( 0.0f, n ) == 1.0f );
        assert_true( rf_pow( 0.0f, n ) == at_zero && rf_pow_one_minus( 1.0f, n ) == at_zero );
    }
    assert_true( rf_pow( 0.3f, 0.0f ) == 1.0f );
    assert_true( rf_pow( FLT_MIN, 1e6f ) == 0.0f );
}

TEST( test_sincos_is_accurate )
{
    double worst = 0.0;
    for ( int i = 0; i < COUNT; ++i )
    {
        // Around the eighths, where the quarter turns meet and the zeros lie, and anywhere.
        double offset = exp2( -24.0 * random_double( i, 0 ) ) / 8.0;
        float u = (float)( floor( 8.0 * random_double( i, 1 ) ) / 8.0 + ( i % 2 ? offset : 0.125 - offset ) );
        u = fminf( u, 1.0f - 0x1p-24f );
        float s, c;
        rf_sincos_2pi( u, &s, &c );
        // The nearest multiple of a quarter turn is taken off first: libm's 2πu is rounded, too.
        double k = floor( 4.0 * u + 0.5 ), r = ( 4.0 * u - k ) * s_pi / 2.0;
        double sines[4] = { sin( r ), cos( r ), -sin( r ), -cos( r ) };
        worst = fmax( worst, relative_error( s, sines[(int)k % 4] ) );
        worst = fmax( worst, relative_error( c, sines[( (int)k + 1 ) % 4] ) );
    }
    assert_error_below( "sincos", worst, 2e-7 );
}
