// reframe convert: what of OBJ and Collada arrives in the scene, every error
// line, and that no file takes the program down with its importer.
#include "cli_run.h"
#include "encode_images.h"

#include "convert/glb_write.h"
#include "convert/run_importer.h"
#include "scene/gltf.h"
#include "scene/textured.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <setjmp.h>
#include <signal.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#include <cmocka.h>

static int enter( void** state )
{
    (void)state;
    cli_enter();
    return 0;
}

static int leave( void** state )
{
    (void)state;
    cli_leave();
    return 0;
}

static void write_text( const char* name, const char* text )
{
    cli_write( name, text, strlen( text ) );
}

static bool near( double a, double b ) { return fabs( a - b ) <= 1e-5 * ( 1.0 + fabs( b ) ); }

static void assert_point( const float* p, double x, double y, double z )
{
    if ( !near( p[0], x ) || !near( p[1], y ) || !near( p[2], z ) )
        fail_msg( "wanted %g %g %g, got %g %g %g", x, y, z, (double)p[0], (double)p[1], (double)p[2] );
}

static RfScene load( const char* name )
{
    char path[256];
    RfScene scene;
    RfLog log = { 0 };
    RfError error;
    snprintf( path, sizeof path, "%s/%s", cli_folder(), name );
    if ( rf_load_gltf( path, &scene, &log, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    return scene;
}

static const RfMaterial* material_of( const RfScene* scene, const char* name )
{
    for ( uint32_t i = 0; i < scene->material_count; ++i )
    {
        if ( scene->materials[i].name != NULL && strcmp( scene->materials[i].name, name ) == 0 )
            return scene->materials + i;
    }
    fail_msg( "there is no material '%s'", name );
    return NULL;
}

// Nothing but what the test wrote and the two files of cli_run.
static void assert_files( int count )
{
    int found = cli_count_files( "", "." );
    if ( found != count + 2 )
        fail_msg( "%d files instead of %d", found - 2, count );
}

static const char s_obj[] = "mtllib a.mtl\no floor\nv 0 0 0\nv 2 0 0\nv 2 3 0\nv 0 3 0\n"
                            "vt 0 0\nvt 1 0\nvt 1 1\nvt 0 0.75\nvn 0 0 1\n"
                            "usemtl wall\nf 1/1/1 2/2/1 3/3/1 4/4/1\n"
                            "usemtl lamp\nf 1 2 3\nusemtl glass\nf 1 2 3\nusemtl gold\nf 1 2 3\nl 1 2\n";
static const char s_mtl[] = "newmtl wall\nKd 0.5 0.25 0.125\nKs 0.5 0.5 0.5\nNs 30\nmap_Kd wall.png\n"
                            "newmtl lamp\nKd 0 0 0\nKe 12 6 3\n"
                            "newmtl glass\nKd 0 0 0\nKs 1 1 1\nTf 1 0.9 0.8\nNi 1.33\nillum 7\n"
                            "newmtl gold\nKd 0 0 0\nKs 0.9 0.7 0.25\nNs 30\n";

static void write_obj( void )
{
    static const uint8_t pixels[6] = { 255, 0, 0, 0, 0, 255 };
    size_t size;
    uint8_t* png = encode_png( 2, 1, 3, pixels, &size );
    cli_write( "wall.png", png, size );
    free( png );
    write_text( "a.obj", s_obj );
    write_text( "a.mtl", s_mtl );
}

static void check_obj_materials( const RfScene* scene )
{
    const RfMaterial* wall = material_of( scene, "wall" );
    assert_int_equal( wall->kind, RF_BSDF_GGX );
    assert_true( wall->textured != NULL );
    assert_true( near( wall->alpha, 0.25 ) ); // sqrt( 2 / 32 )
    assert_true( wall->double_sided );
    const RfMaterial* lamp = material_of( scene, "lamp" );
    assert_true( near( lamp->emission.x, 12 ) && near( lamp->emission.y, 6 ) && near( lamp->emission.z, 3 ) );
    assert_false( lamp->double_sided );
    const RfMaterial* glass = material_of( scene, "glass" );
    assert_int_equal( glass->kind, RF_BSDF_GLASS );
    assert_true( near( glass->ior, 1.33 ) && near( glass->tint.y, 0.9 ) );
    const RfMaterial* gold = material_of( scene, "gold" );
    assert_true( near( gold->specular.x, 0.9 ) && near( gold->specular.z, 0.25 ) && near( gold->diffuse.x, 0 ) );
}

static void test_obj( void** state )
{
    (void)state;
    write_obj();
    const CliResult* run = cli_run( "$R convert a.obj a.glb --json a.json" );
    cli_expect( run, 0, "warning: 1 points and lines are left out" );
    assert_non_null( strstr( run->out, "a.glb: 5 triangles in 4 meshes" ) );
    size_t size;
    char* json = cli_read( "a.json", &size );
    assert_non_null( strstr( json, "\"triangles\": 5" ) );
    assert_non_null( strstr( json, "\"warnings\": 1" ) );
    free( json );
    RfScene scene = load( "a.glb" );
    assert_int_equal( scene.triangles.count, 5 );
    assert_point( &scene.bounds_min.x, 0, 0, 0 );
    assert_point( &scene.bounds_max.x, 2, 3, 0 );
    assert_int_equal( scene.texture_count, 1 );
    assert_true( scene.textures->width == 2 && scene.textures->bytes[0] == 255 && scene.textures->bytes[5] == 255 );
    check_obj_materials( &scene );
    int seen = 0; // v runs down in glTF: the corner at 0 3 0 had 0.75
    for ( uint32_t i = 0; i < scene.triangles.vertex_count; ++i )
    {
        const float* p = scene.triangles.positions + 3 * i;
        const float* uv = scene.triangles.uvs + 2 * i;
        if ( p[0] == 0.0f && p[1] == 3.0f && ++seen > 0 )
            assert_true( near( uv[0], 0 ) && near( uv[1], 0.25 ) );
    }
    assert_true( seen > 0 );
    rf_destroy_scene( &scene );
    assert_files( 5 );
}

static void test_placement( void** state )
{
    (void)state;
    write_obj();
    cli_expect( cli_run( "$R convert a.obj a.glb --up z --scale 0.5 --quiet" ), 0, NULL );
    RfScene scene = load( "a.glb" );
    assert_point( &scene.bounds_min.x, 0, 0, -1.5 ); // y went to −z
    assert_point( &scene.bounds_max.x, 1, 0, 0 );
    assert_true( near( scene.triangles.normals[1], 1 ) );
    rf_destroy_scene( &scene );
}

#define COLLADA( optics )                                                                                                \
    "<?xml version=\"1.0\"?><COLLADA xmlns=\"http://www.collada.org/2005/11/COLLADASchema\" version=\"1.4.1\">"          \
    "<asset><unit name=\"half\" meter=\"0.5\"/><up_axis>Z_UP</up_axis></asset>"                                          \
    "<library_cameras><camera id=\"eye\" name=\"eye\"><optics><technique_common><perspective>" optics                    \
    "<znear>0.1</znear><zfar>100</zfar></perspective></technique_common></optics></camera></library_cameras>"            \
    "<library_lights><light id=\"spot\" name=\"spot\"><technique_common><spot><color>4 2 2</color>"                      \
    "<falloff_angle>60</falloff_angle></spot></technique_common></light></library_lights>"                              \
    "<library_geometries><geometry id=\"g\" name=\"g\"><mesh><source id=\"p\">"                                          \
    "<float_array id=\"pa\" count=\"9\">0 0 0 1 0 0 0 0 1</float_array><technique_common>"                               \
    "<accessor source=\"#pa\" count=\"3\" stride=\"3\"><param name=\"X\" type=\"float\"/><param name=\"Y\" type=\"float\"/>" \
    "<param name=\"Z\" type=\"float\"/></accessor></technique_common></source>"                                          \
    "<vertices id=\"v\"><input semantic=\"POSITION\" source=\"#p\"/></vertices><triangles count=\"1\">"                  \
    "<input semantic=\"VERTEX\" source=\"#v\" offset=\"0\"/><p>0 1 2</p></triangles></mesh></geometry></library_geometries>" \
    "<library_visual_scenes><visual_scene id=\"s\">"                                                                     \
    "<node id=\"tri\" name=\"tri\"><translate>1 2 3</translate><instance_geometry url=\"#g\"/></node>"                   \
    "<node id=\"eye\" name=\"eye\"><translate>0 -5 1</translate><rotate>1 0 0 90</rotate><instance_camera url=\"#eye\"/></node>" \
    "<node id=\"lamp\" name=\"lamp\"><translate>0 0 4</translate><instance_light url=\"#spot\"/></node>"                 \
    "</visual_scene></library_visual_scenes><scene><instance_visual_scene url=\"#s\"/></scene></COLLADA>"

// The way of a node up to the root.
static RfMat4 world_of( const RfScene* scene, int node )
{
    RfMat4 world = rf_mat4_identity();
    for ( ; node >= 0; node = scene->nodes[node].parent )
    {
        const RfNode* n = scene->nodes + node;
        RfMat4 local = n->has_matrix ? n->matrix : rf_mat4_from_trs( n->translation, n->rotation, n->scale );
        world = rf_mat4_mul( &local, &world );
    }
    return world;
}

static void test_collada( void** state )
{
    (void)state;
    write_text( "c.dae", COLLADA( "<xfov>60</xfov><aspect_ratio>2</aspect_ratio>" ) );
    cli_expect( cli_run( "$R convert c.dae c.glb" ), 0, "candela or lux" );
    RfScene scene = load( "c.glb" );
    assert_int_equal( scene.triangles.count, 1 );
    assert_point( &scene.bounds_min.x, 0.5, 1.5, -1 ); // z up, in half metres
    assert_point( &scene.bounds_max.x, 1, 2, -1 );
    assert_int_equal( scene.camera_count, 1 );
    assert_true( near( scene.cameras->yfov, 2 * atan( tan( 0.5235987755982988 ) / 2 ) ) );
    RfMat4 eye = world_of( &scene, scene.cameras->node );
    assert_true( near( eye.m[12], 0 ) && near( eye.m[13], 0.5 ) && near( eye.m[14], 2.5 ) ); // once
    assert_true( near( eye.m[10], 0.5 ) && near( eye.m[5], 0.5 ) );                          // along −z, y up
    assert_int_equal( scene.punctual_count, 1 );
    const RfPunctual* lamp = scene.punctuals;
    assert_int_equal( lamp->kind, RF_PUNCTUAL_SPOT );
    assert_point( &lamp->position.x, 0, 2, 0 );
    assert_point( &lamp->direction.x, 0, -1, 0 );
    assert_point( &lamp->intensity.x, 4, 2, 2 );
    assert_true( near( lamp->cos_outer, cos( 0.5235987755982988 ) ) );
    rf_destroy_scene( &scene );
    // of yfov with its aspect the angle is the file's own; what assimp computes wrongly is dropped
    write_text( "d.dae", COLLADA( "<yfov>40</yfov><aspect_ratio>2</aspect_ratio>" ) );
    cli_expect( cli_run( "$R convert d.dae d.glb --quiet" ), 0, NULL );
    scene = load( "d.glb" );
    assert_true( near( scene.cameras->yfov, 40 * 3.14159265358979 / 180 ) );
    rf_destroy_scene( &scene );
    write_text( "e.dae", COLLADA( "<xfov>60</xfov><yfov>40</yfov>" ) );
    const CliResult* run = cli_run( "$R convert e.dae e.glb" );
    assert_int_equal( run->status, 0 );
    assert_non_null( strstr( run->err, "camera 'eye': is left out: its field of view cannot be told" ) );
}

static void test_refusals( void** state )
{
    (void)state;
    write_obj();
    write_text( "note.xyz", "just some words\n" );
    write_text( "empty.obj", "" );
    write_text( "points.obj", "v 0 0 0\nv 1 0 0\nl 1 2\n" );
    cli_expect( cli_run( "$R convert none.obj a.glb" ), 1, "none.obj: cannot be read: No such file" );
    cli_expect( cli_run( "$R convert note.xyz a.glb" ), 1, "note.xyz: is of no format known here: OBJ, PLY, FBX and Collada" );
    cli_expect( cli_run( "$R convert empty.obj a.glb" ), 1, "empty.obj: is empty" );
    cli_expect( cli_run( "$R convert points.obj a.glb --quiet" ), 1, "points.obj: " );
    cli_expect( cli_run( "$R convert . a.glb" ), 1, ".: is no regular file" );
    cli_expect( cli_run( "$R convert a.obj a.gltf" ), 2, "a.gltf: only .glb is written" );
    cli_expect( cli_run( "$R convert a.obj none/a.glb" ), 1, "none/a.glb: " );
    cli_expect( cli_run( "$R convert $VASE a.glb" ), 2, "is glTF already and needs no conversion" );
    cli_expect( cli_run( "cp $VASE vase.obj; $R convert vase.obj a.glb" ), 2, "vase.obj: is glTF already" );
    cli_expect( cli_run( "$R convert a.obj" ), 2, "OUT.glb" );
    cli_expect( cli_run( "$R convert a.obj a.glb --memory 1M" ), 2, "--memory" );
    cli_expect( cli_run( "$R convert a.obj a.glb --up x" ), 2, "--up" );
    assert_files( 7 );
    write_text( "a.glb", "mine" );
    cli_expect( cli_run( "$R convert a.obj a.glb --quiet" ), 1, "a.glb: is there already: give another name or --overwrite" );
    cli_expect( cli_run( "$R convert none.obj a.glb --overwrite" ), 1, "none.obj: " );
    size_t size;
    char* bytes = cli_read( "a.glb", &size );
    assert_string_equal( bytes, "mine" );
    free( bytes );
    cli_expect( cli_run( "$R convert a.obj a.glb --quiet --overwrite" ), 0, NULL );
    RfScene scene = load( "a.glb" );
    assert_int_equal( scene.triangles.count, 5 );
    rf_destroy_scene( &scene );
}

static void test_missing_texture( void** state )
{
    (void)state;
    write_text( "a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n" );
    write_text( "a.mtl", "newmtl m\nKd 1 1 1\nmap_Kd gone\\wall.png\n" );
    cli_expect( cli_run( "$R convert a.obj a.glb" ), 0, "texture 'gone/wall.png': cannot be read: it is left out" );
    write_text( "wall.png", "no picture" );
    cli_expect( cli_run( "$R convert a.obj a.glb --overwrite" ), 0, "texture 'gone/wall.png': is neither PNG nor JPEG" );
}

static void test_vertex_colors( void** state )
{
    (void)state;
    write_text( "a.obj", "v 0 0 0 1 0.5 0\nv 1 0 0 1 0.5 0\nv 0 1 0 1 0.5 0\nf 1 2 3\n" );
    cli_expect( cli_run( "$R convert a.obj a.glb --quiet" ), 0, NULL );
    RfScene scene = load( "a.glb" );
    assert_non_null( scene.triangles.colors );
    assert_point( scene.triangles.colors, 1, 0.214041, 0 ); // linear
    assert_true( near( scene.materials->textured->factors.base[0], 1 ) ); // and not darkened by assimp's grey
    rf_destroy_scene( &scene );
}

// Files that hang assimp 5.2.5, crash it and make it take all memory.
#define PLY_HEAD "ply\nformat ascii 1.0\n"
#define PLY_VERTICES "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
#define PLY_FACES "element face 1\nproperty list uchar int vertex_indices\n"
#define PLY_CORNERS "end_header\n0 0 0\n1 0 0\n0 1 0\n"

static const char s_hangs[] = PLY_HEAD PLY_VERTICES PLY_FACES; // the header does not end
static const char s_crashes[] = PLY_HEAD PLY_VERTICES PLY_FACES PLY_CORNERS "3 0 1 999999999\n";
static const char s_eats[] = PLY_HEAD PLY_VERTICES "element face 100000000\nproperty list uchar int vertex_indices\n" PLY_CORNERS
                                                   "3 0 1 2\n";

#if defined( __SANITIZE_ADDRESS__ )
#define CRASHED "crashes.ply: the importer failed on it" // the sanitizer takes the signal
#else
#define CRASHED "crashes.ply: the importer crashed on it (Segmentation fault): export it as glTF"
#endif

static void test_bad_importer( void** state )
{
    (void)state;
    write_text( "hangs.ply", s_hangs );
    write_text( "crashes.ply", s_crashes );
    write_text( "eats.ply", s_eats );
    cli_expect( cli_run( "$R convert hangs.ply a.glb --importer assimp --timeout 0.5 --memory 512M" ), 1,
                "hangs.ply: the importer had not finished after 0.5 s: give it more by --timeout, or export it as glTF" );
    cli_expect( cli_run( "$R convert crashes.ply a.glb --importer assimp --memory 512M" ), 1, CRASHED );
#if !defined( __SANITIZE_ADDRESS__ ) // under which there is no limit
    cli_expect( cli_run( "$R convert eats.ply a.glb --importer assimp --memory 512M" ), 1,
                "eats.ply: the importer needs more than 512 MiB of memory: give it more by --memory, or export it as glTF" );
#endif
    write_text( "good.ply", PLY_HEAD PLY_VERTICES PLY_FACES PLY_CORNERS "3 0 1 2\n" );
    assert_files( 4 );
    cli_expect( cli_run( "$R convert good.ply a.glb --importer assimp --quiet" ), 0, NULL );
    assert_files( 5 );
}

static void test_interrupt( void** state )
{
    (void)state;
    write_text( "hangs.ply", s_hangs );
    cli_start( "exec $R convert hangs.ply a.glb --importer assimp" );
    for ( int i = 0; i < 500 && cli_count_files( ".tmp", "." ) == 0; ++i )
        poll( NULL, 0, 10 );
    assert_int_equal( cli_count_files( ".tmp", "." ), 1 );
    poll( NULL, 0, 100 );
    cli_expect( cli_wait( SIGTERM ), 130, "hangs.ply: interrupted" );
    assert_files( 1 );
}

// The library's side, in this process: it has no child left afterwards.
static void test_no_process_left( void** state )
{
    (void)state;
    const struct
    {
        const char* text;
        RfResult result;
    } cases[] = { { s_hangs, RF_ERROR_FORMAT }, { s_crashes, RF_ERROR_FORMAT }, { "ply\n", RF_ERROR_FORMAT } };
    char source[256], target[256], program[1024];
    snprintf( source, sizeof source, "%s/a.ply", cli_folder() );
    snprintf( target, sizeof target, "%s/a.glb", cli_folder() );
    snprintf( program, sizeof program, "%s-import", REFRAME_BINARY );
    RfImporterRun run = { .program = program, .source = source, .target = target, .memory = (size_t)512 << 20, .seconds = 0.3, .scale = 1 };
    for ( size_t i = 0; i < sizeof cases / sizeof cases[0]; ++i )
    {
        RfModelCounts counts;
        RfError error;
        write_text( "a.ply", cases[i].text );
        assert_int_equal( rf_run_importer( &run, &counts, NULL, &error ), cases[i].result );
        assert_int_equal( waitpid( -1, NULL, WNOHANG ), -1 );
        assert_int_equal( errno, ECHILD );
        assert_int_equal( cli_count_files( "", "." ), 1 );
    }
    run.program = "/nowhere/reframe-import";
    RfModelCounts counts;
    RfError error;
    assert_int_equal( rf_run_importer( &run, &counts, NULL, &error ), RF_ERROR_IO );
    assert_non_null( strstr( error.text, "cannot be started" ) );
}

static RfResult write_model( const RfModel* model, RfError* error )
{
    char path[256];
    snprintf( path, sizeof path, "%s/m.glb", cli_folder() );
    return rf_write_glb( path, model, true, error );
}

static void test_writer_refuses( void** state )
{
    (void)state;
    float positions[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    uint32_t indices[3] = { 0, 1, 2 };
    int list[1] = { 0 };
    RfModelMaterial material = rf_default_model_material();
    RfModelMesh mesh = { .vertex_count = 3, .positions = positions, .triangle_count = 1, .indices = indices, .material = 0 };
    RfModelNode node = { .parent = -1, .matrix = rf_mat4_identity(), .mesh_count = 1, .meshes = list };
    RfModel model = { .mesh_count = 1, .meshes = &mesh, .material_count = 1, .materials = &material, .node_count = 1, .nodes = &node };
    RfError error;
    assert_int_equal( write_model( &model, &error ), RF_OK );
    RfScene scene = load( "m.glb" );
    assert_int_equal( scene.triangles.count, 1 );
    rf_destroy_scene( &scene );
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

#define TEST( name ) cmocka_unit_test_setup_teardown( name, enter, leave )

int main( void )
{
    const struct CMUnitTest tests[] = {
        TEST( test_obj ),          TEST( test_placement ),   TEST( test_collada ),
        TEST( test_refusals ),     TEST( test_missing_texture ), TEST( test_bad_importer ),
        TEST( test_interrupt ),    TEST( test_no_process_left ), TEST( test_writer_refuses ),
        TEST( test_vertex_colors ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
