// Tests of hypotheses, for tests of estimators, and the level that they share.
#ifndef REFRAME_TESTS_STATISTICS_H
#define REFRAME_TESTS_STATISTICS_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Two-sided p-value of Student's t with `df` degrees of freedom.
double student_p( double t, double df );

// Welch's test that two samples have the same mean. Equal constant samples: 1.
double welch_p( const double* a, int count_a, const double* b, int count_b );

// What a t-test takes of independent values.
typedef struct Sample
{
    int count; // 0: nothing to test
    double mean;
    double variance; // of the mean
} Sample;

Sample sample_of( const double* values, int count );
double welch_of( Sample a, Sample b );

// Welch's test at place i of a grid of `across` × `down`, where a few rare values may decide: a mean that lacks them has too
// small a variance as well. So its relative variance counts as no smaller than that of the up to 3 × 3 places around it, where some
// will have them. Never below Welch's p.
double place_p( const Sample* a, const Sample* b, int across, int down, int i );

// Kolmogorov–Smirnov: p-value of `count` numbers (sorted in place) being
// uniform in [0, 1].
double uniform_p( double* values, int count );

// Upper tail of the χ² distribution.
double chi_square_p( double chi_square, double df );

// Whether p may be chance: by their p-values, the statistical tests of the suite together fail by chance at most once in
// SUITE_LEVEL⁻¹ runs with fresh seeds, as far as t-tests hold (place_p, where rare paths decide). A test (below) that falls below FIRST_LEVEL is run again with other seeds and four
// times the samples, where each comparison has its share of SUITE_LEVEL, by Šidák: 1 − (1 − SUITE_LEVEL)^(1/SUITE_COMPARISONS).
// Counts the comparison.
bool is_likely( double p );
#define FIRST_LEVEL 1e-4
#define SUITE_LEVEL 1e-3
#define SUITE_COMPARISONS 8000 // at least as many as there are, with REFRAME_LONG too; scripts/test counts them

// Is a mean that comes from df + 1 values too many of its standard errors off? A comparison like is_likely.
bool is_far_off( double t, double df );

// Mean, and the standard error of the mean (NULL: not wanted).
double mean_of( const double* values, int count, double* standard_error );

// What the helpers that render add to the seeds of all renders and references: REFRAME_SEED (0), and whether this is a repetition,
// choose it.
uint64_t suite_seed( void );
// By what they multiply the samples: 4 in a repetition.
int suite_samples( void );

// A bias built in: by what the helpers that render multiply the pictures of renders with reuse, REFRAME_BIAS (1).
double suite_bias( void );

struct CMUnitTest;
// For main(): runs tests, those that fail once more as above, and prints the number of comparisons. Returns how many tests fail.
int run_statistical_tests( const struct CMUnitTest* tests, size_t count );

#endif
