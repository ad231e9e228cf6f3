// info and render of scenes without emissive triangles: punctual lights only, an
// environment only, no light at all.
#include "support/cli_run.h"
#include "support/test.h"

// A floor of one triangle under a camera.
#define GLTF( more, node )                                                                                                       \
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]" more "}],"                                     \
    "\"nodes\":[{\"mesh\":0},{\"camera\":0,\"translation\":[0,2,0],\"rotation\":[-0.70710678,0,0,0.70710678]},{\"translation\":" \
    "[0,1,0]" node "}],"                                                                                                         \
    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.5,\"znear\":0.1}}],"                                     \
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}],"                                                         \
    "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/"                                                                \
    "octet-stream;base64,AAAgwQAAAAAAACBBAAAgQQAAAAAAACBBAAAAAAAAAAAAACDB\"}],"                                                  \
    "\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"                                                                        \
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[-10,0,-10],\"max\":[10,0,"   \
    "10]}]"

static void check( const char* name, const char* text, const char* lights, const char* warning )
{
    cli_write( name, text, strlen( text ) );
    const CliResult* info = cli_run( "$R info %s", name );
    assert_int_equal( info->status, 0 );
    if ( strstr( info->out, lights ) == NULL )
        fail_msg( "'%s' does not say '%s'", info->out, lights );
    const CliResult* render = cli_run( "$R render %s -o %s.exr --size 8x8 --spp 2 --quiet --overwrite", name, name );
    assert_int_equal( render->status, 0 );
    if ( warning == NULL )
        assert_string_equal( render->err, "" );
    else
        assert_non_null( strstr( render->err, warning ) );
}

TEST( test_lamps_sky_and_darkness_are_reported )
{
    cli_enter();
    check( "lamp.gltf",
           GLTF( "", ",\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}" ) ",\"extensions\":{\"KHR_lights_punctual\":{"
                                                                                 "\"lights\":[{\"type\":\"point\"}]}}}",
           "lights     1 (emissive triangles 0, 0 m2; punctual lights 1; sky no)", NULL );
    check( "sky.gltf", GLTF( ",\"extras\":{\"reframe\":{\"environment\":{\"radiance\":[1,1,1]}}}", "" ) "}",
           "lights     1 (emissive triangles 0, 0 m2; punctual lights 0; sky yes)", NULL );
    check( "dark.gltf", GLTF( "", "" ) "}", "lights     0\n", "no lights" );
    check(
        "off.gltf",
        GLTF( "", ",\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}" ) ",\"extensions\":{\"KHR_lights_punctual\":{"
                                                                              "\"lights\":[{\"type\":\"point\",\"name\":\"bulb\","
                                                                              "\"intensity\":0}]}}}",
        "lights     0\n", "none of its lamps has any power ('bulb' is one of 1)" );
    cli_leave();
}
