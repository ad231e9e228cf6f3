// Solves the system of one channel: directly where the weights are constant, else by conjugate gradients.
#ifndef REFRAME_GRADIENT_CHANNEL_H
#define REFRAME_GRADIENT_CHANNEL_H

#include "gradient/multigrid.h"
#include "gradient/transform.h"

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

// Bytes of the vectors of a channel.
size_t rf_channel_bytes( int width, int height );

// Takes the vectors from *memory.
void rf_build_channel( const RfMultigrid* grid, char** memory, RfGradientChannel* channel );

// Sets a plane to the primal; where that is not finite, which its weight of 0 allows, to 0.
void rf_read_primal( const RfGradientChannel* channel, float* plane );

// Solves with weights a and 1 exactly, from the u that is there. `system` holds the same weights.
void rf_solve_channel_constant( const RfGradientSystem* system, const RfCosineTransform* transform, double a,
                                RfGradientChannel* channel );

// Solves by conjugate gradients, from the u that is there, to a relative residual of `tolerance`.
void rf_solve_channel( const RfMultigrid* grid, double tolerance, int max_iterations, RfGradientChannel* channel );

#endif
