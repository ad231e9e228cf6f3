// Materials, lamps and instances of glTF extensions: what is read, and every
// error line.
#include "support/scene_files.h"

#include "scene/gltf/gltf.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include <cmocka.h>

static const float s_corners[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };

// A triangle of material 0, with further members of the document.
static RfResult load_text( const char* material, const char* nodes, const char* more, RfScene* scene, char* line, size_t size )
{
    GltfBuilder b = { 0 };
    GltfFolder folder = make_folder();
    char rest[8192];
    int corners = add_gltf_floats( &b, "VEC3", 3, 3, s_corners );
    static const float moves[6] = { 0, 0, 1, 0, 0, 2 };
    static const float scales[6] = { 1, 1, 1, 2, 2, 2 };
    static const float turns[8] = { 0, 0, 0, 1, 0, 0, 1, 0 };
    int translation = add_gltf_floats( &b, "VEC3", 3, 2, moves ), scale = add_gltf_floats( &b, "VEC3", 3, 2, scales );
    int rotation = add_gltf_floats( &b, "VEC4", 4, 2, turns );
    assert_true( translation == 1 && scale == 2 && rotation == 3 );
    snprintf(
        rest, sizeof rest,
        "\"materials\":[{\"name\":\"m\"%s}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%d},\"material\":0}]}],"
        "\"nodes\":[%s],\"scenes\":[{\"nodes\":[0]}]%s",
        material, corners, nodes, more );
    RfLog log = { 0 };
    RfError error = { 0 };
    RfResult result = rf_load_gltf( write_gltf( &b, &folder, rest ), scene, &log, &error );
    snprintf( line, size, "%s", result == RF_OK ? "" : error.text );
    remove_folder( &folder );
    return result;
}

static RfScene load_ok( const char* material, const char* nodes, const char* more )
{
    RfScene scene;
    char line[1024];
    if ( load_text( material, nodes, more, &scene, line, sizeof line ) != RF_OK )
        fail_msg( "%s", line );
    return scene;
}

static void assert_fails( const char* material, const char* nodes, const char* more, const char* words )
{
    RfScene scene;
    char line[1024];
    assert_int_not_equal( load_text( material, nodes, more, &scene, line, sizeof line ), RF_OK );
    if ( strstr( line, words ) == NULL )
        fail_msg( "'%s' does not say '%s'", line, words );
}

#define MESH "{\"mesh\":0}"
#define EXTENSIONS( text ) ",\"extensions\":{" text "}"

static bool near( float a, double b ) { return fabs( (double)a - b ) <= 1e-6 * ( 1.0 + fabs( b ) ); }

static void test_transmission_makes_glass( void** state )
{
    (void)state;
    RfScene s = load_ok(
        ",\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":0,\"baseColorFactor\":[1,0.5,0.25,1]}" EXTENSIONS(
            "\"KHR_materials_transmission\":{\"transmissionFactor\":1},\"KHR_materials_ior\":{\"ior\":1.3},"
            "\"KHR_materials_volume\":{\"thicknessFactor\":0.1,\"attenuationDistance\":2,\"attenuationColor\":[1,0.5,0.25]}" ),
        MESH, "" );
    const RfMaterial* m = s.materials;
    assert_int_equal( m->kind, RF_BSDF_GLASS );
    assert_true( near( m->ior, 1.3 ) && m->alpha == 0.0f && !m->thin );
    assert_true( near( m->tint.x, 1 ) && near( m->tint.y, 0.5 ) && near( m->tint.z, 0.25 ) && m->diffuse.x == 0.0f );
    assert_true( near( m->absorption.x, 0 ) && near( m->absorption.y, log( 2.0 ) / 2 ) &&
                 near( m->absorption.z, log( 4.0 ) / 2 ) );
    rf_destroy_scene( &s );
    s = load_ok( ",\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":0.5}" EXTENSIONS(
                     "\"KHR_materials_transmission\":{\"transmissionFactor\":0.75}" ),
                 MESH, "" );
    m = s.materials;
    assert_true( m->kind == RF_BSDF_GLASS && m->thin && near( m->alpha, 0.25 ) && near( m->tint.x, 0.75 ) &&
                 near( m->diffuse.x, 0.25 ) );
    rf_destroy_scene( &s );
    s = load_ok( ",\"pbrMetallicRoughness\":{\"roughnessFactor\":0,\"baseColorFactor\":[0.9,0.8,0.7,1]}", MESH, "" );
    m = s.materials;
    assert_true( m->kind == RF_BSDF_GLASS && m->ior == 0.0f && near( m->specular.y, 0.8 ) && m->tint.x == 0.0f );
    rf_destroy_scene( &s );
}

static void test_extras_are_read( void** state )
{
    (void)state;
    RfScene s = load_ok( ",\"extras\":{\"reframe\":{\"bsdf\":\"mirror\",\"specular\":[0.9,0.8,0.7]}}", MESH, "" );
    assert_true( s.materials->kind == RF_BSDF_GLASS && s.materials->ior == 0.0f && near( s.materials->specular.z, 0.7 ) );
    rf_destroy_scene( &s );
    s = load_ok( ",\"extras\":{\"reframe\":{\"bsdf\":\"glass\",\"ior\":1.7}}", MESH, "" );
    assert_true( s.materials->kind == RF_BSDF_GLASS && near( s.materials->ior, 1.7 ) && near( s.materials->tint.x, 1 ) &&
                 s.materials->alpha == 0.0f );
    rf_destroy_scene( &s );
    assert_fails( ",\"extras\":{\"reframe\":{\"bsdf\":\"glass\",\"ior\":0.5}}", MESH, "", "ior: must be a number above 1" );
    assert_fails( ",\"extras\":{\"reframe\":{\"bsdf\":\"glass\",\"tint\":1}}", MESH, "", "tint: is not known here" );
    assert_fails( ",\"extras\":{\"reframe\":{\"bsdf\":\"mirror\"}}", MESH, "", "specular: is missing" );
    assert_fails( ",\"extras\":{\"reframe\":{\"bsdf\":\"wood\"}}", MESH, "", "\"mirror\" or \"glass\"" );
}

static void test_clearcoat_and_unlit( void** state )
{
    (void)state;
    RfScene s = load_ok( EXTENSIONS( "\"KHR_materials_clearcoat\":{\"clearcoatFactor\":0.5,\"clearcoatRoughnessFactor\":0.4}" ),
                         MESH, "" );
    assert_true( s.materials->kind == RF_BSDF_COATED && near( s.materials->clearcoat, 0.5 ) &&
                 near( s.materials->clearcoat_alpha, 0.16 ) );
    rf_destroy_scene( &s );
    s = load_ok( EXTENSIONS( "\"KHR_materials_clearcoat\":{}" ), MESH, "" );
    assert_int_equal( s.materials->kind, RF_BSDF_GGX );
    rf_destroy_scene( &s );
    s = load_ok( ",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.1,0.2,0.3,1]}" EXTENSIONS( "\"KHR_materials_unlit\":{}" ),
                 MESH, "" );
    assert_true( s.materials->kind == RF_BSDF_LAMBERT && near( s.materials->emission.y, 0.2 ) && s.materials->diffuse.y == 0.0f );
    rf_destroy_scene( &s );
}

static void test_faults_are_one_line( void** state )
{
    (void)state;
    assert_fails( EXTENSIONS( "\"KHR_materials_transmission\":{\"transmissionFactor\":2}" ), MESH, "",
                  "transmissionFactor is 2" );
    assert_fails( EXTENSIONS( "\"KHR_materials_volume\":{\"thicknessFactor\":-1}" ), MESH, "", "thicknessFactor is -1" );
    assert_fails( EXTENSIONS( "\"KHR_materials_volume\":{\"attenuationDistance\":0}" ), MESH, "", "attenuationDistance is 0" );
    assert_fails( EXTENSIONS( "\"KHR_materials_volume\":{\"attenuationColor\":[1,1,9]}" ), MESH, "", "attenuationColor is 9" );
    assert_fails( EXTENSIONS( "\"KHR_materials_clearcoat\":{\"clearcoatFactor\":-0.5}" ), MESH, "", "must be 0 to 1" );
    assert_fails( EXTENSIONS( "\"KHR_materials_clearcoat\":7" ), MESH, "", "KHR_materials_clearcoat" );
}

#define LIGHTS( text ) ",\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[" text "]}}"
#define LAMP_NODE                                                                                                                \
    "{\"mesh\":0,\"translation\":[1,2,3],\"rotation\":[-0.70710678,0,0,0.70710678],\"scale\":[2,2,2],"                           \
    "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}"

static void test_lamps_are_read( void** state )
{
    (void)state;
    RfScene s = load_ok( "", LAMP_NODE,
                         LIGHTS( "{\"type\":\"spot\",\"name\":\"desk\",\"color\":[1,0.5,0],\"intensity\":10,\"range\":7,"
                                 "\"spot\":{\"innerConeAngle\":0.1,\"outerConeAngle\":0.5}}" ) );
    assert_int_equal( s.punctual_count, 1 );
    const RfPunctual* p = s.punctuals;
    assert_string_equal( p->name, "desk" );
    assert_int_equal( p->kind, RF_PUNCTUAL_SPOT );
    assert_true( near( p->position.x, 1 ) && near( p->position.y, 2 ) && near( p->position.z, 3 ) );
    assert_true( fabsf( p->direction.y + 1.0f ) < 1e-6f ); // −z turned down, without its scale
    assert_true( near( p->intensity.x, 10 ) && near( p->intensity.y, 5 ) && p->intensity.z == 0.0f && p->range == 7.0f );
    assert_true( near( p->cos_inner, cos( 0.1 ) ) && near( p->cos_outer, cos( 0.5 ) ) );
    rf_destroy_scene( &s );
    s = load_ok( "", LAMP_NODE, LIGHTS( "{\"type\":\"point\"}" ) );
    assert_true( s.punctuals->kind == RF_PUNCTUAL_POINT && isinf( s.punctuals->range ) && s.punctuals->intensity.x == 1.0f );
    rf_destroy_scene( &s );
    s = load_ok( "", LAMP_NODE, LIGHTS( "{\"type\":\"directional\",\"intensity\":3}" ) );
    assert_true( s.punctuals->kind == RF_PUNCTUAL_DIRECTIONAL && s.punctuals->intensity.z == 3.0f );
    rf_destroy_scene( &s );
    assert_fails( "", LAMP_NODE, "", "has no lights" );
    assert_fails( "", LAMP_NODE, LIGHTS( "{\"intensity\":1}" ), "type" );
    assert_fails( "", LAMP_NODE, LIGHTS( "{\"type\":\"laser\"}" ), "must be point, spot or directional" );
    assert_fails( "", LAMP_NODE, LIGHTS( "{\"type\":\"spot\"}" ), "spot" );
    assert_fails( "", LAMP_NODE, LIGHTS( "{\"type\":\"spot\",\"spot\":{\"innerConeAngle\":1,\"outerConeAngle\":0.5}}" ),
                  "cone angles" );
    assert_fails( "", LAMP_NODE, LIGHTS( "{\"type\":\"point\",\"intensity\":-1}" ), "intensity is -1" );
    assert_fails( "", LAMP_NODE, LIGHTS( "{\"type\":\"point\",\"intensity\":2e9}" ),
                  "intensity is 2e+09, beyond what reframe reads: at most 1e+09" );
    assert_fails( "", LAMP_NODE, LIGHTS( "{\"type\":\"point\",\"range\":0}" ), "range is 0" );
    assert_fails( "", LAMP_NODE, LIGHTS( "{\"type\":\"point\",\"color\":[1,1,2]}" ), "color is 2" );
    assert_fails( "", "{\"scale\":[0,0,0],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}",
                  LIGHTS( "{\"type\":\"directional\"}" ), "no direction" );
    assert_fails( "", "{\"extensions\":{\"KHR_lights_punctual\":{\"light\":5}}}", LIGHTS( "{\"type\":\"point\"}" ), "light" );
}

#define INSTANCED( text ) "{\"mesh\":0,\"translation\":[5,0,0],\"extensions\":{\"EXT_mesh_gpu_instancing\":{" text "}}}"

static void test_instances_are_read( void** state )
{
    (void)state;
    RfScene s = load_ok( "", INSTANCED( "\"attributes\":{\"TRANSLATION\":1,\"SCALE\":2,\"ROTATION\":3}" ), "" );
    assert_int_equal( s.triangles.count, 2 );
    const float* p = s.triangles.positions;
    // the second: (1 0 0) doubled, turned half about z, moved by 2 in z and with its node
    const float expected[18] = { 5, 0, 1, 6, 0, 1, 5, 1, 1, 5, 0, 2, 3, 0, 2, 5, -2, 2 };
    for ( int i = 0; i < 18; ++i )
        assert_true( fabsf( p[i] - expected[i] ) < 1e-5f );
    rf_destroy_scene( &s );
    assert_fails( "", INSTANCED( "\"attributes\":{}" ), "", "at least" );
    assert_fails( "", INSTANCED( "" ), "", "attributes" );
    assert_fails( "", INSTANCED( "\"attributes\":{\"TRANSLATION\":3}" ), "", "" );
    assert_fails( "", INSTANCED( "\"attributes\":{\"TRANSLATION\":0,\"SCALE\":2}" ), "", "SCALE has 2 elements" );
    assert_fails( "", INSTANCED( "\"attributes\":{\"TRANSLATION\":99}" ), "", "TRANSLATION" );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_transmission_makes_glass ), cmocka_unit_test( test_extras_are_read ),
        cmocka_unit_test( test_clearcoat_and_unlit ),      cmocka_unit_test( test_faults_are_one_line ),
        cmocka_unit_test( test_lamps_are_read ),           cmocka_unit_test( test_instances_are_read ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
