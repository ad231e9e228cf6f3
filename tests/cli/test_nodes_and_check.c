// Renders on several machines as the program has them: render --check.
#include "support/cli_run.h"
#include "support/test.h"

#define SHOT "$VASE --size 16x9 --spp 6 --group 1 --tile 1 --quiet "

static int count_of( const json_t* json, const char* key ) { return (int)json_array_size( json_object_get( json, key ) ); }

static int number_of( const json_t* json, const char* key ) { return (int)json_integer_value( json_object_get( json, key ) ); }

TEST( test_check_tells_what_is_there )
{
    cli_expect( cli_run( "$R render " SHOT "-o c/f.####.exr --frames 1-3,7-9x2 >told" ), 0, NULL );
    cli_expect( cli_run( "$R render " SHOT "-o c/f.####.exr --frames 1-3 --check >told" ), 0, NULL );
    cli_expect( cli_run( "grep -q '^3 frames in c/f.####.exr: all there, whole and of this render' told" ), 0, NULL );
    const char* line = "c/f.####.exr: 5 of 10 frames are finished; not there: 4-6, 8, 10: --resume continues";
    cli_expect( cli_run( "$R render " SHOT "-o c/f.####.exr --frames 1-10 --check --nodes 2 --json check.json >told" ), 1, line );
    json_auto_t* json = cli_read_json( "check.json" );
    assert_true( json_is_false( json_object_get( json, "complete" ) ) );
    assert_int_equal( number_of( json, "finished" ), 5 );
    assert_int_equal( count_of( json, "missing" ), 5 );
    const json_t* nodes = json_object_get( json, "nodes" );
    assert_int_equal( count_of( nodes, "ranges" ), 2 );
    // a frame that lost its end, and one of other settings
    cli_expect( cli_run( "truncate -s 1500 c/f.0002.exr" ), 0, NULL );
    cli_expect( cli_run( "$R render " SHOT "-o c/f.####.exr --frames 3 --seed 7 --overwrite >told" ), 0, NULL );
    line = "1 of 3 frames are finished; of another render: 3; no frame: 2: --resume --overwrite replaces the rest";
    cli_expect( cli_run( "$R render " SHOT "-o c/f.####.exr --frames 1-3 --check" ), 1, line );
    cli_expect( cli_run( "$R render " SHOT "-o none/f.####.exr --frames 1 --check" ), 1, "0 of 1 frames are finished" );
    assert_false( cli_exists( "none" ) ); // it only looks
}

// Frame 2 is cut, frame 3 has one bit flipped, in the last pixels of the file: of the depth, where there are parts.
TEST( test_damaged_frames_are_found_and_rendered_again )
{
    static const char* const formats[] = { "none", "zip", "piz", "dwaa" };
    for ( size_t i = 0; i < 2 * sizeof formats / sizeof formats[0]; ++i )
    {
        char shot[256];
        snprintf( shot, sizeof shot,
                  "$R render " SHOT "--frames 1-4 --aov depth,normal --compression %s --parts %s -o d/f.####.exr", formats[i / 2],
                  i % 2 == 0 ? "one" : "each" );
        cli_expect( cli_run( "rm -rf d whole; %s >told && cp -r d whole", shot ), 0, NULL );
        cli_expect( cli_run( "%s --check >told", shot ), 0, NULL );
        cli_expect( cli_run( "truncate -s -20 d/f.0002.exr" ), 0, NULL );
        size_t size;
        AUTO_FREE char* bytes = cli_read( "d/f.0003.exr", &size );
        bytes[size - 5] ^= 1;
        cli_write( "d/f.0003.exr", bytes, size );
        cli_expect( cli_run( "%s --check --json check.json", shot ), 1,
                    "2 of 4 frames are finished; damaged: 2, 3: --resume continues" );
        json_t* json = cli_read_json( "check.json" );
        assert_int_equal( count_of( json, "damaged" ), 2 );
        assert_int_equal( number_of( json, "finished" ), 2 );
        json_decref( json );
        const CliResult* done = cli_run( "%s --resume%s --json again.json", shot, i % 3 == 0 ? " --overwrite" : "" );
        cli_expect( done, 0, "warning: --resume: damaged, rendered again: 2, 3: d/f.0002.exr: " );
        json = cli_read_json( "again.json" );
        assert_int_equal( number_of( json, "kept_frames" ), 2 );
        assert_int_equal( count_of( json, "warnings" ), 1 );
        json_decref( json );
        cli_expect( cli_run( "for f in whole/*; do cmp $f d/${f#*/} || exit 1; done" ), 0, NULL );
    }
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
