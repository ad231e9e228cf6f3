// A quantity with its confidence interval.
#ifndef REFRAME_MEASURE_INTERVAL_H
#define REFRAME_MEASURE_INTERVAL_H

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

#endif
