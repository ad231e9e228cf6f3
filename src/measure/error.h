// The error of an image against a reference: relMSE, MSE, bias, maximum; for
// one frame, and pooled over the frames of a sequence by the same code.
// What they are, and that of one image: reframe/measure.h. Sums are in double, in the order of rows
// and frames.
//
// The 95 % interval of the bias comes from blocks of pixels, each pooled over all
// frames: bias_interval.h.
#ifndef REFRAME_MEASURE_ERROR_H
#define REFRAME_MEASURE_ERROR_H

#include "reframe/measure.h"

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

#endif
