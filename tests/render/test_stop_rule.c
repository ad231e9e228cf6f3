// How many passes each group gets for a target error or time: the decisions alone, with
// made-up films, estimates and clock.
#include "support/test.h"
#include "render/stop/stop_rule.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>

#define MOST_FRAMES 256

// A path to render: frame k has relMSE noise[k] by one pass of a full window, and
// an estimate is off by a normal factor of `spread` (of its own in each frame
// and look). A pass costs `pace` seconds per eye, give or take `jitter`.
typedef struct Trial
{
    int frames, group, most_spp;
    double error, seconds;
    double noise[MOST_FRAMES];
    double spread, pace, jitter;
    uint64_t random;
    // what came of it
    RfStop stop;
    int passes[MOST_FRAMES]; // of a frame
    double weight[MOST_FRAMES];
    int half[MOST_FRAMES][2];
    int window_passes[2 * MOST_FRAMES];
    double work, now; // eyes × passes, seconds
    bool reached[MOST_FRAMES];
} Trial;

static double uniform( uint64_t* state )
{
    *state = *state * 6364136223846793005u + 1442695040888963407u;
    return (double)( *state >> 11 ) * 0x1p-53;
}

static double normal( uint64_t* state )
{
    double sum = 0.0;
    for ( int i = 0; i < 12; ++i )
        sum += uniform( state );
    return sum - 6.0;
}

// v of estimates: passes of cut windows count by the eyes that they have.
static double noise_of( const Trial* t, int k )
{
    return t->noise[k] * ( t->stop.rule.plan.cut > 0 ? t->stop.rule.plan.eyes : 1 );
}

static RfFrameNoise estimate( Trial* t, int frame )
{
    bool known = t->passes[frame] > 1;
    return ( RfFrameNoise ){ .frame = frame,
                             .passes = t->passes[frame],
                             .weight = t->weight[frame],
                             .noise = known ? noise_of( t, frame ) * ( 1.0 + t->spread * normal( &t->random ) ) : 0.0,
                             .seen = known ? t->weight[frame] : 0.0 };
}

static RfNoiseEstimates look_at( Trial* t, int window, int done, RfFrameNoise* frames )
{
    RfGroup w = rf_group( &t->stop.rule.plan, window );
    for ( int k = 0; k < w.eyes; ++k )
        frames[k] = estimate( t, w.first + k );
    return ( RfNoiseEstimates ){ window, done, frames, w.eyes };
}

static void run_window( Trial* t, int number )
{
    RfFrameNoise frames[MOST_FRAMES];
    RfGroup window = rf_begin_group( &t->stop, number );
    RfNoiseEstimates look = look_at( t, number, 0, frames );
    int due, done = 0;
    while ( ( due = rf_passes_due( &t->stop, &look, done, t->now ) ) > done )
    {
        int next = t->seconds > 0.0 ? done + 1 : due;
        for ( ; done < next; ++done )
        {
            for ( int k = window.first; k < window.first + window.eyes; ++k )
            {
                t->passes[k] += 1;
                t->weight[k] += window.weight;
                t->half[k][rf_half_of_pass( &window, done )] += 1;
            }
            t->work += window.eyes;
            t->now += t->pace * window.eyes * ( 1.0 + t->jitter * ( uniform( &t->random ) - 0.5 ) );
            rf_note_pass( &t->stop, window.eyes, t->now );
        }
        assert_true( done < 1 << 20 );
        if ( next == due )
            look = look_at( t, number, done, frames );
    }
    rf_end_group( &t->stop, done );
    t->window_passes[number] = done;
    for ( int k = 0; k < window.eyes; ++k )
    {
        int frame = window.first + k, first, last;
        rf_groups_of_frame( &t->stop.rule.plan, frame, &first, &last );
        // the estimate by which the window ended
        RfFrameNoise now = look.done == done ? frames[k] : estimate( t, frame );
        if ( last == number )
            t->reached[frame] = !rf_note_finished( &t->stop, now ).noise;
    }
}

static void run( Trial* t )
{
    RfGroupPlan plan = rf_plan_groups( t->frames, t->group, t->most_spp );
    t->stop = rf_create_stop( &plan, t->most_spp, &( RfStopGoals ){ .noise = t->error, .seconds = t->seconds } );
    t->random = t->random * 2 + 1;
    for ( int w = 0; w < plan.groups; ++w )
        t->stop.units_left += rf_group_units( &t->stop, w );
    double share = 0.0;
    for ( int w = 0; w < plan.groups; ++w )
    {
        run_window( t, w );
        double now = rf_stop_share( &t->stop, t->now );
        assert_true( now >= share - 1e-9 && now <= 1.0 + 1e-9 );
        share = now;
    }
    assert_true( fabs( t->stop.units_left ) < 1e-6 * t->stop.units_all );
}

static Trial make_trial( int frames, int group )
{
    Trial t = { .frames = frames, .group = group, .most_spp = 1 << 16, .pace = 0.01 };
    for ( int k = 0; k < frames; ++k )
        t.noise[k] = 0.1;
    return t;
}

static const int s_shapes[][2] = { { 1, 0 },  { 1, 3 },  { 5, 3 },  { 9, 3 },   { 12, 4 }, { 48, 0 },
                                   { 48, 1 }, { 48, 3 }, { 48, 8 }, { 48, 16 }, { 200, 3 } };
#define SHAPES ( sizeof s_shapes / sizeof s_shapes[0] )

static double true_relmse( const Trial* t, int k ) { return noise_of( t, k ) / t->weight[k]; }

// Work of the plan that gives each frame the weight it needs, and nothing more.
static double least_work( const Trial* t, double weight )
{
    int spp = (int)ceil( weight ) > 2 ? (int)ceil( weight ) : 2;
    RfGroupPlan plan = rf_plan_groups( t->frames, t->group, spp );
    double work = 0.0;
    for ( int w = 0; w < plan.groups; ++w )
        work += (double)rf_group( &plan, w ).passes * rf_group( &plan, w ).eyes;
    return work;
}

// Estimates that are right: every frame is below, at little more than it costs.
TEST( test_exact_estimates_reach_the_error )
{
    static const double errors[] = { 0.05, 0.02, 0.003, 0.0007 };
    for ( size_t s = 0; s < SHAPES; ++s )
    {
        for ( size_t e = 0; e < 4; ++e )
        {
            Trial t = make_trial( s_shapes[s][0], s_shapes[s][1] );
            t.error = errors[e];
            run( &t );
            for ( int k = 0; k < t.frames; ++k )
                assert_true( true_relmse( &t, k ) <= t.error && t.reached[k] );
            assert_int_equal( t.stop.missed, 0 );
            assert_true( t.work <= 1.15 * least_work( &t, 0.1 / t.error ) + 2.0 * t.frames );
        }
    }
}

// As off as estimates of small and heavy-tailed pictures are: the truth is still
// below 1.2 E in nine of ten frames.
TEST( test_noisy_estimates_reach_the_error )
{
    for ( size_t s = 0; s < SHAPES; ++s )
    {
        int above = 0, all = 0;
        double work = 0.0, least = 0.0;
        for ( int seed = 0; seed < 20; ++seed )
        {
            Trial t = make_trial( s_shapes[s][0], s_shapes[s][1] );
            t.error = 0.004;
            t.spread = 0.1;
            t.random = (uint64_t)seed * 77;
            run( &t );
            for ( int k = 0; k < t.frames; ++k )
                above += true_relmse( &t, k ) > 1.2 * t.error;
            all += t.frames;
            work += t.work;
            least += least_work( &t, 0.1 / t.error );
        }
        assert_true( 10 * above < all );
        if ( s_shapes[s][0] > 20 )
            assert_true( work < 1.5 * least );
    }
}

// No window of the middle stands out: what would show as a seam.
TEST( test_passes_are_spread )
{
    for ( int group = 1; group <= 8; group += 7 )
    {
        Trial t = make_trial( 200, group );
        t.error = 0.0007;
        t.spread = 0.02;
        run( &t );
        double mean = 0.1 / t.error / ( 2 * group + 1 );
        for ( int w = 2 * group + 1; w < t.stop.rule.plan.groups - 1; ++w )
            assert_true( t.window_passes[w] > 0.6 * mean - 1.0 && t.window_passes[w] < 1.6 * mean + 1.0 );
    }
}

// Where the noise rises along the path, and where it jumps, passes follow.
TEST( test_passes_follow_the_noise )
{
    Trial t = make_trial( 100, 3 );
    t.error = 0.004;
    for ( int k = 0; k < t.frames; ++k )
        t.noise[k] = k < 60 ? 0.02 + 0.002 * k : 0.6;
    run( &t );
    for ( int k = 0; k < t.frames; ++k )
        assert_true( true_relmse( &t, k ) <= t.error );
    assert_true( t.passes[20] < 0.7 * t.passes[50] );
    assert_true( t.passes[80] > 3 * t.passes[50] );
}

TEST( test_halves_stay_balanced )
{
    for ( size_t s = 0; s < SHAPES; ++s )
    {
        for ( int timed = 0; timed < 2; ++timed )
        {
            Trial t = make_trial( s_shapes[s][0], s_shapes[s][1] );
            t.error = timed ? 0.0 : 0.007;
            t.seconds = timed ? 3.0 * t.frames : 0.0;
            t.spread = 0.2;
            t.jitter = 0.5;
            run( &t );
            for ( int k = 0; k < t.frames; ++k )
            {
                assert_true( t.half[k][0] > 0 && t.half[k][1] > 0 );
                assert_int_equal( abs( t.half[k][0] - t.half[k][1] ), t.passes[k] & 1 );
            }
        }
    }
}

// An error that is not worth more than the least gets the least.
TEST( test_least_passes_are_kept )
{
    for ( size_t s = 0; s < SHAPES; ++s )
    {
        Trial t = make_trial( s_shapes[s][0], s_shapes[s][1] );
        t.error = 100.0;
        run( &t );
        for ( int k = 0; k < t.frames; ++k )
            assert_true( t.passes[k] >= 2 );
        assert_true( t.work <= least_work( &t, 2.0 ) + 2.0 * t.stop.rule.plan.eyes );
    }
}

// --spp is the most; what is above the error then is counted.
TEST( test_most_passes_are_kept )
{
    for ( size_t s = 0; s < SHAPES; ++s )
    {
        Trial t = make_trial( s_shapes[s][0], s_shapes[s][1] );
        t.error = 1e-9;
        t.most_spp = 5 * ( 2 * t.group + 1 );
        run( &t );
        assert_int_equal( t.stop.missed, t.frames );
        assert_true( t.work <= 1.02 * least_work( &t, t.most_spp ) + 2.0 * t.stop.rule.plan.eyes );
        assert_true( t.work >= 0.9 * least_work( &t, t.most_spp ) - 2.0 * t.stop.rule.plan.eyes );
    }
}

// Estimates that are no numbers end, and are no success.
TEST( test_estimates_not_finite_end_the_render )
{
    static const double bad[] = { (double)NAN, (double)INFINITY };
    for ( size_t s = 0; s < SHAPES; ++s )
    {
        for ( int b = 0; b < 2; ++b )
        {
            Trial t = make_trial( s_shapes[s][0], s_shapes[s][1] );
            t.error = 0.004;
            for ( int k = 0; k < t.frames; ++k )
                t.noise[k] = k % 2 == b ? bad[b] : 0.1;
            run( &t );
            for ( int k = 0; k < t.frames; ++k )
                assert_true( t.reached[k] == ( isfinite( t.noise[k] ) && true_relmse( &t, k ) <= t.error ) );
            assert_true( t.work <= 10.0 * least_work( &t, 30 ) );
        }
    }
}

// The time is kept within 10 % and one pass of a window, whatever the machine does.
TEST( test_time_is_kept )
{
    static const double seconds[] = { 0.5, 2.0, 30.0 };
    for ( size_t s = 0; s < SHAPES; ++s )
    {
        for ( size_t i = 0; i < 3; ++i )
        {
            Trial t = make_trial( s_shapes[s][0], s_shapes[s][1] );
            t.seconds = seconds[i] * t.frames;
            t.jitter = 1.0;
            run( &t );
            double pass = 1.5 * t.pace * t.stop.rule.plan.eyes;
            assert_true( fabs( t.now - t.seconds ) <= 0.1 * t.seconds + pass );
            assert_false( t.stop.hurried );
            assert_int_equal( t.stop.missed, 0 );
        }
    }
}

// A machine that becomes three times slower on the way.
TEST( test_time_with_a_changing_pace )
{
    Trial t = make_trial( 200, 3 );
    t.seconds = 400.0;
    RfGroupPlan plan = rf_plan_groups( t.frames, t.group, t.most_spp );
    t.stop = rf_create_stop( &plan, t.most_spp, &( RfStopGoals ){ .seconds = t.seconds } );
    for ( int w = 0; w < plan.groups; ++w )
        t.stop.units_left += rf_group_units( &t.stop, w );
    for ( int w = 0; w < plan.groups; ++w )
    {
        t.pace = w == plan.groups / 2 ? 0.03 : t.pace;
        run_window( &t, w );
    }
    assert_true( fabs( t.now - t.seconds ) <= 0.1 * t.seconds );
    assert_true( t.passes[50] > 2 * t.passes[150] );
}

// Less time than the least takes: the least, and it is reported.
TEST( test_too_short_a_time )
{
    for ( size_t s = 0; s < SHAPES; ++s )
    {
        Trial t = make_trial( s_shapes[s][0], s_shapes[s][1] );
        t.seconds = 0.004 * t.frames;
        run( &t );
        assert_true( t.stop.hurried );
        for ( int k = 0; k < t.frames; ++k )
            assert_true( t.passes[k] >= 2 );
        assert_true( t.work <= least_work( &t, 2.0 ) + 2.0 * t.stop.rule.plan.eyes );
    }
}

// After a tenth of the work the time to the end is known within a tenth where all frames are alike. In the first group
// nothing is.
TEST( test_time_to_the_end_is_in_proportion )
{
    for ( int group = 0; group <= 8; group += 4 )
    {
        Trial whole = make_trial( 120, group ), t = whole;
        whole.error = t.error = 0.002;
        whole.spread = t.spread = 0.05;
        run( &whole );
        RfGroupPlan plan = rf_plan_groups( t.frames, t.group, t.most_spp );
        t.stop = rf_create_stop( &plan, t.most_spp, &( RfStopGoals ){ .noise = t.error } );
        t.random = 1;
        for ( int w = 0; w < plan.groups; ++w )
            t.stop.units_left += rf_group_units( &t.stop, w );
        assert_true( isnan( rf_stop_left( &t.stop, 0.0 ) ) );
        double worst = 0.0;
        for ( int w = 0; w < plan.groups; ++w )
        {
            run_window( &t, w );
            double left = rf_stop_left( &t.stop, t.now ), all = whole.now;
            if ( t.now > 0.1 * all )
                worst = fmax( worst, fabs( t.now + left - all ) / all );
        }
        printf( "group %d: off by %.3f at most\n", group, worst );
        assert_true( worst < 0.1 );
        assert_true( rf_stop_left( &t.stop, t.now ) < 0.01 * t.now );
    }
}

// Both: whichever comes first.
TEST( test_whichever_comes_first_stops )
{
    for ( size_t s = 0; s < SHAPES; ++s )
    {
        Trial noise = make_trial( s_shapes[s][0], s_shapes[s][1] ), both = noise, tight = noise;
        noise.error = both.error = tight.error = 0.004;
        run( &noise );
        both.seconds = 100.0 * noise.now;
        run( &both );
        assert_int_equal( both.stop.missed, 0 );
        assert_true( both.work <= 1.1 * noise.work + 2.0 * both.stop.rule.plan.eyes );
        tight.seconds = 0.5 * noise.now;
        run( &tight );
        assert_true( tight.now <= 1.1 * tight.seconds + tight.pace * tight.stop.rule.plan.eyes );
        assert_true( tight.stop.missed > 0 );
    }
}
