// The error of an image against a reference: relMSE, MSE, bias, maximum; for
// one frame, and pooled over the frames of a sequence by the same code.
//
// With v the image and r the reference, linear RGB, over all pixels:
//   relmse          mean over pixels of Σ_c (v_c − r_c)² / (r̄² + 0.001), where
//                   r̄ is the mean of the reference's channels
//   relmse_trimmed  the same without the worst 0.1 % of the pixels
//   mse, bias       mean over pixels and channels of (v_c − r_c)² and v_c − r_c
//   max             largest |v_c − r_c|
// Sums are in double, in the order of rows and frames.
//
// NaN and infinity in the image and in the reference are counted, never
// repaired: where there are any, all the measures are NaN.
//
// The 95 % interval of the bias comes from the means of 16×16-pixel blocks
// (smaller ones at the borders count by their pixels), of all frames alike: it
// holds where errors reach less far than a block and frames err independently.
// Frames that share samples do not: over a sequence of them it is too narrow.
#ifndef REFRAME_MEASURE_ERROR_H
#define REFRAME_MEASURE_ERROR_H

#include "image/image.h"

#include <stdbool.h>

#define RF_RELMSE_EPSILON 0.001
#define RF_ERROR_BLOCK 16

typedef struct RfErrorMetrics
{
    double relmse, relmse_trimmed, mse, max;
    double bias, bias_low, bias_high; // low and high are NaN for a single block
    size_t nan, inf;                  // pixels of the image with such a channel
    size_t reference_nan, reference_inf; // the same of the reference
} RfErrorMetrics;

// Is there anything that is no number, so that no error can be told?
static inline bool rf_has_no_error( const RfErrorMetrics* m )
{
    return m->nan > 0 || m->inf > 0 || m->reference_nan > 0 || m->reference_inf > 0;
}

// Running sums over frames of one size.
typedef struct RfErrorSummary
{
    int width, height;
    size_t pixels;                   // added so far
    double relative_sum;             // Σ of relative squared errors
    double kept_sum;                 // the same without those in `worst`
    double squared_sum, signed_sum;  // over pixels and channels
    double max;
    size_t nan, inf, reference_nan, reference_inf;
    double* worst;                   // min-heap of the largest relative errors
    size_t worst_count, worst_room;
    size_t blocks;
    double block_weight2;            // Σ w², w the pixels of a block
    double block_mean;               // mean of block biases, weighted by w²
    double block_spread;             // Σ w² (bias − block_mean)²
} RfErrorSummary;

// `frames` is how many will be added: the worst pixels of all are kept aside.
RfResult rf_create_summary( int width, int height, int frames, RfErrorSummary* summary, RfError* error );
void rf_destroy_summary( RfErrorSummary* summary );

// Adds a frame. Fails (RF_ERROR_FORMAT) where sizes differ; then nothing has
// been added.
RfResult rf_summary_add( RfErrorSummary* summary, const RfImage* image, const RfImage* reference, RfError* error );

// The measures of all that was added.
RfErrorMetrics rf_summary_metrics( const RfErrorSummary* summary );

// Of one image.
RfResult rf_measure_error( const RfImage* image, const RfImage* reference, RfErrorMetrics* out, RfError* error );

#endif
