// The light in files: values beyond the range of half floats are counted and reported, and other primaries converted both ways.
#include "support/cli_run.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "image/exr.h"

#define SMALL "--size 24x18 --spp 8 --group 0 --quiet"

// A render whose sky is beyond half floats in red, and of which pixels it says so.
static json_int_t clipped_pixels( const char* options, const char* wanted )
{
    const CliResult* result = cli_run( "$R render bright.json -o h.####.exr --overwrite " SMALL " --json h.json %s", options );
    cli_expect( result, 0, wanted );
    json_auto_t* json = cli_read_json( "h.json" );
    json_int_t pixels = json_integer_value( json_object_get( json, "clipped_pixels" ) );
    const json_t* frame = json_array_get( json_object_get( json, "frames" ), 0 );
    assert_int_equal( json_integer_value( json_object_get( frame, "clipped_pixels" ) ), pixels );
    assert_int_equal( json_array_size( json_object_get( json, "warnings" ) ), wanted != NULL );
    return pixels;
}

TEST( test_clipped_pixels_are_named )
{
    write_room( "" ); // a triangle
    write_text( "bright.json", "{\"scene\":\"room.gltf\",\"environment\":{\"radiance\":[2e5,20000,1],\"light_group\":\"sky\"}}" );
    const char* half = "beyond the range of half floats (65504) and clipped there, in colour, light_sky: give --float";
    json_int_t pixels = clipped_pixels( "--light-groups all", half );
    char text[32];
    snprintf( text, sizeof text, "%lld", (long long)pixels );
    assert_true( pixels > 200 && pixels <= 24 * 18 );
    cli_expect_exr_text( "h.0001.exr", "reframe/clipped-pixels", text );
    cli_expect_exr_text( "h.0001.exr", "reframe/clipped-layers", "colour,light_sky" );
    assert_int_equal( clipped_pixels( "--light-groups all --resume", half ), pixels ); // kept
    // no verdict on the bias of what is not there
    assert_int_equal( clipped_pixels( "--light-groups all --float", NULL ), 0 );
    cli_expect_exr_text( "h.0001.exr", "reframe/clipped-pixels", NULL );
    cli_expect( cli_run( "mv h.0001.exr f.exr" ), 0, NULL );
    clipped_pixels( "--light-groups all", half );
    const char* const layers[] = { "", "--layer light_sky" };
    for ( int i = 0; i < 2; ++i )
    {
        const CliResult* compared = cli_run( "$R compare f.exr h.0001.exr %s", layers[i] );
        assert_non_null( strstr( compared->out, "no verdict on bias, clipped pixels are compared (0 of A, " ) );
    }
    // DWA ends sooner, and only the header tells
    if ( rf_has_dwa() )
    {
        assert_true( clipped_pixels( "--compression dwaa", "give --compression zip and --float" ) >= pixels );
        const CliResult* compared = cli_run( "$R compare f.exr h.0001.exr" );
        assert_non_null( strstr( compared->out, "no verdict on bias" ) );
    }
    // within the range
    write_text( "bright.json", "{\"scene\":\"room.gltf\",\"environment\":{\"radiance\":[65000,1,1]}}" );
    assert_int_equal( clipped_pixels( "", NULL ), 0 );
}

// An EXR of the same light in a colour space.
static void write_sky( const char* name, RfColourSpace space, const float rgb[3] )
{
    float pixels[3 * 8];
    for ( int i = 0; i < 24; ++i )
        pixels[i] = rgb[i % 3] * (float)( 1 + i / 12 );
    RfExrOptions options = rf_default_exr_options();
    options.half = false;
    options.colour_space = space;
    assert_int_equal( rf_write_exr( cli_path( name ), &( RfImage ){ .width = 4, .height = 2, .rgb = pixels }, &options, NULL ),
                      RF_OK );
    char json[256];
    snprintf( json, sizeof json, "{\"scene\":\"room.gltf\",\"environment\":{\"map\":\"%s\"}}", name );
    write_text( "sky.json", json );
}

// The most that two files differ by, of their mean.
static double difference( const char* a, const char* b, const char* layer )
{
    const CliResult* result = cli_run( "$R compare %s %s --json - %s %s", a, b, layer[0] != '\0' ? "--layer" : "", layer );
    cli_expect( result, 0, NULL );
    json_auto_t* json = json_loads( result->out, 0, NULL );
    double most = number( json, "max" ) / number( json, "reference_mean" );
    return most;
}

TEST( test_a_sky_in_acescg_lights_as_in_rec709 )
{
    const float rgb[3] = { 0.9f, 0.4f, 0.1f };
    write_room( "" );
    write_sky( "s.exr", RF_REC709, rgb );
    cli_expect( cli_run( "$R render sky.json -o s709.exr --float " SMALL ), 0, NULL );
    write_sky( "s.exr", RF_ACESCG, rgb );
    cli_expect( cli_run( "$R render sky.json -o scg.exr --float " SMALL ), 0, NULL );
    assert_true( difference( "scg.exr", "s709.exr", "" ) < 1e-5 );
    // light beyond Rec. 709 is no light here
    write_sky( "s.exr", RF_ACESCG, ( float[3] ){ -0.05f, 1.0f, 0.0f } );
    cli_expect( cli_run( "$R render sky.json -o scg.exr --overwrite " SMALL ), 0,
                "the environment has colours outside Rec. 709, which are clipped: 4.8 % of its light" );
}

TEST( test_frames_in_acescg )
{
    static const char* const layers[] = { "", "albedo", "variance", "direct", "emission", "light_sky", "normal" };
    const char* options = SMALL " --aov albedo,variance,normal,direct,emission --light-groups all --cryptomatte object";
    write_room( "" );
    write_text( "sky.json", "{\"scene\":\"room.gltf\",\"environment\":{\"radiance\":[0.9,0.4,0.1],\"light_group\":\"sky\"}}" );
    cli_expect( cli_run( "$R render sky.json -o r.exr %s", options ), 0, NULL );
    cli_expect( cli_run( "$R render sky.json -o a.exr --colorspace acescg --json a.json %s", options ), 0, NULL );
    cli_expect_exr_text( "a.exr", "reframe/colorspace", "acescg" );
    cli_expect_exr_text( "r.exr", "reframe/colorspace", NULL );
    for ( size_t i = 0; i < sizeof layers / sizeof layers[0]; ++i )
        assert_true( difference( "a.exr", "r.exr", layers[i] ) < 4e-3 ); // both are halves
    json_t* json = cli_read_json( "a.json" );
    assert_string_equal( json_string_value( json_object_get( json, "colorspace" ) ), "acescg" );
    json_decref( json );
    // another sequence than that in Rec. 709, which a scene file may ask for
    cli_expect( cli_run( "$R render sky.json -o a.exr --resume %s", options ), 1, "--colorspace acescg (here rec709)" );
    cli_expect( cli_run( "$R render sky.json -o a.exr --resume --colorspace acescg %s", options ), 0, NULL );
    write_text( "asks.json",
                "{\"scene\":\"room.gltf\",\"environment\":{\"radiance\":[1,1,1]},\"render\":{\"colorspace\":\"acescg\"}}" );
    cli_expect( cli_run( "$R render asks.json -o b.exr " SMALL ), 0, NULL );
    cli_expect_exr_text( "b.exr", "reframe/colorspace", "acescg" );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
