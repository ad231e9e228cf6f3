// The scenes made by the scripts in scenes/ load without a warning, and their first and
// last frames are neither NaN nor black.
#include "support/cli_run.h"
#include "support/test.h"

static const char* const s_scenes[] = {
    "vase-room.glb", "bounced-room.glb",        "bounced-room-spots.glb", "still-life.glb",    "glass-lamp.glb",
    "sun-pane.glb",  "still-life-no-glass.glb", "turntable.json",         "textured-room.glb", "office-floor.glb",
};

TEST( test_every_scene_renders_without_a_warning )
{
    for ( size_t i = 0; i < sizeof s_scenes / sizeof s_scenes[0]; ++i )
    {
        for ( int frame = 1; frame <= 48; frame += 47 )
        {
            const CliResult* result =
                cli_run( "$R render '" REFRAME_SCENE_FOLDER "/%s' -o t.exr --frames %d --size 32x18 --spp 4 "
                         "--group 0 --overwrite --quiet",
                         s_scenes[i], frame );
            cli_expect( result, 0, NULL );
            // what the reader leaves out and black frames would be reported here
            if ( strstr( result->err, "warning" ) != NULL )
                fail_msg( "%s: %s", s_scenes[i], result->err );
            cli_expect( cli_run( "$R compare t.exr t.exr" ), 0, NULL ); // fails for NaN and infinity
        }
    }
}

// Without a bounce nothing is lit of what the camera sees.
TEST( test_bounced_room_is_dark_without_a_bounce )
{
    for ( int frame = 1; frame <= 48; frame += 47 )
    {
        const CliResult* result = cli_run( "$R render '" REFRAME_SCENE_FOLDER "/bounced-room.glb' -o t.exr --frames %d "
                                           "--size 64x36 --spp 4 --max-depth 2 --group 0 --overwrite --quiet",
                                           frame );
        assert_true( result->status == 0 && strstr( result->err, "is black" ) != NULL );
    }
}

TEST( test_a_million_triangles_load )
{
    const CliResult* result = cli_run( "$R info '" REFRAME_SCENE_FOLDER "/many.glb'" );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->out, "triangles  1000004\n" ) );
    assert_non_null( strstr( result->out, "instances  50002\n" ) );
}

#define MEADOW_MEGABYTES 300

// 200 million triangles, of which 20,000 are in memory.
TEST( test_a_meadow_of_instances_fits_in_memory )
{
    const CliResult* result = cli_run( "$R info '" REFRAME_SCENE_FOLDER "/meadow.glb'" );
    cli_expect( result, 0, NULL );
    long all = 0, stored = 0;
    const char* line = strstr( result->out, "triangles  " );
    assert_true( line != NULL && sscanf( line, "triangles  %ld (%ld in memory: instances share them)", &all, &stored ) == 2 );
    assert_true( all > 190000000 && stored < 21000 );
    result = cli_run( "python3 -c 'import resource, subprocess, sys; subprocess.check_call(sys.argv[1:]); "
                      "print(\"resident\", resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss // 1024)' "
                      "$R render '" REFRAME_SCENE_FOLDER "/meadow.glb' -o t.exr --frames 24 --size 64x36 --spp 4 --group 0 "
                      "--memory 64M --overwrite --quiet" );
    cli_expect( result, 0, NULL );
#ifndef REFRAME_SANITIZED
    long resident = 0;
    line = strstr( result->out, "resident" );
    assert_true( line != NULL && sscanf( line, "resident %ld", &resident ) == 1 );
    if ( !( resident < MEADOW_MEGABYTES ) )
        fail_msg( "the meadow took %ld MB, it may take %d", resident, MEADOW_MEGABYTES );
#endif
}

TEST( test_office_floor_renders )
{
    const CliResult* result = cli_run( "$R info '" REFRAME_SCENE_FOLDER "/office-floor.glb'" );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->out, "triangles  313632\n" ) );
    assert_non_null( strstr( result->out, "emissive triangles 4900," ) ); // 2450 panes
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
