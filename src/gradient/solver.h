// The working memory of a reconstruction: weights, multigrid levels, and three channels.
#ifndef REFRAME_GRADIENT_SOLVER_H
#define REFRAME_GRADIENT_SOLVER_H

#include "gradient/linear_system.h"

#include "reframe/error.h"

#include <stddef.h>

// Cosine transform of an image with Neumann borders, which diagonalises the system with constant weights
// (FFTW, DCT-II and its inverse).
typedef struct RfCosineTransform
{
    int width, height;
    void *forward, *backward; // plans of FFTW
    double* eigenvalues;      // of Dxᵀ Dx, one per column
} RfCosineTransform;

// Plans transforms of width·height floats in place. Any thread may call it. The plan depends on the size alone
// (FFTW_ESTIMATE). `plane` is any plane, which is not changed. Fails with RF_ERROR_MEMORY.
RfResult rf_create_transform( int width, int height, float* plane, RfCosineTransform* transform, RfError* error );

// Frees the plans. Takes an empty struct.
void rf_destroy_transform( RfCosineTransform* transform );

// Solves (a + b_x Dxᵀ Dx + b_y Dyᵀ Dy) u = r in place, for constant weights, a > 0. `plane` is aligned as the one of the
// plan. Several threads may use one transform.
void rf_solve_constant( const RfCosineTransform* transform, double a, double b_x, double b_y, float* plane );

// The data of one channel, times `scale`, and the vectors of its solve. The solution is `u`.
typedef struct RfGradientChannel
{
    const RfGradientImages* in;
    int index;   // of the channel, 0 to 2
    float scale; // brings the data near 1
    float *u, *r, *p, *q;
    RfMultigridVectors multigrid;
    int iterations;  // of conjugate gradients, so far
    double residual; // relative, after the last solve
    bool converged;  // it is at most the tolerance
} RfGradientChannel;

// Sets a plane to the primal; where that is not finite, which its weight of 0 allows, to 0.
void rf_read_primal( const RfGradientChannel* channel, float* plane );

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

// Solves all channels by conjugate gradients, with the weights that are in solver->system.
void rf_solve_weighted( const RfReconstructOptions* options, RfGradientSolver* solver );

// How the solves went.
RfReconstructInfo rf_solver_info( const RfGradientSolver* solver );

// Writes the solution times `share` into interleaved `rgb`, or adds it. Fails with RF_ERROR_USAGE where it is not
// finite.
RfResult rf_write_solution( const RfGradientSolver* solver, double share, bool add, float* rgb, RfError* error );

// Solves all channels with constant weights a and 1. Fails with RF_ERROR_MEMORY.
RfResult rf_solve_constant_channels( double a, RfGradientSolver* solver, RfError* error );

#endif
