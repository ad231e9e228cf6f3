// The linear system of a reconstruction, for one channel: (diag a + Dᵀ B D) u = a I + Dᵀ B Δ, where D takes
// the differences of neighbours. Matrix-free: the weights are the matrix.
//
// A plane is width·height floats with a row of zeros before and after it (rf_plane), so that the
// operator is one loop without borders.
#ifndef REFRAME_GRADIENT_SYSTEM_H
#define REFRAME_GRADIENT_SYSTEM_H

#include "reframe/reconstruct.h"

// Planes of weights. Those of pairs that leave the image are 0: b_x of the last column, b_y of the last row.
typedef struct RfGradientSystem
{
    int width, height;
    float *a, *b_x, *b_y;
    float* inverse_diagonal; // 0 where the diagonal is
} RfGradientSystem;

// Bytes of a plane with its rows of zeros, a multiple of 64.
size_t rf_plane_bytes( int width, int height );

// Takes a plane from *memory, advances it and zeroes the rows before and after. The plane is aligned to 64.
float* rf_plane( int width, int height, char** memory );

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

#endif
