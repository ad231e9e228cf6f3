// Reconstructs an image from pixels and differences: checks the input, computes weights, solves, and sets the
// level of what no weight determines.
#include "gradient/solver.h"

#include "base/fault.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define RADIUS 2            // of the average
#define MUCH_BRIGHTER 10.0f // times as bright
#define LEAST_VARIANCE 1e-6 // relative to the geometric mean: a few passes that agree by chance are not certain
#define FIRST_FLOOR 0.05f   // of distances, relative to the mean of the primal; it is halved in each round
#define LAST_FLOOR 1e-4f
#define SETTLED 1e-3         // relative change of the norm in a round
#define ROUND_TOLERANCE 1e-3 // of the solves before the last
#define LEAST_WEIGHT 1e-30f  // of the largest; what is below counts as 0

// Pixels of a plane that count: columns·rows of width·height.
typedef struct Extent
{
    int width, columns, rows;
} Extent;

// The pixels, and the pairs of neighbours that differences in x and y are of.
enum
{
    PIXELS,
    PAIRS_X,
    PAIRS_Y,
    PLANES,
};

static const char* const s_data[PLANES] = { "primal", "dx", "dy" };
static const char* const s_weights[PLANES] = { "weight of the primal", "weight of dx", "weight of dy" };
static const char* const s_variances[PLANES] = { "variance of the primal", "variance of dx", "variance of dy" };

static Extent extent_of( const RfGradientImages* in, int of )
{
    return ( Extent ){ .width = in->width, .columns = in->width - ( of == PAIRS_X ), .rows = in->height - ( of == PAIRS_Y ) };
}

// Fails with RF_ERROR_USAGE where options are out of range, or do not go with the weights.
static RfResult check_reconstruct_options( const RfReconstructOptions* options, bool has_weights, RfError* error )
{
    bool weighted = options->method == RF_RECONSTRUCT_WEIGHTED;
    if ( weighted != has_weights )
        return rf_fail( error, RF_ERROR_USAGE,
                        weighted ? "the weighted reconstruction needs weights, and got none"
                                 : "weights are of the weighted reconstruction, not of the others" );
    // a square of alpha that is no float or drowns in the gradients says nothing of the image
    if ( !weighted && ( !isgreaterequal( options->alpha, 1e-4f ) || !islessequal( options->alpha, 1e4f ) ) )
        return rf_fail( error, RF_ERROR_USAGE, "alpha is %g: choose one from 0.0001 to 10000", (double)options->alpha );
    if ( options->method != RF_RECONSTRUCT_L2 && ( !isgreater( options->tolerance, 0.0 ) || options->max_iterations < 1 ) )
        return rf_fail( error, RF_ERROR_USAGE, "the tolerance must be above 0 and the iterations at least 1, got %g and %d",
                        options->tolerance, options->max_iterations );
    if ( options->method == RF_RECONSTRUCT_L1 && options->l1_rounds < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "L1 needs at least 1 round, got %d", options->l1_rounds );
    return RF_OK;
}

// Fails with RF_ERROR_USAGE where a value that counts is negative or not finite. `what` is for the message.
static RfResult check_plane( const float* plane, Extent e, const char* what, RfError* error )
{
    for ( int y = 0; y < e.rows; ++y )
    {
        for ( int x = 0; x < e.columns; ++x )
        {
            float value = plane[(size_t)y * (size_t)e.width + (size_t)x];
            if ( !isgreaterequal( value, 0.0f ) || !islessequal( value, 3.4e38f ) )
                return rf_fail( error, RF_ERROR_USAGE, "%s: %g at pixel (%d, %d): must be finite and at least 0", what,
                                (double)value, x, y );
        }
    }
    return RF_OK;
}

// The largest magnitude among data of weight > 0 goes to *largest.
static RfResult check_data( const float* rgb, const float* weights, Extent e, const char* what, float* largest, RfError* error )
{
    for ( int y = 0; y < e.rows; ++y )
    {
        for ( int x = 0; x < e.columns; ++x )
        {
            size_t i = (size_t)y * (size_t)e.width + (size_t)x;
            if ( weights != NULL && !( weights[i] > 0.0f ) )
                continue;
            for ( size_t c = 0; c < 3; ++c )
            {
                float value = fabsf( rgb[3 * i + c] );
                if ( !isfinite( value ) )
                    return rf_fail( error, RF_ERROR_USAGE, "%s: %s at pixel (%d, %d), which no reconstruction survives", what,
                                    isnan( value ) ? "NaN" : "infinity", x, y );
                *largest = value > *largest ? value : *largest;
            }
        }
    }
    return RF_OK;
}

// Fails with RF_ERROR_USAGE where a weight is negative or not finite, or data that count are not finite.
// *scale is the power of two that brings the largest of the data near 1.
static RfResult check_gradients( const RfGradientImages* in, const RfGradientWeights* weights, float* scale, RfError* error )
{
    const float *data[PLANES] = { in->primal, in->dx, in->dy }, *weight[PLANES] = { NULL };
    float largest = 0.0f;
    if ( in->width < 1 || in->height < 1 )
        return rf_fail( error, RF_ERROR_USAGE, "an image of %dx%d pixels cannot be reconstructed", in->width, in->height );
    if ( weights != NULL )
        memcpy( weight, ( const float*[] ){ weights->a, weights->b_x, weights->b_y }, sizeof weight );
    RfResult result = RF_OK;
    for ( int k = 0; k < PLANES && result == RF_OK && weights != NULL; ++k )
        result = check_plane( weight[k], extent_of( in, k ), s_weights[k], error );
    for ( int k = 0; k < PLANES && result == RF_OK; ++k )
        result = check_data( data[k], weight[k], extent_of( in, k ), s_data[k], &largest, error );
    int exponent = 0;
    if ( largest > 0.0f )
        frexpf( largest, &exponent );
    exponent = exponent < -120 ? -120 : exponent > 120 ? 120 : exponent;
    *scale = RF_FAULT( poisson_scale ) ? 1.0f : ldexpf( 1.0f, -exponent );
    return result;
}

static size_t pixels_of( const RfGradientSystem* system ) { return (size_t)system->width * (size_t)system->height; }

static bool lacks_primal( const RfGradientSystem* system )
{
    for ( size_t i = 0; i < pixels_of( system ); ++i )
    {
        if ( !( system->a[i] > 0.0f ) )
            return true;
    }
    return false;
}

static uint32_t root_of( uint32_t* labels, uint32_t i )
{
    while ( labels[i] != i )
    {
        labels[i] = labels[labels[i]];
        i = labels[i];
    }
    return i;
}

static void join( uint32_t* labels, size_t i, size_t j )
{
    uint32_t a = root_of( labels, (uint32_t)i ), b = root_of( labels, (uint32_t)j );
    if ( a < b )
        labels[b] = a;
    else
        labels[a] = b;
}

// Labels connected components, by gradients of weight > 0: labels[i] is the first pixel of the component of i.
static void label_components( const RfGradientSystem* system, uint32_t* labels )
{
    size_t w = (size_t)system->width, count = pixels_of( system );
    for ( size_t i = 0; i < count; ++i )
        labels[i] = (uint32_t)i;
    for ( size_t i = 0; i < count; ++i )
    {
        if ( system->b_x[i] > 0.0f )
            join( labels, i, i + 1 );
        if ( system->b_y[i] > 0.0f )
            join( labels, i, i + w );
    }
    for ( size_t i = 0; i < count; ++i )
        labels[i] = root_of( labels, (uint32_t)i );
}

// Shifts each component without primal weight so that its mean is that of `start`. `sums` are two doubles per
// pixel.
static void level_components( const RfGradientSystem* system, const uint32_t* labels, const float* start, float* u, double* sums )
{
    size_t count = pixels_of( system );
    double *offset = sums, *members = sums + count; // of the component with this first pixel; members < 0: it has a weight
    memset( sums, 0, 2 * count * sizeof *sums );
    for ( size_t i = 0; i < count; ++i )
    {
        size_t k = labels[i];
        offset[k] += (double)start[i] - (double)u[i];
        members[k] = system->a[i] > 0.0f || members[k] < 0.0 ? -1.0 : members[k] + 1.0;
    }
    for ( size_t i = 0; i < count; ++i )
    {
        size_t k = labels[i];
        if ( members[k] > 0.0 )
            u[i] += (float)( offset[k] / members[k] );
    }
}

// Weights: inverse variances, averaged over neighbours except much brighter ones. Otherwise a dark wall beside a
// window would seem as uncertain as the window's edge, and its value would not count against differences across
// the edge.

// What averages need of the pixels.
typedef struct Brightness
{
    const float *squares, *limit; // squared brightness, and how much is too bright for the pixel
} Brightness;

static int from_of( int i, int radius ) { return i > radius ? i - radius : 0; }

static int to_of( int i, int radius, int count ) { return i + radius < count ? i + radius + 1 : count; }

// The third smallest of 3x3 values, cut at the border; of one or two pixels, 0.
static float third_smallest( const float* values, Extent e, int x, int y )
{
    float least[3] = { INFINITY, INFINITY, INFINITY };
    for ( int v = from_of( y, 1 ); v < to_of( y, 1, e.rows ); ++v )
    {
        for ( int u = from_of( x, 1 ); u < to_of( x, 1, e.columns ); ++u )
        {
            float value = values[(size_t)v * (size_t)e.width + (size_t)u];
            float second = fmaxf( least[0], value ), third = fmaxf( least[1], second );
            least[0] = fminf( least[0], value );
            least[1] = fminf( least[1], second );
            least[2] = fminf( least[2], third );
        }
    }
    return isfinite( least[2] ) ? least[2] : 0.0f;
}

// A pixel darker than all but two around it counts as bright as those: few samples may have missed its light.
static Brightness find_brightness( const RfGradientImages* images, float* const scratch[2] )
{
    Extent all = { images->width, images->width, images->height };
    float *squares = scratch[0], *limit = scratch[1];
    for ( size_t i = 0; i < (size_t)all.width * (size_t)all.rows; ++i )
    {
        const float* value = images->primal + 3 * i;
        squares[i] = value[0] * value[0] + value[1] * value[1] + value[2] * value[2];
    }
    for ( int y = 0; y < all.rows; ++y )
    {
        for ( int x = 0; x < all.width; ++x )
        {
            size_t i = (size_t)y * (size_t)all.width + (size_t)x;
            limit[i] = MUCH_BRIGHTER * MUCH_BRIGHTER * fmaxf( squares[i], third_smallest( squares, all, x, y ) );
        }
    }
    return ( Brightness ){ squares, limit };
}

// The average around (x, y) of what is not too bright: of differences, by the brighter of two pixels, `step` apart.
static float average( const float* values, Brightness b, Extent e, size_t step, int x, int y )
{
    size_t width = (size_t)e.width, at = (size_t)y * width + (size_t)x;
    float limit = fmaxf( b.limit[at], b.limit[at + step] ), sum = 0.0f, count = 0.0f;
    for ( int v = from_of( y, RADIUS ); v < to_of( y, RADIUS, e.rows ); ++v )
    {
        for ( int u = from_of( x, RADIUS ); u < to_of( x, RADIUS, e.columns ); ++u )
        {
            size_t i = (size_t)v * width + (size_t)u;
            bool counts = b.squares[i] <= limit && b.squares[i + step] <= limit;
            sum += counts ? values[i] : 0.0f;
            count += counts ? 1.0f : 0.0f;
        }
    }
    return sum / count; // (x, y) itself counts
}

static void smooth( const float* from, Brightness b, Extent e, size_t step, float* to )
{
    for ( int y = 0; y < e.rows; ++y )
    {
        for ( int x = 0; x < e.columns; ++x )
            to[(size_t)y * (size_t)e.width + (size_t)x] = average( from, b, e, step, x, y );
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

void rf_weights_of_half( const RfGradientHalf* half, float* const scratch[2], float* a, float* b_x, float* b_y )
{
    int w = half->images.width, h = half->images.height;
    const float* variances[3] = { half->variance, half->variance_dx, half->variance_dy };
    const size_t steps[3] = { 0, 1, (size_t)w };
    float* weights[3] = { a, b_x, b_y };
    Brightness brightness = find_brightness( &half->images, scratch );
    size_t count = 0;
    double sum = 0.0;
    for ( int k = 0; k < PLANES; ++k )
    {
        smooth( variances[k], brightness, extent_of( &half->images, k ), steps[k], weights[k] );
        sum += sum_logs( weights[k], extent_of( &half->images, k ), &count );
    }
    double typical = count > 0 || RF_FAULT( typical ) ? exp( sum / (double)count ) : 1.0;
    for ( int k = 0; k < PLANES; ++k )
        invert( weights[k], extent_of( &half->images, k ), h, typical );
}

// L1 by iteratively reweighted least squares: each datum is weighted by the inverse of its distance from the last
// solution. Since weights depend on the data, it is biased.

// Distance over the three channels of a datum (at index `at` of `rgb`) from u_j − u_i, or from u_i where j is i.
static float distance( const RfGradientSolver* solver, const float* rgb, size_t i, size_t j )
{
    float sum = 0.0f;
    for ( int c = 0; c < 3; ++c )
    {
        const RfGradientChannel* channel = solver->channels + c;
        float value = i == j ? channel->u[i] : channel->u[j] - channel->u[i];
        float difference = value - channel->scale * rgb[3 * i + (size_t)c];
        sum += difference * difference;
    }
    return sqrtf( sum );
}

static float weight_of( float distance, float floor ) { return 1.0f / ( distance > floor ? distance : floor ); }

// Sets the weights by the solution, and returns its L1 norm.
static double reweigh( float alpha, float floor, RfGradientSolver* solver )
{
    RfGradientSystem* system = &solver->system;
    const RfGradientImages* in = solver->channels[0].in;
    size_t w = (size_t)system->width;
    double norm = 0.0;
    for ( int y = 0; y < system->height; ++y )
    {
        double row = 0.0;
        for ( size_t x = 0; x < w; ++x )
        {
            size_t i = (size_t)y * w + x;
            float d = distance( solver, in->primal, i, i );
            system->a[i] = alpha * weight_of( d, floor );
            row += (double)( alpha * d );
            if ( x + 1 < w )
            {
                d = distance( solver, in->dx, i, i + 1 );
                system->b_x[i] = weight_of( d, floor );
                row += (double)d;
            }
            if ( y + 1 < system->height )
            {
                d = distance( solver, in->dy, i, i + w );
                system->b_y[i] = weight_of( d, floor );
                row += (double)d;
            }
        }
        norm += row;
    }
    return norm;
}

static float mean_of_primal( const RfGradientSolver* solver )
{
    const RfGradientSystem* system = &solver->system;
    const RfGradientImages* in = solver->channels[0].in;
    size_t count = 3 * (size_t)system->width * (size_t)system->height;
    double sum = 0.0;
    for ( size_t i = 0; i < count; ++i )
        sum += fabs( (double)( in->primal[i] * solver->channels[0].scale ) );
    return (float)( sum / (double)count );
}

// Minimises the L1 norm by rounds of weighted solves, from the solution that is there. `settled` says whether the last
// round left the norm as it was.
static void solve_l1( const RfReconstructOptions* options, RfGradientSolver* solver, bool* settled )
{
    float mean = mean_of_primal( solver );
    float floor = FIRST_FLOOR * ( mean > 0.0f ? mean : 1.0f ), least = floor * ( LAST_FLOOR / FIRST_FLOOR );
    double before = reweigh( options->alpha, floor, solver );
    RfReconstructOptions coarse = *options;
    coarse.tolerance = fmax( ROUND_TOLERANCE, options->tolerance );
    *settled = false;
    for ( int round = 1; round < options->l1_rounds && !( *settled && floor <= least ); ++round )
    {
        rf_solve_weighted( &coarse, solver );
        floor = 0.5f * floor > least ? 0.5f * floor : least;
        double norm = reweigh( options->alpha, floor, solver );
        *settled = fabs( before - norm ) <= SETTLED * norm;
        before = norm;
    }
    rf_solve_weighted( options, solver );
}

static RfResult check_half( const RfGradientHalf* half, float* scale, RfError* error )
{
    RfResult result = check_gradients( &half->images, NULL, scale, error );
    const float* variance[PLANES] = { half->variance, half->variance_dx, half->variance_dy };
    for ( int k = 0; k < PLANES && result == RF_OK && !RF_FAULT( finite_variance ); ++k )
        result = check_plane( variance[k], extent_of( &half->images, k ), s_variances[k], error );
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
    float* scratch[2] = { solver.channels[0].r, solver.channels[0].p };
    rf_weights_of_half( halves + 1 - k, scratch, system->a, system->b_x, system->b_y );
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
    RfResult result = check_reconstruct_options( options, true, error );
    for ( int k = 0; k < 2 && result == RF_OK; ++k )
        result = check_half( halves + k, scales + k, error );
    for ( int k = 0; k < 2 && result == RF_OK; ++k )
        result = solve_half( halves, k, scales[k], options, rgb, of_half != NULL ? of_half[k] : NULL, &worst, error );
    if ( result == RF_OK && info != NULL )
        *info = worst;
    return result;
}

RfReconstructOptions rf_default_reconstruct_options( void )
{
    return ( RfReconstructOptions ){
        .method = RF_RECONSTRUCT_L2, .alpha = 0.2f, .tolerance = 1e-6, .max_iterations = 500, .l1_rounds = 20
    };
}

static float largest_of( const float* weights, Extent e )
{
    float largest = 0.0f;
    for ( int y = 0; y < e.rows; ++y )
    {
        for ( int x = 0; x < e.columns; ++x )
            largest = fmaxf( largest, weights[(size_t)y * (size_t)e.width + (size_t)x] );
    }
    return largest;
}

// Copies weights times 1 / largest; those of the last columns and rows that are skipped are 0.
static void copy_weights( const float* from, Extent e, int height, float largest, float* to )
{
    for ( int y = 0; y < height; ++y )
    {
        for ( int x = 0; x < e.width; ++x )
        {
            size_t i = (size_t)y * (size_t)e.width + (size_t)x;
            float weight = x < e.columns && y < e.rows ? from[i] / largest : 0.0f;
            to[i] = weight >= LEAST_WEIGHT ? weight : 0.0f;
        }
    }
}

// Where pixels have no primal weight, the level of some may be open.
static RfResult level( RfGradientSolver* solver, RfError* error )
{
    const RfGradientSystem* system = &solver->system;
    if ( !lacks_primal( system ) )
        return RF_OK;
    size_t count = (size_t)system->width * (size_t)system->height;
    uint32_t* labels = malloc( count * sizeof *labels );
    double* sums = malloc( 2 * count * sizeof *sums );
    if ( labels != NULL && sums != NULL )
    {
        label_components( system, labels );
        for ( int c = 0; c < 3; ++c )
        {
            rf_read_primal( solver->channels + c, solver->channels[c].r );
            level_components( system, labels, solver->channels[c].r, solver->channels[c].u, sums );
        }
    }
    RfResult result = labels != NULL && sums != NULL
                          ? RF_OK
                          : rf_fail( error, RF_ERROR_MEMORY, "out of memory for a reconstruction of %zu pixels", count );
    free( labels );
    free( sums );
    return result;
}

static RfResult solve_with_weights( const RfGradientImages* in, const RfGradientWeights* weights,
                                    const RfReconstructOptions* options, RfGradientSolver* solver, RfError* error )
{
    const float* from[PLANES] = { weights->a, weights->b_x, weights->b_y };
    float *to[PLANES] = { solver->system.a, solver->system.b_x, solver->system.b_y }, largest = 0.0f;
    for ( int k = 0; k < PLANES; ++k )
        largest = fmaxf( largest, largest_of( from[k], extent_of( in, k ) ) );
    if ( !( largest > 0.0f ) && !RF_FAULT( all_weights_0 ) )
        return rf_fail( error, RF_ERROR_USAGE, "all weights are 0: the image is undefined" );
    for ( int k = 0; k < PLANES; ++k )
        copy_weights( from[k], extent_of( in, k ), in->height, largest, to[k] );
    rf_solve_weighted( options, solver );
    return level( solver, error );
}

static RfResult solve_by( const RfGradientImages* in, const RfGradientWeights* weights, const RfReconstructOptions* options,
                          RfGradientSolver* solver, bool* settled, RfError* error )
{
    if ( options->method == RF_RECONSTRUCT_WEIGHTED )
        return solve_with_weights( in, weights, options, solver, error );
    RfResult result = rf_solve_constant_channels( (double)options->alpha * (double)options->alpha, solver, error );
    if ( result == RF_OK && options->method == RF_RECONSTRUCT_L1 )
        solve_l1( options, solver, settled );
    return result;
}

RfResult rf_reconstruct( const RfGradientImages* in, const RfGradientWeights* weights, const RfReconstructOptions* options,
                         float* rgb, RfReconstructInfo* info, RfError* error )
{
    RfGradientSolver solver;
    float scale;
    bool settled = true;
    RfResult result = check_reconstruct_options( options, weights != NULL, error );
    if ( result == RF_OK )
        result = check_gradients( in, weights, &scale, error );
    if ( result == RF_OK )
        result = rf_create_solver( in, scale, options, &solver, error );
    if ( result != RF_OK )
        return result;
    result = solve_by( in, weights, options, &solver, &settled, error );
    if ( result == RF_OK && info != NULL )
    {
        *info = rf_solver_info( &solver );
        info->converged = info->converged && settled;
        info->biased = options->method == RF_RECONSTRUCT_L1;
    }
    if ( result == RF_OK )
        result = rf_write_solution( &solver, 1.0, false, rgb, error );
    rf_destroy_solver( &solver );
    return result;
}
