#include "support/statistics.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

// Regularised incomplete beta function by Lentz' continued fraction
// (Abramowitz & Stegun 26.5.8); x below the mean (a+1)/(a+b+2).
static double beta_fraction( double a, double b, double x )
{
    double c = 1.0, d = 1.0 - ( a + b ) * x / ( a + 1.0 );
    d = 1.0 / ( fabs( d ) > 1e-300 ? d : 1e-300 );
    double h = d;
    for ( int m = 1; m < 500; ++m )
    {
        double even = m * ( b - m ) * x / ( ( a + 2 * m - 1 ) * ( a + 2 * m ) );
        double odd = -( a + m ) * ( a + b + m ) * x / ( ( a + 2 * m ) * ( a + 2 * m + 1 ) );
        for ( int k = 0; k < 2; ++k )
        {
            double term = k == 0 ? even : odd;
            d = 1.0 + term * d;
            c = 1.0 + term / c;
            d = 1.0 / ( fabs( d ) > 1e-300 ? d : 1e-300 );
            c = fabs( c ) > 1e-300 ? c : 1e-300;
            h *= c * d;
        }
        if ( fabs( c * d - 1.0 ) < 1e-14 )
            break;
    }
    return h;
}

static double incomplete_beta( double a, double b, double x )
{
    if ( x <= 0.0 || x >= 1.0 )
        return x <= 0.0 ? 0.0 : 1.0;
    double front = exp( lgamma( a + b ) - lgamma( a ) - lgamma( b ) + a * log( x ) + b * log1p( -x ) );
    if ( x < ( a + 1.0 ) / ( a + b + 2.0 ) )
        return front * beta_fraction( a, b, x ) / a;
    return 1.0 - front * beta_fraction( b, a, 1.0 - x ) / b;
}

double student_p( double t, double df ) { return incomplete_beta( 0.5 * df, 0.5, df / ( df + t * t ) ); }

static int s_comparisons;
static bool s_repeats;

bool is_likely( double p )
{
#pragma omp atomic
    s_comparisons += 1;
    return p > ( s_repeats ? -expm1( log1p( -SUITE_LEVEL ) / SUITE_COMPARISONS ) : FIRST_LEVEL );
}

bool is_far_off( double t, double df ) { return !is_likely( student_p( t, df ) ); }

// Apart by more than any test adds to it.
#define SEED_STRIDE 10000000u

uint64_t suite_seed( void )
{
    const char* base = getenv( "REFRAME_SEED" );
    return ( base != NULL ? strtoull( base, NULL, 10 ) * SEED_STRIDE : 0 ) + ( s_repeats ? SEED_STRIDE / 2 : 0 );
}

int suite_samples( void ) { return s_repeats ? 4 : 1; }

double suite_bias( void )
{
    const char* bias = getenv( "REFRAME_BIAS" );
    return bias != NULL ? strtod( bias, NULL ) : 1.0;
}

int run_statistical_tests( const struct CMUnitTest* tests, size_t count )
{
    int failed = 0, counted = 0;
    for ( size_t i = 0; i < count; ++i )
    {
        struct CMUnitTest one[1] = { tests[i] };
        s_comparisons = 0;
        bool unlikely = _cmocka_run_group_tests( tests[i].name, one, 1, NULL, NULL ) != 0;
        counted += s_comparisons;
        if ( !unlikely )
            continue;
        printf( "%s: unlikely; once more with other seeds and four times the samples\n", tests[i].name );
        s_repeats = true;
        failed += _cmocka_run_group_tests( tests[i].name, one, 1, NULL, NULL );
        s_repeats = false;
    }
    printf( "%d comparisons\n", counted );
    return failed;
}

double mean_of( const double* values, int count, double* standard_error )
{
    double mean = 0.0, square = 0.0;
    for ( int i = 0; i < count; ++i )
        mean += values[i] / count;
    for ( int i = 0; i < count; ++i )
        square += ( values[i] - mean ) * ( values[i] - mean );
    if ( standard_error != NULL )
        *standard_error = count > 1 ? sqrt( square / ( count - 1 ) / count ) : INFINITY;
    return mean;
}

Sample sample_of( const double* values, int count )
{
    double error, mean = mean_of( values, count, &error );
    return ( Sample ){ count, mean, error * error };
}

double welch_of( Sample a, Sample b )
{
    double both = a.variance + b.variance;
    if ( both == 0.0 )
        return a.mean == b.mean ? 1.0 : 0.0;
    double df = both * both / ( a.variance * a.variance / ( a.count - 1 ) + b.variance * b.variance / ( b.count - 1 ) );
    return student_p( ( a.mean - b.mean ) / sqrt( both ), df );
}

double welch_p( const double* a, int count_a, const double* b, int count_b )
{
    return welch_of( sample_of( a, count_a ), sample_of( b, count_b ) );
}

double place_p( const Sample* a, const Sample* b, int across, int down, int i )
{
    double squares = 0.0, variance_a = 0.0, variance_b = 0.0; // sums, to which dark places hardly add
    for ( int n = 0; n < 9; ++n )
    {
        int x = i % across + n % 3 - 1, y = i / across + n / 3 - 1, k = y * across + x;
        if ( x < 0 || y < 0 || x >= across || y >= down || a[k].count == 0 )
            continue;
        squares += 0.25 * ( a[k].mean + b[k].mean ) * ( a[k].mean + b[k].mean );
        variance_a += a[k].variance;
        variance_b += b[k].variance;
    }
    double here = 0.25 * ( a[i].mean + b[i].mean ) * ( a[i].mean + b[i].mean );
    Sample of_a = a[i], of_b = b[i];
    of_a.variance = fmax( of_a.variance, squares > 0.0 ? here * variance_a / squares : 0.0 );
    of_b.variance = fmax( of_b.variance, squares > 0.0 ? here * variance_b / squares : 0.0 );
    return fmax( welch_of( of_a, of_b ), welch_of( a[i], b[i] ) );
}

static int compare_doubles( const void* a, const void* b )
{
    double x = *(const double*)a, y = *(const double*)b;
    return ( x > y ) - ( x < y );
}

double uniform_p( double* values, int count )
{
    qsort( values, (size_t)count, sizeof *values, compare_doubles );
    double distance = 0.0;
    for ( int i = 0; i < count; ++i )
    {
        double off = fmax( values[i] - (double)i / count, (double)( i + 1 ) / count - values[i] );
        distance = off > distance ? off : distance; // by fmax gcc 12 for ARM64 crashes
    }
    // Kolmogorov's series, with Stephens' correction for small counts
    double root = sqrt( (double)count ), lambda = ( root + 0.12 + 0.11 / root ) * distance, sum = 0.0;
    if ( lambda < 0.2 )
        return 1.0;
    for ( int k = 1; k <= 100; ++k )
        sum += ( k % 2 == 1 ? 2.0 : -2.0 ) * exp( -2.0 * k * k * lambda * lambda );
    return fmin( fmax( sum, 0.0 ), 1.0 );
}

double chi_square_p( double chi_square, double df )
{
    // upper incomplete gamma Q(a, x): series below a + 1, continued fraction above
    double a = 0.5 * df, x = 0.5 * chi_square;
    if ( x <= 0.0 )
        return 1.0;
    double front = exp( a * log( x ) - x - lgamma( a ) );
    if ( x < a + 1.0 )
    {
        double term = 1.0 / a, sum = term;
        for ( int n = 1; n < 10000 && term > 1e-15 * sum; ++n )
        {
            term *= x / ( a + n );
            sum += term;
        }
        return 1.0 - front * sum;
    }
    double b = x + 1.0 - a, c = 1e300, d = 1.0 / b, h = d;
    for ( int n = 1; n < 10000; ++n )
    {
        double an = -n * ( n - a );
        b += 2.0;
        d = 1.0 / ( an * d + b );
        c = b + an / c;
        h *= c * d;
        if ( fabs( c * d - 1.0 ) < 1e-14 )
            break;
    }
    return front * h;
}
