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

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_help_is_a_command ),
        cmocka_unit_test( test_words_of_other_programs ),
        cmocka_unit_test( test_units_and_patterns ),
    };
    return cmocka_run_group_tests( tests, cli_enter_group, cli_leave_group );
}
