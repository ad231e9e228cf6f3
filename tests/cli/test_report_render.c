// What reframe report shows of a render: samples traced, bounds of the error, frames that were kept.
#include "support/cli_run.h"
#include "support/frame_files.h"
#include "support/test.h"

#define SMALL "--size 48x32 --spp 3 --group 1 --quiet "

static const char* samples_of( const char* folder )
{
    static char text[128];
    cli_expect( cli_run( "$R report %s -o n.html --overwrite", folder ), 0, NULL );
    size_t size;
    AUTO_FREE char* page = cli_read( "n.html", &size ); // as many pictures as frames
    json_auto_t* data = page_read_data( "n.html", page_count( page, "<script type=\"text/plain\" id=\"s" ) );
    const char* said = page_fact( page_sequence( data, 0 ), "Cost", "Samples a pixel" );
    snprintf( text, sizeof text, "%s", said != NULL ? said : "" );
    return text;
}

// Those traced, from the frames.
TEST( test_traced_samples )
{
    RfExrString said[] = { { "reframe/spp", "28" }, { "reframe/native-spp", "27.5" }, { "reframe/adaptive", "yes" } };
    page_make_folder( "n" );
    page_write_frame( "n/f1.exr", 20, 20, 1.0f, said, 1 );
    assert_string_equal( samples_of( "n" ), "" ); // of a version that did not count
    page_write_frame( "n/f1.exr", 20, 20, 1.0f, said, 3 );
    assert_string_equal( samples_of( "n" ), "27.5" );
    json_auto_t* data = page_read_data( "n.html", 1 );
    assert_string_equal( page_fact( page_sequence( data, 0 ), "Settings", "spp" ), "28" );
    assert_string_equal( page_fact( page_sequence( data, 0 ), "Settings", "adaptive" ), "yes" );
    said[1].value = "40";
    page_write_frame( "n/f2.exr", 20, 20, 1.0f, said, 2 );
    page_write_frame( "n/f3.exr", 20, 20, 1.0f, NULL, 0 );
    assert_string_equal( samples_of( "n" ), "27.5 to 40" );
}

#define KEPT_JSON                                                                                                                \
    "{\"frames\":[{\"frame\":1,\"seconds\":null,\"native_spp\":2,\"relmse_estimate\":0.5,\"kept\":true},"                        \
    "{\"frame\":2,\"seconds\":3,\"native_spp\":4,\"effective_spp\":6,\"relmse_estimate\":0.25,\"kept\":false}],\"seconds\":6,"   \
    "\"peak_bytes\":0,"                                                                                                          \
    "\"rays\":{\"eye\":6},"                                                                                                      \
    "\"kept_frames\":1,\"interrupted\":false}"

// Frames that were kept have their figures, but no seconds.
TEST( test_kept_frames )
{
    page_make_folder( "t" );
    page_write_frames( "t/f.####.exr", 1, 2, 1.0f, 0.0f );
    const RfExrString old = { "reframe/seconds", "77" };
    page_write_frame( "t/f.0001.exr", 40, 30, 1.0f, &old, 1 );
    cli_write( "t/r.json", KEPT_JSON, strlen( KEPT_JSON ) );
    cli_expect( cli_run( "$R report t -o t.html --overwrite" ), 0, NULL );
    json_auto_t* data = page_read_data( "t.html", 2 );
    const json_t* sequence = page_sequence( data, 0 );
    assert_string_equal( page_fact( sequence, "Cost", "Time" ), "6 s" );
    assert_string_equal( page_fact( sequence, "Cost", "Samples a pixel" ), "2 to 4" );
    assert_string_equal( page_fact( sequence, "Cost", "Effective samples a pixel" ), "6" );
    page_check_item( sequence, "relmse", 0, 0.5 );
    assert_true( json_is_null( page_item( sequence, "seconds", 0 ) ) ); // no times in headers
    page_check_item( sequence, "seconds", 1, 3.0 );
}

// What render leaves.
TEST( test_render_output_as_it_is )
{
    cli_expect( cli_run( "$R render $VASE -o v/f.####.exr --frames 1-3 --json v/render.json " SMALL "&& "
                         "$R render $VASE -o v/f.####.exr --frames 1-4 --resume --json v/render.json " SMALL
                         "&& $R report v -o v.html" ),
                0, NULL );
    json_auto_t* data = page_read_data( "v.html", 4 );
    for ( size_t i = 0; i < 4; ++i )
        assert_true( json_is_number( page_item( page_sequence( data, 0 ), "seconds", i ) ) &&
                     json_is_number( page_item( page_sequence( data, 0 ), "relmse", i ) ) );
    assert_true( atof( samples_of( "v" ) ) >= 2.0 );
}

// Lower bounds of the error, by the JSON or by the header.
TEST( test_lower_bounds_are_marked )
{
    static const char json[] = "{\"frames\":[{\"frame\":1,\"seconds\":2,\"relmse_estimate\":0.01},{\"frame\":2,\"seconds\":2,"
                               "\"relmse_estimate\":0.03,\"relmse_is_lower_bound\":true}],\"seconds\":9,\"rays\":{}}";
    const RfExrString strings[] = { { "reframe/relmse-estimate", "0.02" }, { "reframe/relmse-is-lower-bound", "yes" } };
    page_make_folder( "tail" );
    page_write_frames( "tail/f.####.exr", 1, 2, 1.0f, 0.0f );
    cli_write( "tail/render.json", json, strlen( json ) );
    page_make_folder( "head" );
    page_write_frame( "head/f.exr", 20, 20, 1.0f, strings, 2 );
    cli_expect( cli_run( "$R report tail head -o b.html" ), 0, NULL );
    json_t* data = page_read_data( "b.html", 3 );
    const json_t* sequence = page_sequence( data, 0 );
    assert_true( json_is_false( page_item( sequence, "at_least", 0 ) ) && json_is_true( page_item( sequence, "at_least", 1 ) ) );
    for ( size_t i = 0; i < 2; ++i )
        assert_string_equal( page_fact( page_sequence( data, i ), "Error", "relMSE" ), "at least 0.02, 8.2 % noise, estimated" );
    json_decref( data );
    // against a reference the error is known
    cli_expect( cli_run( "$R report tail --reference tail -o b.html --overwrite" ), 0, NULL );
    data = page_read_data( "b.html", 4 );
    assert_true( json_is_false( page_item( page_sequence( data, 0 ), "at_least", 1 ) ) );
    json_decref( data );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
