// What reframe report says in words: the verdict, and warnings.
#include "support/cli_run.h"
#include "support/frame_files.h"
#include "support/test.h"

#include <jansson.h>

// Two frames, and the JSON of a render that took `seconds` for each.
static void write_render( const char* folder, int threads, double seconds, double first, double second, const char* more )
{
    char name[256], text[1024];
    page_make_folder( folder );
    snprintf( name, sizeof name, "%s/f.####.exr", folder );
    page_write_frames( name, 1, 2, 1.0f, 0.0f );
    int length =
        snprintf( text, sizeof text,
                  "{\"frames\":[{\"frame\":1,\"seconds\":%g,\"relmse_estimate\":%g},{\"frame\":2,\"seconds\":%g,"
                  "\"relmse_estimate\":%g%s}],\"seconds\":9,\"threads\":%d,\"rays\":{},\"scene\":\"in/a.glb\",\"warnings\":["
                  "\"in/a.glb: material red: sheen is not supported\"]}",
                  seconds, first, seconds, second, more, threads );
    snprintf( name, sizeof name, "%s/render.json", folder );
    cli_write( name, text, (size_t)length );
}

static json_t* report( const char* what, int blocks )
{
    cli_expect( cli_run( "$R report %s -o v.html --overwrite --quiet", what ), 0, NULL );
    return page_read_data( "v.html", blocks );
}

static void expect_verdict( const json_t* data, const char* text, int worst, const char* basis )
{
    const json_t* verdict = json_object_get( data, "verdict" );
    assert_string_equal( json_string_value( json_object_get( verdict, "text" ) ), text );
    assert_int_equal( json_integer_value( json_object_get( verdict, "worst_frame" ) ), worst );
    if ( strstr( json_string_value( json_object_get( verdict, "basis" ) ), basis ) == NULL )
        fail_msg( "'%s' has no '%s'", json_string_value( json_object_get( verdict, "basis" ) ), basis );
}

TEST( test_verdict_compares_at_equal_noise )
{
    write_render( "slow", 2, 4.0, 0.03, 0.05, "" ); // relMSE 0.04, 4 s
    write_render( "fast", 2, 2.0, 0.01, 0.03, "" ); // relMSE 0.02, 2 s
    json_t* data = report( "slow fast", 4 );
    expect_verdict( data, "fast is 4 times faster than slow at equal noise", 2, "2 threads each" );
    json_decref( data );
    write_render( "many", 8, 2.0, 0.01, 0.03, "" );
    data = report( "slow many", 4 );
    expect_verdict( data, "slow has 2 times the relMSE of many", 2, "times are not compared" );
    json_decref( data );
    // the first frame stands for more: that took no time, but counts
    write_render( "still", 2, 0.0, 0.01, 0.03, "" );
    assert_int_equal( cli_run( "sed -i 's/\"seconds\":0/\"seconds\":4/' still/render.json" )->status, 0 );
    data = report( "slow still", 4 ); // 0.04 · 8 s against 0.02 · 4 s
    expect_verdict( data, "still is 4 times faster than slow at equal noise", 2, "mean of 2 frames" );
    json_decref( data );
    data = report( "fast", 2 );
    expect_verdict( data, "About 8.2 % noise (relMSE 0.02)", 2, "mean of 2 frames" );
    json_decref( data );
    data = report( "slow/f.0001.exr --render-json slow/render.json", 1 );
    assert_true( json_is_null( json_object_get( json_object_get( data, "verdict" ), "worst_frame" ) ) );
    json_decref( data );
    page_make_folder( "none" );
    page_write_frames( "none/f.####.exr", 1, 2, 1.0f, 0.0f );
    data = report( "none", 2 );
    expect_verdict( data, "The error is unknown", 0, "--reference measures it" );
    json_decref( data );
}

#define SPECKS( pixels, share, rest )                                                                                            \
    "\"relmse_likely\":2,\"specks\":{\"pixels\":" pixels ",\"share\":" share ",\"rest_relmse\":" rest                            \
    ",\"materials\":[{\"material\":\"steel\",\"kind\":\"glint\",\"pixels\":" pixels ",\"share\":" share "},"                     \
    "{\"material\":7,\"kind\":\"none such\"},{}]}"

// Where the error is in few pixels, that is the verdict; a reference knows better.
TEST( test_specks_are_the_verdict )
{
    write_render( "specks", 2, 2.0, 0.01, 0.03, "," SPECKS( "7", "0.9", "0.03" ) );
    json_t* data = report( "specks", 2 );
    expect_verdict( data,
                    "7 specks hold 90 % of the error, mostly on 'steel' (glints); the rest has about 10 % noise (relMSE 0.03)", 2,
                    "estimated" );
    assert_string_equal( page_fact( page_sequence( data, 0 ), "Error", "relMSE" ), "0.02, 8.2 % noise, estimated" );
    json_decref( data );
    data = report( "specks --reference specks", 4 );
    assert_null( strstr( json_string_value( json_object_get( json_object_get( data, "verdict" ), "text" ) ), "specks" ) );
    json_decref( data );
    write_render( "specks", 2, 2.0, 0.01, 0.03, "," SPECKS( "\"x\"", "[]", "0.03" ) );
    data = report( "specks", 2 );
    expect_verdict( data, "About 8.2 % noise (relMSE 0.02)", 2, "estimated" );
    json_decref( data );
}

TEST( test_lower_bounds_and_warnings_are_reported )
{
    write_render( "tail", 2, 2.0, 0.01, 0.03, ",\"relmse_is_lower_bound\":true,\"worst_ten_share\":0.6" );
    json_t* data = report( "tail", 2 );
    expect_verdict( data, "At least 8.2 % noise (relMSE 0.02)", 2, "1 estimate is a lower bound" );
    const json_t *warnings = json_object_get( data, "warnings" ), *sequence = page_sequence( data, 0 );
    assert_int_equal( json_array_size( warnings ), 2 );
    assert_string_equal( json_string_value( json_object_get( json_array_get( warnings, 0 ), "text" ) ),
                         "in/a.glb: material red: sheen is not supported" );
    assert_non_null(
        strstr( json_string_value( json_object_get( json_array_get( warnings, 1 ), "text" ) ), "the ten worst up to 60 %" ) );
    assert_true( json_is_false( page_item( sequence, "at_least", 0 ) ) && json_is_true( page_item( sequence, "at_least", 1 ) ) );
    assert_string_equal( page_fact( sequence, "Error", "relMSE" ), "at least 0.02, 8.2 % noise, estimated" );
    json_decref( data );
    // the other way round: what is a bound of one is the other of the ratio
    write_render( "slow", 2, 4.0, 0.03, 0.05, "" );
    data = report( "slow tail", 4 );
    expect_verdict( data, "tail is at most 4 times faster than slow at equal noise", 2, "1 estimate is a lower bound" );
    json_decref( data );
    // of the header where there is no JSON
    const RfExrString strings[] = { { "reframe/relmse-estimate", "0.02" },
                                    { "reframe/relmse-is-lower-bound", "yes" },
                                    { "reframe/worst-ten-share", "0.4" } };
    page_make_folder( "head" );
    page_write_frame( "head/f.exr", 20, 20, 1.0f, strings, 3 );
    data = report( "head", 1 );
    warnings = json_object_get( data, "warnings" );
    assert_non_null(
        strstr( json_string_value( json_object_get( json_array_get( warnings, 0 ), "text" ) ), "the ten worst up to 40 %" ) );
    assert_string_equal( page_fact( page_sequence( data, 0 ), "Error", "relMSE" ), "at least 0.02, 8.2 % noise, estimated" );
    json_decref( data );
    // against a reference the error is known
    data = report( "tail --reference tail", 4 );
    assert_true( json_is_false( page_item( page_sequence( data, 0 ), "at_least", 1 ) ) );
    json_decref( data );
}

// `render` writes what the page reads.
TEST( test_render_writes_what_is_read )
{
    cli_expect( cli_run( "$R render $VASE -o k/f.##.exr --frames 1-2 --size 24x16 --spp 2 --group 0 --aov variance --quiet "
                         "--json k/r.json" ),
                0, NULL );
    json_auto_t* data = report( "k", 2 );
    const json_t* warnings = json_object_get( data, "warnings" );
    assert_true( json_is_array( warnings ) );
    size_t size;
    AUTO_FREE char* text = cli_read( "k/r.json", &size );
    assert_non_null( strstr( text, "\"warnings\": [" ) );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
