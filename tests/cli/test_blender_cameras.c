// Cameras out of Blender see what Cycles sees: with depth of field, orthographic and panoramic. The mean of the picture is
// that of Cycles within 1 %, and so, within their noise, are the means of its parts. Skipped where Blender is missing.
#include "support/blender_run.h"

static void render_camera( const char* name )
{
    const CliResult* done = cli_run( BLENDER "cameras.blend -P " BLENDER_SCRIPT "%s.glb --camera %s > log", name, name );
    assert_int_equal( done->status, 0 );
    expect_said( done->err, "warning: the film's exposure of 2 is taken as one of the view" );
    expect_said( done->err, "warning: the compositor's nodes are left out" );
    expect_said( done->err, "warning: stereoscopy is left out" );
    assert_null( strstr( done->err, "the shutter's curve" ) );
    cli_expect(
        cli_run( "$R render %s.glb -o %s-ours.exr --spp 128 --tile 3x3 --no-adaptive --max-depth 4 --float > log", name, name ),
        0, NULL );
}

BLENDER_TEST( test_cameras_see_what_cycles_sees )
{
    blender_make( "cameras" );
    static const char* const s_names[] = { "Lens", "Flat", "Round" };
    for ( int i = 0; i < 3; ++i )
    {
        char ours[32], cycles[32];
        snprintf( ours, sizeof ours, "%s-ours.exr", s_names[i] );
        snprintf( cycles, sizeof cycles, "%s.exr", s_names[i] );
        render_camera( s_names[i] );
        Difference d = picture_difference( ours, cycles, 8, 6 );
        assert_true( fabs( d.mean ) < 0.01 );
        assert_true( d.blocks < 0.012 );
        assert_true( d.pixels < 0.045 );
    }
    // the picture without the lens is another
    assert_true( picture_difference( "Lens-ours.exr", "Sharp.exr", 8, 6 ).pixels > 0.055 );
}
