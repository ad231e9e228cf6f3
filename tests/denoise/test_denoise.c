// Denoising by a library that takes means over 5x5 pixels: the errors that are told, the blend, layers, and what is wrong with input.
#include "film/brightness.h"
#include "base/random.h"
#include "reframe/denoise.h"
#include "reframe/measure.h"
#include "support/test.h"

#define WIDTH 160
#define HEIGHT 96
#define PIXELS ( WIDTH * HEIGHT )
#define RUNS 24

typedef struct Frame
{
    float truth[3 * PIXELS], rgb[3 * PIXELS], half[4 * PIXELS], out[3 * PIXELS];
} Frame;

static Frame s_frame;
static RfDenoiser* s_denoiser;

static int set_up( void** state )
{
    (void)state;
    RfError error;
    if ( rf_open_denoiser( REFRAME_BOX_DENOISER, 1, &s_denoiser, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return 0;
}

static int tear_down( void** state )
{
    (void)state;
    rf_close_denoiser( s_denoiser );
    return 0;
}

SHARED_BY_TESTS( set_up, tear_down )

#define PAN 3 // pixels to the left by frame

static int s_shift; // of the frame that is made

// Smooth on the left, with detail of one pixel on the right.
static float truth_at( int x, int y, int c )
{
    float smooth = 0.4f + 0.2f * sinf( 0.05f * (float)( x + 2 * y ) + (float)c );
    return x < WIDTH / 2 ? smooth : smooth * ( ( x + y ) % 2 == 0 ? 1.8f : 0.2f );
}

// Uniform noise of this standard deviation in a half; `share`: the first half's of the samples.
static void make( uint32_t seed, float noise, float share )
{
    for ( int i = 0; i < PIXELS; ++i )
    {
        RfRandomKey key = rf_pixel_key( rf_pass_key( seed, 0, 0, 0 ), (uint32_t)i );
        for ( int c = 0; c < 3; ++c )
        {
            float truth = truth_at( i % WIDTH + s_shift, i / WIDTH, c ), of_half[2];
            for ( int h = 0; h < 2; ++h )
                of_half[h] = truth + noise * sqrtf( 12.0f * 0.5f / ( h == 0 ? share : 1.0f - share ) ) *
                                         ( rf_random( key, (uint32_t)( 2 * c + h ) ) - 0.5f );
            s_frame.truth[3 * i + c] = truth;
            s_frame.rgb[3 * i + c] = share * of_half[0] + ( 1.0f - share ) * of_half[1];
            s_frame.half[4 * i + c] = of_half[0];
        }
        s_frame.half[4 * i + 3] = share;
    }
}

static RfNoisyFrame noisy( void )
{
    return ( RfNoisyFrame ){ .width = WIDTH, .height = HEIGHT, .rgb = s_frame.rgb, .half = s_frame.half, .passes = 16.0 };
}

static double true_error( const float* rgb )
{
    RfErrorMetrics metrics;
    const RfImage image = { WIDTH, HEIGHT, (float*)rgb }, truth = { WIDTH, HEIGHT, s_frame.truth };
    assert_int_equal( rf_measure_error( &image, &truth, &metrics, NULL ), RF_OK );
    return metrics.relmse;
}

// Means over runs of the errors told and the true ones.
typedef struct Errors
{
    double told, is, noisy_told, noisy_is, within, share;
} Errors;

static Errors measure( float noise, float share )
{
    Errors e = { 0 };
    for ( uint32_t run = 0; run < RUNS; ++run )
    {
        RfDenoised d;
        make( 100 + run, noise, share );
        RfNoisyFrame frame = noisy();
        assert_int_equal( rf_denoise( s_denoiser, &frame, s_frame.out, &d, NULL, NULL ), RF_OK );
        double is = true_error( s_frame.out );
        e.told += d.denoised.relmse / RUNS;
        e.is += is / RUNS;
        e.noisy_told += d.noisy / RUNS;
        e.noisy_is += true_error( s_frame.rgb ) / RUNS;
        e.within += ( is >= d.denoised.low && is <= d.denoised.high ) / (double)RUNS;
        e.share += d.share / RUNS;
    }
    return e;
}

// With bias: the mean over 5x5 pixels takes away the detail, so that the blend leaves the right half as it is.
TEST( test_told_errors_are_true )
{
    static const float noise[] = { 0.03f, 0.1f, 0.2f, 0.4f };
    for ( size_t n = 0; n < sizeof noise / sizeof noise[0]; ++n )
    {
        for ( int unequal = 0; unequal < 2; ++unequal )
        {
            Errors e = measure( noise[n], unequal ? 0.6f : 0.5f );
            if ( !( fabs( e.told / e.is - 1.0 ) < 0.1 && fabs( e.noisy_told / e.noisy_is - 1.0 ) < 0.1 && e.is < e.noisy_is &&
                    e.within > 0.9 ) )
                fail_msg( "noise %g: told %g, is %g; noisy told %g, is %g; %.0f %% within the interval; share %.2f",
                          (double)noise[n], e.told, e.is, e.noisy_told, e.noisy_is, 100.0 * e.within, e.share );
        }
    }
}

// Frames of a pan, with noise of their own: the mean along the motion has less error, where the surfaces are the same ones.
TEST( test_frames_beside_are_followed )
{
    static float albedo[3 * PIXELS], other[3 * PIXELS], normal[3 * PIXELS], motion[4 * PIXELS];
    for ( int i = 0; i < 3 * PIXELS; ++i )
    {
        albedo[i] = 0.5f;
        other[i] = 0.9f;
        normal[i] = i % 3 == 2;
    }
    for ( int i = 0; i < 4 * PIXELS; ++i )
        motion[i] = i % 4 == 0 ? PAN : i % 4 == 2 ? -PAN : 0;
    double told[3] = { 0 }, is[3] = { 0 }, along[3] = { 0 };
    for ( uint32_t run = 0; run < RUNS; ++run )
    {
        RfDenoisedHalves halves[2];
        for ( int side = 0; side < 2; ++side )
        {
            s_shift = side == 0 ? -PAN : PAN;
            make( 1000 + 2 * run + (uint32_t)side, 0.4f, 0.5f );
            RfNoisyFrame frame = noisy();
            assert_int_equal( rf_denoise_halves( s_denoiser, &frame, halves + side, NULL ), RF_OK );
        }
        s_shift = 0;
        make( 100 + run, 0.4f, 0.5f );
        for ( int k = 0; k < 3; ++k ) // alone, with both, and with both of other surfaces
        {
            RfNoisyFrame frame = noisy();
            RfDenoised d;
            frame.albedo = albedo;
            frame.normal = normal;
            frame.motion = k > 0 ? motion : NULL;
            for ( int side = 0; side < 2; ++side )
                frame.beside[side] = ( RfFrameBeside ){ halves + side, k == 2 ? other : albedo, normal };
            assert_int_equal( rf_denoise( s_denoiser, &frame, s_frame.out, &d, NULL, NULL ), RF_OK );
            told[k] += d.denoised.relmse / RUNS;
            is[k] += true_error( s_frame.out ) / RUNS;
            along[k] += d.along / RUNS;
        }
        for ( int side = 0; side < 2; ++side )
            rf_free_denoised_halves( halves + side );
    }
    if ( !( fabs( told[1] / is[1] - 1.0 ) < 0.1 && is[1] < 0.95 * is[0] && along[1] > 0.2 && along[0] == 0.0 &&
            fabs( is[2] / is[0] - 1.0 ) < 0.01 ) )
        fail_msg( "alone %g, told %g; along %g, told %g (%.2f of it); others %g", is[0], told[0], is[1], told[1], along[1],
                  is[2] );
}

static RfDenoised denoise( const RfNoisyFrame* frame )
{
    RfDenoised d;
    RfError error;
    if ( rf_denoise( s_denoiser, frame, s_frame.out, &d, NULL, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return d;
}

// Light of two groups and of two passes; of each pixel the parts add up to the picture, before and after.
TEST( test_layers_add_up )
{
    static float layers[4][3 * PIXELS];
    make( 7, 0.2f, 0.5f );
    for ( int i = 0; i < 3 * PIXELS; ++i )
    {
        float part = 0.5f + 0.4f * sinf( 0.01f * (float)i );
        for ( int l = 0; l < 4; ++l )
            layers[l][i] = s_frame.rgb[i] * ( l % 2 == 0 ? part : 1.0f - part );
    }
    const RfNoisyLayer list[] = {
        { 0, layers[0], true }, { 0, layers[1], true }, { 1, layers[2], true }, { 1, layers[3], false }
    };
    RfNoisyFrame frame = noisy();
    frame.layer_count = 4;
    frame.layers = list;
    denoise( &frame );
    double moved = 0.0;
    for ( int i = 0; i < 3 * PIXELS; ++i )
    {
        for ( int set = 0; set < 2; ++set )
            assert_true( fabsf( layers[2 * set][i] + layers[2 * set + 1][i] - s_frame.out[i] ) < 1e-5f );
        moved = fmax( moved, fabs( (double)( layers[0][i] - s_frame.rgb[i] * ( 0.5f + 0.4f * sinf( 0.01f * (float)i ) ) ) ) );
    }
    assert_true( moved > 0.05 );
}

// A denoiser that would do harm is left out: detail alone, without noise to speak of.
TEST( test_picture_is_kept_where_denoising_harms )
{
    make( 3, 0.001f, 0.5f );
    RfNoisyFrame frame = noisy();
    RfDenoised d = denoise( &frame );
    assert_true( true_error( s_frame.out ) < 1.05 * true_error( s_frame.rgb ) );
    assert_true( d.denoised.relmse < 1.05 * d.noisy );
}

// Without halves, or with a pass in each, the picture is denoised and nothing is told.
TEST( test_error_is_not_known_without_halves )
{
    for ( int k = 0; k < 2; ++k )
    {
        make( 5, 0.3f, 0.5f );
        RfNoisyFrame frame = noisy();
        frame.half = k == 0 ? NULL : frame.half;
        frame.passes = k == 0 ? 16.0 : 3.0;
        RfDenoised d = denoise( &frame );
        assert_true( isnan( d.noisy ) && isnan( d.denoised.relmse ) && isnan( d.denoised.high ) );
        assert_true( memcmp( s_frame.out, s_frame.rgb, sizeof s_frame.rgb ) != 0 );
        assert_true( k == 0 ? d.share == 1.0 : d.share > 0.0 );
    }
}

// Pixels that are not finite stay, and spread nowhere.
TEST( test_pixels_that_are_not_finite_stay )
{
    make( 9, 0.3f, 0.5f );
    s_frame.rgb[3 * 5000] = (float)NAN;
    s_frame.half[4 * 7000 + 1] = (float)INFINITY;
    RfNoisyFrame frame = noisy();
    RfDenoised d = denoise( &frame );
    for ( int i = 0; i < 3 * PIXELS; ++i )
        assert_true( i == 3 * 5000 ? isnan( s_frame.out[i] ) != 0 : isfinite( s_frame.out[i] ) != 0 );
    assert_true( isnan( d.denoised.relmse ) && isnan( d.noisy ) && d.share > 0.2 );
    assert_memory_equal( s_frame.out + 3 * 7000, s_frame.rgb + 3 * 7000, 3 * sizeof( float ) );
}

// A render judges one frame while another is written.
TEST( test_two_threads_share_a_denoiser )
{
    static float rgb[2][3 * PIXELS], alone[2][3 * PIXELS], together[2][3 * PIXELS];
    int differ = 0;
    for ( uint32_t k = 0; k < 2; ++k )
    {
        make( 20 + k, 0.3f, 0.5f );
        memcpy( rgb[k], s_frame.rgb, sizeof rgb[k] );
    }
    for ( int i = 0; i < 66; ++i ) // the first two times alone
    {
#pragma omp parallel for num_threads( 2 ) schedule( static, 1 ) reduction( + : differ ) if ( i >= 2 )
        for ( int k = 0; k < 2; ++k )
        {
            RfDenoised d;
            const RfNoisyFrame frame = { .width = WIDTH, .height = HEIGHT, .rgb = rgb[k], .passes = 16.0 };
            float* out = i < 2 ? alone[k] : together[k];
            differ += rf_denoise( s_denoiser, &frame, out, &d, NULL, NULL ) != RF_OK;
            differ += memcmp( out, alone[k], sizeof alone[k] ) != 0;
        }
    }
    assert_int_equal( differ, 0 );
}

// The mean over frames: its interval is narrower than that of a frame.
TEST( test_shots_have_an_interval_of_their_own )
{
    RfDenoisedSums sums = { 0 };
    double mean = 0.0, reach = 0.0;
    for ( uint32_t run = 0; run < 8; ++run )
    {
        RfDenoised d;
        make( 40 + run, 0.2f, 0.5f );
        RfNoisyFrame frame = noisy();
        assert_int_equal( rf_denoise( s_denoiser, &frame, s_frame.out, &d, &sums, NULL ), RF_OK );
        mean += d.denoised.relmse / 8.0;
        reach += ( d.denoised.high - d.denoised.low ) / 8.0;
    }
    RfErrorEstimate all = rf_denoised_error( &sums );
    assert_true( fabs( all.relmse / mean - 1.0 ) < 1e-6 && all.high - all.low < 1.01 * reach );
    rf_free_denoised_sums( &sums );
    assert_true( isnan( rf_denoised_error( &sums ).relmse ) );
}

static void expect_refused( const char* library, const char* fake, const char* words )
{
    RfDenoiser* denoiser;
    RfError error;
    setenv( "FAKE_OIDN", fake, 1 );
    assert_int_equal( rf_open_denoiser( library, 1, &denoiser, &error ), RF_ERROR_UNSUPPORTED );
    assert_null( denoiser );
    if ( strstr( error.text, words ) == NULL || strchr( error.text, '\n' ) != NULL )
        fail_msg( "%s", error.text );
    unsetenv( "FAKE_OIDN" );
}

TEST( test_other_libraries_are_refused )
{
    expect_refused( "/no/such.so", "", "the denoiser cannot be loaded: /no/such.so: " );
    expect_refused( REFRAME_SOURCE_DIR "/README.md", "", "README.md: " );
    expect_refused( "libm.so.6", "", "no Open Image Denoise 2: it lacks oidnNewDevice" );
    expect_refused( REFRAME_BOX_DENOISER, "old", "is Open Image Denoise 1.4, but 2.0 or later is needed" );
    setenv( "REFRAME_OIDN", "/no/other.so", 1 );
    expect_refused( NULL, "", "cannot be loaded: /no/other.so: " );
    unsetenv( "REFRAME_OIDN" );
}

TEST( test_failure_of_the_library_is_told )
{
    RfDenoised d;
    RfError error;
    make( 1, 0.1f, 0.5f );
    RfNoisyFrame frame = noisy();
    setenv( "FAKE_OIDN", "fail", 1 );
    assert_int_equal( rf_denoise( s_denoiser, &frame, s_frame.out, &d, NULL, &error ), RF_ERROR_UNSUPPORTED );
    assert_string_equal( error.text, "Open Image Denoise: it has no memory" );
    unsetenv( "FAKE_OIDN" );
}
