// The add-on that scripts/blender/pack makes, installed and used in a Blender without a window; skipped where Blender or its numpy is
// missing.
#include "support/blender_run.h"
#include "support/test.h"

BLENDER_TEST( test_zip_installs_exports_and_renders )
{
    cli_expect( cli_run( "python3 -B " REFRAME_SOURCE_DIR "/scripts/blender/pack --output a.zip && "
                         "python3 -B " REFRAME_SOURCE_DIR "/scripts/blender/pack --output b.zip && cmp a.zip b.zip" ),
                0, NULL );
    // a user's folder of its own
    const CliResult* done = cli_run(
        "mkdir tmp; export TMPDIR=$PWD/tmp BLENDER_USER_RESOURCES=$PWD/user BLENDER_USER_CONFIG=$PWD/user/config "
        "BLENDER_USER_SCRIPTS=$PWD/user/scripts; " BLENDER "--factory-startup --python-exit-code 9 -P " REFRAME_SOURCE_DIR
        "/tests/support/blender_addon.py -- a.zip $R 2>&1" );
    if ( done->status != 0 || strstr( done->out, "the add-on works\n" ) == NULL ||
         strstr( done->out, "arning: warning:" ) != NULL )
        fail_msg( "%s", done->out );
}
