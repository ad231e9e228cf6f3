// No command writes over what it reads, nor writes one file twice.
#include "support/cli_run.h"
#include "image/sequence.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

// The line fails as a mistake on the command line that says `part`, and the file stays.
static void check_kept( const char* name, const char* part, const char* line )
{
    size_t before, after;
    char *was = cli_read( name, &before ), *is;
    cli_expect( cli_run( "%s", line ), 2, part );
    is = cli_read( name, &after );
    assert_int_equal( before, after );
    assert_memory_equal( was, is, before );
    free( was );
    free( is );
}

static void test_scene_is_never_overwritten( void** state )
{
    (void)state;
    cli_expect(
        cli_run(
            "cp $VASE room.glb && ln -s room.glb link.json && mkdir -p sub && echo '{\"scene\": \"room.glb\"}' > scene.json" ),
        0, NULL );
    check_kept( "room.glb", "--json: room.glb: ends as a file of another kind",
                "$R render room.glb -o f.exr --frames 1 --json room.glb" );
    check_kept( "room.glb", "--json: link.json: would overwrite what is read", "$R info room.glb --json link.json" );
    check_kept( "room.glb", "--svg: room.glb: ends as", "$R cost room.glb --svg room.glb" );
    check_kept( "scene.json", "--json: ./sub/../scene.json: would overwrite what is read",
                "$R tune scene.json --json ./sub/../scene.json" );
    check_kept( "room.glb", "--json: a.svg: ends as a file of another kind", "$R tune room.glb --svg b.svg --json a.svg" );
    check_kept( "room.glb", "--svg: a: is the file of --json too", "$R cost room.glb --svg a --json ./a" );
    check_kept( "room.glb", "expected a name that ends in .exr", "$R render room.glb --frames 1 -o f.json" );
    cli_expect( cli_run( "echo '{}' > path.json" ), 0, NULL );
    check_kept( "path.json", "--json: path.json: is the file of --camera too",
                "$R info room.glb --json /dev/null && $R tune room.glb --camera path.json --json path.json" );
    assert_false( cli_exists( "a" ) || cli_exists( "b.svg" ) || cli_exists( "f.json" ) );
}

static void test_frames_are_never_overwritten( void** state )
{
    (void)state;
    cli_expect( cli_run( "$R render $VASE -o s.####.exr --frames 1-2 --size 16x9 --spp 2 --group 0 --quiet" ), 0, NULL );
    check_kept( "s.0001.exr", "--png: s.0001.exr: ends as", "$R flicker s.####.exr --png s.0001.exr" );
    check_kept( "s.0001.exr", "--json: s.0001.exr: ends as", "$R compare s.0001.exr s.0002.exr --json s.0001.exr" );
    check_kept( "s.0001.exr", "is what is read", "$R png s.0001.exr ./s.0001.exr" );
    cli_expect( cli_run( "for i in 1 2; do cp s.000$i.exr t.$i; done" ), 0, NULL ); // no ending to go by
    check_kept( "t.1", "--json: t.1: would overwrite what is read", "$R flicker t.# --json t.1" );
    check_kept( "t.1", "--png: t.2: is the file of --reference too", "$R flicker s.####.exr --reference t.# --png t.2" );
    cli_expect( cli_run( "$R compare t.1 t.2 --json t.3 --quiet" ), 0, NULL ); // a name of its own
    assert_true( cli_exists( "t.3" ) );
}

static void test_names_of_the_same_file_are_known( void** state )
{
    (void)state;
    assert_true( rf_may_be_same_file( "a.exr", "a.exr" ) && rf_may_be_same_file( "./a.exr", "a.exr" ) );
    assert_true( rf_may_be_same_file( "a.##.exr", "./a.12.exr" ) && rf_may_be_same_file( "a.123.exr", "a.##.exr" ) );
    assert_false( rf_may_be_same_file( "a.##.exr", "a.1.exr" ) || rf_may_be_same_file( "a.##.exr", "a.0123.exr" ) );
    assert_false( rf_may_be_same_file( "a.exr", "b.exr" ) || rf_may_be_same_file( "/a.exr", "a.exr" ) );
    assert_true( rf_may_be_same_file( "a.##.exr", "./a.##.exr" ) );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_scene_is_never_overwritten ),
        cmocka_unit_test( test_frames_are_never_overwritten ),
        cmocka_unit_test( test_names_of_the_same_file_are_known ),
    };
    return cmocka_run_group_tests_name( "written_files", tests, cli_enter_group, cli_leave_group );
}
