// Flicker: the change of the error from one frame to the next.
//
// With e_t = v_t − r_t the error of frame t, over pixels and channels:
//   F1 = sqrt( mean (e_t − e_{t−1})² )
//   φ  = F1² / ( mean e_t² + mean e_{t−1}² )
// Since (a − b)² = a² + b² − 2ab, φ is 1 minus the correlation of the two errors if
// they have the same magnitude: 1 for noise independent in each frame, 0 for a static
// error, 2 for an error that changes sign every frame. Scaling the error scales F1
// and leaves φ unchanged.
//
// With motion compensation, e_{t−1} is the error at the reprojected position in the
// previous frame (follow.h), in all three means. These are taken over the pixels that
// were visible there; their fraction is the coverage. Bilinear interpolation reduces
// noise between pixels, in the numerator and the denominator of φ alike.
//
// Without a reference, e_t − e_{t−1} is v_t − v_{t−1}. It then includes true changes of
// the image: moving objects if there is no motion layer, moving highlights if there
// is. The mean squares in φ come from the variance layer, if any: E e² is the variance
// of an unbiased estimate. Interpolated, the variance is Σ weight² · variance, which
// assumes independent pixels. Pixels of a tile are correlated, so φ comes out too
// large there.
//
// Over many pairs φ is the quotient of sums, not a mean of quotients. Sums are
// accumulated in double over each row, then over rows and pairs in order.
#ifndef REFRAME_MEASURE_FLICKER_H
#define REFRAME_MEASURE_FLICKER_H

#include "measure/follow.h"

// Sums over pairs of frames.
typedef struct RfFlickerSums
{
    int pairs;
    double pixels;     // visible in both frames
    double all_pixels; // of the later frame
    double motion;     // Σ lengths of the motion vectors, pixels; NaN: not compensated
    double difference; // Σ (e_t − e_{t−1})², over pixels and channels
    double square;     // Σ e_t² + e_{t−1}²; NaN: unknown
} RfFlickerSums;

typedef struct RfFlickerMetrics
{
    double f1;       // NaN if no pixel is visible in both frames, or if any is NaN or infinite
    double phi;      // NaN if the error is unknown; 0 if there is no error at all
    double mse;      // mean of the two mean squared errors; NaN like φ
    double coverage; // 0 to 1
    double motion;   // mean length of the motion vectors, pixels per frame; NaN: not compensated
} RfFlickerMetrics;

// The sums of a frame and the previous one, which has the same size. `has_error`: the
// signals are errors against a reference; else they are the frames themselves, and
// mean squared errors come from the variance layer, if there is one.
RfResult rf_measure_flicker( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate, bool has_error,
                             RfFlickerSums* sums, RfError* error );

// Adds the sums of further pairs.
void rf_add_flicker( RfFlickerSums* sums, const RfFlickerSums* more );

// F1, φ and the rest from the sums.
RfFlickerMetrics rf_flicker_metrics( const RfFlickerSums* sums );

#endif
