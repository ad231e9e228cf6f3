// The linear system of a reconstruction, for one channel: (diag a + Dᵀ B D) u = a I + Dᵀ B Δ, where D takes
// the differences of neighbours. Matrix-free: the weights are the matrix.
//
// A plane is width·height floats with a row of zeros before and after it (rf_place_plane), so that the
// operator is one loop without borders.
//
// Its preconditioner is a multigrid V-cycle. On each level 2x2 pixels become one: their a is
// added, and so is half of each b across the new border. Unlike a cosine transform with the mean of the
// weights it follows weights that differ by orders of magnitude.
#ifndef REFRAME_GRADIENT_LINEAR_SYSTEM_H
#define REFRAME_GRADIENT_LINEAR_SYSTEM_H

#include "base/layout.h"
#include "reframe/reconstruct.h"

// Planes of weights. Those of pairs that leave the image are 0: b_x of the last column, b_y of the last row.
typedef struct RfGradientSystem
{
    int width, height;
    float *a, *b_x, *b_y;
    float* inverse_diagonal; // 0 where the diagonal is
} RfGradientSystem;

// Zeroes the rows before and after. The plane is aligned to 64.
float* rf_place_plane( int width, int height, RfLayout* layout );

// The planes of a system.
void rf_place_system( int width, int height, RfLayout* layout, RfGradientSystem* system );

// Computes inverse_diagonal from the weights.
void rf_finish_system( RfGradientSystem* system );

// to = (diag a + Dᵀ B D) u.
void rf_system_apply( const RfGradientSystem* system, const float* u, float* to );

// r = right-hand side − matrix · u for the channel, of data times `scale`. The sums cancel best where u is close
// to the data: no large numbers are subtracted that are not neighbours.
void rf_system_residual( const RfGradientSystem* system, const RfGradientImages* in, int channel, float scale, const float* u,
                         float* r );

// Norm of the data in the units of r over the diagonal, by which residuals are divided:
// ‖a I / diagonal‖ + ‖Dᵀ B Δ / diagonal‖, or 1 where that is 0.
double rf_system_norm( const RfGradientSystem* system, const RfGradientImages* in, int channel, float scale );

// ‖r / diagonal‖.
double rf_system_residual_norm( const RfGradientSystem* system, const float* r );

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

// The levels below `system`; rf_coarsen_multigrid computes them.
void rf_place_multigrid( const RfGradientSystem* system, RfLayout* layout, RfMultigrid* grid );

// Computes the coarse levels from the weights of level 0.
void rf_coarsen_multigrid( RfMultigrid* grid );

void rf_place_multigrid_vectors( const RfMultigrid* grid, RfLayout* layout, RfMultigridVectors* vectors );

// z ≈ the solution of (matrix) z = r, by a symmetric positive definite operator.
void rf_multigrid_cycle( const RfMultigrid* grid, const RfMultigridVectors* vectors, const float* r, float* z );

#endif
