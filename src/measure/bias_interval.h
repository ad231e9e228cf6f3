// The 95 % confidence interval of a mean error, by block averaging over pixels.
//
// One observation is the sum of the errors of a block over all frames. The spread between
// blocks therefore includes the correlation of frames that share samples or have a static
// error. Neighbouring blocks are correlated too, if errors reach across their borders:
// filters, tiles, a sample reused at several positions of several frames. So the estimate is
// repeated with blocks of twice the side, and so on while at least 16 remain, and with
// horizontal and vertical strips if there are at least 8: what a panning camera drags along
// stays in its strip. The widest interval is returned (Flyvbjerg, Petersen, "Error estimates
// on averages of correlated data", 1989, in two dimensions). Student's t accounts for the
// small number of blocks.
//
// A bias that truly varies across the image widens the interval, which errs on the safe side.
#ifndef REFRAME_MEASURE_BIAS_INTERVAL_H
#define REFRAME_MEASURE_BIAS_INTERVAL_H

#include "reframe/error.h"

#define RF_BLOCK_SIDE 16 // pixels; blocks at the right and lower border may be cropped
#define RF_MIN_BLOCKS 16 // larger blocks need at least this many
#define RF_MIN_STRIPS 8

// Half the width of the interval of the mean. `sums` holds the sum of the values in each block
// of an image of width × height pixels, row by row; `values` is the number of values per pixel
// (channels times frames). NaN for a single block. Fails with RF_ERROR_MEMORY.
RfResult rf_mean_margin( const double* sums, int width, int height, double values, double* margin, RfError* error );

// The two-sided 95 % quantile of Student's t, to 0.3 %; freedom ≥ 1.
double rf_student_quantile( int freedom );

#endif
