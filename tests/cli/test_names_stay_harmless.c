// Control characters in the names of files and objects reach no terminal: text has them as \x1b,
// JSON as escapes.
#include "support/cli_run.h"
#include "support/test.h"

#include "base/plain_text.h"

// A camera, a material and a lamp whose names clear the screen, and a triangle.
static const char s_scene[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"extensionsUsed\":[\"KHR_lights_punctual\"],"
    "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\",\"name\":\"lamp\\u001b[2J\"}]}},"
    "\"scenes\":[{\"nodes\":[0,1,2]}],"
    "\"nodes\":[{\"name\":\"eye\\u001B[2J\\nlights     7\\u009b5m\",\"camera\":0},{\"name\":\"thing\",\"mesh\":0},"
    "{\"name\":\"lamp\\u001b]0;x\\u0007\",\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}],"
    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1}}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":0}]}],"
    "\"materials\":[{\"name\":\"skin\\u001b[31m\",\"emissiveFactor\":[1,1,1]}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\",\"min\":[-1,-1,-2],"
    "\"max\":[1,1,-2]}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
    "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
    "AACAvwAAgL8AAADAAACAPwAAgL8AAADAAAAAAAAAgD8AAADA\"}]}";

// What a terminal would obey: control characters but for newlines, also as UTF-8.
static void expect_harmless( const char* text )
{
    for ( const unsigned char* c = (const unsigned char*)text; *c != '\0'; ++c )
    {
        if ( ( *c < 0x20 && *c != '\n' ) || *c == 0x7f || ( c[0] == 0xc2 && c[1] >= 0x80 && c[1] < 0xa0 ) )
            fail_msg( "the character %d is in: %s", *c, text );
    }
}

TEST( test_plain_text )
{
    char plain[64];
    assert_string_equal( rf_plain_text( "a\x1b[2J\n\t\r\x7f", plain, sizeof plain ), "a\\x1b[2J\\n\\t\\x0d\\x7f" );
    assert_string_equal( rf_plain_text( "\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8e\xa5", plain, sizeof plain ),
                         "\xc3\xa9 \xe2\x82\xac \xf0\x9f\x8e\xa5" );
    assert_string_equal( rf_plain_text( "\xc2\x9b"
                                        "5m \x9b"
                                        "5m \xe9",
                                        plain, sizeof plain ),
                         "\\x9b5m \\x9b5m \xe9" );
    assert_string_equal( rf_plain_text( "abc\x1b", plain, 7 ), "abc" ); // no half of an escape
    assert_string_equal( rf_plain_text( "abc\xe2\x82\xac", plain, 6 ), "abc" );
    assert_string_equal( rf_plain_text( "abc\xe2\x82\xac", plain, 7 ), "abc\xe2\x82\xac" );
}

TEST( test_names_of_objects )
{
    cli_write( "scene.gltf", s_scene, strlen( s_scene ) );
    const CliResult* result = cli_run( "$R info scene.gltf" );
    cli_expect( result, 0, NULL );
    expect_harmless( result->out );
    assert_non_null( strstr( result->out, "  eye\\x1b[2J\\nlights     7\\x9b5m: 1 frame" ) );
    assert_non_null( strstr( result->out, "material 'skin\\x1b[31m'" ) );
    assert_non_null( strstr( result->out, "light 'lamp\\x1b" ) );
    result = cli_run( "$R info scene.gltf --json -" );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->out, "eye\\u001B[2J\\nlights" ) );
    result = cli_run( "python3 -c 'import os, pty; pty.spawn([os.environ[\"R\"], \"info\", \"scene.gltf\", \"--json\", \"-\"])' "
                      "| tr -d '\\r'" ); // on a terminal
    expect_harmless( result->out );
    assert_non_null( strstr( result->out, "7\\u009B5m" ) );
    result = cli_run( "$R tune scene.gltf --camera nobody --size 8x8" ); // the error lists the cameras
    assert_true( result->status != 0 );
    expect_harmless( result->err );
}

TEST( test_names_of_files )
{
    cli_write( "s\x1b[1m.gltf", s_scene, strlen( s_scene ) );
    static const char* const commands[] = {
        "$R info s?*1m.gltf",
        "$R render s?*1m.gltf -o \"$(printf 'o\\033[1m.exr')\" --size 8x8 --spp 1",
        "$R compare o*.exr o*.exr",
        "$R tune s?*1m.gltf --size 8x8 --spp 1 --max-depth 2 --budget 1",
        "$R report o*.exr -o \"$(printf 'o\\033[1m.html')\"",
        "$R info \"$(printf 'none\\033[1m.gltf')\"",
        "$R \"$(printf 'none\\033[1m')\"",
        "$R info --\"$(printf 'none\\033[1m')\"",
    };
    for ( size_t i = 0; i < sizeof commands / sizeof commands[0]; ++i )
    {
        const CliResult* result = cli_run( "%s", commands[i] );
        if ( ( i < 5 && result->status != 0 ) || strlen( result->out ) + strlen( result->err ) == 0 )
            fail_msg( "%s: status %d: %s", commands[i], result->status, result->err );
        expect_harmless( result->out );
        expect_harmless( result->err );
        if ( i == 3 ) // in words that bash reads
            assert_non_null( strstr( result->out, "reframe render $'s\\x1b[1m.gltf' -o out/frame.####.exr" ) );
    }
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
