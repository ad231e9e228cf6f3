// Slopes and ratios of times against values worked out by hand, and the coverage of their
// confidence intervals.
#include "support/test.h"
#include "measure/cost.h"
#include "measure/trial.h"

#include "base/random.h"

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

TEST( test_slope_by_hand )
{
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

// Pieces of given errors, in equal pixels; a sample takes `seconds`.
static void make_trial( const double* errors, int count, double seconds, RfTrial* trial )
{
    *trial = ( RfTrial ){ .timed_samples = 1.0, .cpu_seconds = seconds, .time_count = 1, .piece_count = count };
    for ( int i = 0; i < count; ++i )
        trial->pieces[i] = ( RfPieceError ){ .weight = 100.0, .relmse = 100.0 * errors[i] };
}

TEST( test_gain_by_hand )
{
    static RfTrial plain, reuse;
    const double same[] = { 1.0, 3.0, 2.0, 2.0 }, third[] = { 0.5, 1.5, 1.0, 1.0 };
    make_trial( same, 4, 1.0, &plain );
    make_trial( third, 4, 1.5, &reuse );
    RfInterval g = rf_trial_gain( &plain, &reuse );
    near( g.value, 2.0 / 1.5, 1e-14 );
    // the pieces agree: what is left is the noise of the times, 3 % each
    near( log( g.high / g.value ), 1.96 * sqrt( 2.0 ) * 0.03, 1e-3 );
    const double other[] = { 0.75, 1.25, 1.0, 1.0 };
    make_trial( other, 4, 1.0, &reuse );
    g = rf_trial_gain( &plain, &reuse );
    near( g.value, 2.0, 1e-14 );
    double square = 2.0 * 0.0625 * 0.0625; // 3/8 − 5/16 = 1/16, and −1/16
    double quantile = 3.1824;              // freedom: 3 · square² / (square² / 2) − 1 = 5, but no more than 3
    near( log( g.high / g.value ), sqrt( quantile * quantile * square * 4.0 / 3.0 + 1.96 * 1.96 * 2.0 * 0.03 * 0.03 ), 2e-3 );
    // times that differ between the two renders
    plain.time_noise = 0.25;
    near( log( rf_trial_gain( &plain, &reuse ).high / g.value ),
          sqrt( quantile * quantile * square * 4.0 / 3.0 + 1.96 * 1.96 * ( 0.25 / 4.0 + 0.03 * 0.03 ) ), 5e-3 );
    // the worst cells hold 0.3 of the error: it may be twice as much
    plain.time_noise = 0.0;
    plain.relmse = 100.0;
    double before = log( rf_trial_gain( &plain, &reuse ).high / g.value );
    for ( int k = 0; k < 12; ++k )
        rf_keep_worst_cell( plain.worst, k < 2 ? 1.0 : 3.0 ); // ten of them
    near( log( rf_trial_gain( &plain, &reuse ).high / g.value ), sqrt( before * before + log( 2.0 ) * log( 2.0 ) ), 1e-4 );
    // only what both have counts
    plain.piece_count = 3;
    near( rf_trial_gain( &plain, &reuse ).value, 2.0, 1e-14 );
    plain.piece_count = 1;
    assert_true( isnan( rf_trial_gain( &plain, &reuse ).low ) );
    plain.piece_count = 0;
    assert_true( isnan( rf_trial_gain( &plain, &reuse ).value ) );
}

// Errors of 30 pieces, heavy-tailed, that have a part in common, and of which the ratio is 5.
TEST( test_intervals_hold_the_truth )
{
    enum
    {
        TRIES = 4000,
        PIECES = 30
    };
    static RfTrial plain, reuse;
    uint64_t seed = 5;
    int held = 0, slopes = 0;
    for ( int k = 0; k < TRIES; ++k )
    {
        double seconds[4], errors[4], a[PIECES], b[PIECES];
        for ( int i = 0; i < PIECES; ++i )
        {
            double common = lognormal( &seed, 1.0 );
            a[i] = common * lognormal( &seed, 1.0 );
            b[i] = 0.2 * common * lognormal( &seed, 0.7 );
        }
        make_trial( a, PIECES, lognormal( &seed, 0.03 ), &plain );
        make_trial( b, PIECES, lognormal( &seed, 0.03 ), &reuse );
        RfInterval s = rf_trial_gain( &plain, &reuse );
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
    near( (double)slopes / TRIES, 0.95, 0.015 );               // exact in theory; four deviations
    assert_true( held > 0.90 * TRIES && held < 0.99 * TRIES ); // tails are seen too seldom
}
