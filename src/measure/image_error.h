// Error of images and sequences, and the confidence intervals of what is measured.
#ifndef REFRAME_MEASURE_IMAGE_ERROR_H
#define REFRAME_MEASURE_IMAGE_ERROR_H

#include "reframe/error.h"
#include "reframe/measure.h"

// A quantity and its 95 % confidence interval; NaN where it is not known.
typedef struct RfInterval
{
    double value, low, high;
} RfInterval;

// The interval of a positive value whose logarithm is known to `margin`.
RfInterval rf_log_interval( double value, double margin );

// Half the width of the interval of an estimate to which `count` independent pieces of data contribute, by the influence
// of each: by how much, to first order, the estimate would be lower without it. `variance` is added to that of the
// estimate. Student's t has as many degrees of freedom as the spread of the influences is known with, by their kurtosis:
// an estimate that rests on a few large contributions has a wide interval. NaN for fewer than two.
double rf_influence_margin( const double* influence, int count, double variance );

// The two-sided 95 % quantile of Student's t, to 0.3 %; freedom ≥ 1.
double rf_student_quantile( int freedom );

// The error of an image against a reference (reframe/measure.h), for a single frame or pooled over the frames of a sequence. Sums are
// accumulated in double, in row and frame order.
//
// The 95 % interval of the bias is by block averaging: one observation is the sum of the errors of a block of pixels over all frames,
// so that the spread includes the correlation of frames that share samples or have a static error. Since errors reach across borders,
// by filters, tiles and reuse, the estimate is repeated with blocks of twice the side, and so on while at least 16 remain, and with
// strips if there are at least 8: what a panning camera drags along stays in its strip. The widest interval is returned (Flyvbjerg,
// Petersen, "Error estimates on averages of correlated data", 1989, in two dimensions). A bias that truly varies across the image
// widens it, which errs on the safe side.

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
    double* worst; // min-heap of the largest relative errors, at first zeros
    size_t worst_room;
    double* below;        // denominators of a frame
    double reference_sum; // Σ of the means of the reference's channels
    double* block_sums;   // Σ v_c − r_c per block over all frames, row by row
    RfWorstPixel worst_pixel;
} RfErrorSummary;

// Allocates a summary for `frames` frames; their number sizes the heap of worst pixels.
RfResult rf_create_summary( int width, int height, int frames, RfErrorSummary* summary, RfError* error );

void rf_destroy_summary( RfErrorSummary* summary );

// Adds a frame. If the sizes differ it fails (RF_ERROR_FORMAT) and adds nothing.
RfResult rf_summary_add( RfErrorSummary* summary, const RfImage* image, const RfImage* reference, RfError* error );

// The measures over all frames added so far.
RfErrorMetrics rf_summary_metrics( const RfErrorSummary* summary );

// Measures a frame alone, and adds it to the summary, which is created for `frames` frames where it is all zero.
RfResult rf_measure_frame( RfErrorSummary* summary, int frames, const RfImage* image, const RfImage* reference,
                           RfErrorMetrics* metrics, RfError* error );

// The frames of two sequences, ascending.
typedef struct RfFramePairs
{
    int *both, count;
    int *lacking[2], lacking_count[2]; // what the other alone has
    int *all, all_count;
} RfFramePairs;

// Matches frames by their numbers, which ascend. Free with rf_free_frame_pairs.
RfResult rf_pair_frames( const int* const numbers[2], const int counts[2], RfFramePairs* pairs, RfError* error );
void rf_free_frame_pairs( RfFramePairs* pairs );

// Fails with RF_ERROR_IO where one lacks a frame that the other has, and names it.
RfResult rf_check_all_paired( const RfFramePairs* pairs, const char* const patterns[2], RfError* error );

// From the number of a frame to that of the next, as the file of frame `number` says (a camera path may go in
// steps); 1 where it does not.
int rf_sequence_step( const char* pattern, int number );

#endif
