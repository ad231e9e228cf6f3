// A multigrid V-cycle, the preconditioner of the weighted system. On each level 2x2 pixels become one: their a is
// added, and so is half of each b across the new border. Unlike a cosine transform with the mean of the
// weights it follows weights that differ by orders of magnitude (README.md has the figures).
#ifndef REFRAME_GRADIENT_MULTIGRID_H
#define REFRAME_GRADIENT_MULTIGRID_H

#include "gradient/system.h"

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

// Bytes of the coarse systems, and of the vectors of one solve.
size_t rf_multigrid_bytes( int width, int height );
size_t rf_multigrid_vector_bytes( int width, int height );

// Takes the memory of the levels below `system` from *memory; rf_coarsen_multigrid computes them.
void rf_build_multigrid( const RfGradientSystem* system, char** memory, RfMultigrid* grid );

// Computes the coarse levels from the weights of level 0.
void rf_coarsen_multigrid( RfMultigrid* grid );

// Takes the memory of the vectors from *memory.
void rf_build_multigrid_vectors( const RfMultigrid* grid, char** memory, RfMultigridVectors* vectors );

// z = about the solution of (matrix) z = r: symmetric and positive definite.
void rf_multigrid_cycle( const RfMultigrid* grid, const RfMultigridVectors* vectors, const float* r, float* z );

#endif
