// Slopes and ratios of times against values worked out by hand, and the coverage of their
// confidence intervals.
#include "measure/cost_fit.h"

#include "base/random.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>

#include <cmocka.h>

static void near( double value, double wanted, double tolerance )
{
    if ( !( fabs( value - wanted ) <= tolerance ) )
        fail_msg( "%.17g, not %.17g", value, wanted );
}

static double uniform( uint64_t* state )
{
    *state = rf_mix64( *state + 1 );
    return ( (double)( *state >> 11 ) + 0.5 ) * 0x1p-53;
}

// exp(s g) / exp(s²/2), g normal: mean 1.
static double lognormal( uint64_t* state, double s )
{
    double g = sqrt( -2.0 * log( uniform( state ) ) ) * cos( 6.283185307179586 * uniform( state ) );
    return exp( s * g - 0.5 * s * s );
}

static void test_slope_by_hand( void** state )
{
    (void)state;
    const double x[] = { 1.0, 2.0, 4.0, 8.0, 0.0 }, y[] = { 0.3, 0.15, 0.075, 0.0375, 1.0 };
    RfInterval s = rf_fit_slope( x, y, 5 ); // the last point is none
    near( s.value, -1.0, 1e-14 );
    near( s.low, -1.0, 1e-6 );
    near( s.high, -1.0, 1e-6 );
    // log y = 0, −1, −3/2 over log x = 0, 1, 2: slope −3/4; what is left is 1/12, −1/6, 1/12, whose
    // squares sum to 1/24; one degree of freedom, spread 2: deviation sqrt(1/48), times 12.7062
    const double u[] = { 1.0, exp( 1.0 ), exp( 2.0 ) }, v[] = { 1.0, exp( -1.0 ), exp( -1.5 ) };
    s = rf_fit_slope( u, v, 3 );
    near( s.value, -0.75, 1e-14 );
    near( s.high - s.value, 12.7062 * sqrt( 1.0 / 48.0 ), 1e-3 );
    near( s.value - s.low, s.high - s.value, 1e-12 );
    s = rf_fit_slope( u, v, 2 );
    near( s.value, -1.0, 1e-14 );
    assert_true( isnan( s.low ) && isnan( s.high ) );
    assert_true( isnan( rf_fit_slope( u, v, 1 ).value ) && isnan( rf_fit_slope( u, v, 0 ).value ) );
    const double same[] = { 2.0, 2.0, 2.0 };
    assert_true( isnan( rf_fit_slope( same, v, 3 ).value ) );
}

static void test_sums_by_hand( void** state )
{
    (void)state;
    // 1 and 3 passes: (1 · 8 + 3 · 4) / 4 = 5; (2 + 4) s for (20 + 100) samples
    const RfCostUnit units[] = { { 1, { { 8.0, 2.0, 1.0, 20.0 }, { 1.0, 1.0, 1.0, 10.0 } } },
                                 { 3, { { 4.0, 4.0, 2.0, 100.0 }, { 2.0, 6.0, 6.0, 60.0 } } } };
    RfCostPart sum = rf_sum_cost_units( units, 2, 0, -1 );
    near( sum.relmse, 5.0, 1e-14 );
    near( sum.wall_seconds, 0.05, 1e-16 );
    near( sum.cpu_seconds, 0.025, 1e-16 );
    near( rf_sum_cost_units( units, 2, 0, 0 ).relmse, 4.0, 1e-14 );
    // with reuse (1 + 6) / 4 = 7/4, 7 s for 70 samples: 5 · 0.05 / (1.75 · 0.1)
    RfInterval s = rf_cost_speedup( units, 2 );
    near( s.value, 0.25 / 0.175, 1e-14 );
    // leaving out the one or the other: 4 · 0.04 / (2 · 0.1), 8 · 0.1 / (1 · 0.1); the jackknife's
    // deviation of two is half of their distance, times 12.7062
    double half = 0.5 * ( log( 8.0 ) - log( 0.8 ) );
    near( log( s.high / s.value ), 12.7062 * half, 1e-3 );
    near( log( s.value / s.low ), 12.7062 * half, 1e-3 );
    assert_true( isnan( rf_cost_speedup( units, 1 ).low ) && rf_cost_speedup( units, 1 ).value > 0.0 );
    assert_true( isnan( rf_cost_speedup( units, 0 ).value ) );
}

// Twelve units as `cost` has them, errors and times that scatter about a ratio of 5.
static void test_intervals_hold_the_truth( void** state )
{
    (void)state;
    enum
    {
        TRIES = 4000,
        UNITS = 12
    };
    uint64_t seed = 5;
    int held = 0, slopes = 0;
    for ( int k = 0; k < TRIES; ++k )
    {
        RfCostUnit units[UNITS];
        double seconds[4], errors[4];
        for ( int i = 0; i < UNITS; ++i )
        {
            int passes = 2 << ( i / 3 );
            double spread = 0.6 / sqrt( (double)passes ); // fewer samples scatter more
            units[i].passes = passes;
            units[i].parts[0] = ( RfCostPart ){ lognormal( &seed, spread ), passes * lognormal( &seed, 0.05 ), 1.0, passes };
            units[i].parts[1] =
                ( RfCostPart ){ 0.1 * lognormal( &seed, spread ), passes * 2.0 * lognormal( &seed, 0.05 ), 1.0, passes };
        }
        RfInterval s = rf_cost_speedup( units, UNITS );
        held += s.low <= 5.0 && 5.0 <= s.high;
        for ( int i = 0; i < 4; ++i )
        {
            seconds[i] = 2 << i;
            errors[i] = lognormal( &seed, 0.2 ) / seconds[i];
        }
        RfInterval slope = rf_fit_slope( seconds, errors, 4 );
        slopes += slope.low <= -1.0 && -1.0 <= slope.high;
    }
    print_message( "of %d intervals of 95 %%: %.1f %% hold the ratio, %.1f %% the slope\n", TRIES, 100.0 * held / TRIES,
                   100.0 * slopes / TRIES );
    near( (double)slopes / TRIES, 0.95, 0.015 ); // exact in theory; four deviations
    // units that weigh more are few, so that the jackknife holds a little less often
    assert_true( held > 0.90 * TRIES && held < 0.985 * TRIES );
}

int main( void )
{
    const struct CMUnitTest tests[] = { cmocka_unit_test( test_slope_by_hand ), cmocka_unit_test( test_sums_by_hand ),
                                        cmocka_unit_test( test_intervals_hold_the_truth ) };
    return cmocka_run_group_tests_name( "cost_fit", tests, NULL, NULL );
}
