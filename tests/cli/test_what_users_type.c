// What users type out of habit is understood, or answered with what to type.
#include "support/cli_run.h"
#include "support/test.h"

#define TINY " --size 16x9 --spp 2 --group 0 --quiet "

TEST( test_help_is_a_command )
{
    const CliResult* result = cli_run( "$R help" );
    cli_expect( result, 0, NULL );
    assert_int_equal( strncmp( result->out, "usage: reframe COMMAND", 22 ), 0 );
    result = cli_run( "$R help tune" );
    cli_expect( result, 0, NULL );
    assert_int_equal( strncmp( result->out, "usage: reframe tune [OPTIONS] SCENE", 35 ), 0 );
    cli_expect( cli_run( "$R help rendr" ), 2, "reframe: 'rendr': no such command, did you mean render?" );
    cli_expect( cli_run( "$R diff a b" ), 2, "reframe: 'diff': no such command, did you mean compare?" );
    cli_expect( cli_run( "$R version" ), 2, "reframe: 'version': no such command, did you mean --version?" );
}

TEST( test_words_of_other_programs )
{
    cli_expect( cli_run( "$R render $VASE -o a.exr --samples 64" ), 2, "--samples: no such option, did you mean --spp?" );
    cli_expect( cli_run( "$R render $VASE -o a.exr --resolution 64x48" ), 2,
                "--resolution: no such option, did you mean --size?" );
    cli_expect( cli_run( "$R cost $VASE --time 20s" ), 2, "--time: no such option, did you mean --budget?" );
}

// Units reach the render, and numbered names may be written as printf has them.
TEST( test_units_and_patterns )
{
    cli_expect( cli_run( "$R tune $VASE --budget 0 --size 360p --noise 5.8%% --time 1m1s --frames 1 --json tune.json > table" ),
                0, NULL );
    cli_expect( cli_run( "$R render $VASE -o p/f.%%04d.exr --frames 9-10" TINY ), 0, NULL );
    assert_true( cli_exists( "p/f.0009.exr" ) && cli_exists( "p/f.0010.exr" ) );
    cli_expect( cli_run( "$R render $VASE -o p/f.%%04d.exr --frames 9-10 --noise 100%% --time 30s --size 16x9 --overwrite "
                         "--quiet --json r.json" ),
                0, NULL );
    json_auto_t* json = cli_read_json( "r.json" );
    assert_true( json_number_value( json_object_get( json_object_get( json, "noise" ), "wanted" ) ) == 3.0 );
    assert_true( json_number_value( json_object_get( json_object_get( json, "time" ), "wanted" ) ) == 30.0 );
    cli_expect( cli_run( "$R compare p/f.%%04d.exr p/f.####.exr --quiet > table" ), 0, NULL );
    cli_expect( cli_run( "$R cost $VASE --noise 5%%,x" ), 2, "--noise: expected numbers above 0" );
}

// Blender's own files, compressed as Blender 3 or older ones do, or not.
TEST( test_blend_files_are_recognised )
{
    static const char advice[] = "export it by blender -b a.blend -P scripts/blender/export.py -- scene.glb\n";
    static const struct
    {
        const char *bytes, *said;
    } cases[] = {
        { "BLENDER-v304RENDH", "a.blend: is a Blender file: " },
        { "\x28\xb5\x2f\xfd\x60\x10", "a.blend: is a Blender file, compressed by zstd: " },
        { "\x1f\x8b\x08", "a.blend: is a Blender file, compressed by gzip: " },
    };
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        cli_write( "a.blend", cases[i].bytes, strlen( cases[i].bytes ) );
        const CliResult* result = cli_run( "$R info a.blend" );
        cli_expect( result, 1, cases[i].said );
        assert_non_null( strstr( result->err, advice ) );
        cli_expect( cli_run( "$R convert a.blend a.glb" ), 1, cases[i].said );
        cli_expect( cli_run( "cp a.blend scene.json; $R render scene.json -o a.exr" ), 1, "scene.json" );
    }
    cli_write( "a.glb", cases[1].bytes, strlen( cases[1].bytes ) );
    cli_expect( cli_run( "$R info a.glb" ), 1, "a.glb: is compressed by zstd: uncompress it first, or if it is a Blender file" );
}

// What is no scene is named, with what to do; `convert` reads models.
TEST( test_other_files_are_named )
{
    static const struct
    {
        const char *name, *bytes, *said;
        bool is_model;
    } cases[] = {
        { "lfs.glb", "version https://git-lfs.github.com/spec/v1\noid",
          "lfs.glb: is a git-lfs pointer: git lfs pull gets the file", false },
        { "web.gltf", "<!doctype html>\n<html>", "web.gltf: is a web page: download the file itself", false },
        { "z.glb", "PK\3\4abcd", "z.glb: is a zip archive: unpack it", false },
        { "s.usdz", "PK\3\4abcd", "s.usdz: is USD: export it as glTF", false },
        { "s.usd", "PXR-USDC\1", "s.usd: is USD: export it as glTF", false },
        { "m.fbx", "Kaydara FBX Binary  ", "m.fbx: is FBX: reframe convert makes a .glb of it", true },
        { "m.obj", "v 0 0 0\n", "m.obj: is OBJ: reframe convert makes a .glb of it", true },
        { "m.dae", "<?xml version=\"1.0\"?>", "m.dae: is Collada: reframe convert makes a .glb of it", true },
        { "points", "ply\nformat ascii 1.0\n", "points: is PLY: reframe convert makes a .glb of it", true },
    };
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        cli_write( cases[i].name, cases[i].bytes, strlen( cases[i].bytes ) );
        cli_expect( cli_run( "$R render %s -o a.exr", cases[i].name ), 1, cases[i].said );
        const CliResult* converted = cli_run( "$R convert %s new.glb", cases[i].name );
        assert_int_equal( converted->status, 1 );
        assert_true( ( strstr( converted->err, ": is " ) == NULL ) == cases[i].is_model );
    }
    // a byte-order mark, and a number that is rounded
    static const char scene[] = "\xef\xbb\xbf{\"asset\":{\"version\":\"2.0\"},\"materials\":[{\"pbrMetallicRoughness\":{"
                                "\"baseColorFactor\":[%s,1,1,1]}}]}";
    char text[256];
    snprintf( text, sizeof text, scene, "1.0000001" );
    cli_write( "a.gltf", text, strlen( text ) );
    assert_null( strstr( cli_run( "$R info a.gltf" )->err, "baseColorFactor" ) );
    snprintf( text, sizeof text, scene, "1.0011" );
    cli_write( "a.gltf", text, strlen( text ) );
    cli_expect( cli_run( "$R info a.gltf" ), 1, "baseColorFactor is 1.0011, it must be 0 to 1" );
}

// Two folders: what both have is measured, and the rest is named.
TEST( test_folders_are_compared )
{
    cli_expect( cli_run( "$R render $VASE -o a/f.####.exr --frames 1-4" TINY "&& mkdir b && cp a/f.0002.exr b/g_002.exr && "
                         "cp a/f.0004.exr b/g_004.exr && cp a/f.0001.exr b/g_006.exr" ),
                0, NULL );
    const CliResult* result = cli_run( "$R compare a b/ --json c.json" );
    cli_expect( result, 0, NULL );
    assert_non_null( strstr( result->out, "no difference: all pixels are identical" ) );
    assert_non_null( strstr( result->out, "not measured: frame 6, missing from a/f.####.exr\n" ) );
    assert_non_null( strstr( result->out, "not measured: frames 1, 3, missing from b/g_###.exr\n" ) );
    assert_non_null( strstr( result->out, "not measured: frame 5, missing from both sequences\n" ) );
    json_auto_t* json = cli_read_json( "c.json" );
    assert_int_equal( json_array_size( json_object_get( json, "frames" ) ), 2 );
    assert_int_equal( json_array_size( json_object_get( json, "missing_a" ) ), 1 );
    assert_int_equal( json_integer_value( json_array_get( json_object_get( json, "missing_b" ), 1 ) ), 3 );
    cli_expect( cli_run( "$R compare a b/g_###.exr --frames 2,4 --quiet > table" ), 0, NULL );
    cli_expect( cli_run( "$R compare a b --frames 3" ), 1, "reframe compare: b/g_###.exr: frame 3 is missing" );
    cli_expect( cli_run( "$R compare a/f.####.exr b/g_###.exr" ), 1, "but not in" ); // sequences are to be the same
    cli_expect( cli_run( "mkdir e; $R compare a e" ), 1, "e: no EXR file in this folder" );
    cli_expect( cli_run( "cp a/f.0001.exr e/f.0009.exr; $R compare a e" ), 1, "have no frame in common" );
    cli_expect( cli_run( "$R compare a a/f.0001.exr" ), 2, "give two of a kind" );
}

// Sequences, folders and layers as PNG, with the numbers of the frames.
TEST( test_sequences_as_png )
{
    cli_expect( cli_run( "$R render $VASE -o s/f.####.exr --frames 1-4 --aov depth" TINY ), 0, NULL );
    const CliResult* result = cli_run( "$R png s/f.####.exr s/p.%%04d.png" );
    cli_expect( result, 0, NULL );
    assert_string_equal( result->out, "4 frames in s/p.%04d.png\n" );
    assert_int_equal( cli_count_files( ".png", "s" ), 4 );
    cli_expect(
        cli_run( "mkdir t && $R png s t --layer depth.Z --quiet && test -s t/f.0003.png && ! cmp -s t/f.0003.png s/p.0003.png" ),
        0, NULL );
    cli_expect( cli_run( "$R png s/f.0002.exr one.png && cmp one.png s/p.0002.png && $R png s u.####.png --frames 2-3 --quiet && "
                         "cmp u.0002.png one.png && test ! -e u.0001.png" ),
                0, NULL );
    cli_expect( cli_run( "rm s/f.0002.exr; $R png s v.####.png > out" ), 0, "warning: s/f.####.exr: lacks frame 2" );
    cli_expect( cli_run( "$R png s v.png" ), 2, "v.png: has no #### for the number, but there are 3 frames" );
    cli_expect( cli_run( "$R png s s/f.####.exr" ), 2, "s/f.####.exr: ends as a file of another kind: name it .png" );
    cli_expect( cli_run( "$R png s v.####.png --frames 2" ), 1, "s/f.####.exr: frame 2 is missing" );
    cli_expect( cli_run( "$R png s/f.0001.exr v.png --layer nothing" ), 1, "s/f.0001.exr" );
    cli_expect( cli_run( "$R png s/f.0001.exr v.png --frames 1" ), 2, "--frames: needs a sequence" );
}

TEST( test_lens_options_that_make_no_lens_are_refused )
{
#define LENS "$R render $VASE -o l.####.exr --frames 1 --size 16x9 --spp 1 --group 0 --quiet "
    cli_expect( cli_run( LENS "--focus 3" ), 2, "a focus changes nothing without an aperture" );
    cli_expect( cli_run( LENS "--fstop 2" ), 1, "its lens has an aperture but no focus" );
    cli_expect( cli_run( LENS "--fstop 2 --focus nothing" ), 1, "focused on 'nothing', which the scene does not have" );
    cli_expect( cli_run( LENS "--shutter 1,0" ), 2, "--shutter 1,0: expected frames" );
    cli_expect( cli_run( LENS "--focus 0" ), 2, "--focus 0: expected metres above 0" );
    assert_false( cli_exists( "l.0001.exr" ) );
    cli_expect( cli_run( LENS "--fstop 2 --focus 3 --shutter 0.5 > log" ), 0, NULL );
}

SHARED_BY_TESTS( cli_enter_group, cli_leave_group )
