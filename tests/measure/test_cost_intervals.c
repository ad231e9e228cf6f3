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

TEST( test_line_by_hand )
{
    // on a line of the usual exponent, 1.12: the points are in the middle of their logarithms
    const RfErrorPoint on[] = { { 2.0, 0.3 * pow( 2.0, -1.12 ), 1.0 },
                                { 4.0, 0.3 * pow( 4.0, -1.12 ), 1.0 },
                                { 8.0, 0.3 * pow( 8.0, -1.12 ), 1.0 },
                                { 16.0, 0.0, 1.0 } }; // the last one is none
    RfErrorLine line = rf_fit_error_line( on, 4, 0.0 );
    near( line.samples, 4.0, 1e-12 );
    near( line.exponent.value, 1.12, 1e-12 );
    near( rf_line_error( &line, 64.0 ).value, 0.3 * pow( 64.0, -1.12 ), 1e-12 );
    near( rf_line_samples( &line, 0.3 * pow( 64.0, -1.12 ) ).value, 64.0, 1e-9 );
    // logarithms 0 and 2 of the samples, 0 and -3 of the errors: 3 over 2, drawn to 1.12 with the weight (0.15 / 0.08)^2 = 3.515625; what is
    // left of the errors, of the prior and of four deviations of 0.15 has five degrees of freedom
    const RfErrorPoint two[] = { { 1.0, 1.0, 1.0 }, { exp( 2.0 ), exp( -3.0 ), 1.0 } };
    line = rf_fit_error_line( two, 2, 0.5 );
    double prior = 3.515625, p = ( 3.0 + prior * 1.12 ) / ( 2.0 + prior );
    double rest = 4.0 * 0.0225 + prior * ( p - 1.12 ) * ( p - 1.12 ) + 2.0 * ( 1.5 - p ) * ( 1.5 - p );
    double spread = 2.5706 * sqrt( rest / 5.0 ), margin = sqrt( 0.25 + spread * spread / 2.0 );
    near( line.exponent.value, p, 1e-12 );
    near( line.exponent.high - p, fmin( spread / sqrt( 2.0 + prior ), 0.1568 ), 1e-3 );
    near( line.samples, exp( 1.0 ), 1e-12 );
    near( line.error.value, exp( -1.5 ), 1e-12 );
    near( log( line.error.high / line.error.value ), margin, 1e-3 );
    // three e-foldings on, the exponent's margin counts three times; of the samples all is divided by the exponent
    double slack = line.exponent.high - p;
    margin = log( line.error.high / line.error.value );
    RfInterval far = rf_line_error( &line, exp( 4.0 ) ), samples = rf_line_samples( &line, far.value );
    near( far.value, exp( -1.5 - 3.0 * p ), 1e-12 );
    near( log( far.high / far.value ), sqrt( margin * margin + 9.0 * slack * slack ), 1e-12 );
    near( log( samples.value / samples.low ), log( far.high / far.value ) / p, 1e-12 );
    // one point has the usual exponent, none has nothing
    line = rf_fit_error_line( two, 1, 0.0 );
    near( line.exponent.value, 1.12, 1e-12 );
    near( line.exponent.high, 1.12 + 0.1568, 1e-12 );
    line = rf_fit_error_line( on + 3, 1, 0.0 );
    assert_true( isnan( line.samples ) && isnan( line.error.value ) && isnan( line.exponent.low ) );
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
    int held = 0, lines = 0, far = 0;
    for ( int k = 0; k < TRIES; ++k )
    {
        double a[PIECES], b[PIECES];
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
        // the exponents of rooms, and errors that scatter
        RfErrorPoint points[4];
        double exponent = 1.12 + 0.08 * log( lognormal( &seed, 1.0 ) * exp( 0.5 ) );
        for ( int i = 0; i < 4; ++i )
        {
            double samples = 2 << i;
            points[i] =
                ( RfErrorPoint ){ samples, pow( samples, -exponent ) * lognormal( &seed, 0.15 ) * exp( 0.5 * 0.15 * 0.15 ), 1.0 };
        }
        RfErrorLine line = rf_fit_error_line( points, 4, 0.0 );
        RfInterval needed = rf_line_samples( &line, pow( 64.0, -exponent ) );
        lines += line.exponent.low <= exponent && exponent <= line.exponent.high;
        far += needed.low <= 64.0 && 64.0 <= needed.high;
    }
    print_message(
        "of %d intervals of 95 %%: %.1f %% hold the ratio, %.1f %% the exponent, %.1f %% the samples of four times the most\n",
        TRIES, 100.0 * held / TRIES, 100.0 * lines / TRIES, 100.0 * far / TRIES );
    near( (double)lines / TRIES, 0.96, 0.02 );
    near( (double)far / TRIES, 0.96, 0.02 );
    assert_true( held > 0.90 * TRIES && held < 0.99 * TRIES ); // tails are seen too seldom
}
