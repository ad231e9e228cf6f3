// The working memory of a reconstruction: weights, the levels below them, and three channels.
#ifndef REFRAME_GRADIENT_SOLVER_H
#define REFRAME_GRADIENT_SOLVER_H

#include "gradient/channel.h"

typedef struct RfGradientSolver
{
    RfGradientSystem system;
    RfMultigrid grid;
    RfGradientChannel channels[3];
    void* own; // memory to free, or NULL
} RfGradientSolver;

// Lays out the working memory in options->work, or allocates it. Fails with RF_ERROR_MEMORY.
RfResult rf_create_solver( const RfGradientImages* in, float scale, const RfReconstructOptions* options, RfGradientSolver* solver,
                           RfError* error );

// Frees the memory that rf_create_solver allocated.
void rf_destroy_solver( RfGradientSolver* solver );

// Sets constant weights: a, and 1 for gradients.
void rf_set_constant_weights( double a, RfGradientSolver* solver );

// Solves all channels by conjugate gradients, with the weights that are in solver->system.
void rf_solve_weighted( const RfReconstructOptions* options, RfGradientSolver* solver );

// How the solves went.
RfReconstructInfo rf_solver_info( const RfGradientSolver* solver );

// Writes the solution times `share` into interleaved `rgb`, or adds it. Fails with RF_ERROR_USAGE where it is not
// finite.
RfResult rf_write_solution( const RfGradientSolver* solver, double share, bool add, float* rgb, RfError* error );

// Solves all channels with constant weights a and 1. Fails with RF_ERROR_MEMORY.
RfResult rf_solve_constant_channels( double a, RfGradientSolver* solver, RfError* error );

// Minimises the L1 norm by rounds of weighted solves, from the solution that is there. `settled` tells whether the last
// round left the norm as it was.
void rf_solve_l1( const RfReconstructOptions* options, RfGradientSolver* solver, bool* settled );

#endif
