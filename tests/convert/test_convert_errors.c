// reframe convert: every error line; a file that crashes the importer does not take the
// program down.
#include "support/cli_run.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "convert/model.h"
#include "convert/convert.h"

#include <errno.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>

TEST_WITHIN( test_wrong_files_and_options_are_refused, convert_enter, convert_leave )
{
    convert_write_obj();
    convert_write( "note.xyz", "just some words\n" );
    convert_write( "empty.obj", "" );
    convert_write( "points.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n" );
    cli_expect( cli_run( "$R convert none.obj a.glb" ), 1, "none.obj: cannot be read: No such file" );
    cli_expect( cli_run( "$R convert note.xyz a.glb" ), 1, "note.xyz: unknown format: OBJ, PLY, FBX and Collada" );
    cli_expect( cli_run( "$R convert empty.obj a.glb" ), 1, "empty.obj: is empty" );
    cli_expect( cli_run( "$R convert points.obj a.glb --quiet" ), 1, "points.obj: " );
    cli_expect( cli_run( "$R convert . a.glb" ), 1, ".: not a regular file" );
    cli_expect( cli_run( "$R convert a.obj a.gltf" ), 2, "a.gltf: ends as a file of another kind: name it .glb" );
    cli_expect( cli_run( "$R convert a.obj no/such/a.glb" ), 1, "no/such: this folder cannot be made" );
    cli_expect( cli_run( "$R convert $VASE a.glb" ), 2, "is glTF already and needs no conversion" );
    cli_expect( cli_run( "cp $VASE vase.obj; $R convert vase.obj a.glb" ), 2, "vase.obj: is glTF already" );
    cli_expect( cli_run( "$R convert a.obj" ), 2, "OUT.glb" );
    cli_expect( cli_run( "$R convert a.obj a.glb --memory 1M" ), 2, "--memory" );
    cli_expect( cli_run( "$R convert a.obj a.glb --up x" ), 2, "--up" );
    convert_assert_files( 7 );
    convert_write( "a.glb", "mine" );
    cli_expect( cli_run( "$R convert a.obj a.glb --quiet" ), 1, "a.glb: already exists: give another name or --overwrite" );
    cli_expect( cli_run( "$R convert none.obj a.glb --overwrite" ), 1, "none.obj: " );
    size_t size;
    AUTO_FREE char* bytes = cli_read( "a.glb", &size );
    assert_string_equal( bytes, "mine" );
    cli_expect( cli_run( "$R convert a.obj a.glb --quiet --overwrite" ), 0, NULL );
    AUTO_SCENE scene = convert_load( "a.glb" );
    assert_int_equal( scene.triangles.count, 5 );
}

// Files with a corner out of range, and one that makes assimp 5.2 to 5.4 take all memory; and one whose header does not end.
#define PLY_HEAD "ply\nformat ascii 1.0\n"
#define PLY_VERTICES "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
#define PLY_FACES "element face 1\nproperty list uchar int vertex_indices\n"
#define PLY_CORNERS "end_header\n0 0 0\n1 0 0\n0 1 0\n"

static const char s_endless[] = PLY_HEAD PLY_VERTICES PLY_FACES;
static const char s_crashes[] = PLY_HEAD PLY_VERTICES PLY_FACES PLY_CORNERS "3 0 1 999999999\n";
static const char s_eats[] =
    PLY_HEAD PLY_VERTICES "element face 100000000\nproperty list uchar int vertex_indices\n" PLY_CORNERS "3 0 1 2\n";

// The program in a folder of its own, with an importer that never ends, whatever the file.
static void make_hanging_importer( void )
{
    assert_int_equal( cli_run( "mkdir bin; cp $R bin/reframe; printf '#!/bin/sh\\nexec sleep 1000\\n' >bin/reframe-import; "
                               "chmod +x bin/reframe-import" )
                          ->status,
                      0 );
}

TEST_WITHIN( test_bad_importer_is_one_line, convert_enter, convert_leave )
{
    make_hanging_importer();
    convert_write( "good.ply", PLY_HEAD PLY_VERTICES PLY_FACES PLY_CORNERS "3 0 1 2\n" );
    convert_write( "crashes.ply", s_crashes );
    convert_write( "eats.ply", s_eats );
    cli_expect( cli_run( "bin/reframe convert good.ply a.glb --importer assimp --timeout 0.5 --memory 512M" ), 1,
                "good.ply: the importer had not finished after 0.5 s: give it more by --timeout, or export it as glTF" );
    cli_expect( cli_run( "printf '#!/bin/sh\\nkill -SEGV $$\\n' >bin/reframe-import; "
                         "bin/reframe convert good.ply a.glb --importer assimp --memory 512M" ),
                1, "good.ply: the importer crashed on it (Segmentation fault): export it as glTF" );
    cli_expect( cli_run( "$R convert crashes.ply a.glb --importer assimp --memory 512M" ), 1, "there is no vertex 999999999" );
#ifndef REFRAME_SANITIZED // under which there is no limit
    cli_expect( cli_run( "$R convert eats.ply a.glb --importer assimp --memory 512M" ), 1,
                "eats.ply: the importer needs more than 512 MiB of memory: give it more by --memory, or export it as glTF" );
#endif
    convert_assert_files( 4 );
    cli_expect( cli_run( "$R convert good.ply a.glb --importer assimp --quiet" ), 0, NULL );
    convert_assert_files( 5 );
}

// Our own reader says of the same files, at once, where they are wrong.
TEST_WITHIN( test_own_ply_reader_says_where, convert_enter, convert_leave )
{
    convert_write( "endless.ply", s_endless );
    convert_write( "crashes.ply", s_crashes );
    convert_write( "eats.ply", s_eats );
    convert_write( "good.ply", PLY_HEAD PLY_VERTICES PLY_FACES PLY_CORNERS "3 0 1 2\n" );
    cli_expect( cli_run( "$R convert endless.ply a.glb --quiet" ), 1, "endless.ply: line 9: the header has no end_header" );
    cli_expect( cli_run( "$R convert crashes.ply a.glb --quiet" ), 1,
                "crashes.ply: line 13: corner 2 of face 0 is vertex 999999999 of 3" );
    cli_expect( cli_run( "$R convert eats.ply a.glb --quiet" ), 1, "100000000 of element face need more than" );
    assert_false( cli_exists( "a.glb" ) );
    cli_expect( cli_run( "$R convert good.ply a.glb --quiet --up z --scale 2" ), 0, NULL );
    AUTO_SCENE scene = convert_load( "a.glb" );
    assert_int_equal( scene.triangles.count, 1 );
    const float* p = scene.triangles.positions;
    assert_true( p[3] == 2.0f && p[6] == 0.0f && fabsf( p[7] ) < 1e-6f && fabsf( p[8] + 2.0f ) < 1e-6f ); // y up, z towards
}

TEST_WITHIN( test_interrupt_leaves_no_file, convert_enter, convert_leave )
{
    make_hanging_importer();
    convert_write( "a.ply", s_crashes );
    cli_start( "exec bin/reframe convert a.ply a.glb --importer assimp" );
    for ( int i = 0; i < 500 && cli_count_files( ".tmp", "." ) == 0; ++i )
        poll( NULL, 0, 10 );
    assert_int_equal( cli_count_files( ".tmp", "." ), 1 );
    poll( NULL, 0, 100 );
    cli_expect( cli_wait( SIGTERM ), 130, "a.ply: interrupted" );
    convert_assert_files( 2 );
}

// The library's side, in this process: it has no child left afterwards.
TEST_WITHIN( test_no_process_left, convert_enter, convert_leave )
{
    make_hanging_importer();
    char program[1024];
    snprintf( program, sizeof program, "%s-import", REFRAME_BINARY );
    const struct
    {
        const char *program, *text;
    } cases[] = { { cli_path( "bin/reframe-import" ), "ply\n" }, { program, s_crashes }, { program, "ply\n" } };
    RfImporterRun run = {
        .source = cli_path( "a.ply" ), .target = cli_path( "a.glb" ), .memory = (size_t)512 << 20, .seconds = 0.3, .scale = 1
    };
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        RfModelCounts counts;
        RfError error;
        run.program = cases[i].program;
        convert_write( "a.ply", cases[i].text );
        assert_int_equal( rf_run_importer( &run, &counts, NULL, &error ), RF_ERROR_FORMAT );
        assert_int_equal( waitpid( -1, NULL, WNOHANG ), -1 );
        assert_int_equal( errno, ECHILD );
        convert_assert_files( 2 );
    }
    run.program = "/nowhere/reframe-import";
    RfModelCounts counts;
    RfError error;
    assert_int_equal( rf_run_importer( &run, &counts, NULL, &error ), RF_ERROR_IO );
    assert_non_null( strstr( error.text, "cannot be started" ) );
}

static RfResult write_model( const RfModel* model, RfError* error )
{
    return rf_write_glb( cli_path( "m.glb" ), model, true, error );
}

TEST_WITHIN( test_writer_refuses, convert_enter, convert_leave )
{
    float positions[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    uint32_t indices[3] = { 0, 1, 2 };
    int list[1] = { 0 };
    RfModelMaterial material = rf_default_model_material();
    RfModelMesh mesh = { .vertex_count = 3, .positions = positions, .triangle_count = 1, .indices = indices, .material = 0 };
    RfModelNode node = { .parent = -1, .matrix = rf_mat4_identity(), .mesh_count = 1, .meshes = list };
    RfModel model = {
        .mesh_count = 1, .meshes = &mesh, .material_count = 1, .materials = &material, .node_count = 1, .nodes = &node
    };
    RfError error;
    assert_int_equal( write_model( &model, &error ), RF_OK );
    AUTO_SCENE scene = convert_load( "m.glb" );
    assert_int_equal( scene.triangles.count, 1 );
    indices[1] = 3;
    assert_int_equal( write_model( &model, &error ), RF_ERROR_FORMAT );
    assert_non_null( strstr( error.text, "there is no vertex 3" ) );
    indices[1] = 1;
    positions[4] = NAN;
    assert_int_equal( write_model( &model, &error ), RF_ERROR_FORMAT );
    assert_non_null( strstr( error.text, "not finite" ) );
    positions[4] = 0;
    list[0] = 1;
    assert_int_equal( write_model( &model, &error ), RF_ERROR_FORMAT );
    assert_non_null( strstr( error.text, "node 0" ) );
    list[0] = 0;
    material.roughness = 2;
    assert_int_equal( write_model( &model, &error ), RF_ERROR_FORMAT );
    assert_non_null( strstr( error.text, "material 0" ) );
    material.roughness = 1;
    mesh.material = 1;
    assert_int_equal( write_model( &model, &error ), RF_ERROR_FORMAT );
    assert_non_null( strstr( error.text, "no material 1" ) );
    assert_int_equal( cli_count_files( ".tmp", "." ), 0 );
}
