// reframe report as its user sees it: what the page holds, that no name breaks it, and
// what is refused. Choice of frames and layers: test_report_frames.c; looks and playback:
// test_report_browser.c.
#include "output/frame_file.h"
#include "support/cli_run.h"
#include "support/frame_files.h"
#include "support/test.h"

#include <jansson.h>

static json_t* parse_json( const char* text )
{
    json_t* json = json_loads( text, 0, NULL );
    assert_non_null( json );
    return json;
}

TEST( test_two_sequences_against_a_reference )
{
    page_make_folder( "t/a" );
    page_make_folder( "t/b" );
    page_make_folder( "t/r" );
    page_write_frames( "t/a/f.####.exr", 1, 4, 0.75f, 0.0f );
    page_write_frames( "t/b/f.####.exr", 1, 4, 0.5f, 0.25f ); // errors 0, 1/4, 1/2, 3/4
    page_write_frames( "t/r/f.####.exr", 1, 4, 0.5f, 0.0f );
    const CliResult* result =
        cli_run( "$R report t/a t/b --reference t/r -o t.html --json - --fps 25 --exposure 1.5 --title 'All of it' --quiet" );
    cli_expect( result, 0, NULL );
    assert_string_equal( result->err, "" );
    json_auto_t* json = parse_json( result->out );
    size_t size;
    free( cli_read( "t.html", &size ) );
    assert_int_equal( json_integer_value( json_object_get( json, "bytes" ) ), size );
    assert_int_equal( json_integer_value( json_object_get( json, "frames" ) ), 4 );
    assert_int_equal( json_array_size( json_object_get( json, "sequences" ) ), 3 );
    json_auto_t* data = page_read_data( "t.html", 12 );
    assert_string_equal( json_string_value( json_object_get( data, "title" ) ), "All of it" );
    assert_true( json_number_value( json_object_get( data, "fps" ) ) == 25.0 &&
                 json_number_value( json_object_get( data, "exposure" ) ) == 1.5 );
    const json_t *a = page_sequence( data, 0 ), *b = page_sequence( data, 1 ), *r = page_sequence( data, 2 );
    assert_string_equal( json_string_value( json_object_get( a, "name" ) ), "a" );
    assert_string_equal( json_string_value( json_object_get( r, "name" ) ), "reference" );
    page_check_item( a, "relmse", 2, 0.1875 / 0.251 );
    page_check_item( a, "f1", 1, 0.0 );
    page_check_item( a, "phi", 1, 0.0 );
    page_check_item( b, "relmse", 3, 3.0 * 0.5625 / 0.251 );
    page_check_item( b, "f1", 3, 0.25 / sqrt( 0.251 ) );
    page_check_item( b, "phi", 3, 0.0625 / ( 0.5625 + 0.25 ) );
    assert_true( json_is_null( page_item( b, "f1", 0 ) ) && json_is_null( page_item( r, "relmse", 0 ) ) &&
                 json_is_null( page_item( r, "f1", 2 ) ) );
    assert_string_equal( json_string_value( page_item( r, "blocks", 3 ) ), "s2-4" );
    assert_non_null( page_fact( b, "Error", "Flicker: relative F1" ) );
    assert_null( page_fact( r, "Error", "relMSE" ) );
}

// No name ends the script that it stands in, or begins another.
TEST( test_hostile_names_stay_text )
{
    static const char hostile[] = "</script><script>alert(1)</script><!--<b>&\"'";
    const RfExrString strings[] = { { "reframe/scene", hostile },
                                    { "Software", "\xff\xfe no utf-8 </SCRIPT>" },
                                    { "comments", "" } };
    cli_expect( cli_run( "mkdir -p 'h/x<script>\"&'" ), 0, NULL );
    page_write_frame( "h/x<script>\"&/f.1.exr", 20, 20, 1.0f, strings, 3 );
    const CliResult* result = cli_run( "$R report 'h/x<script>\"&' -o h.html --title '</title><script>alert(2)</script>'" );
    cli_expect( result, 0, NULL );
    json_t* data = page_read_data( "h.html", 1 );
    assert_string_equal( json_string_value( json_object_get( data, "title" ) ), "</title><script>alert(2)</script>" );
    const json_t* sequence = page_sequence( data, 0 );
    assert_string_equal( json_string_value( json_object_get( sequence, "name" ) ), "x<script>\"&" );
    assert_string_equal( page_fact( sequence, "Settings", "scene" ), hostile );
    assert_non_null( page_fact( sequence, "Header", "Software" ) );
    json_decref( data );
    size_t size;
    AUTO_FREE char* text = cli_read( "h.html", &size );
    assert_int_equal( page_count( text, "<title>" ) + page_count( text, "</title>" ), 2 );
    // a value without an end
    AUTO_FREE char* longest = malloc( 100001 );
    assert_non_null( longest );
    memset( longest, 'x', 100000 );
    longest[100000] = '\0';
    const RfExrString one = { "comments", longest };
    page_write_frame( "h/long.exr", 20, 20, 1.0f, &one, 1 );
    cli_expect( cli_run( "$R report h/long.exr -o h2.html --quiet" ), 0, NULL );
    data = page_read_data( "h2.html", 1 );
    assert_true( strlen( page_fact( page_sequence( data, 0 ), "Header", "comments" ) ) < 300 );
    json_decref( data );
}

#define RENDER_JSON                                                                                                              \
    "{\"version\":\"1\",\"frames\":[{\"frame\":2,\"seconds\":1.5,\"native_spp\":14,\"relmse_estimate\":0.25}],\"seconds\":125,"  \
    "\"peak_bytes\":2500000,"                                                                                                    \
    "\"rays\":{\"primary\":1000,\"eye\":2500000},\"effects\":[\"diffuse\",\"</script>\"]}"

TEST( test_json_of_render_is_read )
{
    page_make_folder( "j" );
    page_write_frames( "j/f.####.exr", 1, 2, 1.0f, 0.0f );
    cli_write( "j/a.json", "{ no json", 9 );
    cli_write( "j/b.json", "[1, 2]", 6 );
    cli_write( "j/r.json", RENDER_JSON, strlen( RENDER_JSON ) );
    cli_expect( cli_run( "$R report j -o j.html" ), 0, NULL );
    json_t* data = page_read_data( "j.html", 2 );
    const json_t* sequence = page_sequence( data, 0 );
    page_check_item( sequence, "relmse", 1, 0.25 );
    page_check_item( sequence, "seconds", 1, 1.5 );
    page_check_item( sequence, "samples", 1, 14.0 );
    assert_true( json_is_null( page_item( sequence, "relmse", 0 ) ) );
    assert_string_equal( page_fact( sequence, "Cost", "Time" ), "2 min 5 s" );
    assert_string_equal( page_fact( sequence, "Cost", "Memory, peak" ), "2.5 MB" );
    assert_string_equal( page_fact( sequence, "Cost", "Rays" ), "2.5 M" );
    json_decref( data );
    // by name; with a reference the estimate has no place
    cli_expect( cli_run( "mkdir k; mv j/r.json k; $R report j --reference j -o k.html --render-json k/r.json" ), 0, NULL );
    data = page_read_data( "k.html", 4 );
    page_check_item( page_sequence( data, 0 ), "relmse", 1, 0.0 );
    page_check_item( page_sequence( data, 0 ), "seconds", 1, 1.5 );
    json_decref( data );
    cli_expect( cli_run( "$R report j -o k2.html --render-json j/b.json" ), 1,
                "--render-json: j/b.json: is not what reframe render --json writes" );
    cli_expect( cli_run( "$R report j -o k2.html --render-json j/a.json" ), 1, "--render-json: j/a.json: line 1" );
    cli_expect( cli_run( "$R report j -o k2.html --render-json no.json" ), 1, "no.json" );
    cli_expect( cli_run( "$R report j j -o k2.html --render-json k/r.json" ), 2, "--render-json: takes one sequence" );
    assert_false( cli_exists( "k2.html" ) );
}

TEST( test_estimates_in_headers )
{
    page_make_folder( "e" );
    const RfExrString said[] = { { "reframe/relmse-estimate", "0.125" },
                                 { "reframe/group", "3" },
                                 { "reframe/native-spp", "6.5" },
                                 { "reframe/noise", "0.2" } },
                      none = { "reframe/relmse-estimate", "much" };
    page_write_frame( "e/f1.exr", 20, 20, 1.0f, said, 4 );
    page_write_frame( "e/f2.exr", 20, 20, 1.0f, &none, 1 );
    cli_expect( cli_run( "$R report e -o e.html" ), 0, NULL );
    json_auto_t* data = page_read_data( "e.html", 2 );
    page_check_item( page_sequence( data, 0 ), "relmse", 0, 0.125 );
    assert_true( json_is_null( page_item( page_sequence( data, 0 ), "relmse", 1 ) ) );
    page_check_item( page_sequence( data, 0 ), "samples", 0, 6.5 );
    assert_string_equal( page_fact( page_sequence( data, 0 ), "Settings", "group" ), "3" );
    assert_string_equal( page_fact( page_sequence( data, 0 ), "Settings", "noise" ), "0.2" );
}

// Whatever Reframe writes into a header is on the page, but what tells where a frame belongs and what the page has as numbers.
TEST( test_every_attribute_is_shown )
{
    static const RfKey elsewhere[] = {
        RF_KEY_FRAME,          RF_KEY_FRAMES,          RF_KEY_SHOT,
        RF_KEY_STEP,           RF_KEY_EFFECTS,         RF_KEY_CALLS_FOR,
        RF_KEY_FINGERPRINT,    RF_KEY_RELMSE_ESTIMATE, RF_KEY_RELMSE_IS_LOWER_BOUND,
        RF_KEY_RELMSE_LIKELY,  RF_KEY_WORST_TEN_SHARE, RF_KEY_FLICKER_ESTIMATE,
        RF_KEY_FLICKER_LIKELY, RF_KEY_REACHED,         RF_KEY_FLICKER_IS_LOWER_BOUND,
        RF_KEY_NATIVE_SPP,     RF_KEY_EFFECTIVE_SPP,   RF_KEY_FLICKER_WORST_TEN_SHARE,
        RF_KEY_CLIPPED_PIXELS, RF_KEY_DENOISED_RELMSE, RF_KEY_DENOISED_LOW,
        RF_KEY_DENOISED_HIGH,
    };
    RfExrString strings[RF_KEY_COUNT];
    char values[RF_KEY_COUNT][32];
    for ( int key = 0; key < RF_KEY_COUNT; ++key )
    {
        snprintf( values[key], sizeof values[key], "value of key %d.", key );
        strings[key] = ( RfExrString ){ rf_key_name( (RfKey)key ), values[key] };
    }
    page_make_folder( "keys" );
    page_write_frame( "keys/f1.exr", 20, 20, 1.0f, strings, RF_KEY_COUNT );
    cli_expect( cli_run( "$R report keys -o keys.html" ), 0, NULL );
    json_auto_t* data = page_read_data( "keys.html", 1 );
    AUTO_FREE char* text = json_dumps( json_object_get( page_sequence( data, 0 ), "facts" ), 0 );
    assert_non_null( text );
    for ( int key = 0; key < RF_KEY_COUNT; ++key )
    {
        bool is_elsewhere = false;
        for ( size_t i = 0; i < sizeof elsewhere / sizeof elsewhere[0]; ++i )
            is_elsewhere |= (int)elsewhere[i] == key;
        if ( ( strstr( text, values[key] ) != NULL ) == is_elsewhere )
            fail_msg( "%s", rf_key_name( (RfKey)key ) );
    }
}

// What the reference says of itself is no error of it.
TEST( test_reference_json_is_no_error )
{
    page_make_folder( "q/a" );
    page_make_folder( "q/r" );
    page_write_frames( "q/a/f.####.exr", 1, 2, 1.0f, 0.0f );
    page_write_frames( "q/r/f.####.exr", 1, 2, 1.0f, 0.0f );
    cli_write( "q/r/r.json", RENDER_JSON, strlen( RENDER_JSON ) );
    cli_expect( cli_run( "$R report q/a --reference q/r -o q.html" ), 0, NULL );
    json_auto_t* data = page_read_data( "q.html", 4 );
    page_check_item( page_sequence( data, 0 ), "relmse", 1, 0.0 );
    assert_true( json_is_null( page_item( page_sequence( data, 1 ), "relmse", 1 ) ) );
    page_check_item( page_sequence( data, 1 ), "seconds", 1, 1.5 );
    assert_string_equal( page_fact( page_sequence( data, 1 ), "Cost", "Time" ), "2 min 5 s" );
}

TEST( test_width_shrinks_pictures )
{
    page_write_frame( "w.exr", 100, 50, 1.0f, NULL, 0 );
    cli_expect( cli_run( "$R report w.exr -o w.html --width 40 --json w.json" ), 0, NULL );
    json_auto_t* data = page_read_data( "w.html", 1 );
    assert_int_equal( json_integer_value( json_object_get( page_sequence( data, 0 ), "width" ) ), 34 );
    assert_int_equal( json_integer_value( json_object_get( page_sequence( data, 0 ), "height" ) ), 17 );
    assert_string_equal( page_fact( page_sequence( data, 0 ), "Picture", "Size" ), "100 x 50, shown as 34 x 17" );
    assert_true( cli_exists( "w.json" ) );
}

// What render leaves, its JSON too.
TEST( test_render_output_as_it_is )
{
    cli_expect(
        cli_run( "$R render $VASE -o v/f.####.exr --frames 1-3 --size 48x32 --spp 3 --group 1 --aov motion,depth,variance "
                 "--json v/render.json --quiet && $R report v -o v.html" ),
        0, NULL );
    json_auto_t* data = page_read_data( "v.html", 3 );
    const json_t* sequence = page_sequence( data, 0 );
    assert_true( json_is_number( page_item( sequence, "f1", 2 ) ) && json_is_number( page_item( sequence, "phi", 2 ) ) &&
                 json_is_null( page_item( sequence, "f1", 0 ) ) );
    assert_true( json_number_value( json_object_get( data, "fps" ) ) == 24.0 );
    static const char* const wanted[][2] = { { "Settings", "camera" }, { "Settings", "group" }, { "Settings", "aov" },
                                             { "Cost", "Rays" },       { "Cost", "Threads" },   { "Cost", "Memory, peak" } };
    for ( size_t i = 0; i < sizeof wanted / sizeof wanted[0]; ++i )
        assert_non_null( page_fact( sequence, wanted[i][0], wanted[i][1] ) );
    assert_non_null( page_fact( sequence, "Error", "Flicker: phi" ) );
}

TEST( test_wrong_input_is_refused )
{
    page_make_folder( "x/a" );
    page_make_folder( "x/empty" );
    page_make_folder( "x/two" );
    page_write_frames( "x/a/f.####.exr", 1, 3, 1.0f, 0.0f );
    page_write_frames( "x/two/f.####.exr", 1, 2, 1.0f, 0.0f );
    page_write_frames( "x/two/diff.####.exr", 1, 2, 1.0f, 0.0f );
    cli_expect( cli_run( "$R report" ), 2, "DIR is missing" );
    cli_expect( cli_run( "$R report x/a" ), 2, "--output: is missing" );
    cli_expect( cli_run( "$R report x/a -o x/a/f.0001.exr --overwrite" ), 2, "expected a name that ends with .html" );
    cli_expect( cli_run( "$R report a b c d e f g h i -o x.html" ), 2, "'i' is one file too many" );
    cli_expect( cli_run( "$R report x/a '' -o x.html" ), 2, "DIR: the name is empty" );
    cli_expect( cli_run( "$R report x/none -o x.html" ), 1, "x/none: cannot be read: No such file" );
    cli_expect( cli_run( "$R report x/none.#.exr -o x.html" ), 1, "x/none.#.exr: no such file" );
    cli_expect( cli_run( "$R report x/empty -o x.html" ), 1, "x/empty: no EXR file in this folder" );
    cli_expect( cli_run( "$R report x/two -o x.html" ), 2, "diff.####.exr and f.####.exr: name one" );
    cli_expect( cli_run( "$R report x/two/f.####.exr -o x.html" ), 0, NULL );
    cli_expect( cli_run( "$R report x/a -o x.html" ), 1, "x.html: already exists: --overwrite replaces it" );
    cli_expect( cli_run( "$R report x/a -o x.html --overwrite" ), 0, NULL );
    cli_expect( cli_run( "$R report x/a -o no/such/x.html" ), 1, "no/such: this folder cannot be made" );
    cli_expect( cli_run( "$R report x/a -o y.html --frames 7-9" ), 2, "--frames" );
    cli_expect( cli_run( "$R report x/a -o y.html --frames 1-2 --exposure 9" ), 2, "--exposure" );
    page_write_frame( "x/a/f.0003.exr", 41, 30, 1.0f, NULL, 0 );
    cli_expect( cli_run( "$R report x/a -o y.html --quiet" ), 1, "f.0003.exr: has 41x30 pixels" );
    page_write_frame( "x/other.exr", 39, 30, 1.0f, NULL, 0 );
    cli_expect( cli_run( "$R report x/two/f.0001.exr --reference x/other.exr -o y.html --quiet" ), 1,
                "x/other.exr: has 39x30 pixels" );
    cli_write( "x/a/f.0003.exr", "EXR", 3 );
    cli_expect( cli_run( "$R report x/a/f.0003.exr -o y.html --quiet" ), 1, "f.0003.exr: not a readable EXR file" );
    cli_expect( cli_run( "ulimit -f 8; $R report x/two/f.####.exr -o y.html --quiet" ), 1, "y.html" );
    assert_false( cli_exists( "y.html" ) );
    assert_int_equal( cli_count_files( ".tmp", "." ), 0 );
    assert_int_equal( cli_run( "ls -a | grep -c '^\\..*html' > n; test \"$(cat n)\" = 0" )->status, 0 );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
