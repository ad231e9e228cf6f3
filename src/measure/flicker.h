// Flicker: how much the error of a frame differs from that of the frame before.
//
// With e_t = v_t − r_t the error of frame t, over pixels and channels:
//   F1 = sqrt( mean (e_t − e_{t−1})² )
//   φ  = F1² / ( mean e_t² + mean e_{t−1}² )
// (../shared/design/cli.md). Since (a − b)² = a² + b² − 2ab, φ is 1 less the
// correlation of the two errors where they are equally large: 1 is noise that is
// independent in each frame, 0 an error that stands still, 2 one that changes
// its sign from frame to frame. Scaling the error scales F1 and leaves φ.
//
// Motion-compensated, e_{t−1} is what the pixel had where it was in the frame
// before (follow.h), in all three means, and these go over the pixels that were
// seen there: their share is the coverage. Bilinear interpolation makes noise
// smaller between pixels, which is as small in both parts of φ.
//
// Without a reference e_t − e_{t−1} is v_t − v_{t−1}, which also has what changed
// in truth: what moves, if there is no motion layer; what shines, if there is.
// The mean squares of φ are then those of the variance layer, where there is one:
// E e² is the variance where there is no bias. Between pixels it is the sum of
// weights² times variances, which takes neighbouring pixels for independent; those
// of tiles are not, and φ comes out too large there.
//
// In all, sums over the pairs are divided, not quotients averaged. Sums are in
// double, over each row, then over rows and pairs in order.
#ifndef REFRAME_MEASURE_FLICKER_H
#define REFRAME_MEASURE_FLICKER_H

#include "measure/follow.h"

// Sums over pairs of frames.
typedef struct RfFlickerSums
{
    int pairs;
    double pixels;     // seen in both frames
    double all_pixels; // of the later frame
    double motion;     // Σ length of the way from where it was, pixels; NaN: not compensated
    double difference; // Σ (e_t − e_{t−1})², over pixels and channels
    double square;     // Σ e_t² + e_{t−1}²; NaN: not known
} RfFlickerSums;

typedef struct RfFlickerMetrics
{
    double f1;       // NaN where no pixel was seen in both frames, or one is no number
    double phi;      // NaN where the error is not known; 0 where there is no error at all
    double mse;      // mean of the two mean squares of the error; NaN as φ
    double coverage; // 0 to 1
    double motion;   // mean length of the way that a pixel's surface made, pixels a frame; NaN: not compensated
} RfFlickerMetrics;

// The sums of the pair of a frame and the one before, which is of the same size.
// `has_error`: the signals are errors; else the picture, whose error's mean
// square comes from the variance, if at all.
RfResult rf_measure_flicker( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate, bool has_error,
                             RfFlickerSums* sums, RfError* error );

// Adds the sums of further pairs.
void rf_add_flicker( RfFlickerSums* sums, const RfFlickerSums* more );

RfFlickerMetrics rf_flicker_metrics( const RfFlickerSums* sums );

#endif
