// The script in src/cli/denoising.md: Blender's Denoise node gets frames with albedo and normal, and each of them comes out under its
// number, as it was where Blender is built without Open Image Denoise. Skipped where Blender is missing.
#include "support/blender_run.h"
#include "support/test.h"

#define PAGE REFRAME_SOURCE_DIR "/src/cli/denoising.md"

// relMSE of a frame that Blender wrote against one that it read.
static double difference( const char* written, const char* read )
{
    const CliResult* done = cli_run( "$R compare out/clean-%s.exr out/shot.%s.exr --json -", written, read );
    cli_expect( done, 0, NULL );
    const char* relmse = strstr( done->out, "\"relmse\": " );
    assert_non_null( relmse );
    return strtod( relmse + strlen( "\"relmse\": " ), NULL );
}

TEST( test_frames_pass_the_node )
{
    cli_expect(
        cli_run( "$R render $VASE -o out/shot.####.exr --frames 3-12 --size 48x27 --spp 16 --group 0 --filter box --quiet "
                 "--aov denoise_albedo,denoise_normal --names blender" ),
        0, NULL );
    cli_expect( cli_run( "sed -n '/^    import bpy/,/^    bpy.ops.render/s/^    //p' " PAGE " > script" ), 0, NULL );
    const CliResult* done =
        cli_run( BLENDER "--factory-startup --python-exit-code 9 -P script -- 3 12 out/shot.0003.exr $PWD/out/clean- 2>&1" );
    if ( done->status != 0 )
        fail_msg( "%s", done->out );
    assert_true( difference( "0003", "0003" ) < 0.1 && difference( "0012", "0012" ) < 0.1 );
    assert_true( difference( "0003", "0012" ) > 2.0 * difference( "0003", "0003" ) );
}

int main( void )
{
    if ( !enter_with_blender() )
        return 0;
    int failed = run_listed_tests();
    cli_leave();
    return failed;
}
