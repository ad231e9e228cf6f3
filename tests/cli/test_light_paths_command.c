// render --light-paths: JSON and header name them, and --resume tells frames apart.
#include "support/cli_run.h"
#include "support/test.h"

#define LAMP "'" REFRAME_SCENE_FOLDER "/glass-lamp.glb' "
#define RENDER "$R render " LAMP "--size 24x16 --spp 2 --group 0 --tile 1 --frames 1 --quiet "

TEST( test_json_names_them )
{
    const CliResult* done = cli_run( RENDER "-o on.####.exr --light-paths on --json on.json" );
    assert_int_equal( done->status, 0 );
    json_auto_t* json = cli_read_json( "on.json" );
    assert_string_equal( json_string_value( json_object_get( json, "light_paths" ) ), "on" );
    assert_string_equal( json_string_value( json_object_get( json, "kernel_normalization" ) ), "exact" );
    cli_expect( cli_run( RENDER "-o off.####.exr --light-paths wherever" ), 2, "--light-paths: expected on or off" );
}

TEST( test_frames_are_told_apart )
{
    cli_expect( cli_run( RENDER "-o apart.####.exr --light-paths on --overwrite" ), 0, NULL );
    cli_expect( cli_run( RENDER "-o apart.####.exr --light-paths on --resume" ), 0, NULL );
    cli_expect( cli_run( RENDER "-o apart.####.exr --resume" ), 1, "light-paths on" );
    cli_expect( cli_run( RENDER "-o apart.####.exr --light-paths on --kernel-normalization disc --resume" ), 1,
                "kernel-normalization exact" );
}

TEST( test_what_cannot_be_done_is_reported )
{
    const CliResult* done = cli_run( "$R render '" REFRAME_SCENE_FOLDER
                                     "/vase-room.glb' --size 24x16 --spp 2 --group 0 --tile 1 --frames 1 -o none.####.exr "
                                     "--light-paths on --quiet" );
    assert_int_equal( done->status, 0 );
    assert_non_null( strstr( done->err, "--light-paths on: there are none: no perfect mirror" ) );
    done =
        cli_run( "$R render " LAMP "--size 24x16 --spp 2 --frames 1 -o gradient.####.exr --estimator gradient --light-paths on" );
    assert_int_equal( done->status, 0 );
    assert_non_null( strstr( done->err, "--light-paths on: there are none: the estimator does not support them" ) );
    done = cli_run( RENDER "-o disc.####.exr --light-paths on --kernel-normalization disc" );
    assert_int_equal( done->status, 0 );
    assert_non_null( strstr( done->err, "--kernel-normalization disc: is biased" ) );
    done = cli_run( RENDER "-o exact.####.exr --light-paths on" );
    assert_int_equal( done->status, 0 );
    assert_null( strstr( done->err, "light-paths" ) );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
