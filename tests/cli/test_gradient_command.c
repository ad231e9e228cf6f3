// render --estimator gradient: what it refuses, it refuses by name; frames are the same bits alone, in a sequence, with any
// threads and memory; --resume knows them; the header tells them apart.
#include "support/cli_run.h"
#include "support/test.h"

#define RENDER "$R render $VASE --estimator gradient --size 40x30 --spp 4 --quiet --overwrite "

TEST( test_what_does_not_work_is_refused_by_name )
{
    static const struct
    {
        const char *options, *answer;
    } s_cases[] = {
        { "--group 1", "the estimator 'gradient' reuses no frames, where gradients seldom pay: group 0, not 1" },
        { "--tile rooks16", "the estimator 'gradient' needs tiles of 1 pixel, or blocks of 2x2 to 8x8" },
        { "--tile 1x4", "the estimator 'gradient' needs tiles of 1 pixel" },
        { "--tile 16x4", "the estimator 'gradient' needs tiles of 1 pixel" },
        { "--adaptive", "the estimator 'gradient' has no adaptive sampling" },
        { "--weights eq15", "the estimator 'gradient' has exact weights only" },
        { "--normalize ratio", "the estimator 'gradient' has no normalisation to choose" },
    };
    for ( size_t i = 0; i < sizeof s_cases / sizeof s_cases[0]; ++i )
        cli_expect( cli_run( RENDER "-o a.####.exr --frames 1 %s", s_cases[i].options ), 2, s_cases[i].answer );
    cli_expect( cli_run( "$R render $VASE -o a.####.exr --estimator gradients" ), 2,
                "reframe render: --estimator: expected reuse or gradient, got 'gradients'" );
    cli_expect( cli_run( "$R render $VASE -o a.####.exr --reconstruction l2" ), 2,
                "reframe render: --reconstruction: needs --estimator gradient" );
}

#define AOVS "--aov albedo,normal,depth,motion "

TEST( test_bias_and_few_samples_are_said )
{
    const char* render = "$R render $VASE --estimator gradient --size 24x16 --frames 1 --overwrite -o said.####.exr --quiet ";
    const CliResult* done = cli_run( "%s --spp 4 --reconstruction l1", render );
    assert_true( done->status == 0 && strstr( done->err, "l1: is biased" ) != NULL );
    done = cli_run( "%s --spp 3", render );
    assert_true( done->status == 0 && strstr( done->err, "is l2 with less than 4 samples" ) != NULL );
    done = cli_run( "%s --spp 4", render );
    assert_true( done->status == 0 && strstr( done->err, "reconstruction" ) == NULL );
}

TEST( test_bits_do_not_depend_on_company )
{
    cli_expect( cli_run( RENDER AOVS "-o all.####.exr --frames 1-3 --threads 1" ), 0, NULL );
    cli_expect( cli_run( RENDER AOVS "-o one.####.exr --frames 2 --threads 3 --memory 24M" ), 0, NULL );
    cli_expect( cli_run( "cmp all.0002.exr one.0002.exr" ), 0, NULL );
    cli_expect( cli_run( RENDER AOVS "-o soft.####.exr --frames 1-2 --filter tent" ), 0, NULL );
    cli_expect( cli_run( RENDER AOVS "-o soft3.####.exr --frames 2 --filter tent --threads 3" ), 0, NULL );
    cli_expect( cli_run( "cmp soft.0002.exr soft3.0002.exr" ), 0, NULL );
    cli_expect( cli_run( RENDER AOVS "-o pairs.####.exr --frames 2 --tile 1" ), 0, NULL );
    cli_expect( cli_run( RENDER AOVS "-o pairs3.####.exr --frames 2-3 --tile 1 --threads 3" ), 0, NULL );
    cli_expect( cli_run( "cmp pairs.0002.exr pairs3.0002.exr" ), 0, NULL );
}

TEST( test_frames_are_resumed_and_told_apart )
{
    cli_expect( cli_run( RENDER "-o r.####.exr --frames 1" ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE --estimator gradient --size 40x30 --spp 4 --quiet -o r.####.exr --frames 1-2 --resume "
                         "--json r.json" ),
                0, NULL );
    json_auto_t* json = cli_read_json( "r.json" );
    const json_t* frames = json_object_get( json, "frames" );
    assert_true( json_is_true( json_object_get( json_array_get( frames, 0 ), "kept" ) ) );
    assert_true( json_is_false( json_object_get( json_array_get( frames, 1 ), "kept" ) ) );
    assert_string_equal( json_string_value( json_object_get( json, "estimator" ) ), "gradient" );
    assert_string_equal( json_string_value( json_object_get( json, "reconstruction" ) ), "weighted" );
    static const char again[] =
        "$R render $VASE --size 40x30 --spp 4 --quiet -o r.####.exr --frames 1 --resume --group 0 --tile 6x6 ";
    cli_expect( cli_run( "%s", again ), 1, "estimator gradient" );
    cli_expect( cli_run( "%s --estimator gradient --reconstruction l2", again ), 1, "reconstruction weighted" );
}

TEST( test_noise_is_estimated_and_stops )
{
    cli_expect( cli_run( "$R render $VASE --estimator gradient --size 40x30 --noise 0.05 --quiet -o n.####.exr --frames 1 "
                         "--aov albedo,samples --json n.json" ),
                0, NULL );
    json_auto_t* json = cli_read_json( "n.json" );
    const json_t* frame = json_array_get( json_object_get( json, "frames" ), 0 );
    assert_true( json_number_value( json_object_get( frame, "relmse_estimate" ) ) <= 0.05 );
    assert_true( json_number_value( json_object_get( frame, "native_spp" ) ) >= 2.0 );
}

// Another program can solve what is written: at constant weights the picture is the same.
TEST( test_written_gradients_are_reconstructed )
{
    cli_expect( cli_run( RENDER "-o g.####.exr --frames 1 --float --reconstruction l2 --aov gradients" ), 0, NULL );
    cli_expect( cli_run( "$R reconstruct g.0001.exr -o solved.exr --method l2 --alpha 0.5 --quiet" ), 0, NULL );
    cli_expect( cli_run( "$R compare g.0001.exr solved.exr --json c.json > /dev/null" ), 0, NULL );
    json_auto_t* json = cli_read_json( "c.json" );
    assert_true( json_number_value( json_object_get( json, "relmse" ) ) < 1e-6 );
    cli_expect( cli_run( "$R render $VASE -o a.####.exr --size 40x30 --frames 1 --aov primal,dx" ), 2,
                "the estimator 'reuse' has no gradients: choose another by --estimator, or leave that option out" );
    cli_expect( cli_run( RENDER "-o a.####.exr --frames 1 --aov dx,gradients" ), 2, "AOV dx is given twice" );
    cli_expect( cli_run( RENDER "-o a.####.exr --frames 1 --aov gradient" ), 2, "did you mean gradients?" );
}

// Extra samples are left out where they are not asked for, without a word.
TEST( test_adaptive_auto_is_off )
{
    const CliResult* done = cli_run( RENDER "-o a.####.exr --frames 1 --adaptive auto --json a.json" );
    assert_int_equal( done->status, 0 );
    assert_string_equal( done->err, "" );
    json_auto_t* json = cli_read_json( "a.json" );
    assert_int_equal( json_array_size( json_object_get( json, "warnings" ) ), 0 );
}

// What render can do, cost and tune can weigh: the tiles beside path tracing, which is that of the other estimator.
TEST( test_it_is_planned_and_tuned )
{
    static const char shot[] = "$VASE --estimator gradient --size 48x36 --frames 1-2 --quiet --threads 2";
    const CliResult* done = cli_run( "$R tune %s --budget 0 --json p.json", shot );
    assert_true( done->status == 0 && strstr( done->out, "--estimator gradient: 4x4 tiles" ) != NULL );
    json_t* json = cli_read_json( "p.json" );
    assert_true( json_array_size( json_object_get( json, "groups" ) ) == 1 );
    assert_string_equal( json_string_value( json_object_get( json, "why" ) ), "the estimator 'gradient' reuses no frames" );
    json_decref( json );
    char cost[256];
    snprintf( cost, sizeof cost, "$R cost %s --tile 4x4 --json c.json", shot );
    done = cli_measure( cost, 4 );
    assert_true( done->status == 0 && strstr( done->out, "4x4 tiles" ) != NULL );
    json = cli_read_json( "c.json" );
    assert_true( json_number_value( json_object_get( json, "pixels" ) ) > 1000.0 );
    json_decref( json );
    for ( int budget = 6; budget < 10000; budget *= 4 ) // a busy machine needs more for the first round
    {
        done = cli_run( "$R tune %s --budget %d --spp 4", shot, budget );
        if ( done->status != 0 || strstr( done->out, "reframe render" ) != NULL )
            break;
    }
    assert_true( done->status == 0 && strstr( done->out, " 4x4 " ) != NULL );
    const char* command = strstr( done->out, "reframe render" );
    assert_non_null( command );
    bool plain = strstr( command, "--tile 1 " ) != NULL;
    assert_non_null( strstr( command, plain ? "--estimator reuse" : "--estimator gradient" ) );
    const char* named = strstr( command, "--estimator" );
    assert_null( strstr( named + 1, "--estimator" ) ); // once
}

TEST( test_variance_and_alpha_are_written )
{
    cli_expect( cli_run( RENDER "-o va.####.exr --frames 1 --alpha --aov variance --json va.json" ), 0, NULL );
    cli_expect( cli_run( "$R png va.0001.exr va.png" ), 0, NULL );
    json_auto_t* json = cli_read_json( "va.json" );
    const json_t* paths = json_object_get( json, "shared_paths" );
    json_int_t found = json_integer_value( json_object_get( paths, "found" ) );
    json_int_t kept = json_integer_value( json_object_get( paths, "kept" ) );
    assert_true( kept > 0 && kept < found );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
