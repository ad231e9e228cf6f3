// Measures: the error of images and sequences against a reference, and flicker.
//
//     RfErrorMetrics metrics;
//     if ( rf_measure_sequences( "a/frame.####.exr", "reference/frame.####.exr", &metrics, &error ) == RF_OK )
//         printf( "relMSE %g, bias %g\n", metrics.relmse, metrics.bias );
#ifndef REFRAME_MEASURE_H
#define REFRAME_MEASURE_H

#include "reframe/error.h"
#include "reframe/image.h"
#include "reframe/types.h"

RF_API_BEGIN

#define RF_RELMSE_EPSILON 0.001

// The pixel with the largest relative squared error, the quantity that relMSE averages.
typedef struct RfWorstPixel
{
    int frame, x, y; // frames count from 0 in their order; −1: no pixel differs
    double relative;
} RfWorstPixel;

// With v the image and r the reference, linear RGB, over all pixels of all frames:
//   relmse          mean over pixels of Σ_c (v_c − r_c)² / (b² + RF_RELMSE_EPSILON), where b is the
//                   brightness of the reference: of the mean of its channels the median over 3×3
//                   pixels, and of that the mean over 5×5; at borders the nearest pixel is repeated
//   relmse_trimmed  relmse without the worst 0.1 % of the pixels
//   mse, bias       mean over pixels and channels of (v_c − r_c)² and v_c − r_c
//   max             largest |v_c − r_c|
// NaN and infinite pixels are counted, never repaired: if there are any, all measures are NaN.
typedef struct RfErrorMetrics
{
    double relmse, relmse_trimmed, mse, max;
    double bias, bias_low, bias_high; // mean and its 95 % interval from blocks of pixels; NaN for a single block
    double reference_mean;            // over pixels and channels
    RfWorstPixel worst;
    size_t nan, inf;                     // pixels of the image with a NaN or infinite channel
    size_t reference_nan, reference_inf; // pixels of the reference
} RfErrorMetrics;

// The error of one image. Fails with RF_ERROR_FORMAT where the sizes differ, RF_ERROR_MEMORY.
RfResult rf_measure_error( const RfImage* image, const RfImage* reference, RfErrorMetrics* metrics, RfError* error );

// The error of all frames of a sequence of EXR files, pooled. Both patterns have #### for the
// number, or both name one file. Fails with RF_ERROR_IO where one sequence lacks a frame that the
// other has, RF_ERROR_FORMAT where data windows differ, or as reading the files does.
RfResult rf_measure_sequences( const char* pattern, const char* reference, RfErrorMetrics* metrics, RfError* error );

// How much the error e = v − r of a frame differs from that of the frame before:
//   f1   sqrt( mean (e_t − e_{t−1})² ) over pixels and channels
//   f1_relative  the same, each square divided by b² + RF_RELMSE_EPSILON as in relMSE, by the mean of both
//        frames: times 100 it is in percent, as noise is
//   phi  f1² / ( mean e_t² + mean e_{t−1}² ): 1 is noise that is independent in each frame, 0 an
//        error that stands still, 2 one that changes its sign from frame to frame
typedef struct RfFlickerMetrics
{
    double f1;          // NaN if no pixel is visible in both frames, or if any is NaN or infinite
    double f1_relative; // likewise
    double phi;         // NaN if the error is unknown; 0 if there is no error at all
    double mse;         // mean of the two mean squared errors; NaN like phi
    double coverage;    // share of the pixels visible in both frames, 0 to 1
    double motion;      // mean length of the motion vectors, pixels per frame; NaN: motion is not followed
} RfFlickerMetrics;

// The flicker of a sequence of EXR files. With `reference` (a pattern too) that of the error, pixel
// by pixel; with NULL that of the picture, along its motion AOV where it has one, and with the
// error from its variance AOV. Fails with RF_ERROR_IO where there are fewer than two frames, they
// have gaps or the reference lacks one, RF_ERROR_FORMAT where data windows differ.
RfResult rf_measure_sequence_flicker( const char* pattern, const char* reference, RfFlickerMetrics* metrics, RfError* error );

RF_API_END

#endif
