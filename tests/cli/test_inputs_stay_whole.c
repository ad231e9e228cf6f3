// No command writes over what it reads, nor writes one file twice.
#include "support/cli_run.h"
#include "support/test.h"
#include "image/sequence.h"

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

TEST( test_scene_is_never_overwritten )
{
    cli_expect(
        cli_run(
            "cp $VASE room.glb && ln -s room.glb link.json && mkdir -p sub && echo '{\"scene\": \"room.glb\"}' > scene.json" ),
        0, NULL );
    check_kept( "room.glb", "--json: room.glb: ends as a file of another kind",
                "$R render room.glb -o f.exr --frames 1 --json room.glb" );
    check_kept( "room.glb", "--json: link.json: would overwrite an input", "$R info room.glb --json link.json" );
    check_kept( "room.glb", "--svg: room.glb: ends as", "$R cost room.glb --svg room.glb" );
    check_kept( "scene.json", "--json: ./sub/../scene.json: would overwrite an input",
                "$R tune scene.json --json ./sub/../scene.json" );
    check_kept( "room.glb", "--json: a.svg: ends as a file of another kind", "$R tune room.glb --svg b.svg --json a.svg" );
    check_kept( "room.glb", "--svg: a: is the file of --json too", "$R cost room.glb --svg a --json ./a" );
    check_kept( "room.glb", "expected a name that ends in .exr", "$R render room.glb --frames 1 -o f.json" );
    cli_expect( cli_run( "echo '{}' > path.json" ), 0, NULL );
    check_kept( "path.json", "--json: path.json: is the file of --camera too",
                "$R info room.glb --json /dev/null && $R tune room.glb --camera path.json --json path.json" );
    assert_false( cli_exists( "a" ) || cli_exists( "b.svg" ) || cli_exists( "f.json" ) );
}

TEST( test_frames_are_never_overwritten )
{
    cli_expect( cli_run( "$R render $VASE -o s.####.exr --frames 1-2 --size 16x9 --spp 2 --group 0 --quiet" ), 0, NULL );
    check_kept( "s.0001.exr", "--png: s.0001.exr: ends as", "$R flicker s.####.exr --png s.0001.exr" );
    check_kept( "s.0001.exr", "--json: s.0001.exr: ends as", "$R compare s.0001.exr s.0002.exr --json s.0001.exr" );
    check_kept( "s.0001.exr", "name it .png", "$R png s.0001.exr ./s.0001.exr" );
    cli_expect( cli_run( "for i in 1 2; do cp s.000$i.exr t.$i; done" ), 0, NULL ); // no ending to go by
    check_kept( "t.1", "is also the input", "$R png t.1 ./t.1" );
    check_kept( "t.1", "--json: t.1: would overwrite an input", "$R flicker t.# --json t.1" );
    check_kept( "t.1", "--png: t.2: is the file of --reference too", "$R flicker s.####.exr --reference t.# --png t.2" );
    cli_expect( cli_run( "$R compare t.1 t.2 --json t.3 --quiet" ), 0, NULL ); // a name of its own
    assert_true( cli_exists( "t.3" ) );
}

// Before any input is looked at: a folder that cannot be made, a folder in the way. What is there stays as it is, and the last part
// of a folder is made, as for frames.
TEST( test_results_are_tried_before_the_work )
{
    static const char* const lines[] = {
        "$R render none.glb -o n.exr --json %s.json",
        "$R render none.glb -o n.exr --preview %s.png",
        "$R info none.glb --json %s.json",
        "$R convert none.obj none.glb --json %s.json",
        "$R compare none.exr none.exr --json %s.json",
        "$R compare none.exr none.exr --diff %s.exr",
        "$R flicker none.#.exr --json %s.json",
        "$R flicker none.#.exr --png %s.png",
        "$R cost none.glb --json %s.json",
        "$R cost none.glb --svg %s.svg",
        "$R tune none.glb --json %s.json",
        "$R tune none.glb --svg %s.svg",
        "$R reconstruct none.exr -o %s.exr",
        "$R reconstruct none.exr -o n.exr --json %s.json",
        "$R report none -o n.html --json %s.json",
    };
    cli_expect( cli_run( "mkdir in-the-way.json in-the-way.png in-the-way.exr in-the-way.svg; : > is-file" ), 0, NULL );
    for ( size_t i = 0; i < sizeof lines / sizeof lines[0]; ++i )
    {
        const char *place = strstr( lines[i], "%s" ), *option = strstr( lines[i], " -" );
        for ( const char* next = option; next != NULL && next < place; next = strstr( next + 1, " -" ) )
            option = next;
        char name[32], part[96], line[256];
        snprintf( name, sizeof name, "%.*s", (int)( place - option - 2 ), option + 1 );
        snprintf( line, sizeof line, lines[i], "no/such/result" );
        snprintf( part, sizeof part, "%s: no/such: this folder cannot be made", strcmp( name, "-o" ) == 0 ? "--output" : name );
        cli_expect( cli_run( "%s", line ), 1, part );
        snprintf( line, sizeof line, lines[i], "is-file/result" );
        cli_expect( cli_run( "%s", line ), 1, "is-file: is not a folder" );
        snprintf( line, sizeof line, lines[i], "in-the-way" );
        cli_expect( cli_run( "%s", line ), 1, ": is a folder: choose another name" );
        snprintf( line, sizeof line, lines[i], "new/result" );
        const CliResult* done = cli_run( "rm -rf new; %s", line );
        assert_true( done->status != 0 && strstr( done->err, "none" ) != NULL ); // the input is missing
        assert_true( cli_exists( "new" ) );
        assert_int_equal( cli_count_files( "", "new" ), 0 );
    }
    cli_expect( cli_run( "echo old > old.json; touch -d 2001-01-01 old.json; $R info none.glb --json old.json" ), 1, "none.glb" );
    cli_expect( cli_run( "grep -q old old.json && test -z \"$(find old.json -newermt 2002-01-01)\"" ), 0, NULL );
    cli_expect( cli_run( "$R info $VASE --json new/deep.json >told && grep -q triangles new/deep.json" ), 0, NULL );
    cli_expect( cli_run( "printf 'ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                         "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
                         "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n' > tri.ply; $R convert tri.ply made/tri.glb --quiet" ),
                0, NULL );
    cli_expect( cli_run( "$R convert tri.ply no/such/tri.glb" ), 1, "no/such: this folder cannot be made" );
}

// Pictures and results have a format of their own, whatever they are called.
TEST( test_endings_of_other_kinds_are_refused )
{
    cli_expect( cli_run( "$R render $VASE -o e.exr --frames 1 --size 16x9 --spp 2 --group 0 --quiet" ), 0, NULL );
    static const char* const other[] = { "jpg", "JPEG", "tif", "webp", "exr", "xyz" };
    for ( size_t i = 0; i < sizeof other / sizeof other[0]; ++i )
    {
        char part[64];
        snprintf( part, sizeof part, "out.%s: ends as a file of another kind: name it .png", other[i] );
        cli_expect( cli_run( "$R png e.exr out.%s", other[i] ), 2, part );
        assert_int_not_equal( cli_run( "ls out.*" )->status, 0 );
    }
    cli_expect( cli_run( "$R png e.exr out.PNG && $R png e.exr plain && $R png e.exr take.2" ), 0, NULL );
    cli_expect( cli_run( "$R compare e.exr e.exr --json out.txt" ), 2, "--json: out.txt: ends as a file of another kind" );
    cli_expect( cli_run( "$R compare e.exr e.exr --json tmp.Ab3dE9xyzW --quiet" ), 0, NULL ); // as mktemp names them
}

TEST( test_names_of_the_same_file_are_known )
{
    assert_true( rf_may_be_same_file( "a.exr", "a.exr" ) && rf_may_be_same_file( "./a.exr", "a.exr" ) );
    assert_true( rf_may_be_same_file( "a.##.exr", "./a.12.exr" ) && rf_may_be_same_file( "a.123.exr", "a.##.exr" ) );
    assert_false( rf_may_be_same_file( "a.##.exr", "a.1.exr" ) || rf_may_be_same_file( "a.##.exr", "a.0123.exr" ) );
    assert_false( rf_may_be_same_file( "a.exr", "b.exr" ) || rf_may_be_same_file( "/a.exr", "a.exr" ) );
    assert_true( rf_may_be_same_file( "a.##.exr", "./a.##.exr" ) );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
