// Reconstruction: the image that best fits a noisy primal image and noisy gradients, the minimiser
// for each channel of
//
//     Σ_i a_i (u_i − I_i)² + Σ_(i,j) b_ij (u_j − u_i − Δ_ij)²
//
//     RfReconstructOptions options = rf_default_reconstruct_options();
//     RfGradientImages in = { width, height, primal, dx, dy };
//     result = rf_reconstruct( &in, NULL, &options, rgb, &info, &error );
#ifndef REFRAME_RECONSTRUCT_H
#define REFRAME_RECONSTRUCT_H

#include "reframe/error.h"
#include "reframe/types.h"

RF_API_BEGIN

// The data. Images are interleaved RGB, rows from top to bottom: channel c at (x, y) is
// [3 (y·width + x) + c]. dx at (x, y) is the value at (x+1, y) minus the one at (x, y); its last
// column is not read. dy at (x, y) is the value at (x, y+1) minus the one at (x, y); its last
// row is not read.
typedef struct RfGradientImages
{
    int width, height;
    const float *primal, *dx, *dy;
} RfGradientImages;

// Weights, one float ≥ 0 per pixel (of dx and dy: of the pair that starts there), for all channels;
// only their ratios matter. What has weight 0 is ignored, and may be NaN.
typedef struct RfGradientWeights
{
    const float* a;         // of the primal
    const float *b_x, *b_y; // of dx and dy
} RfGradientWeights;

// One of two independent halves of the passes of a render: the means over its passes, and an
// unbiased estimate of the variance of each of these means, one float ≥ 0 per pixel, such as
// the sum over the channels. Estimates may be noisy: they are smoothed.
typedef struct RfGradientHalf
{
    RfGradientImages images;
    const float *variance, *variance_dx, *variance_dy;
    double passes; // > 0: the share of this half in the average
} RfGradientHalf;

typedef enum RfReconstructMethod
{
    RF_RECONSTRUCT_L2,       // a = alpha², b = 1: exact and unbiased
    RF_RECONSTRUCT_WEIGHTED, // the caller's weights: unbiased if they are independent of the data
    RF_RECONSTRUCT_L1,       // minimises Σ alpha |u − I| + Σ |u_j − u_i − Δ|: robust, but biased
} RfReconstructMethod;

typedef struct RfReconstructOptions
{
    RfReconstructMethod method;
    float alpha;        // of L2 and L1, > 0
    double tolerance;   // of WEIGHTED and L1: the relative residual at which the solver stops
    int max_iterations; // of WEIGHTED, per channel
    int l1_rounds;      // of L1: how often its weights are computed anew
    void* work;         // rf_reconstruct_bytes() bytes, aligned to 64; NULL: allocated by the call
} RfReconstructOptions;

// L2 with alpha = 0.2 (Kettunen et al. 2015), tolerance 1e-6, at most 500 iterations, 20 rounds of L1.
RfReconstructOptions rf_default_reconstruct_options( void );

// How a solve went; the worst of its channels.
typedef struct RfReconstructInfo
{
    int iterations;  // of conjugate gradients, in all rounds; 0 where the solve is direct
    double residual; // ‖right-hand side − matrix · u‖ / ‖right-hand side‖, computed anew from the result
    bool converged;  // the residual reached the tolerance
    bool biased;     // the method is biased (L1)
} RfReconstructInfo;

// Bytes of working memory of rf_reconstruct and rf_reconstruct_halves. Weights of the primal that are 0 take 20
// bytes per pixel more, which are always allocated by the call.
size_t rf_reconstruct_bytes( int width, int height );

// Reconstructs into `rgb` (interleaved, may be in->primal). `weights` are those of WEIGHTED, NULL for the
// other methods. A result that did not converge is no failure: see info, which may be NULL. Fails
// with RF_ERROR_USAGE where data or weights are not finite or a weight is negative, and
// RF_ERROR_MEMORY. Bits depend on the arguments alone, not on threads.
RfResult rf_reconstruct( const RfGradientImages* in, const RfGradientWeights* weights, const RfReconstructOptions* options,
                         float* rgb, RfReconstructInfo* info, RfError* error );

// Cross-fitted reconstruction: inverse variances of one half, smoothed over 5x5 pixels, are the weights
// of the other half's data, which they are independent of, so the result is unbiased. The
// average of the two, by their passes, goes to `rgb`, which must not be one of the inputs. `of_half`
// are the two solutions, [k] from the data of half k, or NULL. options->method must be WEIGHTED.
RfResult rf_reconstruct_halves( const RfGradientHalf halves[2], const RfReconstructOptions* options, float* rgb,
                                float* const of_half[2], RfReconstructInfo* info, RfError* error );

RF_API_END

#endif
