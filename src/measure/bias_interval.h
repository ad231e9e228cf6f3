// How well a mean error is known: its 95 % interval, from blocks of pixels.
//
// The sum of the errors of a block over all frames is one observation, so that
// frames that share samples, or whose error stands still, count as what they are:
// the spread between blocks has it all. Blocks next to each other are not
// independent either, where errors reach over their borders: filters, tiles, a
// sample that several frames show at several places. So the same is done with
// blocks of twice the side, and so on while there are 16 of them at least, and with
// strips across the image and down it, where there are 8: what a camera that pans
// drags along stays in its strip. The widest interval counts (Flyvbjerg, Petersen,
// "Error estimates on averages of correlated data", 1989, in two dimensions). Few
// blocks are met by Student's t.
//
// What differs between places in truth, a bias that is here and not there, widens
// the interval: it errs on the side of caution.
#ifndef REFRAME_MEASURE_BIAS_INTERVAL_H
#define REFRAME_MEASURE_BIAS_INTERVAL_H

#include "reframe/error.h"

#define RF_BLOCK_SIDE 16    // pixels of the smallest blocks; those at the right and the lower border may be cut
#define RF_FEWEST_BLOCKS 16 // of larger ones
#define RF_FEWEST_STRIPS 8

// Half the width of the interval of the mean. `sums` has the sum of the values
// in each block of an image of width x height pixels, row by row, `values` how many
// values a pixel has in it (channels, frames). NaN for a single block. Fails
// (RF_ERROR_MEMORY) where there is no room for a copy of the sums.
RfResult rf_mean_margin( const double* sums, int width, int height, double values, double* margin, RfError* error );

// The two-sided 95 % quantile of Student's t, to 0.3 %; freedom ≥ 1.
double rf_student_quantile( int freedom );

#endif
