// Tests of hypotheses, for tests of estimators.
#ifndef REFRAME_TESTS_STATISTICS_H
#define REFRAME_TESTS_STATISTICS_H

#include <stdbool.h>
#include <stddef.h>

// Two-sided p-value of Student's t with `df` degrees of freedom.
double student_p( double t, double df );

// Welch's test that two samples have the same mean. Equal constant samples: 1.
double welch_p( const double* a, int count_a, const double* b, int count_b );

// Kolmogorov–Smirnov: p-value of `count` numbers (sorted in place) being
// uniform in [0, 1].
double uniform_p( double* values, int count );

// Upper tail of the χ² distribution.
double chi_square_p( double chi_square, double df );

// Is a mean `t` standard errors off, and is that as unlikely as 4 of them are
// where the error is known (6e-5)? It comes from df + 1 values here.
bool is_far_off( double t, double df );

// Mean, and the standard error of the mean.
double mean_of( const double* values, int count, double* standard_error );

#endif
