#include "base/fault.h"
#include "gradient/check.h"
#include "gradient/reconstruct.h"
#include "gradient/solver.h"

#include <math.h>

static RfResult check_half( const RfGradientHalf* half, float* scale, RfError* error )
{
    int w = half->images.width, h = half->images.height;
    RfResult result = rf_check_gradients( &half->images, NULL, scale, error );
    if ( result == RF_OK && !RF_FAULT( finite_variance ) )
        result = rf_check_plane( half->variance, w, h, 0, 0, "variance of the primal", error );
    if ( result == RF_OK && !RF_FAULT( finite_variance ) )
        result = rf_check_plane( half->variance_dx, w, h, 1, 0, "variance of dx", error );
    if ( result == RF_OK && !RF_FAULT( finite_variance ) )
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
    RfResult result = rf_check_reconstruct_options( options, true, error );
    for ( int k = 0; k < 2 && result == RF_OK; ++k )
        result = check_half( halves + k, scales + k, error );
    for ( int k = 0; k < 2 && result == RF_OK; ++k )
        result = solve_half( halves, k, scales[k], options, rgb, of_half != NULL ? of_half[k] : NULL, &worst, error );
    if ( result == RF_OK && info != NULL )
        *info = worst;
    return result;
}
