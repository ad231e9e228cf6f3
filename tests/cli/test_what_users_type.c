// What users type out of habit is understood, or answered with what to type.
#include "support/cli_run.h"

#include <setjmp.h>
#include <stdarg.h>
#include <string.h>

#include <cmocka.h>

#define TINY " --size 16x9 --spp 2 --group 0 --quiet "

static void test_help_is_a_command( void** state )
{
    (void)state;
    const CliResult* result = cli_run( "$R help" );
    cli_expect( result, 0, NULL );
    assert_int_equal( strncmp( result->out, "usage: reframe COMMAND", 22 ), 0 );
    result = cli_run( "$R help plan" );
    cli_expect( result, 0, NULL );
    assert_int_equal( strncmp( result->out, "usage: reframe plan [OPTIONS] SCENE", 35 ), 0 );
    cli_expect( cli_run( "$R help rendr" ), 2, "reframe: 'rendr': no such command, did you mean render?" );
    cli_expect( cli_run( "$R diff a b" ), 2, "reframe: 'diff': no such command, did you mean compare?" );
    cli_expect( cli_run( "$R version" ), 2, "reframe: 'version': no such command, did you mean --version?" );
}

static void test_words_of_other_programs( void** state )
{
    (void)state;
    cli_expect( cli_run( "$R render $VASE -o a.exr --samples 64" ), 2, "--samples: no such option, did you mean --spp?" );
    cli_expect( cli_run( "$R render $VASE -o a.exr --resolution 64x48" ), 2,
                "--resolution: no such option, did you mean --size?" );
    cli_expect( cli_run( "$R tune $VASE --time 20s" ), 2, "--time: no such option, did you mean --budget?" );
}

// Units reach the render, and numbered names may be written as printf has them.
static void test_units_and_patterns( void** state )
{
    (void)state;
    cli_expect( cli_run( "$R plan $VASE --size 360p --noise 1%% --time 1m1s --frames 1 --json plan.json > table" ), 0, NULL );
    cli_expect( cli_run( "$R render $VASE -o p/f.%%04d.exr --frames 9-10" TINY ), 0, NULL );
    assert_true( cli_exists( "p/f.0009.exr" ) && cli_exists( "p/f.0010.exr" ) );
    cli_expect( cli_run( "$R render $VASE -o p/f.%%04d.exr --frames 9-10 --noise 300%% --time 30s --size 16x9 --overwrite "
                         "--quiet --json r.json" ),
                0, NULL );
    json_t* json = cli_read_json( "r.json" );
    assert_true( json_number_value( json_object_get( json_object_get( json, "noise" ), "wanted" ) ) == 3.0 );
    assert_true( json_number_value( json_object_get( json_object_get( json, "time" ), "wanted" ) ) == 30.0 );
    json_decref( json );
    cli_expect( cli_run( "$R compare p/f.%%04d.exr p/f.####.exr --quiet > table" ), 0, NULL );
    cli_expect( cli_run( "$R cost $VASE --noise 5%%,x" ), 2, "--noise: wants numbers above 0" );
}

// Blender's own files, compressed as Blender 3 or older ones do, or not.
static void test_blend_files_are_recognised( void** state )
{
    (void)state;
    static const char advice[] = "export it by blender -b a.blend -P scripts/blender-export.py -- scene.glb\n";
    static const struct
    {
        const char *bytes, *said;
    } cases[] = {
        { "BLENDER-v304RENDH", "a.blend: is a Blender file: " },
        { "\x28\xb5\x2f\xfd\x60\x10", "a.blend: is a Blender file, compressed by zstd: " },
        { "\x1f\x8b\x08", "a.blend: is a Blender file, compressed by gzip: " },
    };
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        cli_write( "a.blend", cases[i].bytes, strlen( cases[i].bytes ) );
        const CliResult* result = cli_run( "$R info a.blend" );
        cli_expect( result, 1, cases[i].said );
        assert_non_null( strstr( result->err, advice ) );
        cli_expect( cli_run( "$R convert a.blend a.glb" ), 1, cases[i].said );
        cli_expect( cli_run( "cp a.blend scene.json; $R render scene.json -o a.exr" ), 1, "scene.json" );
    }
    cli_write( "a.glb", cases[1].bytes, strlen( cases[1].bytes ) );
    cli_expect( cli_run( "$R info a.glb" ), 1, "a.glb: is compressed by zstd: uncompress it first, or if it is a Blender file" );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_help_is_a_command ),
        cmocka_unit_test( test_words_of_other_programs ),
        cmocka_unit_test( test_units_and_patterns ),
        cmocka_unit_test( test_blend_files_are_recognised ),
    };
    return cmocka_run_group_tests( tests, cli_enter_group, cli_leave_group );
}
