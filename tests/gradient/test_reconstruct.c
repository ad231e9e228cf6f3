// Reconstruction against dense algebra and known solutions; hard weights and data.
#include "support/test.h"
#include "base/random.h"
#include "reframe/reconstruct.h"

#include <omp.h>

#define MOST 4096 // pixels

typedef struct Problem
{
    RfGradientImages in;
    RfGradientWeights weights;
    float primal[3 * MOST], dx[3 * MOST], dy[3 * MOST], a[MOST], b_x[MOST], b_y[MOST];
} Problem;

static Problem s_problem, s_other;
static float s_rgb[3 * MOST], s_rgb2[3 * MOST];

static float even( uint32_t seed, uint32_t i ) { return rf_random( rf_pixel_key( rf_pass_key( seed, 0, 0, 0 ), i ), 0 ); }

// Data in −1 to 1, weights 10^(−decades) to 1; what lies beyond the border is NaN.
static void make( Problem* p, int width, int height, uint32_t seed, double decades )
{
    int count = width * height;
    assert_true( count <= MOST );
    for ( int i = 0; i < count; ++i )
    {
        bool last_x = i % width == width - 1, last_y = i / width == height - 1;
        for ( int c = 0; c < 3; ++c )
        {
            uint32_t k = (uint32_t)( 9 * i + 3 * c );
            p->primal[3 * i + c] = 2.0f * even( seed, k ) - 1.0f;
            p->dx[3 * i + c] = last_x ? NAN : 2.0f * even( seed, k + 1 ) - 1.0f;
            p->dy[3 * i + c] = last_y ? NAN : 2.0f * even( seed, k + 2 ) - 1.0f;
        }
        uint32_t k = 3 * (uint32_t)i;
        p->a[i] = (float)pow( 10.0, -decades * (double)even( seed + 1, k ) );
        p->b_x[i] = last_x ? NAN : (float)pow( 10.0, -decades * (double)even( seed + 1, k + 1 ) );
        p->b_y[i] = last_y ? NAN : (float)pow( 10.0, -decades * (double)even( seed + 1, k + 2 ) );
    }
    p->in = ( RfGradientImages ){ width, height, p->primal, p->dx, p->dy };
    p->weights = ( RfGradientWeights ){ p->a, p->b_x, p->b_y };
}

static void set_weights( Problem* p, float a, float b )
{
    for ( int i = 0; i < p->in.width * p->in.height; ++i )
        p->a[i] = a, p->b_x[i] = b, p->b_y[i] = b;
}

// Data of an image u(x, y) without noise.
static void make_exact( Problem* p, int width, int height, float ( *u )( int x, int y, int c ) )
{
    make( p, width, height, 1, 0.0 );
    for ( int i = 0; i < width * height; ++i )
    {
        for ( int c = 0; c < 3; ++c )
        {
            int x = i % width, y = i / width;
            p->primal[3 * i + c] = u( x, y, c );
            p->dx[3 * i + c] = u( x + 1, y, c ) - u( x, y, c );
            p->dy[3 * i + c] = u( x, y + 1, c ) - u( x, y, c );
        }
    }
}

// Adds b (u_j − u_i − d)² to the normal equations.
static void add_pair( double* matrix, double* right, int n, int i, int j, double b, double d )
{
    matrix[i * n + i] += b, matrix[j * n + j] += b;
    matrix[i * n + j] -= b, matrix[j * n + i] -= b;
    right[i] -= b * d, right[j] += b * d;
}

// Solves by Cholesky, in place.
static void solve_dense( double* m, double* x, int n )
{
    for ( int j = 0; j < n; ++j )
    {
        for ( int k = 0; k < j; ++k )
        {
            for ( int i = j; i < n; ++i )
                m[i * n + j] -= m[i * n + k] * m[j * n + k];
        }
        double root = sqrt( m[j * n + j] );
        assert_true( root > 0.0 );
        for ( int i = j; i < n; ++i )
            m[i * n + j] /= root;
    }
    for ( int i = 0; i < n; ++i )
    {
        for ( int k = 0; k < i; ++k )
            x[i] -= m[i * n + k] * x[k];
        x[i] /= m[i * n + i];
    }
    for ( int i = n - 1; i >= 0; --i )
    {
        for ( int k = i + 1; k < n; ++k )
            x[i] -= m[k * n + i] * x[k];
        x[i] /= m[i * n + i];
    }
}

// The largest difference from the dense solution, over the largest value.
static double dense_error( const Problem* p, const float* rgb )
{
    int w = p->in.width, n = w * p->in.height;
    double worst = 0.0, largest = 0.0;
    double *matrix = malloc( (size_t)( n * n ) * sizeof *matrix ), *right = malloc( (size_t)n * sizeof *right );
    assert_true( matrix != NULL && right != NULL );
    for ( int c = 0; c < 3; ++c )
    {
        memset( matrix, 0, (size_t)( n * n ) * sizeof *matrix );
        for ( int i = 0; i < n; ++i )
        {
            matrix[i * n + i] = (double)p->a[i];
            right[i] = p->a[i] > 0.0f ? (double)( p->a[i] ) * (double)p->primal[3 * i + c] : 0.0;
        }
        for ( int i = 0; i < n; ++i )
        {
            if ( i % w < w - 1 )
                add_pair( matrix, right, n, i, i + 1, (double)p->b_x[i], (double)p->dx[3 * i + c] );
            if ( i + w < n )
                add_pair( matrix, right, n, i, i + w, (double)p->b_y[i], (double)p->dy[3 * i + c] );
        }
        solve_dense( matrix, right, n );
        for ( int i = 0; i < n; ++i )
        {
            worst = fmax( worst, fabs( (double)rgb[3 * i + c] - right[i] ) );
            largest = fmax( largest, fabs( right[i] ) );
        }
    }
    free( matrix );
    free( right );
    return worst / largest;
}

static RfReconstructInfo solve( const Problem* p, RfReconstructMethod method, float alpha, float* rgb )
{
    RfReconstructOptions options = rf_default_reconstruct_options();
    RfReconstructInfo info;
    RfError error;
    options.method = method;
    options.alpha = alpha;
    const RfGradientWeights* weights = method == RF_RECONSTRUCT_WEIGHTED ? &p->weights : NULL;
    if ( rf_reconstruct( &p->in, weights, &options, rgb, &info, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return info;
}

static const int s_sizes[][2] = { { 1, 1 }, { 1, 7 }, { 9, 1 }, { 2, 2 }, { 3, 3 }, { 5, 4 }, { 6, 11 }, { 16, 9 } };
#define SIZES ( (int)( sizeof s_sizes / sizeof s_sizes[0] ) )

TEST( test_constant_weights_solve_the_dense_system )
{
    const float alphas[3] = { 1.0f, 0.2f, 0.001f };
    for ( int k = 0; k < 3 * SIZES; ++k )
    {
        float alpha = alphas[k % 3];
        make( &s_problem, s_sizes[k / 3][0], s_sizes[k / 3][1], (uint32_t)k, 0.0 );
        RfReconstructInfo info = solve( &s_problem, RF_RECONSTRUCT_L2, alpha, s_rgb );
        set_weights( &s_problem, alpha * alpha, 1.0f );
        double error = dense_error( &s_problem, s_rgb );
        if ( !( error < 5e-6 ) || !info.converged || info.iterations != 0 || info.biased )
            fail_msg( "%dx%d, alpha %g: off by %g, residual %g", s_problem.in.width, s_problem.in.height, (double)alpha, error,
                      info.residual );
    }
}

TEST( test_weights_solve_the_dense_system )
{
    const double decades[4] = { 0.5, 2.0, 4.0, 8.0 }, bounds[4] = { 1e-5, 2e-5, 2e-4, 2e-3 };
    for ( int k = 0; k < 4 * SIZES; ++k )
    {
        make( &s_problem, s_sizes[k / 4][0], s_sizes[k / 4][1], (uint32_t)k, decades[k % 4] );
        RfReconstructInfo info = solve( &s_problem, RF_RECONSTRUCT_WEIGHTED, 1.0f, s_rgb );
        double error = dense_error( &s_problem, s_rgb );
        if ( !( error < bounds[k % 4] ) || !info.converged || info.biased )
            fail_msg( "%dx%d, %g decades: off by %g, residual %g after %d", s_problem.in.width, s_problem.in.height,
                      decades[k % 4], error, info.residual, info.iterations );
    }
}

TEST( test_equal_weights_give_the_answer_of_the_cosine_transform )
{
    make( &s_problem, 64, 63, 5, 0.0 );
    solve( &s_problem, RF_RECONSTRUCT_L2, 0.2f, s_rgb );
    set_weights( &s_problem, 0.04f * 1e-9f, 1e-9f ); // their unit is free
    RfReconstructInfo info = solve( &s_problem, RF_RECONSTRUCT_WEIGHTED, 0.2f, s_rgb2 );
    assert_true( info.converged && info.iterations > 0 && info.iterations < 12 );
    for ( int i = 0; i < 3 * 64 * 63; ++i )
        assert_true( fabsf( s_rgb[i] - s_rgb2[i] ) < 2e-5f );
}

static float saddle( int x, int y, int c ) { return (float)( x * x - y * y + 7 * x ) * ( 1.0f + (float)c ) * 0.01f; }

TEST( test_exact_data_are_the_solution )
{
    const RfReconstructMethod methods[3] = { RF_RECONSTRUCT_L2, RF_RECONSTRUCT_WEIGHTED, RF_RECONSTRUCT_L1 };
    for ( int k = 0; k < 3; ++k )
    {
        make_exact( &s_problem, 40, 31, saddle );
        solve( &s_problem, methods[k], 0.2f, s_rgb );
        for ( int i = 0; i < 3 * 40 * 31; ++i )
            assert_true( fabsf( s_rgb[i] - s_problem.primal[i] ) < 2e-5f );
    }
}

// Given on the border, without gradients inside: the solution is harmonic, and x² − y² is so on a grid too.
TEST( test_borders_alone_give_the_harmonic_image )
{
    make_exact( &s_problem, 33, 30, saddle );
    set_weights( &s_problem, 0.0f, 1.0f );
    for ( int i = 0; i < 33 * 30; ++i )
    {
        int x = i % 33, y = i / 33;
        bool border = x == 0 || y == 0 || x == 32 || y == 29;
        s_problem.a[i] = border ? 1e7f : 0.0f;
        for ( int c = 0; c < 3; ++c )
        {
            s_problem.dx[3 * i + c] = s_problem.dy[3 * i + c] = 0.0f;
            if ( !border )
                s_problem.primal[3 * i + c] = NAN; // of weight 0
        }
    }
    RfReconstructInfo info = solve( &s_problem, RF_RECONSTRUCT_WEIGHTED, 1.0f, s_rgb );
    assert_true( info.converged );
    for ( int i = 0; i < 33 * 30; ++i )
    {
        for ( int c = 0; c < 3; ++c )
            assert_true( fabsf( s_rgb[3 * i + c] - saddle( i % 33, i / 33, c ) ) < 2e-3f );
    }
}

TEST( test_solutions_are_linear_in_the_data )
{
    static float sum[3 * MOST];
    for ( int k = 0; k < 2; ++k )
    {
        RfReconstructMethod method = k == 0 ? RF_RECONSTRUCT_L2 : RF_RECONSTRUCT_WEIGHTED;
        make( &s_problem, 30, 20, 3, 2.0 );
        make( &s_other, 30, 20, 8, 2.0 );
        s_other.weights = s_problem.weights;
        solve( &s_problem, method, 0.2f, s_rgb );
        solve( &s_other, method, 0.2f, s_rgb2 );
        for ( int i = 0; i < 3 * 600; ++i )
        {
            s_problem.primal[i] = 3.0f * s_problem.primal[i] - 2.0f * s_other.primal[i];
            s_problem.dx[i] = 3.0f * s_problem.dx[i] - 2.0f * s_other.dx[i];
            s_problem.dy[i] = 3.0f * s_problem.dy[i] - 2.0f * s_other.dy[i];
        }
        solve( &s_problem, method, 0.2f, sum );
        for ( int i = 0; i < 3 * 600; ++i )
            assert_true( fabsf( sum[i] - ( 3.0f * s_rgb[i] - 2.0f * s_rgb2[i] ) ) < 2e-4f );
    }
}

TEST( test_the_unit_of_the_data_does_not_matter )
{
    const float units[3] = { 0x1p-100f, 0x1p+60f, 0x1p+110f };
    for ( int k = 0; k < 9; ++k )
    {
        RfReconstructMethod method = (RfReconstructMethod)( k % 3 );
        float unit = units[k / 3];
        make( &s_problem, 12, 9, 3, 1.0 );
        solve( &s_problem, method, 0.2f, s_rgb );
        for ( int i = 0; i < 3 * 108; ++i )
            s_problem.primal[i] *= unit, s_problem.dx[i] *= unit, s_problem.dy[i] *= unit;
        solve( &s_problem, method, 0.2f, s_rgb2 );
        for ( int i = 0; i < 3 * 108; ++i )
            assert_true( s_rgb2[i] == s_rgb[i] * unit );
    }
}

// Two halves of an image that no gradient connects; the left one has no primal weight.
TEST( test_without_primal_weight_the_mean_stays )
{
    make( &s_problem, 20, 10, 4, 0.0 );
    double mean = 0.0, found = 0.0;
    for ( int i = 0; i < 200; ++i )
    {
        if ( i % 20 == 9 )
            s_problem.b_x[i] = 0.0f;
        if ( i % 20 < 10 )
            s_problem.a[i] = 0.0f, mean += (double)s_problem.primal[3 * i] / 100.0;
    }
    assert_true( solve( &s_problem, RF_RECONSTRUCT_WEIGHTED, 1.0f, s_rgb ).converged );
    for ( int i = 0; i < 200; ++i )
        found += i % 20 < 10 ? (double)s_rgb[3 * i] / 100.0 : 0.0;
    assert_true( fabs( found - mean ) < 1e-6 );
    // each half is the solution of its own, the left one up to its level
    make( &s_other, 10, 10, 4, 0.0 );
    for ( int y = 0; y < 10; ++y )
    {
        for ( int k = 0; k < 30; ++k )
        {
            s_other.primal[30 * y + k] = s_problem.primal[60 * y + k];
            s_other.dx[30 * y + k] = s_problem.dx[60 * y + k];
            s_other.dy[30 * y + k] = s_problem.dy[60 * y + k];
        }
    }
    solve( &s_other, RF_RECONSTRUCT_L2, 1e-3f, s_rgb2 );
    for ( int y = 0; y < 10; ++y )
    {
        for ( int k = 0; k < 30; ++k )
            assert_true( fabsf( s_rgb[60 * y + k] - s_rgb2[30 * y + k] ) < 2e-4f );
    }
}

static void check_refused( const RfReconstructOptions* options, const RfGradientWeights* weights, const char* part )
{
    RfError error;
    memset( s_rgb, 0, sizeof s_rgb );
    assert_int_equal( rf_reconstruct( &s_problem.in, weights, options, s_rgb, NULL, &error ), RF_ERROR_USAGE );
    if ( strstr( error.text, part ) == NULL )
        fail_msg( "'%s' lacks '%s'", error.text, part );
    assert_true( s_rgb[0] == 0.0f );
}

TEST( test_what_cannot_be_solved_is_refused )
{
    RfReconstructOptions options = rf_default_reconstruct_options(), weighted = options;
    weighted.method = RF_RECONSTRUCT_WEIGHTED;
    make( &s_problem, 6, 4, 1, 1.0 );
    const RfGradientWeights* weights = &s_problem.weights;
    check_refused( &weighted, NULL, "got none" );
    check_refused( &options, weights, "weights are of the weighted" );
    options.alpha = 0.0f;
    check_refused( &options, NULL, "alpha is 0" );
    options.alpha = NAN;
    check_refused( &options, NULL, "alpha is " );
    options.alpha = 0.2f;
    s_problem.a[8] = -1.0f;
    check_refused( &weighted, weights, "weight of the primal: -1 at pixel (2, 1)" );
    s_problem.a[8] = 1.0f;
    s_problem.b_x[6] = INFINITY;
    check_refused( &weighted, weights, "weight of dx: inf at pixel (0, 1)" );
    s_problem.b_x[6] = 1.0f;
    s_problem.dy[3 * 13 + 2] = NAN;
    check_refused( &options, NULL, "dy: NaN at pixel (1, 2)" );
    check_refused( &weighted, weights, "dy: NaN at pixel (1, 2)" );
    s_problem.b_y[13] = 0.0f;
    assert_true( solve( &s_problem, RF_RECONSTRUCT_WEIGHTED, 1.0f, s_rgb ).converged );
    for ( int i = 0; i < 72; ++i )
        assert_true( isfinite( s_rgb[i] ) );
    set_weights( &s_problem, 0.0f, 0.0f );
    check_refused( &weighted, weights, "all weights are 0" );
}

TEST( test_one_iteration_does_not_claim_to_converge )
{
    RfReconstructOptions options = rf_default_reconstruct_options();
    RfReconstructInfo info;
    options.method = RF_RECONSTRUCT_WEIGHTED;
    options.max_iterations = 1;
    make( &s_problem, 40, 40, 6, 4.0 );
    assert_int_equal( rf_reconstruct( &s_problem.in, &s_problem.weights, &options, s_rgb, &info, NULL ), RF_OK );
    assert_true( !info.converged && info.iterations == 1 && info.residual > 1e-4 && info.residual < 1.0 );
}

// Weights over 20 decades, whole regions of them: finite, and near the data that weigh most.
TEST( test_huge_ratios_of_weights )
{
    make( &s_problem, 20, 14, 6, 0.0 );
    for ( int i = 0; i < 20 * 14; ++i )
    {
        float unit = i % 20 < 10 ? 1e-10f : 1e10f;
        s_problem.a[i] *= unit * ( i / 20 < 7 ? 1e-3f : 1.0f );
        s_problem.b_x[i] *= unit;
        s_problem.b_y[i] *= unit;
    }
    RfReconstructInfo info = solve( &s_problem, RF_RECONSTRUCT_WEIGHTED, 1.0f, s_rgb );
    if ( !info.converged || !( dense_error( &s_problem, s_rgb ) < 1e-3 ) )
        fail_msg( "residual %g after %d, off by %g", info.residual, info.iterations, dense_error( &s_problem, s_rgb ) );
}

static float flat( int x, int y, int c ) { return (void)x, (void)y, 0.5f + 0.1f * (float)c; }

// What L1 is for, and what it costs.
TEST( test_l1_drops_outliers_and_says_that_it_is_biased )
{
    make_exact( &s_problem, 30, 30, flat );
    s_problem.primal[3 * 435] = 1000.0f;
    s_problem.dx[3 * 200] = 50.0f;
    RfReconstructInfo info = solve( &s_problem, RF_RECONSTRUCT_L1, 0.2f, s_rgb );
    assert_true( info.biased && info.converged );
    solve( &s_problem, RF_RECONSTRUCT_L2, 0.2f, s_rgb2 );
    float worst = 0.0f, worst2 = 0.0f;
    for ( int i = 0; i < 900; ++i )
    {
        worst = fmaxf( worst, fabsf( s_rgb[3 * i] - 0.5f ) );
        worst2 = fmaxf( worst2, fabsf( s_rgb2[3 * i] - 0.5f ) );
    }
    assert_true( worst < 0.01f && worst2 > 1.0f );
}

TEST( test_same_bits_for_any_threads_and_memory )
{
    size_t bytes = rf_reconstruct_bytes( 61, 47 );
    AUTO_FREE char* work = aligned_alloc( 64, bytes + 64 );
    assert_non_null( work );
    for ( int k = 0; k < 3; ++k )
    {
        RfReconstructOptions options = rf_default_reconstruct_options();
        options.method = (RfReconstructMethod)k;
        make( &s_problem, 61, 47, 9, 2.0 );
        const RfGradientWeights* weights = options.method == RF_RECONSTRUCT_WEIGHTED ? &s_problem.weights : NULL;
        omp_set_num_threads( 3 );
        assert_int_equal( rf_reconstruct( &s_problem.in, weights, &options, s_rgb, NULL, NULL ), RF_OK );
        omp_set_num_threads( 1 );
        memset( work, 0x7f, bytes + 64 );
        options.work = work;
        assert_int_equal( rf_reconstruct( &s_problem.in, weights, &options, s_problem.primal, NULL, NULL ), RF_OK ); // in place
        assert_memory_equal( s_rgb, s_problem.primal, 3 * 61 * 47 * sizeof( float ) );
        for ( int i = 0; i < 64; ++i )
            assert_true( work[bytes + (size_t)i] == 0x7f );
    }
}
