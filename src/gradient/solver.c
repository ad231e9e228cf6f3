#include "gradient/solver.h"

#include "trace/trace.h"

#include <math.h>
#include <stdlib.h>

size_t rf_reconstruct_bytes( int width, int height )
{
    return 4 * rf_plane_bytes( width, height ) + rf_multigrid_bytes( width, height ) + 3 * rf_channel_bytes( width, height );
}

RfResult rf_create_solver( const RfGradientImages* in, float scale, const RfReconstructOptions* options, RfGradientSolver* solver,
                           RfError* error )
{
    size_t bytes = rf_reconstruct_bytes( in->width, in->height );
    *solver = ( RfGradientSolver ){ 0 };
    solver->own = options->work == NULL ? aligned_alloc( 64, bytes ) : NULL;
    char* memory = options->work != NULL ? options->work : solver->own;
    if ( memory == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for a reconstruction of %dx%d pixels, %zu MiB", in->width,
                        in->height, bytes >> 20 );
    RfGradientSystem* system = &solver->system;
    float** const planes[4] = { &system->a, &system->b_x, &system->b_y, &system->inverse_diagonal };
    system->width = in->width;
    system->height = in->height;
    for ( int k = 0; k < 4; ++k )
        *planes[k] = rf_plane( in->width, in->height, &memory );
    rf_build_multigrid( system, &memory, &solver->grid );
    for ( int c = 0; c < 3; ++c )
    {
        solver->channels[c] = ( RfGradientChannel ){ .in = in, .index = c, .scale = scale };
        rf_build_channel( &solver->grid, &memory, solver->channels + c );
        rf_read_primal( solver->channels + c, solver->channels[c].u );
    }
    return RF_OK;
}

void rf_destroy_solver( RfGradientSolver* solver )
{
    free( solver->own );
    solver->own = NULL;
}

void rf_set_constant_weights( double a, RfGradientSolver* solver )
{
    RfGradientSystem* system = &solver->system;
    size_t w = (size_t)system->width, count = w * (size_t)system->height;
    for ( size_t i = 0; i < count; ++i )
    {
        system->a[i] = (float)a;
        system->b_x[i] = ( i + 1 ) % w != 0 ? 1.0f : 0.0f;
        system->b_y[i] = i + w < count ? 1.0f : 0.0f;
    }
    rf_finish_system( system );
}

void rf_solve_weighted( const RfReconstructOptions* options, RfGradientSolver* solver )
{
    rf_finish_system( &solver->system );
    rf_coarsen_multigrid( &solver->grid );
#pragma omp parallel for schedule( static, 1 )
    for ( int c = 0; c < 3; ++c )
    {
        rf_set_float_mode(); // light that fades out in the dark would take forever in subnormals
        rf_solve_channel( &solver->grid, options->tolerance, options->max_iterations, solver->channels + c );
    }
}

RfResult rf_solve_constant_channels( double a, RfGradientSolver* solver, RfError* error )
{
    RfCosineTransform transform;
    const RfGradientSystem* system = &solver->system;
    rf_set_constant_weights( a, solver );
    RfResult result = rf_create_transform( system->width, system->height, solver->channels[0].r, &transform, error );
    if ( result != RF_OK )
        return result;
#pragma omp parallel for schedule( static, 1 )
    for ( int c = 0; c < 3; ++c )
    {
        rf_set_float_mode();
        rf_solve_channel_constant( system, &transform, a, solver->channels + c );
    }
    rf_destroy_transform( &transform );
    return RF_OK;
}

RfReconstructInfo rf_solver_info( const RfGradientSolver* solver )
{
    RfReconstructInfo info = { .converged = true };
    for ( int c = 0; c < 3; ++c )
    {
        const RfGradientChannel* channel = solver->channels + c;
        info.iterations = channel->iterations > info.iterations ? channel->iterations : info.iterations;
        info.residual = channel->residual > info.residual ? channel->residual : info.residual;
        info.converged = info.converged && channel->converged;
    }
    return info;
}

RfResult rf_write_solution( const RfGradientSolver* solver, double share, bool add, float* rgb, RfError* error )
{
    const RfGradientChannel* channels = solver->channels;
    size_t count = (size_t)solver->system.width * (size_t)solver->system.height;
    float factor = (float)( share / (double)channels[0].scale );
    bool finite = true;
    for ( size_t i = 0; i < count; ++i )
    {
        for ( size_t c = 0; c < 3; ++c )
        {
            float value = channels[c].u[i] * factor + ( add ? rgb[3 * i + c] : 0.0f );
            finite = finite && isfinite( value );
            rgb[3 * i + c] = value;
        }
    }
    return finite ? RF_OK : rf_fail( error, RF_ERROR_USAGE, "the gradients add up to more than a float holds" );
}
