// The error of an image against a reference: relMSE, MSE, bias and maximum, for
// a single frame or pooled over the frames of a sequence.
//
// With v the image and r the reference, linear RGB, over all pixels:
//   relmse          mean over pixels of Σ_c (v_c − r_c)² / (r̄² + 0.001), where
//                   r̄ is the mean over the channels of the reference
//   relmse_trimmed  relmse without the worst 0.1 % of the pixels
//   mse, bias       mean over pixels and channels of (v_c − r_c)² and v_c − r_c
//   max             largest |v_c − r_c|
// Sums are accumulated in double, in row and frame order.
//
// NaN and infinite pixels of the image and the reference are counted, never
// repaired: if there are any, all measures are NaN.
//
// The 95 % confidence interval of the bias is estimated from blocks of pixels,
// each pooled over all frames: bias_interval.h.
#ifndef REFRAME_MEASURE_ERROR_H
#define REFRAME_MEASURE_ERROR_H

#include "image/image.h"

#include <stdbool.h>

#define RF_RELMSE_EPSILON 0.001

// The pixel with the largest relative squared error, the quantity that relMSE averages.
typedef struct RfWorstPixel
{
    int frame, x, y; // frames count from 0 in the order they were added; −1: no pixel differs
    double relative;
} RfWorstPixel;

typedef struct RfErrorMetrics
{
    double relmse, relmse_trimmed, mse, max;
    double bias, bias_low, bias_high; // mean and its 95 % interval, NaN for a single block
    double reference_mean;            // over pixels and channels
    RfWorstPixel worst;
    size_t nan, inf;                     // pixels of the image with a NaN or infinite channel
    size_t reference_nan, reference_inf; // pixels of the reference
} RfErrorMetrics;

// True if any pixel is NaN or infinite, so that the measures are undefined.
static inline bool rf_has_no_error( const RfErrorMetrics* m )
{
    return m->nan > 0 || m->inf > 0 || m->reference_nan > 0 || m->reference_inf > 0;
}

// Running sums over frames of equal size.
typedef struct RfErrorSummary
{
    int width, height;
    int frames;                     // added so far
    size_t pixels;                  // in those frames
    double relative_sum;            // Σ relative squared errors
    double kept_sum;                // Σ relative squared errors that are not in `worst`
    double squared_sum, signed_sum; // over pixels and channels
    double max;
    size_t nan, inf, reference_nan, reference_inf;
    double* worst; // min-heap of the largest relative errors
    size_t worst_count, worst_room;
    double reference_sum; // Σ r̄
    double* block_sums;   // Σ v_c − r_c per block over all frames, row by row
    RfWorstPixel worst_pixel;
} RfErrorSummary;

// Allocates a summary for `frames` frames; their number sizes the heap of worst pixels.
RfResult rf_create_summary( int width, int height, int frames, RfErrorSummary* summary, RfError* error );

// Frees the arrays of a summary and clears it.
void rf_destroy_summary( RfErrorSummary* summary );

// Adds a frame. If the sizes differ it fails (RF_ERROR_FORMAT) and adds nothing.
RfResult rf_summary_add( RfErrorSummary* summary, const RfImage* image, const RfImage* reference, RfError* error );

// The measures over all frames added so far.
RfErrorMetrics rf_summary_metrics( const RfErrorSummary* summary );

// The measures of a single image.
RfResult rf_measure_error( const RfImage* image, const RfImage* reference, RfErrorMetrics* out, RfError* error );

#endif
