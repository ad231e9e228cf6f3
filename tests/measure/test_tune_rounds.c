// Whole tuning runs: rounds, halving, the least budget, interruption.
#include "support/render_support.h"
#include "support/test.h"

static RfTune tune_of( const TuneSetup* s )
{
    RfTune tune;
    RfError error;
    if ( rf_tune( &s->job, &tune, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return tune;
}

// Without time there is the first round, whose errors are the same for any threads.
TEST( test_first_round_is_repeatable )
{
    AUTO_BY( end_tune_setup ) TuneSetup s;
    begin_tune_setup( &s, 7, 14 );
    RfTune one = tune_of( &s );
    s.settings.threads = 1;
    RfTune other = tune_of( &s );
    assert_true( one.round_count == 1 && one.count == 4 * RF_TUNE_TILES && one.chosen >= 0 );
    assert_true( one.rounds[0].pixels == TUNE_WIDTH * TUNE_HEIGHT && one.rounds[0].regions == 1 );
    for ( int r = 0; r < one.count; ++r )
    {
        const RfTrialRow *a = one.rows + r, *b = other.rows + r;
        assert_true( a->rounds == 1 && a->trial.groups >= 1 && a->relmse > 0.0 && a->f1 > 0.0 && a->efficiency > 0.0 &&
                     a->gain.value > 0.0 );
        assert_true( a->trial.relmse == b->trial.relmse && a->trial.change == b->trial.change &&
                     a->trial.samples == b->trial.samples );
        assert_true( a->chosen == ( r == one.chosen ) && a->efficiency <= one.rows[one.chosen].efficiency );
        assert_true( a->gain.low <= a->gain.value && a->gain.value <= a->gain.high );
        assert_true( a->group > 0 || fabs( a->phi - 1.0 ) < 1e-6 );
    }
    // 7 frames that share their paths are better than each alone
    assert_true( one.rows[3].group == 3 && one.rows[3].relmse < 0.4 * one.rows[0].relmse && one.rows[3].phi < 0.5 );
}

// A camera that stands still, and the shortest path that does not.
TEST( test_short_paths_are_tuned )
{
    for ( int eyes = 1; eyes <= 2; ++eyes )
    {
        AUTO_BY( end_tune_setup ) TuneSetup s;
        begin_tune_setup( &s, eyes, 8 );
        RfTune tune = tune_of( &s );
        assert_true( tune.count == eyes * RF_TUNE_TILES && tune.chosen >= 0 );
        for ( int r = 0; r < tune.count; ++r )
            assert_true( tune.rows[r].efficiency > 0.0 && tune.rows[r].eyes <= eyes );
    }
}

typedef struct Halving
{
    int rounds, candidates[RF_TUNE_ROUNDS + 1];
} Halving;

static void note_round( void* user, const RfTune* tune, const RfTuneRound* round, int candidates )
{
    Halving* halving = user;
    assert_true( round->regions > 0 && halving->rounds < RF_TUNE_ROUNDS && tune->round_count == halving->rounds );
    halving->candidates[halving->rounds++] = candidates;
}

// A third round is not waited for.
static bool is_in_second( void* user )
{
    const Halving* halving = user;
    return halving->rounds <= 2;
}

// Halving from the first round to the last: fewer settings each time, all of which
// were in every round before, and the best of the last is chosen. The pictures are so
// small that the most places are tried long before the budget is gone.
TEST( test_rounds_halve_the_settings )
{
    AUTO_BY( end_tune_setup ) TuneSetup s;
    begin_tune_setup( &s, 7, 14 );
    orbit_eyes( s.eyes, TUNE_EYES, 1.0f, 6, 4 );
    Halving halving = { 0 };
    RfTrialWatch watch = { is_in_second, &halving };
    s.job.watch = &watch;
    s.job.report = note_round;
    s.job.user = &halving;
    s.job.budget = 60.0;
    RfTune tune;
    RfError error = { 0 };
    RfResult result = rf_tune( &s.job, &tune, &error );
    assert_true( result == RF_OK || result == RF_ERROR_INTERRUPTED );
    assert_int_equal( tune.round_count, 2 );
    assert_int_equal( halving.candidates[0], 4 * RF_TUNE_TILES );
    assert_true( halving.candidates[1] <= 17 && halving.candidates[1] > 1 );
    assert_true( halving.rounds < 3 || halving.candidates[2] <= 9 );
    int in_round[3] = { 0 };
    for ( int r = 0; r < tune.count; ++r )
    {
        for ( int k = 1; k <= tune.rows[r].rounds; ++k )
            in_round[k - 1] += 1;
        assert_true( tune.rows[r].rounds < 2 || tune.rows[r].efficiency <= tune.rows[tune.chosen].efficiency );
    }
    assert_true( in_round[0] == halving.candidates[0] && in_round[1] == halving.candidates[1] && in_round[2] == 0 );
    assert_int_equal( tune.rows[tune.chosen].rounds, 2 );
}

// Where nothing fits, the least of all rows is named; with that, and with any budget
// above, the tuning runs, though its guide would take more. With less it does not.
TEST( test_named_least_budget_works )
{
    AUTO_BY( end_tune_setup ) TuneSetup s;
    RfTune tune;
    RfError error;
    begin_tune_setup( &s, 5, 10 );
    orbit_eyes( s.eyes, TUNE_EYES, 1.0f, 48, 36 );
    s.settings.max_depth = 2;
    s.settings.memory = 1000;
    assert_int_equal( rf_tune( &s.job, &tune, &error ), RF_ERROR_MEMORY );
    assert_true( error.remedy == RF_REMEDY_MEMORY );
    size_t named = error.least_memory, most = 0;
    for ( int r = 0; r < tune.count; ++r )
    {
        assert_true( tune.rows[r].fit.least >= named && tune.rows[r].excluded != NULL && tune.rows[r].fit.bytes_films == 0 );
        most = tune.rows[r].fit.least > most ? tune.rows[r].fit.least : most;
    }
    assert_int_equal( tune.rows[0].fit.least, named ); // one frame, no tiles
    assert_true( most > named + named / 4 );
    s.settings.memory = named - named / 100;
    assert_int_equal( rf_tune( &s.job, &tune, &error ), RF_ERROR_MEMORY );
    for ( int k = 0; k <= 4; ++k )
    {
        s.settings.memory = ( named + (size_t)k * ( most - named ) / 4 ) / 1024 * 1024; // `least` is rounded up to KiB
        tune = tune_of( &s );
        assert_true( tune.chosen >= 0 && tune.rows[tune.chosen].fit.least <= s.settings.memory );
        for ( int r = 0; r < tune.count; ++r )
            assert_true( ( tune.rows[r].excluded == NULL ) == ( tune.rows[r].fit.least <= s.settings.memory ) &&
                         ( tune.rows[r].rounds > 0 ) == ( tune.rows[r].excluded == NULL ) );
        assert_true( k < 4 || tune_rows_tried( &tune ) == tune.count );
    }
}

typedef struct Stop
{
    int rounds, wanted;
} Stop;

static bool go_on( void* user )
{
    const Stop* stop = user;
    return stop->rounds < stop->wanted;
}

static void count_round( void* user, const RfTune* tune, const RfTuneRound* round, int candidates )
{
    Stop* stop = user;
    assert_true( round->pixels > 0.0 && candidates > 0 && tune->round_count == stop->rounds );
    stop->rounds += 1;
}

TEST( test_interruption_after_any_round )
{
    AUTO_BY( end_tune_setup ) TuneSetup s;
    begin_tune_setup( &s, 7, 14 );
    for ( int wanted = 0; wanted < 3; ++wanted )
    {
        Stop stop = { 0, wanted };
        RfTrialWatch watch = { go_on, &stop };
        s.job.watch = &watch;
        s.job.report = count_round;
        s.job.user = &stop;
        s.job.budget = 1000.0; // of which nothing is waited for
        s.job.shot.eye_count = s.job.shot.frame_count = 3;
        RfTune tune;
        RfError error;
        assert_int_equal( rf_tune( &s.job, &tune, &error ), RF_ERROR_INTERRUPTED );
        assert_int_equal( tune.round_count, wanted > 0 ? wanted - 1 : 0 );
        assert_true( ( tune.chosen >= 0 ) == ( tune.round_count > 0 ) );
        if ( wanted == 2 )
            break;
    }
}

// Nothing to see: no error to compare.
TEST( test_black_pictures_cannot_be_compared )
{
    AUTO_BY( end_tune_setup ) TuneSetup s;
    begin_tune_setup( &s, 2, 4 );
    for ( int i = 0; i < 2; ++i )
        s.eyes[i].origin = rf_vec3( 100.0f, 100.0f, 100.0f );
    RfTune tune;
    RfError error;
    assert_int_equal( rf_tune( &s.job, &tune, &error ), RF_ERROR_SCENE );
    assert_non_null( strstr( error.text, "black" ) );
}
