#include "gradient/check.h"
#include "gradient/reconstruct.h"
#include "gradient/solver.h"

#include <math.h>

#define RADIUS 2            // of the smoothing
#define LEAST_VARIANCE 1e-6 // relative to the geometric mean: a few passes that agree by chance are not certain

// Pixels of a plane that count: columns·rows of width·height.
typedef struct Extent
{
    int width, columns, rows;
} Extent;

static int from_of( int i ) { return i > RADIUS ? i - RADIUS : 0; }

static int to_of( int i, int count ) { return i + RADIUS < count ? i + RADIUS + 1 : count; }

// Averages over 5x5 pixels, first along rows, then along columns.
static void smooth( const float* from, Extent e, float* scratch, float* to )
{
    for ( int y = 0; y < e.rows; ++y )
    {
        const float* row = from + (size_t)y * (size_t)e.width;
        for ( int x = 0; x < e.columns; ++x )
        {
            int first = from_of( x ), end = to_of( x, e.columns );
            double sum = 0.0;
            for ( int k = first; k < end; ++k )
                sum += (double)row[k];
            scratch[(size_t)y * (size_t)e.width + (size_t)x] = (float)( sum / ( end - first ) );
        }
    }
    for ( int y = 0; y < e.rows; ++y )
    {
        int first = from_of( y ), end = to_of( y, e.rows );
        for ( int x = 0; x < e.columns; ++x )
        {
            double sum = 0.0;
            for ( int k = first; k < end; ++k )
                sum += (double)scratch[(size_t)k * (size_t)e.width + (size_t)x];
            to[(size_t)y * (size_t)e.width + (size_t)x] = (float)( sum / ( end - first ) );
        }
    }
}

// Σ log of the values above 0, and their number.
static double sum_logs( const float* values, Extent e, size_t* count )
{
    double sum = 0.0;
    for ( int y = 0; y < e.rows; ++y )
    {
        for ( int x = 0; x < e.columns; ++x )
        {
            float value = values[(size_t)y * (size_t)e.width + (size_t)x];
            sum += value > 0.0f ? log( (double)value ) : 0.0;
            *count += value > 0.0f;
        }
    }
    return sum;
}

static void invert( float* values, Extent e, int height, double typical )
{
    for ( int y = 0; y < height; ++y )
    {
        for ( int x = 0; x < e.width; ++x )
        {
            float* value = values + (size_t)y * (size_t)e.width + (size_t)x;
            double variance = fmax( (double)*value, LEAST_VARIANCE * typical );
            *value = x < e.columns && y < e.rows ? (float)( typical / variance ) : 0.0f;
        }
    }
}

void rf_weights_of_half( const RfGradientHalf* half, float* scratch, float* a, float* b_x, float* b_y )
{
    int w = half->images.width, h = half->images.height;
    const float* variances[3] = { half->variance, half->variance_dx, half->variance_dy };
    const Extent extents[3] = { { w, w, h }, { w, w - 1, h }, { w, w, h - 1 } };
    float* weights[3] = { a, b_x, b_y };
    size_t count = 0;
    double sum = 0.0;
    for ( int k = 0; k < 3; ++k )
    {
        smooth( variances[k], extents[k], scratch, weights[k] );
        sum += sum_logs( weights[k], extents[k], &count );
    }
    double typical = count > 0 ? exp( sum / (double)count ) : 1.0;
    for ( int k = 0; k < 3; ++k )
        invert( weights[k], extents[k], h, typical );
}

static RfResult check_half( const RfGradientHalf* half, float* scale, RfError* error )
{
    int w = half->images.width, h = half->images.height;
    RfResult result = rf_check_gradients( &half->images, NULL, scale, error );
    if ( result == RF_OK )
        result = rf_check_plane( half->variance, w, h, 0, 0, "variance of the primal", error );
    if ( result == RF_OK )
        result = rf_check_plane( half->variance_dx, w, h, 1, 0, "variance of dx", error );
    if ( result == RF_OK )
        result = rf_check_plane( half->variance_dy, w, h, 0, 1, "variance of dy", error );
    if ( result == RF_OK && !( half->passes > 0.0 && isfinite( half->passes ) ) )
        result = rf_fail( error, RF_ERROR_USAGE, "a half of %g passes has no share in the average", half->passes );
    return result;
}

static void keep_worst( const RfReconstructInfo* of_half, RfReconstructInfo* info )
{
    info->iterations = of_half->iterations > info->iterations ? of_half->iterations : info->iterations;
    info->residual = of_half->residual > info->residual ? of_half->residual : info->residual;
    info->converged = info->converged && of_half->converged;
}

// Solves for the data of half k with weights of the other one, and adds its share to rgb.
static RfResult solve_half( const RfGradientHalf halves[2], int k, float scale, const RfReconstructOptions* options, float* rgb,
                            float* of_half, RfReconstructInfo* info, RfError* error )
{
    RfGradientSolver solver;
    RfGradientSystem* system = &solver.system;
    RfResult result = rf_create_solver( &halves[k].images, scale, options, &solver, error );
    if ( result != RF_OK )
        return result;
    rf_weights_of_half( halves + 1 - k, solver.channels[0].r, system->a, system->b_x, system->b_y );
    rf_solve_weighted( options, &solver );
    RfReconstructInfo solved = rf_solver_info( &solver );
    keep_worst( &solved, info );
    double share = halves[k].passes / ( halves[0].passes + halves[1].passes );
    result = rf_write_solution( &solver, share, k > 0, rgb, error );
    if ( result == RF_OK && of_half != NULL )
        result = rf_write_solution( &solver, 1.0, false, of_half, error );
    rf_destroy_solver( &solver );
    return result;
}

RfResult rf_reconstruct_halves( const RfGradientHalf halves[2], const RfReconstructOptions* options, float* rgb,
                                float* const of_half[2], RfReconstructInfo* info, RfError* error )
{
    float scales[2];
    RfReconstructInfo worst = { .converged = true };
    if ( options->method != RF_RECONSTRUCT_WEIGHTED )
        return rf_fail( error, RF_ERROR_USAGE, "two halves are of the weighted reconstruction" );
    if ( halves[0].images.width != halves[1].images.width || halves[0].images.height != halves[1].images.height )
        return rf_fail( error, RF_ERROR_USAGE, "the halves differ in size" );
    RfResult result = rf_check_reconstruct_options( options, true, error );
    for ( int k = 0; k < 2 && result == RF_OK; ++k )
        result = check_half( halves + k, scales + k, error );
    for ( int k = 0; k < 2 && result == RF_OK; ++k )
        result = solve_half( halves, k, scales[k], options, rgb, of_half != NULL ? of_half[k] : NULL, &worst, error );
    if ( result == RF_OK && info != NULL )
        *info = worst;
    return result;
}
