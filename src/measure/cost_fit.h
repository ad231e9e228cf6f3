// What the points of `cost` say together: slopes, and the ratio of times.
#ifndef REFRAME_MEASURE_COST_FIT_H
#define REFRAME_MEASURE_COST_FIT_H

// A quantity and its 95 % interval; NaN where there are too few points to tell.
typedef struct RfInterval
{
    double value, low, high;
} RfInterval;

// The slope of log y over log x by least squares, all points alike, with Student's
// quantile for the scatter about the line. Points that are not above 0 are left out.
// Two points at least; three for the interval.
RfInterval rf_fit_slope( const double* x, const double* y, int count );

// One of the two ways (0: path tracing, 1: with reuse) at a place and a count of samples.
typedef struct RfCostPart
{
    double relmse; // of a single sample
    double wall_seconds, cpu_seconds;
    double samples; // that these seconds were for
} RfCostPart;

typedef struct RfCostUnit
{
    int passes;
    RfCostPart parts[2];
} RfCostUnit;

// All units together but one (−1: all): relmse of a single sample, weighed by the
// passes, since more samples tell more of it; seconds of one sample.
RfCostPart rf_sum_cost_units( const RfCostUnit* units, int count, int part, int without );

// relMSE × wall seconds of part 0 over that of part 1: the ratio of times at equal
// error. The interval is that of the jackknife over the units, in the logarithm.
RfInterval rf_cost_speedup( const RfCostUnit* units, int count );

#endif
