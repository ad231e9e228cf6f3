// render --noise reaches the error and --time keeps the time, in every mode of rendering.
#include "support/cli_run.h"
#include "support/test.h"
#include "image/exr.h"

#include <jansson.h>
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define LARGER "--size 64x36 --group 1 --quiet " // estimates of small pictures are as uncertain as their errors
#define SMALL "--size 40x24 --group 1 --quiet "

static double value_of( const json_t* json, const char* key ) { return json_number_value( json_object_get( json, key ) ); }

static const json_t* frame_of( const json_t* json, size_t i ) { return json_array_get( json_object_get( json, "frames" ), i ); }

// Seeds and not only one, each frame of them, against the truth.
TEST( test_the_error_is_reached )
{
    const double wanted = 0.03;
    cli_expect( cli_run( "$R render $VASE -o ref.####.exr --frames 5,30 --spp 150 --seed 99 --float " LARGER ), 0, NULL );
    int above = 0, all = 0;
    double native = 0.0;
    for ( int seed = 1; seed <= 8; ++seed )
    {
        cli_expect(
            cli_run( "$R render $VASE -o n.####.exr --overwrite --frames 5,30 --noise %g --seed %d --float --json n.json " LARGER,
                     wanted, seed ),
            0, NULL );
        cli_expect( cli_run( "$R compare n.####.exr ref.####.exr --json c.json" ), 0, NULL );
        json_t *json = cli_read_json( "n.json" ), *error = cli_read_json( "c.json" );
        assert_int_equal( value_of( json_object_get( json, "noise" ), "missed" ), 0 );
        for ( size_t i = 0; i < 2; ++i )
        {
            assert_true( json_is_true( json_object_get( frame_of( json, i ), "reached" ) ) );
            assert_true( value_of( frame_of( json, i ), "relmse_estimate" ) <= wanted );
            above += value_of( frame_of( error, i ), "relmse" ) > 1.2 * wanted;
            native += value_of( frame_of( json, i ), "native_spp" );
            ++all;
        }
        json_decref( json );
        json_decref( error );
    }
    printf( "%d of %d frames above 1.2 of what was wanted, %.1f samples\n", above, all, native / all );
    assert_true( above <= all / 10 );
    assert_true( native / all < 25.0 ); // about twice what it takes
}

TEST( test_less_noise_takes_more )
{
    static const char* const errors[] = { "0.1", "0.03", "0.01" };
    double before = 0.0;
    for ( int i = 0; i < 3; ++i )
    {
        cli_expect(
            cli_run( "$R render $VASE -o l.####.exr --overwrite --frames 3-5 --noise %s --filter box --json l.json " SMALL,
                     errors[i] ),
            0, NULL );
        json_t* json = cli_read_json( "l.json" );
        double native = value_of( frame_of( json, 1 ), "native_spp" );
        assert_true( native >= 2.0 && native > before );
        before = native;
        json_decref( json );
    }
}

TEST( test_threads_change_nothing )
{
    cli_expect( cli_run( "for t in 1 2 5; do $R render $VASE -o t$t.####.exr --frames 1-4 --noise 0.04 --threads $t " SMALL
                         " || exit 1; done; for f in t2.* t5.*; do cmp $f t1.${f#t?.} || exit 1; done" ),
                0, NULL );
}

TEST( test_what_is_not_reached_is_reported )
{
    const CliResult* result = cli_run( "$R render $VASE -o m.####.exr --frames 1-4 --noise 1e-6 --spp 9 --json m.json " SMALL );
    cli_expect( result, 0, "--noise: 0.058 % (relMSE 1e-06) not reached in 4 of 4 frames" );
    json_t* json = cli_read_json( "m.json" );
    assert_int_equal( value_of( json_object_get( json, "noise" ), "missed" ), 4 );
    assert_true( json_is_false( json_object_get( frame_of( json, 0 ), "reached" ) ) );
    for ( size_t i = 0; i < 4; ++i )
        assert_true( value_of( frame_of( json, i ), "native_spp" ) >= 8.0 &&
                     value_of( frame_of( json, i ), "native_spp" ) <= 15.0 );
    json_decref( json );
}

// How much of it is used is a matter of the machine: tests/render/test_stop_rule.c has a clock of its own.
TEST( test_time_is_taken )
{
    cli_expect( cli_run( "$R render $VASE -o s.####.exr --frames 1-6 --time 0.4 --json s.json " SMALL ), 0, NULL );
    json_t* json = cli_read_json( "s.json" );
    assert_true( json_is_boolean( json_object_get( json_object_get( json, "time" ), "too_short" ) ) );
    assert_true( value_of( frame_of( json, 3 ), "native_spp" ) >= 2.0 );
    json_decref( json );
}

TEST( test_too_short_a_time_is_reported )
{
    cli_expect( cli_run( "$R render $VASE -o z.####.exr --frames 1-4 --time 1e-7 --json z.json " SMALL ), 0,
                "--time 1e-07: too short" );
    json_t* json = cli_read_json( "z.json" );
    assert_true( json_is_true( json_object_get( json_object_get( json, "time" ), "too_short" ) ) );
    for ( size_t i = 0; i < 4; ++i )
    {
        assert_true( value_of( frame_of( json, i ), "native_spp" ) >= 2.0 );
        assert_true( isfinite( value_of( frame_of( json, i ), "relmse_estimate" ) ) );
    }
    json_decref( json );
}

// Whichever comes first.
TEST( test_whichever_comes_first_stops )
{
    cli_expect( cli_run( "$R render $VASE -o b.####.exr --frames 1-4 --noise 0.1 --time 1000 --json b.json " SMALL ), 0, NULL );
    json_t* json = cli_read_json( "b.json" );
    assert_int_equal( value_of( json_object_get( json, "noise" ), "missed" ), 0 );
    json_decref( json );
    cli_expect( cli_run( "$R render $VASE -o b.####.exr --overwrite --frames 1-4 --noise 1e-7 --time 1 " SMALL ), 0,
                "not reached in 4" );
}

TEST( test_resume_keeps_frames_that_reached_it )
{
    cli_expect(
        cli_run( "$R render $VASE -o r.####.exr --frames 1-4 --noise 0.05 " SMALL " && cp r.0003.exr kept.exr && rm r.0002.exr" ),
        0, NULL );
    cli_expect( cli_run( "$R render $VASE -o r.####.exr --frames 1-4 --noise 0.05 --resume --json r.json " SMALL
                         " && cmp r.0003.exr kept.exr" ),
                0, NULL );
    json_t* json = cli_read_json( "r.json" );
    assert_int_equal( json_array_size( json_object_get( json, "frames" ) ), 4 );
    for ( size_t i = 0; i < 4; ++i )
    {
        assert_true( value_of( frame_of( json, i ), "relmse_estimate" ) <= 0.05 );
        assert_true( json_is_true( json_object_get( frame_of( json, i ), "reached" ) ) );
        assert_int_equal( json_is_true( json_object_get( frame_of( json, i ), "kept" ) ), i != 1 );
    }
    json_decref( json );
    cli_expect( cli_run( "$R render $VASE -o r.####.exr --frames 1-5 --noise 0.04 --resume " SMALL ), 1,
                "of another render, of --noise 0.05" );
    cli_expect( cli_run( "$R render $VASE -o r.####.exr --frames 1-5 --noise 0.05 --time 9 --resume " SMALL ), 1, "--resume: " );
    cli_expect( cli_run( "$R render $VASE -o r.####.exr --frames 1-5 --resume " SMALL ), 1, "--resume: " );
}

TEST( test_header_and_json_agree )
{
    cli_expect( cli_run( "$R render $VASE -o h.####.exr --frames 2,3 --noise 0.05 --json h.json " SMALL ), 0, NULL );
    json_t* json = cli_read_json( "h.json" );
    static const char* const keys[][2] = { { "reframe/relmse-estimate", "relmse_estimate" },
                                           { "reframe/relmse-likely", "relmse_likely" },
                                           { "reframe/worst-ten-share", "worst_ten_share" },
                                           { "reframe/native-spp", "native_spp" },
                                           { "reframe/effective-spp", "effective_spp" } };
    char path[512], value[64];
    snprintf( path, sizeof path, "%s/h.0003.exr", cli_folder() );
    RfError error;
    for ( size_t i = 0; i < sizeof keys / sizeof keys[0]; ++i )
    {
        assert_int_equal( rf_read_exr_string( path, keys[i][0], value, sizeof value, &error ), RF_OK );
        double wanted = value_of( frame_of( json, 1 ), keys[i][1] );
        assert_true( fabs( strtod( value, NULL ) - wanted ) <= 1e-5 * wanted );
    }
    assert_int_equal( rf_read_exr_string( path, "reframe/noise", value, sizeof value, &error ), RF_OK );
    assert_string_equal( value, "0.05" );
    json_decref( json );
}

TEST( test_wrong_values_are_refused )
{
    static const char* const wrong[][2] = {
        { "--noise -1", "--noise: expected" },
        { "--noise low", "--noise: expected" },
        { "--noise nan", "--noise: expected" },
        { "--noise 1e9", "--noise: expected" },
        { "--time -2", "--time: expected" },
        { "--time inf", "--time: expected" },
        { "--time", "--time" },
        { "--no-time", "--no-time" },
    };
    for ( size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i )
        cli_expect( cli_run( "$R render $VASE -o e.exr %s", wrong[i][0] ), 2, wrong[i][1] );
}

// 0 is what it is without; a scene file's samples are no bound, the command line's are.
TEST( test_defaults_of_a_scene_file )
{
    static const char scene[] = "{\"scene\":\"room.glb\",\"render\":{\"noise\":\"6.3%\",\"spp\":3}}";
    cli_expect( cli_run( "ln -sf $VASE room.glb" ), 0, NULL );
    cli_write( "scene.json", scene, sizeof scene - 1 );
    cli_expect( cli_run( "$R render scene.json -o d.exr --frames 5 --json d.json " SMALL ), 0, NULL );
    json_t* json = cli_read_json( "d.json" );
    assert_true( fabs( value_of( json_object_get( json, "noise" ), "wanted" ) - 3.0 * 0.063 * 0.063 ) < 1e-15 );
    assert_true( value_of( frame_of( json, 0 ), "native_spp" ) > 3.0 );
    assert_true( value_of( frame_of( json, 0 ), "relmse_estimate" ) <= 0.012 );
    json_decref( json );
    cli_expect( cli_run( "$R render scene.json -o d.exr --overwrite --spp 3 --frames 5 " SMALL ), 0, "not reached in 1 of 1" );
    cli_expect( cli_run( "$R render scene.json -o d.exr --overwrite --noise 0 --frames 5 " SMALL
                         " && $R render $VASE -o e.exr --spp 3 --frames 5 " SMALL " && $R compare d.exr e.exr --json d.json" ),
                0, NULL );
    json = cli_read_json( "d.json" );
    assert_true( value_of( json, "relmse" ) == 0.0 );
    json_decref( json );
}

// Ways of rendering that have their own films, passes or sums.
TEST( test_every_way_of_rendering_reaches_it )
{
    static const char* const kinds[] = { "--group 0 --tile 1",
                                         "--group 40",
                                         "--tile rooks4",
                                         "--weights eq15",
                                         "--normalize ratio",
                                         "--normalize none",
                                         "--aov variance,samples,depth,motion",
                                         "--memory 2600K --threads 1 --group 4 --no-adaptive" };
    for ( size_t i = 0; i < sizeof kinds / sizeof kinds[0]; ++i )
    {
        cli_expect(
            cli_run(
                "$R render $VASE -o k.####.exr --overwrite --frames 10-14x2 --noise 0.1 --size 40x24 --quiet --json k.json %s",
                kinds[i] ),
            0, NULL );
        json_t* json = cli_read_json( "k.json" );
        assert_int_equal( value_of( json_object_get( json, "noise" ), "missed" ), 0 );
        for ( size_t k = 0; k < 3; ++k )
            assert_true( value_of( frame_of( json, k ), "relmse_estimate" ) <= 0.1 );
        json_decref( json );
    }
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
