// How long reconstructions take on one core, and how well they converge: constant weights, weights that differ by
// orders of magnitude, L1; and what other preconditioners would take for one channel of the weighted one. Data are a
// picture of tiles with noise.
// Usage: bench_reconstruct [WIDTH HEIGHT]     (default 1920 1080)
#include "base/random.h"
#include "base/system.h"
#include "gradient/system.h"
#include "gradient/reconstruct.h"
#include "gradient/solver.h"

#include <math.h>
#include <omp.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

static void print_info( const char* name, double seconds, const RfReconstructInfo* info )
{
    printf( "%-10s %7.2f s %6d iterations, residual %.1e%s\n", name, seconds, info->iterations, info->residual,
            info->converged ? "" : ", not converged" );
}

// Two halves of the same data; weights serve as variances, which differ as much: those of b for the primal, of a for gradients.
static void run_halves( const Bench* b )
{
    RfReconstructOptions options = rf_default_reconstruct_options();
    RfGradientHalf half = { b->in, b->b_x, b->a, b->a, 1.0 };
    const RfGradientHalf halves[2] = { half, half };
    RfReconstructInfo info;
    options.method = RF_RECONSTRUCT_WEIGHTED;
    double start = rf_process_seconds();
    if ( rf_reconstruct_halves( halves, &options, b->rgb, NULL, &info, NULL ) != RF_OK )
        exit( 1 );
    print_info( "two halves", rf_process_seconds() - start, &info );
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
    print_info( name, rf_process_seconds() - start, &info );
}

typedef enum Kind
{
    JACOBI,        // the diagonal
    COSINE,        // the mean weights, solved by the cosine transform
    SCALED_COSINE, // the same after scaling to a diagonal of 1
    MULTIGRID
} Kind;

static const char* const s_kinds[] = { "diagonal", "cosine transform", "scaled cosine transform", "multigrid" };

// One channel by conjugate gradients in plain loops.
typedef struct Solve
{
    RfGradientSystem system;
    RfMultigrid grid;
    RfMultigridVectors vectors;
    RfCosineTransform transform;
    float *u, *r, *z, *p, *q, *scale;
    double a[4], b[4]; // constant weights of each kind
    size_t count;
} Solve;

static void precondition( Solve* s, Kind kind )
{
    size_t count = s->count;
    if ( kind == MULTIGRID )
    {
        rf_multigrid_cycle( &s->grid, &s->vectors, s->r, s->z );
        return;
    }
    for ( size_t i = 0; i < count; ++i )
        s->z[i] = s->r[i] * ( kind == COSINE ? 1.0f : kind == JACOBI ? s->system.inverse_diagonal[i] : s->scale[i] );
    if ( kind != JACOBI )
        rf_solve_constant( &s->transform, s->a[kind], s->b[kind], s->b[kind], s->z );
    for ( size_t i = 0; i < count && kind == SCALED_COSINE; ++i )
        s->z[i] *= s->scale[i];
}

static double dot( const float* a, const float* b, size_t count )
{
    double sum = 0.0;
    for ( size_t i = 0; i < count; ++i )
        sum += (double)a[i] * (double)b[i];
    return sum;
}

static void iterate( const Bench* b, Solve* s, Kind kind )
{
    const double tolerance = 1e-6;
    const int most = 200;
    size_t bytes = s->count * sizeof( float );
    int k = 0;
    memset( s->u, 0, bytes );
    rf_system_residual( &s->system, &b->in, 0, 1.0f, s->u, s->r );
    double start = rf_process_seconds(), norm = rf_system_norm( &s->system, &b->in, 0, 1.0f ), residual = 1.0;
    precondition( s, kind );
    memcpy( s->p, s->z, bytes );
    double product = dot( s->r, s->z, s->count );
    while ( k < most && residual > tolerance )
    {
        rf_system_apply( &s->system, s->p, s->q );
        float alpha = (float)( product / dot( s->p, s->q, s->count ) );
        for ( size_t i = 0; i < s->count; ++i )
            s->u[i] += alpha * s->p[i], s->r[i] -= alpha * s->q[i];
        residual = rf_system_residual_norm( &s->system, s->r ) / norm;
        precondition( s, kind );
        double next = dot( s->r, s->z, s->count );
        float beta = (float)( next / product );
        product = next;
        for ( size_t i = 0; i < s->count; ++i )
            s->p[i] = s->z[i] + beta * s->p[i];
        ++k;
    }
    printf( "  %-24s %8.2f s %6d iterations, residual %.1e\n", s_kinds[kind], rf_process_seconds() - start, k, residual );
}

static void set_weights( const Bench* b, Solve* s )
{
    size_t w = (size_t)b->width;
    double sum_a = 0.0, sum_b = 0.0, share = 0.0, n = (double)s->count;
    for ( size_t i = 0; i < s->count; ++i )
    {
        s->system.a[i] = b->a[i];
        s->system.b_x[i] = ( i + 1 ) % w != 0 ? b->b_x[i] : 0.0f;
        s->system.b_y[i] = i + w < s->count ? b->b_y[i] : 0.0f;
        sum_a += (double)s->system.a[i];
        sum_b += 0.5 * (double)( s->system.b_x[i] + s->system.b_y[i] );
    }
    rf_finish_system( &s->system );
    for ( size_t i = 0; i < s->count; ++i )
    {
        s->scale[i] = sqrtf( s->system.inverse_diagonal[i] );
        share += (double)( s->system.a[i] * s->system.inverse_diagonal[i] );
    }
    s->a[COSINE] = sum_a / n, s->b[COSINE] = sum_b / n;
    s->a[SCALED_COSINE] = share / n, s->b[SCALED_COSINE] = 0.25 * ( 1.0 - share / n );
}

static void compare_preconditioners( const Bench* b )
{
    static Solve s;
    size_t planes = 10 * rf_plane_bytes( b->width, b->height );
    char* memory = aligned_alloc( 64, planes + rf_multigrid_bytes( b->width, b->height ) +
                                          rf_multigrid_vector_bytes( b->width, b->height ) );
    void* all = memory;
    float** const to[10] = { &s.system.a, &s.system.b_x, &s.system.b_y, &s.system.inverse_diagonal, &s.u, &s.r, &s.z,
                             &s.p,        &s.q,          &s.scale };
    if ( memory == NULL )
        abort();
    s.system.width = b->width, s.system.height = b->height;
    s.count = b->pixels;
    for ( int k = 0; k < 10; ++k )
        *to[k] = rf_plane( b->width, b->height, &memory );
    rf_build_multigrid( &s.system, &memory, &s.grid );
    rf_build_multigrid_vectors( &s.grid, &memory, &s.vectors );
    set_weights( b, &s );
    rf_coarsen_multigrid( &s.grid );
    if ( rf_create_transform( b->width, b->height, s.z, &s.transform, NULL ) != RF_OK )
        abort();
    printf( "one channel, weighted, preconditioned by\n" );
    for ( int kind = JACOBI; kind <= MULTIGRID; ++kind )
        iterate( b, &s, (Kind)kind );
    rf_destroy_transform( &s.transform );
    free( all );
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
    run_halves( &b );
    run( &b, "l1", RF_RECONSTRUCT_L1 );
    compare_preconditioners( &b );
    return 0;
}
