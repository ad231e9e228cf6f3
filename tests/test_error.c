// The measures of error against closed forms.
#include "measure/error.h"
#include "test_image_support.h"

#include <math.h>

static RfImage make_constant( int width, int height, float value )
{
    RfImage image;
    assert_int_equal( rf_create_image( width, height, &image, NULL ), RF_OK );
    for ( int i = 0; i < 3 * width * height; ++i )
        image.rgb[i] = value;
    return image;
}

static RfErrorMetrics measure( const RfImage* image, const RfImage* reference )
{
    RfErrorMetrics metrics;
    RfError error = { 0 };
    if ( rf_measure_error( image, reference, &metrics, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return metrics;
}

static void check_near( double value, double wanted )
{
    if ( !( fabs( value - wanted ) <= 1e-12 * fabs( wanted ) + 1e-300 ) )
        fail_msg( "%.17g, not %.17g", value, wanted );
}

static void test_identical( void** state )
{
    (void)state;
    RfImage image = make_image( 50, 40, 4 );
    RfErrorMetrics metrics = measure( &image, &image );
    assert_true( metrics.relmse == 0.0 && metrics.relmse_trimmed == 0.0 && metrics.mse == 0.0 );
    assert_true( metrics.bias == 0.0 && metrics.bias_low == 0.0 && metrics.bias_high == 0.0 && metrics.max == 0.0 );
    rf_destroy_image( &image );
}

static void test_constant_offset( void** state )
{
    (void)state;
    RfImage reference = make_constant( 33, 21, 0.5f ), image = make_constant( 33, 21, 0.75f );
    RfErrorMetrics metrics = measure( &image, &reference );
    check_near( metrics.relmse, 3.0 * 0.0625 / 0.251 );
    check_near( metrics.relmse_trimmed, metrics.relmse );
    check_near( metrics.mse, 0.0625 );
    check_near( metrics.bias, 0.25 );
    check_near( metrics.bias_low, 0.25 );
    check_near( metrics.bias_high, 0.25 );
    check_near( metrics.max, 0.25 );
    check_near( measure( &reference, &image ).bias, -0.25 );
    rf_destroy_image( &image );
    rf_destroy_image( &reference );
}

// r̄ is the mean of the reference's channels, and the sum goes over channels.
static void test_known_pixel( void** state )
{
    (void)state;
    RfImage reference = make_constant( 1, 1, 0.0f ), image = make_constant( 1, 1, 1.0f );
    reference.rgb[0] = 3.0f; // r̄ = 1; differences −2, 1, 1
    RfErrorMetrics metrics = measure( &image, &reference );
    check_near( metrics.relmse, 6.0 / 1.001 );
    check_near( metrics.mse, 2.0 );
    check_near( metrics.bias, 0.0 );
    check_near( metrics.max, 2.0 );
    assert_true( isnan( metrics.bias_low ) && isnan( metrics.bias_high ) ); // one block has no spread
    rf_destroy_image( &image );
    rf_destroy_image( &reference );
}

// Twice the error: twice bias and max, four times the squares. And a known
// ratio: v = 2 r with r large gives 3 r² / (r² + ε).
static void test_scaling( void** state )
{
    (void)state;
    RfImage reference = make_constant( 40, 30, 8.0f ), image = make_image( 40, 30, 2 ), twice = make_image( 40, 30, 2 );
    for ( int i = 0; i < 3600; ++i )
    {
        float offset = (float)( i % 5 - 1 ); // exact in float
        image.rgb[i] = 8.0f + offset;
        twice.rgb[i] = 8.0f + 2.0f * offset;
    }
    RfErrorMetrics a = measure( &image, &reference ), b = measure( &twice, &reference );
    check_near( b.relmse, 4.0 * a.relmse );
    check_near( b.relmse_trimmed, 4.0 * a.relmse_trimmed );
    check_near( b.mse, 4.0 * a.mse );
    check_near( b.bias, 2.0 * a.bias );
    check_near( b.max, 2.0 * a.max );
    check_near( a.bias, 1.0 );
    check_near( a.mse, 3.0 ); // of −1 0 1 2 3
    rf_destroy_image( &image );
    image = make_constant( 40, 30, 16.0f );
    check_near( measure( &image, &reference ).relmse, 3.0 * 64.0 / 64.001 );
    rf_destroy_image( &image );
    rf_destroy_image( &twice );
    rf_destroy_image( &reference );
}

// 2000 pixels: the two worst are left out, also beside a firefly so bright
// that it swallows the rest in a sum; 999 pixels: none is.
static void test_trimmed( void** state )
{
    (void)state;
    RfImage reference = make_constant( 50, 40, 0.0f ), image = make_constant( 50, 40, 0.0f );
    for ( int i = 0; i < 2000; ++i )
        image.rgb[3 * i] = 1.0f;
    image.rgb[3 * 700] = 1e15f;
    image.rgb[3 * 1999] = 3.0f;
    RfErrorMetrics metrics = measure( &image, &reference );
    check_near( metrics.relmse_trimmed, 1000.0 );
    assert_true( metrics.relmse > 1e29 );
    image.rgb[5] = 2.0f; // third: stays in
    check_near( measure( &image, &reference ).relmse_trimmed, 1000.0 * ( 1997.0 + 5.0 ) / 1998.0 );
    RfImage small = make_constant( 37, 27, 0.0f ), black = make_constant( 37, 27, 0.0f );
    small.rgb[0] = 1.0f;
    metrics = measure( &small, &black );
    check_near( metrics.relmse_trimmed, metrics.relmse );
    rf_destroy_image( &small );
    rf_destroy_image( &black );
    rf_destroy_image( &image );
    rf_destroy_image( &reference );
}

static int descending( const void* a, const void* b )
{
    double x = *(const double*)a, y = *(const double*)b;
    return ( x < y ) - ( x > y );
}

// The heap of the worst against a sort.
static void test_trimmed_sorted( void** state )
{
    (void)state;
    enum { PIXELS = 200 * 150 };
    RfImage reference = make_image( 200, 150, 8 ), image = make_image( 200, 150, 9 );
    double* values = malloc( PIXELS * sizeof( double ) );
    assert_non_null( values );
    for ( int i = 0; i < PIXELS; ++i )
    {
        const float *v = image.rgb + 3 * i, *r = reference.rgb + 3 * i;
        double mean = ( (double)r[0] + r[1] + r[2] ) / 3.0, sum = 0.0;
        for ( int c = 0; c < 3; ++c )
            sum += ( (double)v[c] - r[c] ) * ( (double)v[c] - r[c] );
        values[i] = sum / ( mean * mean + 0.001 );
    }
    qsort( values, PIXELS, sizeof( double ), descending );
    double kept = 0.0;
    for ( int i = 30; i < PIXELS; ++i )
        kept += values[i];
    double wanted = kept / ( PIXELS - 30 );
    assert_true( fabs( measure( &image, &reference ).relmse_trimmed - wanted ) < 1e-10 * wanted );
    free( values );
    rf_destroy_image( &image );
    rf_destroy_image( &reference );
}

static void test_not_finite( void** state )
{
    (void)state;
    RfImage reference = make_constant( 20, 20, 1.0f ), image = make_constant( 20, 20, 1.0f );
    image.rgb[0] = NAN;
    image.rgb[1] = NAN; // the same pixel
    image.rgb[5] = INFINITY;
    image.rgb[9] = -INFINITY;
    image.rgb[10] = NAN; // counts as both
    RfErrorMetrics metrics = measure( &image, &reference );
    assert_int_equal( metrics.nan, 2 );
    assert_int_equal( metrics.inf, 2 );
    assert_true( isnan( metrics.relmse ) && isnan( metrics.relmse_trimmed ) && isnan( metrics.mse ) );
    assert_true( isnan( metrics.bias ) && isnan( metrics.bias_low ) && isnan( metrics.max ) );
    assert_true( metrics.reference_nan == 0 && metrics.reference_inf == 0 );
    metrics = measure( &reference, &image );
    assert_true( metrics.nan == 0 && metrics.inf == 0 && metrics.reference_nan == 2 && metrics.reference_inf == 2 );
    assert_true( isnan( metrics.relmse ) && isnan( metrics.mse ) && isnan( metrics.bias ) && isnan( metrics.max ) );
    RfError error;
    rf_destroy_image( &image );
    image = make_constant( 20, 19, 1.0f );
    assert_int_equal( rf_measure_error( &image, &reference, &metrics, &error ), RF_ERROR_FORMAT );
    assert_non_null( strstr( error.text, "20x19" ) );
    rf_destroy_image( &image );
    rf_destroy_image( &reference );
}

// Frames pooled give what one picture of them all would.
static void test_pooled( void** state )
{
    (void)state;
    RfImage reference = make_image( 48, 96, 5 ), image = make_image( 48, 96, 6 );
    RfErrorMetrics whole = measure( &image, &reference );
    RfErrorSummary summary;
    assert_int_equal( rf_create_summary( 48, 32, 3, &summary, NULL ), RF_OK );
    for ( int frame = 0; frame < 3; ++frame )
    {
        RfImage a = { 48, 32, image.rgb + 3 * 48 * 32 * frame }, b = { 48, 32, reference.rgb + 3 * 48 * 32 * frame };
        assert_int_equal( rf_summary_add( &summary, &a, &b, NULL ), RF_OK );
    }
    RfErrorMetrics pooled = rf_summary_metrics( &summary );
    assert_memory_equal( &pooled, &whole, sizeof whole );
    assert_int_equal( rf_summary_add( &summary, &image, &reference, NULL ), RF_ERROR_FORMAT );
    rf_destroy_summary( &summary );
    rf_destroy_image( &image );
    rf_destroy_image( &reference );
}

// Noise about a known bias: the interval holds it in about 95 % of the trials.
// 400 trials: standard deviation 1.1 %; 4 of them either way.
static void test_bias_interval( void** state )
{
    (void)state;
    enum { TRIALS = 400, WIDTH = 100, HEIGHT = 70 }; // blocks at the borders are smaller
    RfImage reference = make_constant( WIDTH, HEIGHT, 1.0f ), image = make_constant( WIDTH, HEIGHT, 0.0f );
    uint32_t seed = 99;
    int held = 0;
    for ( int trial = 0; trial < TRIALS; ++trial )
    {
        for ( int i = 0; i < 3 * WIDTH * HEIGHT; ++i )
        {
            double uniform = next_random( &seed ) * 0x1p-32; // squared: skewed, mean 1/3
            image.rgb[i] = (float)( 1.0 + 0.01 + uniform * uniform - 1.0 / 3.0 );
        }
        RfErrorMetrics metrics = measure( &image, &reference );
        assert_true( metrics.bias_low < metrics.bias && metrics.bias < metrics.bias_high );
        held += metrics.bias_low <= 0.01 && 0.01 <= metrics.bias_high;
    }
    print_message( "the interval held the bias in %d of %d trials\n", held, TRIALS );
    assert_in_range( held, TRIALS * 90 / 100, TRIALS * 99 / 100 );
    rf_destroy_image( &image );
    rf_destroy_image( &reference );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_identical ),  cmocka_unit_test( test_constant_offset ),
        cmocka_unit_test( test_known_pixel ), cmocka_unit_test( test_scaling ),
        cmocka_unit_test( test_trimmed ),    cmocka_unit_test( test_trimmed_sorted ),
        cmocka_unit_test( test_not_finite ), cmocka_unit_test( test_pooled ),
        cmocka_unit_test( test_bias_interval ),
    };
    return cmocka_run_group_tests_name( "error", tests, NULL, NULL );
}
