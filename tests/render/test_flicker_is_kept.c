// render --flicker reaches the F1 that it is asked for, in every mode of rendering, and tells it; cost, plan and tune know of it.
#include "support/cli_run.h"
#include "support/test.h"
#include "image/exr.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define ROOM REFRAME_SCENE_FOLDER "/noise-shelf.glb" // no lamp is seen, whose rim would be all of F1
#define SMALL "--size 48x27 --group 1 --quiet "

static double value_of( const json_t* json, const char* key ) { return json_number_value( json_object_get( json, key ) ); }

static const json_t* frame_of( const json_t* json, size_t i ) { return json_array_get( json_object_get( json, "frames" ), i ); }

static size_t count_of( const json_t* json ) { return json_array_size( json_object_get( json, "frames" ) ); }

// Every pair that was rendered is below by what is reported, or missed, and the first frame has none. Returns the missed pairs:
// the earlier frame of a pair is finished before the later one, so a rare one of them cannot be mended (1 of 60 in this room).
static int check_told( const json_t* json, double wanted )
{
    assert_true( value_of( json_object_get( json, "flicker" ), "wanted" ) == wanted );
    assert_true( json_is_null( json_object_get( frame_of( json, 0 ), "flicker_estimate" ) ) );
    int missed = 0;
    for ( size_t i = 1; i < count_of( json ); ++i )
    {
        const json_t* frame = frame_of( json, i );
        double told = value_of( frame, "flicker_estimate" ), likely = value_of( frame, "flicker_likely" );
        bool bound = json_is_true( json_object_get( frame, "flicker_is_lower_bound" ) );
        bool reached = json_is_true( json_object_get( frame, "reached" ) );
        missed += !reached;
        assert_true( told > 0.0 && ( !reached || likely <= wanted ) && likely <= 1.2 * wanted );
        assert_true( bound ? told < likely : told == likely );
    }
    assert_int_equal( value_of( json_object_get( json, "flicker" ), "missed" ), missed );
    return missed;
}

// What is reported against a reference, over all pairs of three seeds.
TEST( test_the_flicker_is_reached )
{
    cli_expect( cli_run( "$R render " ROOM " -o ref.####.exr --frames 3-7 --float --spp 300 --tile 3x3 --seed 99 " SMALL ), 0,
                NULL );
    double truth = 0.0, told = 0.0;
    int missed = 0;
    for ( int seed = 1; seed <= 3; ++seed )
    {
        cli_expect( cli_run( "$R render " ROOM " -o f.####.exr --overwrite --frames 3-7 --float --flicker 0.15 --seed %d --json "
                             "f.json " SMALL " && $R flicker f.####.exr --reference ref.####.exr --no-spectrum --json t.json",
                             seed ),
                    0, NULL );
        json_t *json = cli_read_json( "f.json" ), *flicker = cli_read_json( "t.json" );
        missed += check_told( json, 0.15 );
        assert_int_equal( json_array_size( json_object_get( flicker, "pairs" ) ), 4 );
        for ( size_t i = 0; i < 4; ++i )
        {
            double f1 = value_of( json_array_get( json_object_get( flicker, "pairs" ), i ), "f1_relative" );
            double likely = value_of( frame_of( json, i + 1 ), "flicker_likely" );
            truth += f1 * f1;
            told += likely * likely;
        }
        json_decref( json );
        json_decref( flicker );
    }
    printf( "F1 %.5f, told %.5f\n", sqrt( truth / 12.0 ), sqrt( told / 12.0 ) );
    assert_true( missed <= 1 );
    assert_true( truth / 12.0 <= 1.1 * 0.15 * 0.15 );
    assert_true( told / truth > 0.64 && told / truth < 1.5625 ); // 0.8 to 1.25 of F1
}

TEST( test_less_flicker_takes_more )
{
    double spp[2] = { 0 };
    int missed = 0;
    for ( int i = 0; i < 16; ++i )
    {
        double wanted = i % 2 == 0 ? 0.2 : 0.1;
        cli_expect( cli_run( "$R render " ROOM
                             " -o m.####.exr --overwrite --frames 3-6 --flicker %g --seed %d --json m.json " SMALL,
                             wanted, 1 + i / 2 ),
                    0, NULL );
        json_t* json = cli_read_json( "m.json" );
        missed += check_told( json, wanted );
        spp[i % 2] += value_of( frame_of( json, 2 ), "native_spp" ) / 8.0;
        json_decref( json );
    }
    printf( "samples for half of F1: %.1f, not %.1f; %d of 48 pairs missed\n", spp[1], spp[0], missed );
    assert_true( spp[1] > 2.0 * spp[0] && spp[1] < 5.0 * spp[0] && missed <= 4 );
}

// Neither threads nor a second run change a bit.
TEST( test_threads_change_nothing )
{
    cli_expect( cli_run( "$R render " ROOM " -o one.####.exr --frames 3-6 --flicker 0.2 --threads 1 " SMALL " && $R render " ROOM
                         " -o two.####.exr --frames 3-6 --flicker 0.2 --threads 3 " SMALL
                         " && for f in 3 4 5 6; do cmp one.000$f.exr two.000$f.exr || exit 1; done" ),
                0, NULL );
}

TEST( test_both_goals_hold )
{
    int missed = 0;
    static const char* const goals[] = { "--flicker 0.15 --noise 1", "--flicker 1 --noise 0.05", "--flicker 0.2 --noise 0.1" };
    for ( size_t i = 0; i < sizeof goals / sizeof goals[0]; ++i )
    {
        cli_expect( cli_run( "$R render " ROOM " -o n.####.exr --overwrite --frames 3-5 %s --json n.json " SMALL, goals[i] ), 0,
                    NULL );
        json_t* json = cli_read_json( "n.json" );
        assert_int_equal( value_of( json_object_get( json, "noise" ), "missed" ), 0 );
        missed += check_told( json, value_of( json_object_get( json, "flicker" ), "wanted" ) );
        for ( size_t k = 0; k < 3; ++k )
            assert_true( value_of( frame_of( json, k ), "relmse_likely" ) <=
                         value_of( json_object_get( json, "noise" ), "wanted" ) );
        json_decref( json );
    }
    assert_true( missed <= 1 );
}

TEST( test_what_is_not_reached_is_reported )
{
    cli_expect( cli_run( "$R render " ROOM " -o w.####.exr --frames 1-3 --flicker 1e-6 --spp 6 --json w.json " SMALL ), 0,
                "--flicker: 0.0001 % not reached in 2 of 3 frames" );
    json_t* json = cli_read_json( "w.json" );
    assert_int_equal( value_of( json_object_get( json, "flicker" ), "missed" ), 2 );
    assert_true( json_is_null( json_object_get( frame_of( json, 0 ), "flicker_estimate" ) ) ); // the first of the path
    assert_true( json_is_false( json_object_get( frame_of( json, 1 ), "reached" ) ) );
    json_decref( json );
}

// Each frame of its own samples; all frames in one group; cut groups; extra samples; other filters; a frame without
// neighbours, which is held to what two like it would have; films that fit the budget closely.
TEST( test_every_way_of_rendering_reaches_it )
{
    static const char* const kinds[] = { "--frames 3-5 --group 0 --tile 1",          "--frames 3-5 --group 40",
                                         "--frames 3-5 --group 20 --filter box",     "--frames 3-5 --group 1 --adaptive",
                                         "--frames 3-5 --group 1 --normalize ratio", "--frames 3 --group 2" };
    int missed = 0;
    for ( size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i )
    {
        cli_expect( cli_run( "$R render " ROOM " -o k.####.exr --overwrite --flicker 0.3 --size 32x18 --quiet --json k.json %s",
                             kinds[i] ),
                    0, NULL );
        json_t* json = cli_read_json( "k.json" );
        missed += check_told( json, 0.3 );
        json_decref( json );
    }
    assert_true( missed <= 1 );
}

TEST( test_resume_goes_on )
{
    cli_expect( cli_run( "$R render " ROOM " -o r.####.exr --frames 3-6 --flicker 0.3 " SMALL
                         " && cp r.0003.exr kept.exr && rm r.0005.exr" ),
                0, NULL );
    cli_expect( cli_run( "$R render " ROOM " -o r.####.exr --frames 3-6 --flicker 0.3 --resume --json r.json " SMALL
                         " && cmp r.0003.exr kept.exr" ),
                0, NULL );
    json_t* json = cli_read_json( "r.json" );
    assert_int_equal( count_of( json ), 4 );
    for ( size_t i = 0; i < 4; ++i )
    {
        assert_int_equal( json_is_true( json_object_get( frame_of( json, i ), "kept" ) ), i != 2 );
        assert_true( json_is_true( json_object_get( frame_of( json, i ), "reached" ) ) );
        assert_int_equal( json_is_null( json_object_get( frame_of( json, i ), "flicker_estimate" ) ), i == 0 || i == 2 );
    }
    json_decref( json );
    cli_expect( cli_run( "$R render " ROOM " -o r.####.exr --frames 3-6 --flicker 0.2 --resume " SMALL ), 1,
                "of another render, of --flicker 0.3 (here 0.2)" );
    cli_expect( cli_run( "$R render " ROOM " -o r.####.exr --frames 3-6 --resume " SMALL ), 1, "--resume: " );
}

TEST( test_header_and_json_agree )
{
    cli_expect( cli_run( "$R render " ROOM " -o h.####.exr --frames 3-4 --flicker 0.3 --json h.json " SMALL ), 0, NULL );
    json_t* json = cli_read_json( "h.json" );
    static const char* const keys[][2] = { { "reframe/flicker-estimate", "flicker_estimate" },
                                           { "reframe/flicker-likely", "flicker_likely" },
                                           { "reframe/flicker-worst-ten-share", "flicker_worst_ten_share" } };
    char path[512], value[64];
    snprintf( path, sizeof path, "%s/h.0004.exr", cli_folder() );
    for ( size_t i = 0; i < sizeof keys / sizeof keys[0]; ++i )
    {
        assert_int_equal( rf_read_exr_string( path, keys[i][0], value, sizeof value, NULL ), RF_OK );
        double wanted = value_of( frame_of( json, 1 ), keys[i][1] );
        assert_true( fabs( strtod( value, NULL ) - wanted ) <= 1e-5 * wanted );
    }
    assert_int_equal( rf_read_exr_string( path, "reframe/flicker", value, sizeof value, NULL ), RF_OK );
    assert_string_equal( value, "0.3" );
    assert_int_equal( rf_read_exr_string( path, "reframe/reached", value, sizeof value, NULL ), RF_OK );
    assert_string_equal( value, "yes" );
    json_decref( json );
}

TEST( test_wrong_values_are_refused )
{
    static const char* const wrong[][2] = { { "--flicker -1", "--flicker: expected" },
                                            { "--flicker low", "--flicker: expected" },
                                            { "--flicker 2%%", "--flicker: expected" },
                                            { "--flicker 1e9", "--flicker: expected" },
                                            { "--flicker 0.1 --estimator gradient",
                                              "the estimator 'gradient' has no estimate of flicker" } };
    for ( size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i )
        cli_expect( cli_run( "$R render " ROOM " -o e.exr --frames 1 --size 8x8 --quiet %s", wrong[i][0] ), 2, wrong[i][1] );
    cli_expect(
        cli_run( "$R render " ROOM " -o e.####.exr --frames 1-9 --size 400x300 --group 4 --memory 20M --flicker 1 --quiet" ), 1,
        "too small for frames of 400x300" );
}

// What cost predicts for path tracing is what such a render of a few frames takes, within a factor of two; plan and
// cost have it in their JSON.
TEST( test_what_it_takes_is_predicted )
{
    cli_expect( cli_measure( "$R cost " ROOM " --frames 3-6 --size 48x27 --group 1 --flicker 30%,15% --quiet --json c.json", 4 ),
                0, NULL );
    cli_expect( cli_run( "$R render " ROOM
                         " -o c.####.exr --frames 3-6 --size 48x27 --group 0 --tile 1 --filter box --no-adaptive "
                         "--flicker 0.15 --quiet --json d.json" ),
                0, NULL );
    json_t *cost = cli_read_json( "c.json" ), *json = cli_read_json( "d.json" );
    const json_t* wanted = json_object_get( cost, "wanted_flicker" );
    assert_int_equal( json_array_size( wanted ), 2 );
    const json_t *easy = json_array_get( wanted, 0 ), *hard = json_array_get( wanted, 1 );
    assert_true( value_of( easy, "f1" ) == 0.3 && value_of( hard, "f1" ) == 0.15 );
    double spp = value_of( json_object_get( hard, "plain" ), "spp" ),
           ratio = spp / value_of( json_object_get( easy, "plain" ), "spp" );
    assert_true( ratio > 3.3 && ratio < 4.7 );
    double taken = 0.0;
    for ( size_t i = 0; i < 4; ++i )
        taken += value_of( frame_of( json, i ), "native_spp" ) / 4.0;
    printf( "samples for F1 0.15: predicted %.0f, taken %.1f\n", spp, taken );
    assert_true( spp > 0.4 * taken && spp < 2.5 * taken );
    json_decref( cost );
    json_decref( json );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
