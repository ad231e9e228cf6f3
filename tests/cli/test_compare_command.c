// reframe compare as a script sees it: exit status, JSON, and what it refuses.
#include "cli/commands.h"
#include "support/cli_run.h"
#include "support/image_files.h"
#include "image/sequence.h"
#include "support/image_support.h"
#include "support/test.h"

#include <jansson.h>

static void write_constant( const char* name, int side, float value )
{
    AUTO_IMAGE image;
    RfError error;
    assert_int_equal( rf_create_image( side, side, &image, &error ), RF_OK );
    for ( int i = 0; i < 3 * side * side; ++i )
        image.rgb[i] = value;
    RfExrOptions options = rf_default_exr_options();
    options.half = false;
    assert_int_equal( rf_write_exr( cli_path( name ), &image, &options, &error ), RF_OK );
}

// Runs compare; further arguments up to NULL.
static int compare( const char* a, const char* b, ... )
{
    char* arguments[COMMAND_ARGUMENTS] = { "compare", (char*)cli_path( a ), (char*)cli_path( b ), "--json",
                                           (char*)cli_path( "out.json" ) };
    const int count = 5;
    va_list more;
    va_start( more, b );
    int status = run_command_to_json( rf_command_compare, count, arguments, more );
    va_end( more );
    return status;
}

TEST( test_two_files_give_exact_figures )
{
    write_constant( "a.exr", 40, 0.75f );
    write_constant( "b.exr", 40, 0.5f );
    assert_int_equal( compare( "a.exr", "b.exr", "--diff", cli_path( "d.exr" ), NULL ), 0 );
    json_auto_t* json = load_json();
    assert_true( fabs( number( json, "relmse" ) - 0.1875 / 0.251 ) < 1e-8 );
    assert_true( fabs( number( json, "relmse_trimmed" ) - 0.1875 / 0.251 ) < 1e-8 );
    assert_true( number( json, "mse" ) == 0.0625 && number( json, "bias" ) == 0.25 && number( json, "max" ) == 0.25 );
    assert_true( number( json, "bias_low" ) <= 0.25 && number( json, "bias_high" ) >= 0.25 );
    assert_true( number( json, "nan" ) == 0.0 && number( json, "inf" ) == 0.0 );
    const json_t* frames = json_object_get( json, "frames" );
    assert_int_equal( json_array_size( frames ), 1 );
    assert_true( number( json_array_get( frames, 0 ), "frame" ) == 1.0 );
    AUTO_IMAGE diff;
    assert_int_equal( rf_read_exr( cli_path( "d.exr" ), &diff, NULL ), RF_OK );
    assert_true( diff.rgb[0] == 0.25f && diff.rgb[3 * 1600 - 1] == 0.25f );
}

TEST( test_sequences_are_pooled )
{
    for ( int frame = 3; frame <= 5; ++frame )
    {
        char name[64];
        assert_int_equal( rf_sequence_name( "s.####.exr", frame, name, sizeof name, NULL ), RF_OK );
        write_constant( name, 20, (float)frame );
        assert_int_equal( rf_sequence_name( "t.####.exr", frame, name, sizeof name, NULL ), RF_OK );
        write_constant( name, 20, 3.0f );
    }
    assert_int_equal( compare( "s.####.exr", "t.####.exr", "--diff", cli_path( "d.##.exr" ), NULL ), 0 );
    json_t* json = load_json();
    const json_t* frames = json_object_get( json, "frames" );
    assert_int_equal( json_array_size( frames ), 3 );
    assert_true( number( json_array_get( frames, 2 ), "frame" ) == 5.0 );
    assert_true( number( json_array_get( frames, 2 ), "mse" ) == 4.0 );
    assert_true( number( json, "bias" ) == 1.0 && number( json, "max" ) == 2.0 );
    assert_true( fabs( number( json, "mse" ) - 5.0 / 3.0 ) < 1e-8 );
    json_decref( json );
    assert_true( cli_exists( "d.05.exr" ) );
    assert_int_equal( compare( "s.####.exr", "t.####.exr", "--diff", cli_path( "one.exr" ), NULL ), 2 );
    assert_int_equal( compare( "s.####.exr", "b.exr", NULL ), 2 );
    assert_int_equal( remove( cli_path( "t.0004.exr" ) ), 0 );
    assert_int_equal( compare( "s.####.exr", "t.####.exr", NULL ), 1 );
    assert_false( cli_exists( "out.json" ) );
}

TEST( test_pixels_not_finite_are_counted )
{
    write_constant( "nan.exr", 40, NAN );
    assert_int_equal( compare( "nan.exr", "b.exr", "--quiet", NULL ), 1 );
    json_t* json = load_json();
    assert_true( json_is_null( json_object_get( json, "relmse" ) ) );
    assert_true( number( json, "nan" ) == 1600.0 );
    json_decref( json );
    // of the reference they are counted too, over all frames
    assert_int_equal( compare( "b.exr", "nan.exr", NULL ), 1 );
    json = load_json();
    assert_true( number( json, "nan" ) == 0.0 && number( json, "reference_nan" ) == 1600.0 );
    assert_true( json_is_null( json_object_get( json, "mse" ) ) );
    json_decref( json );
    write_constant( "inf.exr", 40, INFINITY );
    assert_int_equal( compare( "inf.exr", "inf.exr", NULL ), 1 );
    json = load_json();
    assert_true( number( json, "inf" ) == 1600.0 && number( json, "reference_inf" ) == 1600.0 &&
                 number( json, "reference_nan" ) == 0.0 );
    json_decref( json );
}

TEST( test_what_differs_in_kind_is_refused )
{
    write_constant( "small.exr", 39, 1.0f );
    assert_int_equal( compare( "small.exr", "b.exr", NULL ), 1 );
    assert_int_equal( compare( "none.exr", "b.exr", NULL ), 1 );
    assert_int_equal( compare( "a.exr", "b.exr", "--what", NULL ), 2 );
    char* one[] = { "compare", "a.exr", NULL };
    assert_int_equal( rf_command_compare( 2, one ), 2 );
    char* help[] = { "compare", "--help", NULL };
    assert_int_equal( rf_command_compare( 2, help ), 0 );
}

static void write_foreign( const char* name, const Foreign* parts, int count )
{
    write_foreign_exr( cli_path( name ), parts, count );
}

static void check_number( const char* key, double wanted )
{
    json_auto_t* json = load_json();
    double value = number( json, key );
    if ( !( fabs( value - wanted ) <= 1e-8 * fabs( wanted ) ) )
        fail_msg( "%s: %.12g, not %.12g", key, value, wanted );
}

// Layers by name, half and float, several parts.
TEST( test_files_of_other_programs )
{
    Foreign blender = { .names = { "L.Combined.B", "L.Combined.G", "L.Combined.R", "L.Diff.B", "L.Diff.G", "L.Diff.R" },
                        .values = { 1, 1, 1, 3, 3, 3 },
                        .width = 20,
                        .height = 10 };
    Foreign nuke[3] = {
        { .names = { "Z" }, .values = { 7 }, .width = 20, .height = 10, .part = "depth" },
        { .names = { "A", "B", "G", "R" }, .values = { 1, 2, 2, 2 }, .width = 20, .height = 10, .half = true, .part = "rgba" },
        { .names = { "N.X", "N.Y", "N.Z", "X" }, .values = { 4, 5, 6, 9 }, .width = 20, .height = 10, .part = "N" }
    };
    write_foreign( "bl.exr", &blender, 1 );
    write_foreign( "nk.exr", nuke, 3 );
    check_done( compare( "bl.exr", "nk.exr", NULL ) ); // the colour of the second part
    check_number( "bias", -1.0 );
    check_done( compare( "bl.exr", "nk.exr", "--layer", "L.Diff", "--reference-layer", "rgba", NULL ) );
    check_number( "bias", 1.0 );
    check_done( compare( "bl.exr", "nk.exr", "--layer", "L.Diff.R", "--reference-layer", "Z", NULL ) );
    check_number( "bias", -4.0 );
    check_done( compare( "bl.exr", "nk.exr", "--layer", "L.Diff", "--reference-layer", "N", NULL ) );
    check_number( "mse", ( 1.0 + 4.0 + 9.0 ) / 3.0 );
    check_done( compare( "nk.exr", "nk.exr", "--layer", "N.Y,N.X,N.X", "--reference-layer", "X", NULL ) );
    check_number( "mse", ( 16.0 + 25.0 + 25.0 ) / 3.0 );
    check_done( compare( "bl.exr", "bl.exr", "--layer", "L.Diff", NULL ) ); // of both
    check_number( "max", 0.0 );
    check_number( "reference_mean", 3.0 );
    check_failed( compare( "bl.exr", "nk.exr", "--layer", "L.Diff", NULL ), 1,
                  "nk.exr: has no layer L.Diff; it has depth, alpha, N" );
    check_failed( compare( "bl.exr", "nk.exr", "--layer", "L.Diff.R,,L.Diff.G", NULL ), 1, "has no layer" );
    check_failed( compare( "bl.exr", "nk.exr", "--layer", "L.Diff.R,L.Diff.R,L.Diff.R,L.Diff.R", NULL ), 1, "has no layer" );
    // a pass has the same name whoever wrote the file
    Foreign ours = { .names = { "B", "G", "R", "light_key.B", "light_key.G", "light_key.R" },
                     .values = { 1, 1, 1, 2, 2, 2 },
                     .width = 20,
                     .height = 10 };
    Foreign theirs = { .names = { "L.Combined.B", "L.Combined.G", "L.Combined.R", "L.Combined_key.B", "L.Combined_key.G",
                                  "L.Combined_key.R" },
                       .values = { 1, 1, 1, 3, 3, 3 },
                       .width = 20,
                       .height = 10 };
    write_foreign( "us.exr", &ours, 1 );
    write_foreign( "th.exr", &theirs, 1 );
    check_done( compare( "us.exr", "th.exr", "--layer", "light_key", NULL ) );
    check_number( "bias", -1.0 );
    Foreign several = { .names = { "a.B", "a.G", "a.R", "b.B", "b.G", "b.R" }, .width = 20, .height = 10 };
    Foreign later[2] = { { .names = { "Z" }, .width = 20, .height = 10, .part = "depth" }, several };
    write_foreign( "se.exr", &several, 1 );
    write_foreign( "la.exr", later, 2 );
    check_failed( compare( "se.exr", "nk.exr", NULL ), 1,
                  "se.exr: has more than one layer of colour: a, b: name one by --layer" );
    check_failed( compare( "la.exr", "nk.exr", NULL ), 1,
                  "la.exr: has more than one layer of colour: a, b: name one by --layer" );
    Foreign none = { .names = { "foo" }, .width = 20, .height = 10 };
    write_foreign( "no.exr", &none, 1 );
    check_failed( compare( "no.exr", "nk.exr", NULL ), 1, "no.exr: has no channels R, G, B and no Y; it has foo" );
}

TEST( test_data_windows_must_agree_or_overlap )
{
    Foreign a = { .names = { "B", "G", "R" }, .values = { 1, 1, 1 }, .x = -5, .y = 3, .width = 20, .height = 10 };
    Foreign b = { .names = { "B", "G", "R" }, .values = { 3, 3, 3 }, .x = -5, .y = 3, .width = 20, .height = 10 };
    write_foreign( "wa.exr", &a, 1 );
    write_foreign( "wb.exr", &b, 1 );
    check_done( compare( "wa.exr", "wb.exr", NULL ) ); // the same, though not that of the display
    check_number( "bias", -2.0 );
    b.x = 0; // of the same size, elsewhere
    write_foreign( "wb.exr", &b, 1 );
    check_failed( compare( "wa.exr", "wb.exr", NULL ), 1, "the data windows differ" );
    check_done( compare( "wa.exr", "wb.exr", "--overlap", "--diff", cli_path( "w.exr" ), NULL ) );
    check_number( "bias", -2.0 );
    AUTO_IMAGE diff;
    assert_int_equal( rf_read_exr( cli_path( "w.exr" ), &diff, NULL ), RF_OK );
    assert_true( diff.width == 15 && diff.height == 10 && diff.rgb[0] == -2.0f );
    AUTO_BY( rf_destroy_exr_header ) RfExrHeader header;
    assert_int_equal( rf_read_exr_header( cli_path( "w.exr" ), NULL, &header, NULL ), RF_OK );
    assert_true( header.x == 0 && header.y == 3 && header.width == 15 && header.height == 10 ); // where the pixels were
    json_auto_t* json = load_json();
    const json_t* worst = json_object_get( json, "worst" );
    assert_true( number( worst, "x" ) == 0.0 && number( worst, "y" ) == 3.0 );
    b.width = 21;
    b.x = -5;
    write_foreign( "wb.exr", &b, 1 );
    check_failed( compare( "wa.exr", "wb.exr", NULL ), 1, "20x10 pixels" );
    b.x = 15; // beside it
    write_foreign( "wb.exr", &b, 1 );
    check_failed( compare( "wa.exr", "wb.exr", "--overlap", NULL ), 1, "no pixel in common" );
    // what is cropped is what lies there
    AUTO_IMAGE image, part;
    assert_int_equal( rf_create_image( 20, 10, &image, NULL ), RF_OK );
    assert_int_equal( rf_create_image( 8, 4, &part, NULL ), RF_OK );
    for ( int i = 0; i < 600; ++i )
        image.rgb[i] = (float)i;
    for ( int i = 0; i < 96; ++i )
        part.rgb[i] = (float)( i / 24 * 60 + i % 24 ); // the corner from (0, 0) on
    RfExrOptions options = rf_default_exr_options();
    options.half = false;
    assert_int_equal( rf_write_exr( cli_path( "wa.exr" ), &image, &options, NULL ), RF_OK );
    assert_int_equal( rf_write_exr( cli_path( "wb.exr" ), &part, &options, NULL ), RF_OK );
    check_done( compare( "wa.exr", "wb.exr", "--overlap", NULL ) );
    check_number( "max", 0.0 );
}

TEST( test_only_chosen_frames_are_wanted )
{
    for ( int frame = 1; frame <= 4; ++frame )
    {
        char name[64];
        snprintf( name, sizeof name, "ca.%d.exr", frame );
        write_constant( name, 20, (float)frame );
        snprintf( name, sizeof name, "cb.%d.exr", frame );
        if ( frame != 2 )
            write_constant( name, 20, 1.0f );
    }
    check_failed( compare( "ca.#.exr", "cb.#.exr", NULL ), 1, "frame 2 is in" );
    check_done( compare( "ca.#.exr", "cb.#.exr", "--frames", "3-4", NULL ) );
    check_number( "bias", 2.5 );
    json_auto_t* json = load_json();
    assert_true( number( json_object_get( json, "worst" ), "frame" ) == 4.0 );
    assert_non_null( strstr( json_string_value( json_object_get( json, "verdict" ) ), "in frame 4" ) );
    check_failed( compare( "ca.#.exr", "cb.#.exr", "--frames", "1-3", NULL ), 1, "frame 2 is missing" );
    check_failed( compare( "ca.#.exr", "cb.#.exr", "--frames", "9", NULL ), 2, "--frames" );
    check_failed( compare( "ca.1.exr", "cb.1.exr", "--frames", "1", NULL ), 2, "--frames" );
    // the images themselves stay
    check_failed( compare( "ca.1.exr", "cb.1.exr", "--diff", cli_path( "ca.1.exr" ), NULL ), 2, "would overwrite an input" );
    check_failed( compare( "ca.#.exr", "cb.#.exr", "--frames", "3-4", "--diff", cli_path( "cb.#.exr" ), NULL ), 2,
                  "would overwrite an input" );
    check_failed( compare( "ca.1.exr", "cb.1.exr", "--diff", cli_path( "ca.#.exr" ), NULL ), 2, "would overwrite an input" );
    // the difference of frame 1 is frame 11
    write_constant( "ca.11.exr", 20, 1.0f );
    write_constant( "cb.11.exr", 20, 1.0f );
    check_failed( compare( "ca.#.exr", "cb.#.exr", "--frames", "1,11", "--diff", cli_path( "ca.1#.exr" ), NULL ), 2,
                  "is one of the images" );
    check_done( compare( "ca.1.exr", "cb.1.exr", NULL ) );
}

// The same holes in both sequences are reported; what steps regularly has none.
TEST( test_missing_in_both )
{
    static const int frames[] = { 1, 2, 5, 6, 10 };
    for ( int i = 0; i < 5; ++i )
    {
        char name[64];
        snprintf( name, sizeof name, "ma.%d.exr", frames[i] );
        write_constant( name, 20, 1.0f );
        snprintf( name, sizeof name, "mb.%d.exr", 2 * frames[i] );
        write_constant( name, 20, 1.0f );
    }
    for ( int k = 0; k < 2; ++k )
    {
        const char* sequence = k == 0 ? "ma.#.exr" : "mb.#.exr";
        check_done( compare( sequence, sequence, NULL ) );
        json_t* json = load_json();
        const json_t* missing = json_object_get( json, "missing" );
        assert_int_equal( json_array_size( missing ), 5 ); // 3 4 7 8 9, and twice as much
        assert_int_equal( json_integer_value( json_array_get( missing, 4 ) ), k == 0 ? 9 : 18 );
        json_decref( json );
        check_done( compare( sequence, sequence, "--frames", "2-10x8", NULL ) ); // as asked
        json = load_json();
        assert_int_equal( json_array_size( json_object_get( json, "missing" ) ), 0 );
        json_decref( json );
    }
    int some[] = { 3, 4, 7, 8, 9, 100000, 1000000 };
    char text[32];
    rf_format_frames( some, 6, text, sizeof text );
    assert_string_equal( text, "3, 4, 7-9, 100000" );
    rf_format_frames( some, 7, text, 22 );
    assert_string_equal( text, "3, 4, 7-9, ..." );
    rf_format_frames( NULL, 0, text, sizeof text );
    assert_string_equal( text, "" );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
