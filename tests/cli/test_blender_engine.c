// The render engine of the add-on, in a Blender without a window (support/blender_engine.py); skipped where Blender or its numpy is missing.
#include "support/blender_run.h"
#include "support/test.h"

BLENDER_TEST( test_engine_renders_in_blender )
{
    cli_expect( cli_run( "python3 -B " REFRAME_SOURCE_DIR "/scripts/blender/pack --output a.zip" ), 0, NULL );
    const CliResult* done = cli_run(
        BLENDER
        "--factory-startup --python-exit-code 9 -P " REFRAME_SOURCE_DIR
        "/tests/support/blender_engine.py -- a.zip $R > log 2>&1; s=$?; grep -v '^Fra\\|^Info' log | tail -n 12; exit $s" );
    if ( done->status != 0 || strstr( done->out, "the engine works\n" ) == NULL )
        fail_msg( "%s", done->out );
}
