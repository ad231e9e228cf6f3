// How long reconstructions take on one core, and how well they converge: constant weights, weights that differ by
// orders of magnitude, L1. Data are a picture of tiles with noise.
// Usage: bench_reconstruct [WIDTH HEIGHT]     (default 1920 1080)
#include "base/random.h"
#include "base/system.h"
#include "gradient/reconstruct.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct Bench
{
    int width, height;
    size_t pixels;
    RfGradientImages in;
    float *primal, *dx, *dy, *a, *b_x, *b_y, *rgb;
} Bench;

static float* floats( size_t count )
{
    float* memory = malloc( count * sizeof *memory );
    if ( memory == NULL )
        abort();
    return memory;
}

static float truth( int x, int y, int channel ) { return ( x / 60 + y / 45 ) % 2 == 0 ? 0.05f : 0.3f + 0.4f * (float)channel; }

static void make( Bench* b )
{
    b->pixels = (size_t)b->width * (size_t)b->height;
    float** const images[4] = { &b->primal, &b->dx, &b->dy, &b->rgb };
    float** const weights[3] = { &b->a, &b->b_x, &b->b_y };
    for ( int k = 0; k < 4; ++k )
        *images[k] = floats( 3 * b->pixels );
    for ( int k = 0; k < 3; ++k )
        *weights[k] = floats( b->pixels );
    for ( size_t i = 0; i < b->pixels; ++i )
    {
        int x = (int)( i % (size_t)b->width ), y = (int)( i / (size_t)b->width );
        RfRandomKey key = rf_pixel_key( rf_pass_key( 1, 0, 0, 0 ), (uint32_t)i );
        for ( int c = 0; c < 3; ++c )
        {
            float v = truth( x, y, c );
            b->primal[3 * i + (size_t)c] = v + 0.5f * ( rf_random( key, (uint32_t)c ) - 0.5f );
            b->dx[3 * i + (size_t)c] = truth( x + 1, y, c ) - v + 0.1f * ( rf_random( key, 3 + (uint32_t)c ) - 0.5f );
            b->dy[3 * i + (size_t)c] = truth( x, y + 1, c ) - v + 0.1f * ( rf_random( key, 6 + (uint32_t)c ) - 0.5f );
        }
        // inverse variances: smooth over four orders of magnitude, poor gradients across edges, and noise
        float field = sinf( 0.013f * (float)x ) + cosf( 0.017f * (float)y ) + ( rf_random( key, 9 ) - 0.5f );
        bool edge = ( x + 1 ) % 60 < 3 || ( y + 1 ) % 45 < 3;
        b->a[i] = 0.04f * expf( 2.0f * field );
        b->b_x[i] = expf( 2.0f * ( field - ( edge ? 2.0f : 0.0f ) + ( rf_random( key, 10 ) - 0.5f ) ) );
        b->b_y[i] = expf( 2.0f * ( field - ( edge ? 2.0f : 0.0f ) + ( rf_random( key, 11 ) - 0.5f ) ) );
    }
    b->in = ( RfGradientImages ){ b->width, b->height, b->primal, b->dx, b->dy };
}

static void run( const Bench* b, const char* name, RfReconstructMethod method )
{
    RfReconstructOptions options = rf_default_reconstruct_options();
    RfGradientWeights weights = { b->a, b->b_x, b->b_y };
    RfReconstructInfo info;
    RfError error;
    options.method = method;
    double start = rf_process_seconds();
    if ( rf_reconstruct( &b->in, method == RF_RECONSTRUCT_WEIGHTED ? &weights : NULL, &options, b->rgb, &info, &error ) != RF_OK )
    {
        fprintf( stderr, "%s\n", error.text );
        exit( 1 );
    }
    printf( "%-9s %8.2f s %6d iterations, residual %.1e%s\n", name, rf_process_seconds() - start, info.iterations, info.residual,
            info.converged ? "" : ", not converged" );
}

int main( int argc, char** argv )
{
    Bench b = { .width = 1920, .height = 1080 };
    if ( argc == 3 )
        b.width = atoi( argv[1] ), b.height = atoi( argv[2] );
    if ( b.width < 1 || b.height < 1 )
        return 2;
    omp_set_num_threads( 1 );
    make( &b );
    printf( "%dx%d, 3 channels, one thread, %zu MiB\n", b.width, b.height, rf_reconstruct_bytes( b.width, b.height ) >> 20 );
    run( &b, "l2", RF_RECONSTRUCT_L2 );
    run( &b, "weighted", RF_RECONSTRUCT_WEIGHTED );
    run( &b, "l1", RF_RECONSTRUCT_L1 );
    return 0;
}
