// The cross-fitted reconstruction is unbiased, under noise whose variance estimates go with the noise
// itself; weights from the same half are not.
#include "base/random.h"
#include "gradient/solver.h"
#include "support/statistics.h"
#include "support/test.h"

#include <omp.h>

#define WIDTH 10
#define HEIGHT 8
#define PIXELS ( WIDTH * HEIGHT )
#define PASSES 4 // per half
#define BLOCK 2
#define BLOCKS ( PIXELS / ( BLOCK * BLOCK ) )

typedef struct Planes
{
    float primal[3 * PIXELS], dx[3 * PIXELS], dy[3 * PIXELS];
    float variance[PIXELS], variance_dx[PIXELS], variance_dy[PIXELS];
} Planes;

static Planes s_planes[2];

static double truth( int x, int y ) { return ( x < 4 ) != ( y < 3 ) ? 0.2 : 1.5 + 0.1 * x; }

// Mean and estimated variance of the mean of PASSES skewed samples of this mean: a low sum has a low estimate.
static float sample_mean( uint64_t key, uint32_t place, double mean, double spread, float* variance )
{
    double sum = 0.0, squares = 0.0;
    for ( uint32_t pass = 0; pass < PASSES; ++pass )
    {
        double u = (double)rf_random( rf_pixel_key( key, place ), pass );
        double value = mean + spread * ( -log( 1.0 - u ) - 1.0 );
        sum += value, squares += value * value;
    }
    double average = sum / PASSES, of_mean = ( squares / PASSES - average * average ) / ( PASSES - 1 );
    *variance = (float)fmax( of_mean, 0.0 );
    return (float)average;
}

static RfGradientHalf make_half( Planes* p, uint64_t seed, uint32_t half )
{
    uint64_t key = rf_pass_key( seed, half, 0, 0 );
    for ( int i = 0; i < PIXELS; ++i )
    {
        int x = i % WIDTH, y = i / WIDTH;
        uint32_t place = 3 * (uint32_t)i;
        double v = truth( x, y );
        float primal = sample_mean( key, place, v, v, p->variance + i );
        float dx = sample_mean( key, place + 1, truth( x + 1, y ) - v, x == 3 ? 1.0 : 0.2, p->variance_dx + i );
        float dy = sample_mean( key, place + 2, truth( x, y + 1 ) - v, y == 2 ? 1.0 : 0.2, p->variance_dy + i );
        for ( int c = 0; c < 3; ++c )
            p->primal[3 * i + c] = primal, p->dx[3 * i + c] = dx, p->dy[3 * i + c] = dy;
    }
    return ( RfGradientHalf ){ .images = { WIDTH, HEIGHT, p->primal, p->dx, p->dy },
                               .variance = p->variance,
                               .variance_dx = p->variance_dx,
                               .variance_dy = p->variance_dy,
                               .passes = PASSES };
}

static void must( RfResult result, const RfError* error )
{
    if ( result != RF_OK )
        fail_msg( "%s", error->text );
}

static RfReconstructOptions weighted( void )
{
    RfReconstructOptions options = rf_default_reconstruct_options();
    options.method = RF_RECONSTRUCT_WEIGHTED;
    return options;
}

// Both halves by weights of their own, averaged.
static void solve_by_own_weights( const RfGradientHalf halves[2], float* rgb )
{
    static float rooms[2][PIXELS], a[PIXELS], b_x[PIXELS], b_y[PIXELS], one[3 * PIXELS];
    float* const scratch[2] = { rooms[0], rooms[1] };
    const RfGradientWeights weights = { a, b_x, b_y };
    RfReconstructOptions options = weighted();
    RfError error;
    memset( rgb, 0, 3 * PIXELS * sizeof *rgb );
    for ( int k = 0; k < 2; ++k )
    {
        rf_weights_of_half( halves + k, scratch, a, b_x, b_y );
        must( rf_reconstruct( &halves[k].images, &weights, &options, one, NULL, &error ), &error );
        for ( int i = 0; i < 3 * PIXELS; ++i )
            rgb[i] += 0.5f * one[i];
    }
}

static void solve_crossfit( const RfGradientHalf halves[2], float* rgb )
{
    RfReconstructOptions options = weighted();
    RfReconstructInfo info;
    RfError error;
    must( rf_reconstruct_halves( halves, &options, rgb, NULL, &info, &error ), &error );
    assert_true( info.converged && !info.biased );
}

// t of the mean error of the whole image, and the largest |t| of a block; *squares is the mean squared error.
static double judge( void ( *solve )( const RfGradientHalf halves[2], float* rgb ), int seeds, double* worst, double* squares )
{
    AUTO_FREE double* values = malloc( (size_t)( seeds * ( BLOCKS + 1 ) ) * sizeof *values );
    float rgb[3 * PIXELS];
    assert_non_null( values );
    memset( values, 0, (size_t)( seeds * ( BLOCKS + 1 ) ) * sizeof *values );
    *squares = *worst = 0.0;
    for ( int seed = 0; seed < seeds; ++seed )
    {
        RfGradientHalf halves[2];
        for ( uint32_t k = 0; k < 2; ++k )
            halves[k] = make_half( s_planes + k, (uint64_t)seed + 1, k );
        solve( halves, rgb );
        for ( int i = 0; i < PIXELS; ++i )
        {
            int x = i % WIDTH, y = i / WIDTH, block = y / BLOCK * ( WIDTH / BLOCK ) + x / BLOCK;
            double error = (double)rgb[3 * i] - truth( x, y );
            values[seed] += error / PIXELS;
            values[( block + 1 ) * seeds + seed] += error;
            *squares += error * error / PIXELS / seeds;
        }
    }
    double standard_error, whole = mean_of( values, seeds, &standard_error );
    whole /= standard_error;
    for ( int k = 1; k <= BLOCKS; ++k )
    {
        double mean = mean_of( values + k * seeds, seeds, &standard_error );
        *worst = fmax( *worst, fabs( mean / standard_error ) );
    }
    return whole;
}

TEST( test_weights_of_the_other_half_are_unbiased )
{
    double worst, squares, own_worst, own_squares;
    int seeds = getenv( "REFRAME_LONG" ) != NULL ? 40000 : 4000;
    double whole = judge( solve_crossfit, seeds, &worst, &squares );
    double own = judge( solve_by_own_weights, seeds, &own_worst, &own_squares );
    printf( "%d seeds: t = %.2f, of blocks at most %.2f, mse %.4f; weights of the same half: t = %.1f, mse %.4f\n", seeds, whole,
            worst, squares, own, own_squares );
    assert_false( is_far_off( whole, seeds - 1 ) );
    assert_true( worst < 4.5 ); // of 20: 1.4e-4
    assert_true( own < -20.0 ); // the test sees a bias
}

static void mean_of_halves( const RfGradientHalf halves[2], float* rgb )
{
    for ( int i = 0; i < 3 * PIXELS; ++i )
        rgb[i] = 0.5f * ( halves[0].images.primal[i] + halves[1].images.primal[i] );
}

static void constant_weights( const RfGradientHalf halves[2], float* rgb )
{
    RfReconstructOptions options = rf_default_reconstruct_options();
    RfError error;
    float solved[2][3 * PIXELS];
    for ( int k = 0; k < 2; ++k )
        must( rf_reconstruct( &halves[k].images, NULL, &options, solved[k], NULL, &error ), &error );
    for ( int i = 0; i < 3 * PIXELS; ++i )
        rgb[i] = 0.5f * ( solved[0][i] + solved[1][i] );
}

// Gradients help, and the more so where weights know how good they are.
TEST( test_weights_of_the_other_half_beat_constant_ones )
{
    double worst, primal, constant, crossfit;
    double t_primal = judge( mean_of_halves, 500, &worst, &primal ), t = judge( constant_weights, 500, &worst, &constant );
    judge( solve_crossfit, 500, &worst, &crossfit );
    printf( "mse: primal %.4f, alpha 0.2 %.4f, weights of the other half %.4f\n", primal, constant, crossfit );
    assert_false( is_far_off( t_primal, 499 ) || is_far_off( t, 499 ) );
    assert_true( constant < 0.6 * primal && crossfit < 0.9 * constant );
}

TEST( test_weights_are_inverses_of_smoothed_variances )
{
    float rooms[2][PIXELS], a[PIXELS], b_x[PIXELS], b_y[PIXELS];
    float* const scratch[2] = { rooms[0], rooms[1] };
    RfGradientHalf half = make_half( s_planes, 1, 0 );
    for ( int i = 0; i < 3 * PIXELS; ++i )
        s_planes[0].primal[i] = 1.0f;
    for ( int i = 0; i < PIXELS; ++i )
        s_planes[0].variance[i] = s_planes[0].variance_dx[i] = s_planes[0].variance_dy[i] = 4.0f;
    for ( int y = 0; y < HEIGHT; ++y )
        s_planes[0].variance_dx[y * WIDTH + WIDTH - 1] = NAN; // not read
    s_planes[0].variance[4 * WIDTH + 5] = 104.0f;
    rf_weights_of_half( &half, scratch, a, b_x, b_y );
    // 24 of 4 and one of 104 are 8 on average: half the weight, in the corner of the window too
    assert_true( fabsf( a[4 * WIDTH + 5] / a[0] - 0.5f ) < 1e-6f && fabsf( a[2 * WIDTH + 3] / a[0] - 0.5f ) < 1e-6f );
    assert_true( fabsf( a[1 * WIDTH + 5] / a[0] - 1.0f ) < 1e-6f );
    assert_true( b_x[0] == a[0] && b_y[0] == a[0] && b_x[WIDTH - 1] == 0.0f && b_y[PIXELS - 1] == 0.0f );
    memset( s_planes[0].variance, 0, sizeof s_planes[0].variance ); // certain by chance
    rf_weights_of_half( &half, scratch, a, b_x, b_y );
    assert_true( a[0] / b_x[0] > 1e5f && isfinite( a[0] / b_x[0] ) );
    memset( s_planes[0].variance_dx, 0, sizeof s_planes[0].variance );
    memset( s_planes[0].variance_dy, 0, sizeof s_planes[0].variance );
    rf_weights_of_half( &half, scratch, a, b_x, b_y );
    assert_true( isfinite( a[0] ) && a[0] == b_x[0] && a[0] == b_y[0] );
}

// A window on the left, with noise at its edge: the wall beside it keeps the weight that its own noise deserves, and only
// the differences across the edge lose theirs.
TEST( test_bright_pixels_do_not_decide_on_dark_ones )
{
    float rooms[2][PIXELS], a[PIXELS], b_x[PIXELS], b_y[PIXELS];
    float* const scratch[2] = { rooms[0], rooms[1] };
    RfGradientHalf half = make_half( s_planes, 1, 0 );
    const int edge = WIDTH / 2, row = HEIGHT / 2 * WIDTH;
    for ( int i = 0; i < PIXELS; ++i )
    {
        bool window = i % WIDTH < edge;
        for ( int c = 0; c < 3; ++c )
            s_planes[0].primal[3 * i + c] = window ? 30.0f : 0.03f;
        s_planes[0].variance[i] = i % WIDTH == edge - 1 ? 90.0f : 9e-5f; // a tenth of the brightness squared
        s_planes[0].variance_dx[i] = i % WIDTH == edge - 1 ? 90.0f : 9e-6f;
        s_planes[0].variance_dy[i] = 9e-6f;
    }
    rf_weights_of_half( &half, scratch, a, b_x, b_y );
    assert_true( a[row + edge] > 0.2f * a[row + WIDTH - 1] );
    assert_true( b_x[row + edge - 1] < 1e-4f * a[row + edge] );
    assert_true( b_x[row + edge] > a[row + edge] && b_y[row + edge] > a[row + edge] );
}

TEST( test_halves_count_by_their_passes )
{
    RfReconstructOptions options = weighted();
    RfError error;
    static float rgb[3 * PIXELS], of_half[2][3 * PIXELS];
    float* const solutions[2] = { of_half[0], of_half[1] };
    RfGradientHalf halves[2] = { make_half( s_planes, 7, 0 ), make_half( s_planes + 1, 7, 1 ) };
    halves[0].passes = 3.0;
    halves[1].passes = 1.0;
    must( rf_reconstruct_halves( halves, &options, rgb, solutions, NULL, &error ), &error );
    for ( int i = 0; i < 3 * PIXELS; ++i )
        assert_true( fabsf( rgb[i] - ( 0.75f * of_half[0][i] + 0.25f * of_half[1][i] ) ) < 1e-6f );
    assert_true( fabsf( of_half[0][0] - of_half[1][0] ) > 1e-4f );
}

TEST( test_halves_that_do_not_fit_are_refused )
{
    RfReconstructOptions options = weighted();
    RfError error;
    static float rgb[3 * PIXELS];
    RfGradientHalf halves[2] = { make_half( s_planes, 7, 0 ), make_half( s_planes + 1, 7, 1 ) };
    halves[1].passes = 0.0;
    assert_int_equal( rf_reconstruct_halves( halves, &options, rgb, NULL, NULL, &error ), RF_ERROR_USAGE );
    assert_non_null( strstr( error.text, "0 passes" ) );
    halves[1].passes = 4.0;
    s_planes[1].variance_dy[5] = -1.0f;
    assert_int_equal( rf_reconstruct_halves( halves, &options, rgb, NULL, NULL, &error ), RF_ERROR_USAGE );
    assert_non_null( strstr( error.text, "variance of dy: -1 at pixel (5, 0)" ) );
    s_planes[1].variance_dy[5] = 1.0f;
    halves[1].images.width -= 1;
    assert_int_equal( rf_reconstruct_halves( halves, &options, rgb, NULL, NULL, &error ), RF_ERROR_USAGE );
    halves[1].images.width += 1;
    options.method = RF_RECONSTRUCT_L2;
    assert_int_equal( rf_reconstruct_halves( halves, &options, rgb, NULL, NULL, &error ), RF_ERROR_USAGE );
}

int main( void )
{
    omp_set_num_threads( 1 ); // the images are tiny
    return run_listed_tests();
}
