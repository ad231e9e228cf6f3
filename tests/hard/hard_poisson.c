// Input cases of Poisson systems.
#include "hard/hard_inputs.h"
#include "reframe/reconstruct.h"

#include <math.h>
#include <stdlib.h>

// Solves a Poisson system of equal data and returns how far the result is from it.
static double solve_equal( int width, int height, RfReconstructMethod method, float weight, float value )
{
    size_t count = (size_t)width * (size_t)height;
    float *primal = malloc( 3 * count * sizeof( float ) ), *zero = calloc( 3 * count, sizeof( float ) );
    float *weights = malloc( count * sizeof( float ) ), *rgb = calloc( 3 * count, sizeof( float ) );
    if ( primal == NULL || zero == NULL || weights == NULL || rgb == NULL )
        abort();
    for ( size_t i = 0; i < 3 * count; ++i )
        primal[i] = value;
    for ( size_t i = 0; i < count; ++i )
        weights[i] = weight;
    RfGradientImages in = { width, height, primal, zero, zero };
    RfGradientWeights w = { weights, weights, weights };
    RfReconstructOptions options = rf_default_reconstruct_options();
    RfError error;
    options.method = method;
    RfResult result = rf_reconstruct( &in, method == RF_RECONSTRUCT_WEIGHTED ? &w : NULL, &options, rgb, NULL, &error );
    double worst = 0.0;
    for ( size_t i = 0; i < 3 * count; ++i )
        worst =
            fmax( worst, isfinite( rgb[i] ) ? fabs( ( (double)rgb[i] - (double)value ) / ( value > 0.0f ? (double)value : 1.0 ) )
                                            : INFINITY );
    free( primal );
    free( zero );
    free( weights );
    free( rgb );
    if ( weight == 0.0f ) // must be refused
        return result == RF_ERROR_USAGE ? 0.0 : INFINITY;
    return result == RF_OK ? worst : INFINITY;
}

static HardInput poisson( void )
{
    HardInput out = { 0 };
    static const int sizes[][2] = { { 1, 1 }, { 1, 37 }, { 37, 1 }, { 1, 4096 }, { 2, 1 }, { 3, 3 }, { 16, 12 } };
    static const float values[] = { 1.0f, 1e-30f, 1e30f, 0.0f };
    double worst = 0.0;
    for ( int s = 0; s < 7; ++s )
    {
        for ( int v = 0; v < 4; ++v )
        {
            for ( int m = RF_RECONSTRUCT_L2; m <= RF_RECONSTRUCT_L1; ++m )
            {
                worst = fmax( worst, solve_equal( sizes[s][0], sizes[s][1], (RfReconstructMethod)m, 1.0f, values[v] ) );
                if ( m == RF_RECONSTRUCT_WEIGHTED )
                    worst =
                        fmax( worst, fmax( solve_equal( sizes[s][0], sizes[s][1], RF_RECONSTRUCT_WEIGHTED, 1e-38f, values[v] ),
                                           solve_equal( sizes[s][0], sizes[s][1], RF_RECONSTRUCT_WEIGHTED, 1e38f, values[v] ) ) );
            }
        }
    }
    out.holds = worst < 1e-5;
    HARD_TELL( "1x1, 1xn, equal data from 0 to 1e30, weights of 1e-38 to 1e38: off by %.2g", worst );
}

// Random data times 1e-30 and 1e30: the solution is that of the data, times as much.
static HardInput poisson_scaled( void )
{
    enum
    {
        W = 9,
        H = 7
    };
    HardInput out = { 0 };
    static const double scales[] = { 1.0, 1e-30, 1e30 };
    float data[3][3 * W * H], rgb[3][3 * W * H], weights[W * H];
    double worst = 0.0;
    for ( int m = RF_RECONSTRUCT_L2; m <= RF_RECONSTRUCT_L1; ++m )
    {
        for ( int s = 0; s < 3; ++s )
        {
            for ( uint32_t i = 0; i < 3 * W * H; ++i )
            {
                for ( uint32_t k = 0; k < 3; ++k )
                    data[k][i] = (float)( scales[s] * (double)( hard_even( i, k ) - ( k > 0 ? 0.5f : 0.0f ) ) );
                weights[i / 3] = 0.1f + hard_even( i, 3 );
            }
            RfGradientImages in = { W, H, data[0], data[1], data[2] };
            RfGradientWeights w = { weights, weights, weights };
            RfReconstructOptions options = rf_default_reconstruct_options();
            RfError error;
            options.method = (RfReconstructMethod)m;
            RfResult result = rf_reconstruct( &in, m == RF_RECONSTRUCT_WEIGHTED ? &w : NULL, &options, rgb[s], NULL, &error );
            for ( int i = 0; i < 3 * W * H; ++i )
            {
                double off = fabs( (double)rgb[s][i] / scales[s] - (double)rgb[0][i] );
                worst = result == RF_OK && off <= 1e30 ? fmax( worst, off ) : INFINITY;
            }
        }
    }
    out.holds = worst < 1e-3;
    HARD_TELL( "random data times 1e-30 and 1e30: off by %.2g at most", worst );
}

static HardInput poisson_zero( void )
{
    HardInput out = { 0 };
    double worst = 0.0;
    static const int sizes[][2] = { { 1, 1 }, { 1, 37 }, { 16, 12 } };
    for ( int s = 0; s < 3; ++s )
        worst = fmax( worst, solve_equal( sizes[s][0], sizes[s][1], RF_RECONSTRUCT_WEIGHTED, 0.0f, 1.0f ) );
    out.holds = worst == 0.0;
    HARD_TELL( "all weights 0: refused by a message" );
}

// Only the first pixel of a row has a primal weight; half of the pairs have none.
static HardInput poisson_open( void )
{
    HardInput out = { .holds = true };
    enum
    {
        N = 33
    };
    float primal[3 * N], zero[3 * N] = { 0 }, a[N] = { 1.0f }, b[N], rgb[3 * N];
    for ( int i = 0; i < N; ++i )
        b[i] = i < N / 2 ? 1.0f : 0.0f;
    for ( int i = 0; i < 3 * N; ++i )
        primal[i] = i < 3 ? 5.0f : NAN;
    RfGradientImages in = { N, 1, primal, zero, zero };
    RfGradientWeights w = { a, b, b };
    RfReconstructOptions options = rf_default_reconstruct_options();
    RfError error;
    options.method = RF_RECONSTRUCT_WEIGHTED;
    for ( int i = 3; i < 3 * N; ++i )
        primal[i] = 7.0f; // weight 0
    if ( rf_reconstruct( &in, &w, &options, rgb, NULL, &error ) != RF_OK )
        out.holds = false;
    for ( int i = 0; i < 3 * N; ++i )
        out.holds = out.holds && isfinite( rgb[i] ) && ( i > 3 * ( N / 2 ) || fabsf( rgb[i] - 5.0f ) < 1e-3f );
    HARD_TELL( "a row with the weight of one pixel, and pixels that nothing ties to it" );
}

const HardCase g_hard_poisson[] = {
    { "poisson-equal", "Poisson systems of 1x1, 1xn and of equal data", "no neighbours, no gradient", HARD_INPUT, 0, NULL,
      poisson },
    { "poisson-scaled", "Poisson systems of radiance 1e-30 and 1e30", "squares of distances", HARD_INPUT, 0, NULL,
      poisson_scaled },
    { "poisson-zero-weights", "Poisson systems whose weights are all 0", "1/diagonal", HARD_INPUT, 0, NULL, poisson_zero },
    { "poisson-open", "parts of a system that nothing ties to data", "a singular matrix", HARD_INPUT, 0, NULL, poisson_open },
    { 0 },
};
