// What moves, appears and disappears in Blender does so in the .glb of scripts/blender/export.py, frame by frame: small scenes
// (support/blender_movement.py) are exported, and support/blender_compare.py compares every object and instance with Blender's.
// Skipped where Blender or its numpy is missing.
#include "support/blender_run.h"

static void export_scene( const char* name, const char* options )
{
    blender_make( "movement --samples 64 %s", name );
    assert_null( strstr( blender_exported( name, options )->err, "blender-export: loss" ) );
}

// Every frame that was exported has what Blender shows in it.
static void expect_movement( const char* name, const char* options, int step, int things )
{
    export_scene( name, options );
    const CliResult* done =
        cli_run( BLENDER "%s.blend --python-exit-code 9 -P " REFRAME_SOURCE_DIR "/tests/support/blender_compare.py -- %s.glb %d",
                 name, name, step );
    assert_int_equal( done->status, 0 );
    char text[64];
    snprintf( text, sizeof text, "compared %d things", things );
    if ( strstr( done->out, "things differ" ) != NULL || strstr( done->out, text ) == NULL )
        fail_msg( "%s: wanted '%s':\n%s", name, text, done->out );
}

BLENDER_TEST( test_what_moves_rigidly ) { expect_movement( "rigid", "", 1, 199 ); }

BLENDER_TEST( test_particles_instances_and_physics ) { expect_movement( "many", "", 1, 580 ); }

// Simulations go through the frames that are left out.
BLENDER_TEST( test_steps ) { expect_movement( "many", "--frames 1-12x4", 4, 145 ); }

static double difference_of( const char* a, const char* b ) { return picture_difference( a, b, 1, 1 ).pixels; }

// What turns, goes and appears, blurred as in Cycles.
BLENDER_TEST( test_blurred_frames_are_those_of_cycles )
{
    export_scene( "film", "" );
    cli_expect( cli_run( "$R render film.glb -o f.####.exr --frames 4,5 --group 0 --tile 1 --spp 64 --filter box --quiet" ), 0,
                NULL );
    double before = difference_of( "f.0004.exr", "film-4.exr" ), after = difference_of( "f.0005.exr", "film-5.exr" );
    print_message( "difference %.4f and %.4f\n", before, after );
    assert_true( before < 0.06 && after < 0.06 );
    assert_true( difference_of( "f.0004.exr", "film-5.exr" ) > 0.2 ); // what appears is seen
}

// A marker changes the camera in frame 4: with the shutter open for all of a frame, frames 3 and 4 are those of each camera alone.
BLENDER_TEST( test_cuts_are_not_blurred )
{
    export_scene( "edit", "" );
    static const char* const s_cameras[] = { "Eye", "Side" };
#define RENDER_EDIT "$R render %s.glb -o %s.####.exr --frames %s --size 32x24 --spp 64 --tile 1 --quiet"
    cli_expect( cli_run( RENDER_EDIT " --group 0", "edit", "edit", "3,4" ), 0, NULL );
    for ( int i = 0; i < 2; ++i )
    {
        const char* name = s_cameras[i];
        assert_int_equal( cli_run( BLENDER "edit.blend -P " BLENDER_SCRIPT "%s.glb --camera %s > log", name, name )->status, 0 );
        cli_expect( cli_run( RENDER_EDIT " --group 0", name, name, "3,4" ), 0, NULL );
    }
    print_message( "difference %g and %g\n", difference_of( "edit.0003.exr", "Eye.0003.exr" ),
                   difference_of( "edit.0004.exr", "Side.0004.exr" ) );
    assert_true( difference_of( "edit.0003.exr", "Eye.0003.exr" ) < 0.01 );
    assert_true( difference_of( "edit.0004.exr", "Side.0004.exr" ) < 0.05 ); // other random numbers
    assert_true( difference_of( "edit.0004.exr", "Eye.0004.exr" ) > 0.1 );
    // groups do not go across
    cli_expect( cli_run( RENDER_EDIT, "edit", "all", "1-6" ), 0, NULL );
    cli_expect( cli_run( RENDER_EDIT, "edit", "last", "4-6" ), 0, NULL );
    assert_int_equal( cli_run( "cmp all.0004.exr last.0004.exr" )->status, 0 );
}
