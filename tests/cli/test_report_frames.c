// Which frames, layers and parts of files reframe report takes, and what it says about
// missing ones.
#include "support/cli_run.h"
#include "support/image_files.h"
#include "support/frame_files.h"
#include "support/test.h"

// The missing frames of a sequence, as the page names them.
static const char* missing_of( const json_t* data, size_t sequence )
{
    const char* text = page_fact( page_sequence( data, sequence ), "Picture", "Missing frames" );
    return text != NULL ? text : "";
}

TEST( test_missing_frames_are_reported )
{
    page_make_folder( "m/a" );
    page_make_folder( "m/b" );
    page_write_frames( "m/a/f.##.exr", 1, 5, 1.0f, 0.5f );
    cli_expect( cli_run( "rm m/a/f.03.exr" ), 0, NULL );
    page_write_frames( "m/b/f_#.exr", 4, 6, 1.0f, 0.0f );
    cli_expect( cli_run( "$R report m/a m/b -o m.html" ), 0, NULL );
    json_t* data = page_read_data( "m.html", 4 + 3 );
    assert_int_equal( json_array_size( json_object_get( data, "frames" ) ), 5 ); // 1 2 4 5 6
    const json_t *a = page_sequence( data, 0 ), *b = page_sequence( data, 1 );
    assert_true( json_is_null( page_item( a, "blocks", 4 ) ) && json_is_null( page_item( b, "blocks", 1 ) ) );
    page_check_item( a, "f1", 1, 0.5 / sqrt( 0.5 * ( 1.0 * 1.0 + 1.5 * 1.5 ) + 0.001 ) );
    assert_true( json_is_null( page_item( a, "f1", 2 ) ) ); // 4 has no 3 before it
    page_check_item( a, "f1", 3, 0.5 / sqrt( 0.5 * ( 2.5 * 2.5 + 3.0 * 3.0 ) + 0.001 ) );
    assert_true( json_is_null( page_item( b, "f1", 2 ) ) );
    page_check_item( b, "f1", 4, 0.0 );
    assert_string_equal( missing_of( data, 0 ), "3, 6" );
    assert_string_equal( missing_of( data, 1 ), "1-3" );
    json_decref( data );
    cli_expect( cli_run( "$R report m/a -o m2.html --frames 2-4" ), 0, NULL );
    data = page_read_data( "m2.html", 2 );
    assert_int_equal( json_array_size( json_object_get( data, "frames" ) ), 2 );
    assert_string_equal( missing_of( data, 0 ), "3" );
    json_decref( data );
    cli_expect( cli_run( "$R report m/a -o m4.html --frames 1-2,4-5" ), 0, NULL );
    data = page_read_data( "m4.html", 4 );
    assert_string_equal( missing_of( data, 0 ), "" ); // 3 is not asked for
    json_decref( data );
    // where the reference ends, the error does
    cli_expect( cli_run( "$R report m/b --reference m/a -o m3.html" ), 0, NULL );
    data = page_read_data( "m3.html", 3 + 2 );
    assert_true( json_is_number( page_item( page_sequence( data, 0 ), "relmse", 1 ) ) &&
                 json_is_null( page_item( page_sequence( data, 0 ), "relmse", 2 ) ) );
    assert_true( json_is_null( page_item( page_sequence( data, 0 ), "f1", 2 ) ) );
    json_decref( data );
}

TEST( test_files_of_other_programs )
{
    page_make_folder( "o" );
    Foreign parts[2] = { { .names = { "Z" }, .values = { 7 }, .x = 3, .y = 5, .width = 20, .height = 10, .part = "depth" },
                         { .names = { "L.Combined.B", "L.Combined.G", "L.Combined.R" },
                           .values = { 1, NAN, 1 },
                           .width = 30,
                           .height = 20,
                           .half = true,
                           .part = "beauty" } };
    write_foreign_exr( cli_path( "o/x.0007.left.exr" ), parts, 2 );
    write_foreign_exr( cli_path( "o/x.0008.left.exr" ), parts, 2 );
    cli_expect( cli_run( "$R report o -o o.html" ), 0, NULL );
    json_auto_t* data = page_read_data( "o.html", 2 );
    const json_t* sequence = page_sequence( data, 0 );
    assert_int_equal( json_integer_value( json_array_get( json_object_get( data, "frames" ), 1 ) ), 8 );
    assert_int_equal( json_integer_value( json_object_get( sequence, "width" ) ), 30 );
    page_check_item( sequence, "bad", 0, 600.0 );
    assert_true( json_is_null( page_item( sequence, "f1", 1 ) ) );
    assert_null( page_fact( sequence, "Settings", "group" ) );
    page_check_item( sequence, "bad", 1, 600.0 );
}

// The regular step is the smallest that occurs.
TEST( test_holes_by_the_smallest_step )
{
    page_make_folder( "g" );
    page_write_frames( "g/f.##.exr", 1, 2, 1.0f, 0.0f );
    page_write_frames( "g/f.##.exr", 5, 5, 1.0f, 0.0f );
    const CliResult* result = cli_run( "$R report g -o g.html --json -" );
    assert_int_equal( result->status, 0 );
    assert_non_null( strstr( result->out, "\"missing\": 2" ) );
    json_t* data = page_read_data( "g.html", 3 );
    assert_string_equal( missing_of( data, 0 ), "3, 4" );
    json_decref( data );
    page_make_folder( "h" );
    for ( int frame = 1; frame <= 9; frame += 2 )
        page_write_frames( "h/f.##.exr", frame, frame, 1.0f, 0.0f );
    cli_expect( cli_run( "$R report h -o h.html" ), 0, NULL );
    data = page_read_data( "h.html", 5 );
    assert_string_equal( missing_of( data, 0 ), "" );
    json_decref( data );
}

static void write_parts( const char* name, const Foreign* parts, int count )
{
    write_foreign_exr( cli_path( name ), parts, count );
}

#define COLOUR( value )                                                                                                          \
    {                                                                                                                            \
        .names = { "B", "G", "R" }, .values = { value, value, value }, .width = 20, .height = 10, .part = "beauty"               \
    }

// Motion in the first part, colour in the second, depth in the third; then a frame without motion.
TEST( test_layers_found_across_parts )
{
    page_make_folder( "p" );
    page_make_folder( "p/r" );
    for ( int frame = 1; frame <= 5; ++frame )
    {
        char name[64];
        float value = frame % 2 == 1 ? 2.0f : 1.0f;
        Foreign parts[3] = { { .names = { "motion.X", "motion.Y" }, .values = { 5, 0 }, .width = 20, .height = 10, .part = "m" },
                             COLOUR( value ),
                             { .names = { "Z" }, .values = { 3 }, .width = 20, .height = 10, .part = "depth" } };
        snprintf( name, sizeof name, "p/f.%d.exr", frame );
        write_parts( name, frame != 3 ? parts : parts + 1, frame != 3 ? 3 : 2 );
        Foreign reference = COLOUR( 0.0f );
        snprintf( name, sizeof name, "p/r/f.%d.exr", frame );
        write_parts( name, &reference, 1 );
    }
    cli_expect( cli_run( "$R report p -o p.html" ), 0, NULL );
    json_t* data = page_read_data( "p.html", 5 );
    const json_t* sequence = page_sequence( data, 0 );
    page_check_item( sequence, "f1", 1, 1.0 / sqrt( 2.501 ) );
    assert_true( json_is_null( page_item( sequence, "f1", 2 ) ) ); // 3 has no motion; where the others lie is known
    page_check_item( sequence, "f1", 3, 1.0 / sqrt( 2.501 ) );
    assert_string_equal( page_fact( sequence, "Error", "Flicker: relative F1" ), "0.632" );
    json_decref( data );
    cli_expect( cli_run( "$R report p --reference p/r -o p2.html" ), 0, NULL );
    data = page_read_data( "p2.html", 10 );
    sequence = page_sequence( data, 0 );
    page_check_item( sequence, "f1", 2, 1.0 / sqrt( 0.001 ) );                    // plain
    assert_string_equal( page_fact( sequence, "Error", "Flicker: phi" ), "0.2" ); // 1 / (4 + 1)
    assert_null( page_fact( page_sequence( data, 1 ), "Error", "Flicker: phi" ) );
    json_decref( data );
}

TEST( test_layers_are_chosen_by_name )
{
    page_make_folder( "l/a" );
    page_make_folder( "l/r" );
    Foreign a = {
        .names = { "x.B", "x.G", "x.R", "y.B", "y.G", "y.R" }, .values = { 1, 1, 1, 2, 2, 2 }, .width = 20, .height = 10
    };
    Foreign r = COLOUR( 1.5f );
    write_parts( "l/a/f.1.exr", &a, 1 );
    write_parts( "l/r/f.1.exr", &r, 1 );
    cli_expect( cli_run( "$R report l/a -o l.html --quiet" ), 1, "has more than one layer of colour: x, y: name one by --layer" );
    cli_expect( cli_run( "$R report l/a -o l.html --layer x --reference-layer y" ), 2, "--reference-layer: needs --reference" );
    cli_expect( cli_run( "$R report l/a -o l.html --layer z --quiet" ), 1, "f.1.exr: has no layer z; it has x, y\n" );
    cli_expect( cli_run( "$R report l/a --reference l/a -o l.html --layer x --reference-layer y --quiet" ), 0, NULL );
    json_t* data = page_read_data( "l.html", 2 );
    page_check_item( page_sequence( data, 0 ), "relmse", 0, 3.0 / 4.001 );
    json_decref( data );
    cli_expect( cli_run( "$R report l/a --reference l/r -o l2.html --layer y --quiet" ), 1, "r/f.1.exr: has no layer y" );
    cli_expect( cli_run( "$R report l/a --reference l/r -o l2.html --layer y --reference-layer R --quiet" ), 0, NULL );
    data = page_read_data( "l2.html", 2 );
    page_check_item( page_sequence( data, 0 ), "relmse", 0, 3.0 * 0.25 / 2.251 );
    json_decref( data );
}

// Scene values fit their bytes, as fine as these allow.
TEST( test_values_fit_their_bytes )
{
    page_make_folder( "b" );
    page_write_frames( "b/f.#.exr", 1, 3, 1.0f, 0.0f ); // 40×30 pixels: 9608 bytes of the page for values of each
    static const struct
    {
        const char* options;
        int most, factor;
    } cases[] = { { "", 30000, 1 }, { "--values 16K", 16384, 2 }, { "--values 6000", 6000, 3 }, { "--values 0", 0, 0 } };
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        const CliResult* result = cli_run( "$R report b -o b.html --overwrite --quiet --json - %s", cases[i].options );
        cli_expect( result, 0, NULL );
        json_auto_t* json = json_loads( result->out, 0, NULL );
        json_int_t bytes = json_integer_value( json_object_get( page_sequence( json, 0 ), "value_bytes" ) );
        if ( bytes > cases[i].most || bytes < cases[i].most * 2 / 5 )
            fail_msg( "%s: %lld bytes", cases[i].options, (long long)bytes );
        json_auto_t* data = page_read_data( "b.html", 3 );
        int factor = (int)json_integer_value( json_object_get( page_sequence( data, 0 ), "value_factor" ) );
        if ( factor != cases[i].factor )
            fail_msg( "%s: %d", cases[i].options, factor );
    }
}

// AOVs are those that the first file has under the usual names; a frame without them has none.
TEST( test_aovs_of_the_files )
{
    page_make_folder( "q" );
    for ( int frame = 1; frame <= 3; ++frame )
    {
        char name[64];
        Foreign parts[2] = { COLOUR( 2.0f ),
                             { .names = { "ViewLayer.Depth.Z", "normal.X", "normal.Y" },
                               .values = { 3, 0, 1 },
                               .width = 20,
                               .height = 10,
                               .part = "d" } };
        snprintf( name, sizeof name, "q/f.%d.exr", frame );
        write_parts( name, parts, frame != 2 ? 2 : 1 );
    }
    cli_expect( cli_run( "$R report q -o q.html --quiet" ), 0, NULL );
    json_t* data = page_read_data( "q.html", 3 );
    const json_t *sequence = page_sequence( data, 0 ), *layers = json_object_get( sequence, "layers" );
    assert_int_equal( json_array_size( layers ), 1 ); // a normal without Z is none
    assert_string_equal( json_string_value( json_object_get( json_array_get( layers, 0 ), "name" ) ), "depth" );
    assert_true( json_is_true( page_item( sequence, "has_layers", 0 ) ) &&
                 json_is_false( page_item( sequence, "has_layers", 1 ) ) );
    json_decref( data );
    cli_expect( cli_run( "$R report q -o q2.html --passes 0 --quiet" ), 0, NULL );
    data = page_read_data( "q2.html", 3 );
    assert_int_equal( json_array_size( json_object_get( page_sequence( data, 0 ), "layers" ) ), 0 );
    json_decref( data );
}

// Passes of any names and parts, as many as have room; the others are named.
TEST( test_passes_have_room_or_are_named )
{
    page_make_folder( "u" );
    const Foreign parts[4] = {
        COLOUR( 2.0f ),
        { .names = { "light_key.B", "light_key.G", "light_key.R" },
          .values = { 1, 2, 3 },
          .width = 20,
          .height = 10,
          .part = "k" },
        { .names = { "CryptoObject00.A", "CryptoObject00.B", "CryptoObject00.G", "CryptoObject00.R", "object_index.Y" },
          .values = { 0, 0, 1, 5, 3 },
          .width = 20,
          .height = 10,
          .part = "c" },
        { .names = { "depth.Z" }, .values = { 3 }, .width = 10, .height = 10, .part = "other window" },
    };
    write_parts( "u/f.1.exr", parts, 4 );
    static const char* const lost[2] = { "depth", "object_index, depth" };
    for ( int few = 0; few < 2; ++few )
    {
        cli_expect( cli_run( "$R report u -o u.html --overwrite --quiet %s", few ? "--passes 200" : "" ), 0, NULL );
        json_auto_t* data = page_read_data( "u.html", 1 );
        const json_t *layers = json_object_get( page_sequence( data, 0 ), "layers" ), *key = json_array_get( layers, 0 );
        const json_t* crypto = json_array_get( layers, 1 );
        assert_int_equal( json_array_size( layers ), few ? 2 : 3 );
        assert_string_equal( json_string_value( json_object_get( key, "name" ) ), "light_key" );
        assert_true( json_is_true( json_object_get( key, "group" ) ) && json_is_false( json_object_get( crypto, "group" ) ) );
        assert_string_equal( json_string_value( json_object_get( crypto, "look" ) ), "mattes" );
        assert_string_equal( page_fact( page_sequence( data, 0 ), "Picture", "Passes left out" ), lost[few] );
    }
}

// Of a data window larger than the display window, 64x64, the page shows what is in this.
TEST( test_overscan_is_left_out )
{
    page_make_folder( "w" );
    const Foreign part = {
        .names = { "B", "G", "R", "depth.Z" }, .values = { 1, 2, 3, 4 }, .x = 0, .y = -4, .width = 64, .height = 72
    };
    write_parts( "w/f.1.exr", &part, 1 );
    cli_expect( cli_run( "$R report w -o w.html --quiet" ), 0, NULL );
    json_auto_t* data = page_read_data( "w.html", 1 );
    const json_t *sequence = page_sequence( data, 0 ), *layer = json_array_get( json_object_get( sequence, "layers" ), 0 );
    assert_int_equal( json_integer_value( json_object_get( sequence, "width" ) ), 64 );
    assert_int_equal( json_integer_value( json_object_get( sequence, "file_height" ) ), 64 );
    assert_int_equal( json_integer_value( json_object_get( layer, "width" ) ), 64 );
    assert_string_equal( page_fact( sequence, "Picture", "Size" ), "64 x 64, with overscan 64 x 72" );
}

TEST( test_sizes_must_agree )
{
    page_make_folder( "s" );
    page_write_frames( "s/f.#.exr", 1, 2, 1.0f, 0.0f );
    page_write_frame( "s/f.3.exr", 41, 30, 1.0f, NULL, 0 );
    cli_expect( cli_run( "$R report s -o s.html --quiet" ), 1,
                "f.3.exr: has 41x30 pixels and s/f.1.exr 40x30: all frames of a sequence need the same size" );
    cli_expect( cli_run( "$R report s/f.1.exr --reference s/f.3.exr -o s.html --quiet" ), 1,
                "f.3.exr: has 41x30 pixels and s/f.1.exr 40x30: a reference" );
    assert_false( cli_exists( "s.html" ) );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
