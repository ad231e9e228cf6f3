// Tuning decides: which settings are tried and why, how the time is divided, which is
// chosen.
#include "render/groups.h"
#include "support/render_support.h"
#include "support/test.h"

TEST( test_every_setting_is_a_row )
{
    static const int paths[][2] = { { 1, 1 }, { 2, 2 }, { 5, 3 }, { 6, 4 }, { 48, 9 } };
    TuneSetup s;
    for ( int i = 0; i < 5; ++i )
    {
        begin_tune_setup( &s, paths[i][0], 33 );
        RfTune tune = { 0 };
        RfRenderSettings common;
        RfError error;
        assert_int_equal( rf_list_tune_rows( &s.job, &tune, &common, &error ), RF_OK );
        assert_int_equal( tune.count, RF_TUNE_TILES * paths[i][1] );
        // a single frame is always tried, and the group of which the plan thinks best
        assert_true( tune_rows_tried( &tune ) >= RF_TUNE_TILES * ( paths[i][0] > 1 ? 2 : 1 ) );
        for ( int r = 0; r < tune.count; ++r )
        {
            const RfTrialRow* row = tune.rows + r;
            RfRenderSettings settings = rf_tune_settings( row, &common ), used;
            assert_int_equal(
                rf_resolve_settings( &( RfShot ){ s.tracer, s.eyes, paths[i][0], NULL, 0 }, &settings, &used, &error ), RF_OK );
            assert_true( used.group == row->group && used.spp == row->spp && row->fit.films > 0 );
            RfGroupPlan plan = rf_plan_groups( paths[i][0], row->group, 33 );
            assert_true( row->eyes == plan.eyes && row->samples >= 33.0 * TUNE_WIDTH * TUNE_HEIGHT * paths[i][0] );
            assert_true( row->cost > 100.0 && row->predicted_gain > 0.0 );
            assert_true( row->excluded == NULL || ( row->group > 0 && strstr( row->excluded, "by the plan" ) != NULL ) );
        }
        end_tune_setup( &s );
    }
}

// What does not fit, or would take far more samples than were asked for, is said.
TEST( test_excluded_rows_say_why )
{
    AUTO_BY( end_tune_setup ) TuneSetup s;
    RfTune tune = { 0 };
    RfRenderSettings common;
    RfError error;
    begin_tune_setup( &s, 48, 5 );
    assert_int_equal( rf_list_tune_rows( &s.job, &tune, &common, &error ), RF_OK );
    for ( int r = 0; r < tune.count; ++r )
    {
        const char* why = tune.rows[r].excluded;
        assert_true( why != NULL || tune.rows[r].spp <= 10 );
        assert_true( why == NULL || strstr( why, tune.rows[r].spp > 10 ? "spp would" : "predicted to gain less" ) != NULL );
        assert_true( why == NULL || tune.rows[r].group > 0 );
    }
    size_t least = tune.rows[0].fit.least;
    tune = ( RfTune ){ 0 };
    s.settings.memory = least;
    assert_int_equal( rf_list_tune_rows( &s.job, &tune, &common, &error ), RF_OK );
    assert_int_equal( tune_rows_tried( &tune ), 1 );
    assert_null( tune.rows[0].excluded );
    assert_true( strstr( tune.rows[RF_TUNE_GROUPS].excluded, "memory" ) != NULL );
    assert_true( tune.rows[RF_TUNE_GROUPS].fit.least > least && tune.rows[RF_TUNE_GROUPS].fit.films == 0 );
    tune = ( RfTune ){ 0 };
    s.settings.memory = least - 1024;
    assert_int_equal( rf_list_tune_rows( &s.job, &tune, &common, &error ), RF_ERROR_MEMORY );
    assert_true( error.remedy == RF_REMEDY_MEMORY && error.least_memory == least );
}

static RfTrial made_trial( double relmse, double seconds )
{
    return ( RfTrial ){ .groups = 1,
                        .weight = 100.0,
                        .log_passes = 100.0 * log( 10.0 ), // as rendered
                        .samples = 1000.0,
                        .timed_samples = 500.0,
                        .cpu_seconds = 500.0 * seconds,
                        .relmse = 100.0 * relmse,
                        .change_weight = 100.0,
                        .change = 100.0 / 6.0,
                        .piece_count = 2,
                        .pieces = { { 50.0, 50.0 * relmse }, { 50.0, 50.0 * relmse } } };
}

// Rows of one tile whose errors and times are made up.
static RfTune made_tune( int count )
{
    RfTune tune = { .count = count, .chosen = -1, .round_count = 1 };
    for ( int i = 0; i < count; ++i )
    {
        tune.rows[i] = ( RfTrialRow ){
            .group = i, .eyes = 2 * i + 1, .spp = 10, .fit = { .threads = 2 }, .samples = 1e6, .cost = 500.0, .rounds = 1
        };
        tune.rows[i].trial = made_trial( 1.0, 1e-6 * ( i + 1 ) );
    }
    return tune;
}

TEST( test_most_efficient_row_is_chosen )
{
    RfTune tune = made_tune( 4 );
    tune.rows[2].trial = tune.rows[1].trial;      // equal trials
    tune.rows[3].trial = made_trial( 0.1, 5e-6 ); // the best, but
    rf_predict_tune_rows( &tune, 1000.0, 10 );
    assert_int_equal( tune.chosen, 3 );
    assert_true( tune.rows[3].chosen && !tune.rows[0].chosen );
    assert_true( tune.rows[1].efficiency == tune.rows[2].efficiency && tune.rows[1].relmse == tune.rows[2].relmse );
    const RfTrialRow* first = tune.rows;
    assert_true( fabs( first->cpu_seconds - 1.0 ) < 1e-9 && fabs( first->seconds - 0.5 ) < 1e-9 &&
                 fabs( first->relmse - 0.1 ) < 1e-12 );
    assert_true( fabs( first->efficiency - 100.0 ) < 1e-6 && first->gain.value == 1.0 ); // 10 frames / ( 0.1 · 1 s )
    assert_true( fabs( first->phi - 0.5 ) < 1e-12 && fabs( first->f1 - sqrt( 2.0 / 6.0 / 10.0 ) ) < 1e-12 );
    assert_true( fabs( tune.rows[3].gain.value - 2.0 ) < 1e-9 );
    double f1 = first->f1;
    tune.rows[0].trial.log_passes =
        100.0 * log( 2.0 ); // then errors fall by the usual exponent; efficiencies compare what was tried
    rf_predict_tune_rows( &tune, 1000.0, 10 );
    assert_true( fabs( first->relmse - 0.5 * pow( 5.0, -1.12 ) ) < 1e-12 && fabs( first->efficiency - 100.0 ) < 1e-6 );
    assert_true( fabs( first->f1 / f1 - pow( 5.0, -0.06 ) ) < 1e-12 );
    for ( int i = 0; i < 3; ++i ) // it was given up early
        tune.rows[i].rounds = 2;
    rf_predict_tune_rows( &tune, 1000.0, 10 );
    assert_int_equal( tune.chosen, 0 );
    assert_false( tune.rows[3].chosen );
    for ( int i = 0; i < 3; ++i )
        tune.rows[i].trial.relmse = i == 0 ? (double)NAN : 0.0;
    rf_predict_tune_rows( &tune, 1000.0, 10 );
    assert_int_equal( tune.chosen, -1 );
    tune.rows[3].rounds = 0;
    rf_predict_tune_rows( &tune, 1000.0, 10 );
    assert_true( isnan( tune.rows[3].efficiency ) && isnan( tune.rows[3].seconds ) && isnan( tune.rows[3].gain.value ) );
}

// Values that follow the model stay; one that is off moves back, the less the more is known of it.
// By F1, whose square falls with samples as relMSE does, another row may be the best.
TEST( test_least_flicker_is_chosen )
{
    RfTune tune = made_tune( 3 );
    tune.rows[1].trial.change /= 5.0; // a fifth of F1 squared, at twice the time
    tune.goal = RF_TUNE_FLICKER;
    rf_predict_tune_rows( &tune, 1000.0, 10 );
    assert_int_equal( tune.chosen, 1 );
    const RfTrialRow *first = tune.rows, *best = tune.rows + 1;
    assert_true( fabs( first->efficiency - 10.0 / ( first->f1 * first->f1 * first->cpu_seconds ) ) < 1e-6 * first->efficiency );
    assert_true( fabs( best->gain.value - 2.5 ) < 1e-9 && isnan( best->gain.low ) );
    assert_true( fabs( first->relmse - 0.1 ) < 1e-12 && best->f1 < first->f1 );
    tune.goal = RF_TUNE_NOISE;
    rf_predict_tune_rows( &tune, 1000.0, 10 );
    assert_int_equal( tune.chosen, 0 );
}

TEST( test_smoothing_follows_the_model )
{
    static const int eyes[] = { 1, 3, 5, 7, 9, 13, 17, 25, 33 };
    for ( int evidence = 1; evidence <= 100; evidence *= 10 )
    {
        RfTune tune = { .chosen = -1 };
        for ( int tile = 0; tile < RF_TUNE_TILES; ++tile )
        {
            for ( int i = 0; i < 9; ++i )
            {
                RfTrialRow* row = tune.rows + tune.count++;
                double x = log( eyes[i] ), odd = 0.02 * ( ( 7 * i + 3 * tile ) % 5 - 2 );
                *row = ( RfTrialRow ){
                    .group = eyes[i] / 2, .eyes = eyes[i], .tile = { RF_TILE_BLOCK, tile + 1, 1 }, .spp = 10, .rounds = 1
                };
                row->trial = made_trial( exp( -x + 0.1 * x * x - 0.3 * tile - 0.02 * tile * x + odd ),
                                         1e-6 * exp( 0.4 * x + 0.2 * tile ) );
            }
        }
        RfTune clean = tune;
        rf_smooth_tune_rows( &clean );
        for ( int i = 0; i < clean.count; ++i )
            assert_true( fabs( clean.rows[i].log_error ) < 0.05 && fabs( clean.rows[i].log_time ) < 1e-4 );
        RfTrialRow* off = tune.rows + 21; // 3 frames, the third tile
        off->trial.relmse *= exp( 1.0 );
        RfTrial once = off->trial;
        for ( int k = 1; k < evidence; ++k )
            rf_add_trial( &off->trial, &once );
        rf_smooth_tune_rows( &tune );
        if ( evidence == 1 )
            assert_true( off->log_error < -0.5 && off->log_error > -1.1 );
        if ( evidence == 100 )
            assert_true( off->log_error < 0.0 && off->log_error > -0.6 );
        assert_true( fabs( off->log_time ) < 1e-3 );
    }
    // as many values as terms, or fewer, or none that is a number: they stay
    RfTune tune = made_tune( 3 );
    rf_smooth_tune_rows( &tune );
    assert_true( tune.rows[1].log_error == 0.0 && tune.rows[2].log_time == 0.0 );
}

static int cut( const RfTune* tune, int kept, bool* candidate )
{
    int count = 0;
    rf_cut_tune_candidates( tune, kept, candidate );
    for ( int i = 0; i < tune->count; ++i )
        count += candidate[i];
    return count;
}

TEST( test_cutting_keeps_the_most_efficient )
{
    RfTune tune = made_tune( 8 );
    for ( int i = 0; i < 8; ++i )
        tune.rows[i].tile = ( RfTile ){ RF_TILE_BLOCK, 3, 3 };
    for ( int i = 0; i < 8; ++i )
        tune.rows[i].efficiency = 100.0 - 5.0 * i;
    tune.rows[0].efficiency = (double)NAN;
    tune.rows[7].efficiency = 40.0;
    bool candidate[RF_TUNE_ROWS] = { true, true, true, true, true, true, false, true };
    assert_int_equal( cut( &tune, 8, candidate ), 5 ); // without number; long given up; below half of the best
    assert_true( !candidate[0] && candidate[1] && candidate[5] && !candidate[6] && !candidate[7] );
    assert_int_equal( cut( &tune, 2, candidate ), 2 );
    assert_true( candidate[1] && candidate[2] );
    assert_int_equal( cut( &tune, 1, candidate ), 1 );
    tune.round_count = 0; // what is guessed says who goes first, but not that there is no hope
    candidate[2] = candidate[5] = true;
    tune.rows[5].efficiency = 1.0;
    assert_int_equal( cut( &tune, 3, candidate ), 3 );
    assert_true( candidate[1] && candidate[2] && candidate[5] );
    tune.round_count = 1;
    // path tracing stays, since the others are compared with it
    tune.rows[0] = ( RfTrialRow ){ .tile = { RF_TILE_NONE, 1, 1 }, .efficiency = 1.0 };
    candidate[0] = true;
    assert_int_equal( cut( &tune, 1, candidate ), 2 );
    assert_true( candidate[0] && candidate[1] );
    // and what a render takes by itself
    tune.rows[2].usual = candidate[2] = true;
    assert_int_equal( cut( &tune, 1, candidate ), 3 );
    assert_int_equal( cut( &tune, 0, candidate ), 2 );
    assert_true( candidate[0] && candidate[2] );
    candidate[1] = true;
    candidate[2] = false;
    tune.rows[1].efficiency = tune.rows[0].efficiency = (double)NAN;
    assert_int_equal( cut( &tune, 1, candidate ), 0 );
}

TEST( test_places_are_spread_evenly )
{
    static const double first[] = { 0.5, 0.25, 0.75, 0.125, 0.625 };
    for ( int i = 0; i < 5; ++i )
        assert_true( rf_tune_position( i ) == first[i] );
    int parts[16] = { 0 };
    for ( int i = 0; i < 15; ++i )
        parts[(int)( 16.0 * rf_tune_position( i ) )] += 1;
    for ( int i = 1; i < 16; ++i ) // evenly
        assert_int_equal( parts[i], 1 );
}

// Frames get about as many samples in all trials.
TEST( test_small_groups_get_more_passes )
{
    for ( int eyes = 1; eyes < 50; ++eyes )
    {
        int passes = rf_tune_passes( eyes, 2 );
        assert_true( passes >= 2 && ( eyes >= 7 || abs( passes * eyes - 2 * 7 ) <= eyes + 2 ) );
        assert_int_equal( rf_tune_passes( eyes, 4 ), 2 * passes );
    }
}

static RfTuneOutlook outlook_of( int number, double left )
{
    return ( RfTuneOutlook ){ .number = number,
                              .width = 320,
                              .height = 200,
                              .left = left,
                              .must = number == 0,
                              .rate = 2.0,
                              .cost_second = 2e-9,
                              .memory = (size_t)1 << 30,
                              .workers = 2 };
}

// More time never makes smaller pieces or fewer places, and none of it is overdrawn.
TEST( test_time_is_never_overdrawn )
{
    bool candidate[RF_TUNE_ROWS];
    for ( int i = 0; i < RF_TUNE_ROWS; ++i )
        candidate[i] = true;
    for ( int number = 0; number < RF_TUNE_ROUNDS; ++number )
    {
        RfTune tune = made_tune( 9 );
        for ( int i = 0; i < 9; ++i )
            tune.rows[i].rounds = number;
        double last = 0.0;
        bool refused = false, full = false, between = false;
        for ( double left = 1e-3; left < 1e7; left *= 3.0 )
        {
            RfTuneOutlook o = outlook_of( number, left );
            RfTuneRound round;
            bool planned = rf_plan_tune_round( &tune, candidate, &o, &round );
            assert_true( planned || number > 0 );
            refused = refused || !planned;
            if ( !planned )
                continue;
            double pixels = round.pixels;
            assert_true( pixels <= 320 * 200 && round.regions >= 1 && round.regions <= 24 && round.passes >= 2 );
            assert_true( round.regions * pixels >= 0.97 * last );
            assert_true( round.seconds < 1.05 * left || ( number == 0 && round.regions == 1 && pixels <= 2500.0 ) );
            double cost = rf_tune_round_cost( &tune, candidate, &round, o.cost_second );
            assert_true( fabs( round.seconds - cost / o.rate ) < 1e-9 * round.seconds );
            between = between || ( pixels < 320 * 200 && pixels > 3600.0 && round.seconds > 0.2 * left );
            full = full || pixels == 320 * 200;
            last = round.regions * pixels;
        }
        assert_true( refused == ( number > 0 ) && full && between );
    }
}

// Little memory: smaller pieces.
TEST( test_little_memory_smaller_pieces )
{
    RfTune tune = made_tune( 9 );
    bool candidate[RF_TUNE_ROWS] = { true, true, true, true, true, true, true, true, true };
    RfTuneOutlook o = outlook_of( 1, 1e6 );
    RfTuneRound large, small;
    assert_true( rf_plan_tune_round( &tune, candidate, &o, &large ) );
    o.memory = (size_t)1 << 20;
    assert_true( rf_plan_tune_round( &tune, candidate, &o, &small ) );
    assert_true( large.pixels == 320 * 200 && small.pixels < 320 * 200 );
    double bytes = 2.0 * (double)rf_trial_bytes( 17, 1 ) * small.pixels;
    assert_true( bytes < (double)o.memory );
    // a film of a single pixel is tried as it is
    o.width = o.height = 1;
    assert_true( rf_plan_tune_round( &tune, candidate, &o, &small ) && small.pixels == 1.0 );
}
