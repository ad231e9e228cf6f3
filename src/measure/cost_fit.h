// Fits the measurements of `cost`: slopes, and sums of units.
#ifndef REFRAME_MEASURE_COST_FIT_H
#define REFRAME_MEASURE_COST_FIT_H

#include "measure/interval.h"

// The slope of log y against log x by unweighted least squares, with Student's t for the
// scatter about the line. Points that are not above 0 are skipped. Needs at least two points,
// and three for the interval.
RfInterval rf_fit_slope( const double* x, const double* y, int count );

// One of the two methods (0: path tracing, 1: with reuse) at one position and sample count.
typedef struct RfCostPart
{
    double relmse; // of a single sample
    double wall_seconds, cpu_seconds;
    double samples; // rendered in these seconds
} RfCostPart;

typedef struct RfCostUnit
{
    int passes;
    RfCostPart parts[2];
} RfCostUnit;

// All units combined: relMSE of a single sample, weighted by
// passes because more samples determine it better; seconds of one sample.
RfCostPart rf_sum_cost_units( const RfCostUnit* units, int count, int part );

#endif
