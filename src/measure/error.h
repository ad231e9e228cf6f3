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
// The 95 % interval of the bias comes from blocks of pixels, each pooled over all
// frames: bias_interval.h.
#ifndef REFRAME_MEASURE_ERROR_H
#define REFRAME_MEASURE_ERROR_H

#include "image/image.h"

#include <stdbool.h>

#define RF_RELMSE_EPSILON 0.001

// Where the relative error, that which relMSE is the mean of, is largest.
typedef struct RfWorstPixel
{
    int frame, x, y; // in the order of adding, from 0; −1 where no pixel is in error
    double relative;
} RfWorstPixel;

typedef struct RfErrorMetrics
{
    double relmse, relmse_trimmed, mse, max;
    double bias, bias_low, bias_high; // low and high are NaN for a single block
    double reference_mean;            // of the reference, over pixels and channels
    RfWorstPixel worst;
    size_t nan, inf;                     // pixels of the image with such a channel
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
    int frames;                     // added so far
    size_t pixels;                  // of them
    double relative_sum;            // Σ of relative squared errors
    double kept_sum;                // the same without those in `worst`
    double squared_sum, signed_sum; // over pixels and channels
    double max;
    size_t nan, inf, reference_nan, reference_inf;
    double* worst; // min-heap of the largest relative errors
    size_t worst_count, worst_room;
    double reference_sum; // Σ r̄
    double* block_sums;   // Σ v_c − r_c in each block of all frames, row by row
    RfWorstPixel worst_pixel;
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
