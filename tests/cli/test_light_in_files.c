// The light that files can hold: values beyond the range of half floats are counted and reported.
#include "support/cli_run.h"
#include "support/scene_files.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#include "image/exr.h"

#define SMALL "--size 24x18 --spp 8 --group 0 --quiet"

static void expect_header( const char* name, const char* key, const char* wanted )
{
    char path[512], text[256] = "";
    snprintf( path, sizeof path, "%s/%s", cli_folder(), name );
    rf_read_exr_string( path, key, text, sizeof text, NULL );
    assert_string_equal( text, wanted );
}

// A render whose sky is beyond half floats in red, and of which pixels it says so.
static json_int_t clipped_pixels( const char* options, const char* wanted )
{
    const CliResult* result = cli_run( "$R render bright.json -o h.####.exr --overwrite " SMALL " --json h.json %s", options );
    cli_expect( result, 0, wanted );
    json_t* json = cli_read_json( "h.json" );
    json_int_t pixels = json_integer_value( json_object_get( json, "clipped_pixels" ) );
    const json_t* frame = json_array_get( json_object_get( json, "frames" ), 0 );
    assert_int_equal( json_integer_value( json_object_get( frame, "clipped_pixels" ) ), pixels );
    assert_int_equal( json_array_size( json_object_get( json, "warnings" ) ), wanted != NULL );
    json_decref( json );
    return pixels;
}

static void test_clipped_pixels_are_named( void** state )
{
    (void)state;
    write_room( "" ); // a triangle
    write_text( "bright.json", "{\"scene\":\"room.gltf\",\"environment\":{\"radiance\":[2e5,20000,1],\"light_group\":\"sky\"}}" );
    const char* half = "beyond the range of half floats (65504) and clipped there, in colour, light_sky: give --float";
    json_int_t pixels = clipped_pixels( "--light-groups all", half );
    char text[32];
    snprintf( text, sizeof text, "%lld", (long long)pixels );
    assert_true( pixels > 200 && pixels <= 24 * 18 );
    expect_header( "h.0001.exr", "reframe/clipped-pixels", text );
    expect_header( "h.0001.exr", "reframe/clipped-layers", "colour,light_sky" );
    assert_int_equal( clipped_pixels( "--light-groups all --resume", half ), pixels ); // kept
    // no verdict on the bias of what is not there
    assert_int_equal( clipped_pixels( "--light-groups all --float", NULL ), 0 );
    expect_header( "h.0001.exr", "reframe/clipped-pixels", "" );
    cli_expect( cli_run( "mv h.0001.exr f.exr" ), 0, NULL );
    clipped_pixels( "--light-groups all", half );
    const char* const layers[] = { "", "--layer light_sky" };
    for ( int i = 0; i < 2; ++i )
    {
        const CliResult* compared = cli_run( "$R compare f.exr h.0001.exr %s", layers[i] );
        assert_non_null( strstr( compared->out, "no verdict on bias, clipped pixels are compared (0 of A, " ) );
    }
    cli_expect( cli_run( "rm h.json && $R report h.####.exr -o page.html" ), 0, NULL );
    size_t size;
    char* page = cli_read( "page.html", &size );
    assert_non_null( strstr( page, "clipped by the range of the file" ) );
    free( page );
    // DWA ends sooner, and only the header tells
    if ( rf_has_dwa() )
    {
        assert_true( clipped_pixels( "--compression dwaa", "give --compression zip and --float" ) >= pixels );
        const CliResult* compared = cli_run( "$R compare f.exr h.0001.exr" );
        assert_non_null( strstr( compared->out, "no verdict on bias" ) );
    }
    // within the range
    write_text( "bright.json", "{\"scene\":\"room.gltf\",\"environment\":{\"radiance\":[65000,1,1]}}" );
    assert_int_equal( clipped_pixels( "--spp 1", NULL ), 0 );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_clipped_pixels_are_named ),
    };
    return cmocka_run_group_tests( tests, cli_enter_group, cli_leave_group );
}
