#include "base/fault.h"
#include "gradient/check.h"
#include "gradient/components.h"
#include "gradient/solver.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LEAST_WEIGHT 1e-30f // of the largest; what is below counts as 0

RfReconstructOptions rf_default_reconstruct_options( void )
{
    return ( RfReconstructOptions ){
        .method = RF_RECONSTRUCT_L2, .alpha = 0.2f, .tolerance = 1e-6, .max_iterations = 500, .l1_rounds = 20
    };
}

static float largest_of( const float* weights, const RfGradientImages* in, int skip_x, int skip_y )
{
    float largest = 0.0f;
    for ( int y = 0; y < in->height - skip_y; ++y )
    {
        for ( int x = 0; x < in->width - skip_x; ++x )
            largest = fmaxf( largest, weights[(size_t)y * (size_t)in->width + (size_t)x] );
    }
    return largest;
}

// Copies weights times 1 / largest; those of the last columns and rows that are skipped are 0.
static void copy_weights( const float* from, const RfGradientImages* in, int skip_x, int skip_y, float largest, float* to )
{
    for ( int y = 0; y < in->height; ++y )
    {
        for ( int x = 0; x < in->width; ++x )
        {
            size_t i = (size_t)y * (size_t)in->width + (size_t)x;
            float weight = x < in->width - skip_x && y < in->height - skip_y ? from[i] / largest : 0.0f;
            to[i] = weight >= LEAST_WEIGHT ? weight : 0.0f;
        }
    }
}

// Where pixels have no primal weight, the level of some may be open.
static RfResult level( RfGradientSolver* solver, RfError* error )
{
    const RfGradientSystem* system = &solver->system;
    if ( !rf_lacks_primal( system ) )
        return RF_OK;
    size_t count = (size_t)system->width * (size_t)system->height;
    uint32_t* labels = malloc( count * sizeof *labels );
    double* sums = malloc( 2 * count * sizeof *sums );
    if ( labels != NULL && sums != NULL )
    {
        rf_label_components( system, labels );
        for ( int c = 0; c < 3; ++c )
        {
            rf_read_primal( solver->channels + c, solver->channels[c].r );
            rf_level_components( system, labels, solver->channels[c].r, solver->channels[c].u, sums );
        }
    }
    RfResult result = labels != NULL && sums != NULL
                          ? RF_OK
                          : rf_fail( error, RF_ERROR_MEMORY, "no memory left for a reconstruction of %zu pixels", count );
    free( labels );
    free( sums );
    return result;
}

static RfResult solve_weighted( const RfGradientImages* in, const RfGradientWeights* weights, const RfReconstructOptions* options,
                                RfGradientSolver* solver, RfError* error )
{
    float largest = fmaxf( largest_of( weights->a, in, 0, 0 ),
                           fmaxf( largest_of( weights->b_x, in, 1, 0 ), largest_of( weights->b_y, in, 0, 1 ) ) );
    if ( !( largest > 0.0f ) && !RF_FAULT( all_weights_0 ) )
        return rf_fail( error, RF_ERROR_USAGE, "all weights are 0: nothing tells what the image is" );
    copy_weights( weights->a, in, 0, 0, largest, solver->system.a );
    copy_weights( weights->b_x, in, 1, 0, largest, solver->system.b_x );
    copy_weights( weights->b_y, in, 0, 1, largest, solver->system.b_y );
    rf_solve_weighted( options, solver );
    return level( solver, error );
}

static RfResult solve( const RfGradientImages* in, const RfGradientWeights* weights, const RfReconstructOptions* options,
                       RfGradientSolver* solver, bool* settled, RfError* error )
{
    if ( options->method == RF_RECONSTRUCT_WEIGHTED )
        return solve_weighted( in, weights, options, solver, error );
    RfResult result = rf_solve_constant_channels( (double)options->alpha * (double)options->alpha, solver, error );
    if ( result == RF_OK && options->method == RF_RECONSTRUCT_L1 )
        rf_solve_l1( options, solver, settled );
    return result;
}

RfResult rf_reconstruct( const RfGradientImages* in, const RfGradientWeights* weights, const RfReconstructOptions* options,
                         float* rgb, RfReconstructInfo* info, RfError* error )
{
    RfGradientSolver solver;
    float scale;
    bool settled = true;
    RfResult result = rf_check_reconstruct_options( options, weights != NULL, error );
    if ( result == RF_OK )
        result = rf_check_gradients( in, weights, &scale, error );
    if ( result == RF_OK )
        result = rf_create_solver( in, scale, options, &solver, error );
    if ( result != RF_OK )
        return result;
    result = solve( in, weights, options, &solver, &settled, error );
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
