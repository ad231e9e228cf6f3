// The working memory of a reconstruction: weights, multigrid levels, and three channels.
#ifndef REFRAME_GRADIENT_SOLVER_H
#define REFRAME_GRADIENT_SOLVER_H

#include "base/layout.h"
#include "reframe/error.h"
#include "reframe/reconstruct.h"

#include <stddef.h>

// Planes of weights. Those of pairs that leave the image are 0: b_x of the last column, b_y of the last row.
typedef struct RfGradientSystem
{
    int width, height;
    float *a, *b_x, *b_y;
    float* inverse_diagonal; // 0 where the diagonal is
} RfGradientSystem;

#define RF_MULTIGRID_LEVELS 16

// The systems from fine to coarse; level 0 is the caller's.
typedef struct RfMultigrid
{
    int count;
    RfGradientSystem levels[RF_MULTIGRID_LEVELS];
} RfMultigrid;

// Vectors of one solve. Level 0 has only `t`.
typedef struct RfMultigridVectors
{
    float *x[RF_MULTIGRID_LEVELS], *b[RF_MULTIGRID_LEVELS], *t[RF_MULTIGRID_LEVELS];
} RfMultigridVectors;

// Cosine transform of an image with Neumann borders, which diagonalises the system with constant weights
// (FFTW, DCT-II and its inverse).
typedef struct RfCosineTransform
{
    int width, height;
    void *forward, *backward; // plans of FFTW
    double* eigenvalues;      // of Dxᵀ Dx, one per column
} RfCosineTransform;

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

void rf_destroy_solver( RfGradientSolver* solver );

// Solves all channels by conjugate gradients, with the weights that are in solver->system.
void rf_solve_weighted( const RfReconstructOptions* options, RfGradientSolver* solver );
RfReconstructInfo rf_solver_info( const RfGradientSolver* solver );

// Writes the solution times `share` into interleaved `rgb`, or adds it. Fails with RF_ERROR_USAGE where it is not
// finite.
RfResult rf_write_solution( const RfGradientSolver* solver, double share, bool add, float* rgb, RfError* error );

// Solves all channels with constant weights a and 1. Fails with RF_ERROR_MEMORY.
RfResult rf_solve_constant_channels( double a, RfGradientSolver* solver, RfError* error );

// Weights of the primal (a), dx and dy (b_x, b_y) from the variances of a half: inverse averages over 5x5 pixels
// without much brighter ones, bounded from above, in units of a typical one. The last column of b_x and the last
// row of b_y are 0. `scratch` are two floats per pixel.
void rf_weights_of_half( const RfGradientHalf* half, float* const scratch[2], float* a, float* b_x, float* b_y );

#endif
