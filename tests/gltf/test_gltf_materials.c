// Materials, lamps and instances of glTF extensions: what is read, and every
// error line.
#include "support/scene_files.h"
#include "support/test.h"

#include "gltf/gltf.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

static const float s_corners[9] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };

// The last warning.
static char s_warning[1024];

static void keep_warning( void* user, const char* line )
{
    (void)user;
    snprintf( s_warning, sizeof s_warning, "%s", line );
}

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
    RfLog log = { .fn = keep_warning };
    RfError error = { 0 };
    s_warning[0] = '\0';
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

TEST( test_transmission_makes_glass )
{
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

TEST( test_extras_are_read )
{
    RfScene s = load_ok( ",\"extras\":{\"reframe\":{\"bsdf\":\"mirror\",\"specular\":[0.9,0.8,0.7]}}", MESH, "" );
    assert_true( s.materials->kind == RF_BSDF_GLASS && s.materials->ior == 0.0f && near( s.materials->specular.z, 0.7 ) );
    rf_destroy_scene( &s );
    s = load_ok( ",\"extras\":{\"reframe\":{\"bsdf\":\"glass\",\"ior\":1.7}}", MESH, "" );
    assert_true( s.materials->kind == RF_BSDF_GLASS && near( s.materials->ior, 1.7 ) && near( s.materials->tint.x, 1 ) &&
                 s.materials->alpha == 0.0f );
    rf_destroy_scene( &s );
    assert_fails( ",\"extras\":{\"reframe\":{\"bsdf\":\"glass\",\"ior\":0.5}}", MESH, "",
                  "ior: must be a number > 1 and <= 10, got 0.5" );
    assert_fails( ",\"extras\":{\"reframe\":{\"bsdf\":\"glass\",\"tint\":1}}", MESH, "",
                  "tint: unknown key, the keys here are: bsdf, ior" );
    assert_fails( ",\"extras\":{\"reframe\":{\"bsdf\":\"mirror\"}}", MESH, "", "specular: is missing" );
    assert_fails( ",\"extras\":{\"reframe\":{\"bsdf\":\"wood\"}}", MESH, "", "\"mirror\" or \"glass\"" );
}

TEST( test_clearcoat_and_unlit )
{
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
    assert_true( s.materials->unlit && !rf_emits( s.materials ) );
    rf_destroy_scene( &s );
}

#define WHITE ",\"pbrMetallicRoughness\":{\"metallicFactor\":0}"
#define TRANSMITS( share ) "\"KHR_materials_transmission\":{\"transmissionFactor\":" share "}"
#define SHINES_THROUGH "\"KHR_materials_diffuse_transmission\":{\"diffuseTransmissionFactor\":1}"
#define SCATTER( transmission, distance, anisotropy )                                                                            \
    transmission ",\"KHR_materials_volume\":{\"thicknessFactor\":0.1,\"attenuationColor\":[0.5,0.5,0.5],"                        \
                 "\"attenuationDistance\":" distance "},\"KHR_materials_volume_scatter\":{\"multiscatterColor\":[0.9,0.5,0],"    \
                 "\"scatterAnisotropy\":" anisotropy "}"

// Bodies that scatter inside: dense ones are opaque, with the albedo of a half-space.
TEST( test_scatter_stands_in )
{
    RfScene s = load_ok( WHITE EXTENSIONS( SCATTER( TRANSMITS( "1" ), "0.01", "0" ) ), MESH, "" );
    const RfMaterial* m = s.materials;
    assert_true( m->kind == RF_BSDF_GGX && near( m->diffuse.x, 0.9 ) && near( m->diffuse.y, 0.5 ) && near( m->diffuse.z, 0 ) );
    rf_destroy_scene( &s );
    // 0.7 mean free paths deep: glass, as without the extension
    s = load_ok( WHITE EXTENSIONS( SCATTER( TRANSMITS( "1" ), "0.1", "0" ) ), MESH, "" );
    assert_true( s.materials->kind == RF_BSDF_GLASS && near( s.materials->absorption.x, log( 2.0 ) / 0.1 ) );
    rf_destroy_scene( &s );
    // by Monte Carlo, walks in a half-space with g = 0.5 bring .858 and .384
    s = load_ok( WHITE EXTENSIONS( SCATTER( SHINES_THROUGH, "1", "0.5" ) ), MESH, "" );
    m = s.materials;
    assert_true( m->kind == RF_BSDF_GGX && m->through.x == 0.0f && fabsf( m->diffuse.x - 0.858f ) < 0.004f &&
                 fabsf( m->diffuse.y - 0.384f ) < 0.004f );
    rf_destroy_scene( &s );
    // half is let in, and half of what comes back is sent inside again: ½ + ¼ A / (1 − ½ A)
    s = load_ok( WHITE EXTENSIONS( SCATTER( TRANSMITS( "0.5" ), "0.01", "0" ) ), MESH, "" );
    assert_true( near( s.materials->diffuse.x, 0.5 + 0.25 * 0.9 / 0.55 ) && near( s.materials->diffuse.z, 0.5 ) );
    rf_destroy_scene( &s );
    assert_fails( EXTENSIONS( SCATTER( SHINES_THROUGH, "1", "1" ) ), MESH, "", "scatterAnisotropy is 1, it must be between" );
}

#define DIFFUSE_TRANSMISSION                                                                                                     \
    "\"KHR_materials_diffuse_transmission\":{\"diffuseTransmissionFactor\":0.25,\"diffuseTransmissionColorFactor\":[1,0.5,0]}"
#define PLASTIC ",\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.8,0.4,0.2,1],\"metallicFactor\":0.5}"

TEST( test_diffuse_transmission )
{
    RfScene s = load_ok( PLASTIC EXTENSIONS( DIFFUSE_TRANSMISSION ), MESH, "" );
    const RfMaterial* m = s.materials;
    assert_int_equal( m->kind, RF_BSDF_TRANSLUCENT );
    assert_true( near( m->diffuse.x, 0.5 * 0.75 * 0.8 ) && near( m->diffuse.z, 0.5 * 0.75 * 0.2 ) );
    assert_true( near( m->through.x, 0.5 * 0.25 ) && near( m->through.y, 0.5 * 0.125 ) && m->through.z == 0.0f );
    rf_destroy_scene( &s );
    // metals have no base; glass that transmits all light has none either
    s = load_ok( EXTENSIONS( DIFFUSE_TRANSMISSION ), MESH, "" );
    assert_int_equal( s.materials->kind, RF_BSDF_GGX );
    rf_destroy_scene( &s );
    s = load_ok( PLASTIC EXTENSIONS( DIFFUSE_TRANSMISSION ",\"KHR_materials_transmission\":{\"transmissionFactor\":1}" ), MESH,
                 "" );
    assert_int_equal( s.materials->kind, RF_BSDF_GLASS );
    rf_destroy_scene( &s );
    assert_fails( EXTENSIONS( "\"KHR_materials_diffuse_transmission\":{\"diffuseTransmissionFactor\":1.5}" ), MESH, "",
                  "diffuseTransmissionFactor is 1.5, it must be 0 to 1" );
    assert_fails( EXTENSIONS( "\"KHR_materials_diffuse_transmission\":{\"diffuseTransmissionColorFactor\":[1,2,1]}" ), MESH, "",
                  "diffuseTransmissionColorFactor is 2, it must be 0 to 1" );
}

// What its model does not know is lost with a warning that names the material.
TEST( test_losses_beside_diffuse_transmission )
{
    static const struct
    {
        const char *more, *warning;
        RfBsdfKind kind;
    } cases[] = {
        { ",\"KHR_materials_clearcoat\":{\"clearcoatFactor\":1}", "a clear coat over diffuse transmission", RF_BSDF_TRANSLUCENT },
        { ",\"KHR_materials_anisotropy\":{\"anisotropyStrength\":1}", "sheen, anisotropy and films", RF_BSDF_TRANSLUCENT },
        { ",\"KHR_materials_volume\":{\"thicknessFactor\":1,\"attenuationDistance\":1}", "clear inside", RF_BSDF_TRANSLUCENT },
        { ",\"KHR_materials_transmission\":{\"transmissionFactor\":0.5}", "the opaque part of", RF_BSDF_GLASS },
    };
    for ( size_t i = 0; i < sizeof cases / sizeof *cases; ++i )
    {
        char material[512];
        snprintf( material, sizeof material, PLASTIC ",\"extensions\":{" DIFFUSE_TRANSMISSION "%s}", cases[i].more );
        RfScene s = load_ok( material, MESH, "" );
        assert_int_equal( s.materials->kind, cases[i].kind );
        if ( strstr( s_warning, cases[i].warning ) == NULL || strstr( s_warning, "'m'" ) == NULL )
            fail_msg( "'%s' does not say '%s'", s_warning, cases[i].warning );
        rf_destroy_scene( &s );
    }
}

TEST( test_faults_are_one_line )
{
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

#define OURS( text ) LIGHTS( "{\"type\":\"point\",\"extras\":{\"reframe\":{" text "}}}" )

TEST( test_faults_of_profiles_are_one_line )
{
    assert_fails( "", LAMP_NODE, OURS( "\"ies\":\"no-such.ies\"" ), "no-such.ies" );
    assert_fails( "", LAMP_NODE, OURS( "\"ies\":7" ), "lights[0].extras.reframe.ies: must be" );
    assert_fails( "", LAMP_NODE, OURS( "\"ies\":{\"bufferView\":99}" ), "ies.bufferView" );
    assert_fails( "", LAMP_NODE, OURS( "\"ies\":{\"bufferView\":0}" ), "bufferViews[0]: not an IES file" );
    assert_fails( "", LAMP_NODE, OURS( "\"ies\":{}" ), "bufferView" );
    assert_fails( "", LAMP_NODE, OURS( "\"profile\":{\"vertical\":[0,90],\"horizontal\":[0]}" ), "relative" );
    assert_fails( "", LAMP_NODE, OURS( "\"profile\":{\"vertical\":[0,90],\"horizontal\":[0],\"relative\":[1,2,3]}" ),
                  "has 3 intensities for 2 vertical and 1 horizontal angles" );
    assert_fails( "", LAMP_NODE, OURS( "\"profile\":{\"vertical\":[90,0],\"horizontal\":[0],\"relative\":[1,2]}" ),
                  "its vertical angle 1 is 0 degrees" );
    assert_fails( "", LAMP_NODE, OURS( "\"ies\":\"a.ies\",\"profile\":{}" ), "both ies and profile" );
    assert_fails( "", LAMP_NODE, OURS( "\"eis\":\"a.ies\"" ), "eis" );
    assert_fails( "", LAMP_NODE,
                  LIGHTS( "{\"type\":\"point\",\"intensity\":1e20,\"extras\":{\"reframe\":{\"profile\":{\"vertical\":[0,90],"
                          "\"horizontal\":[0],\"relative\":[1e12,1]}}}}" ),
                  "intensity" );
}

TEST( test_lamps_are_read )
{
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
    s = load_ok( "", LAMP_NODE,
                 LIGHTS( "{\"type\":\"spot\",\"spot\":{},\"extras\":{\"reframe\":{\"profile\":{\"vertical\":[0,90],"
                         "\"horizontal\":[0],\"relative\":[3,1]}}}}" ) );
    p = s.punctuals;
    // a table in the place of the cone
    assert_true( p->kind == RF_PUNCTUAL_POINT && p->turned && p->profile != NULL && p->profile->most == 3.0f );
    assert_true( fabsf( p->across.x - 1.0f ) < 1e-6f && p->profile->mean > 0.0 );
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

#define SIZED( type, text ) LIGHTS( "{\"type\":\"" type "\",\"extras\":{\"reframe\":{" text "}}}" )

TEST( test_lamps_have_sizes )
{
    RfScene s = load_ok( "", LAMP_NODE, SIZED( "point", "\"radius\":0.1,\"soft\":true" ) );
    assert_true( s.punctuals->kind == RF_PUNCTUAL_POINT && near( s.punctuals->radius, 0.1 ) && s.punctuals->soft );
    rf_destroy_scene( &s );
    s = load_ok( "", LAMP_NODE, SIZED( "directional", "\"angle\":60" ) );
    assert_true( fabsf( s.punctuals->versine - 0.13397460f ) < 1e-6f ); // 1 − cos 30°
    rf_destroy_scene( &s );
    s = load_ok( "", LAMP_NODE, SIZED( "point", "\"shape\":\"ellipse\",\"size\":[1,0.5],\"spread\":90" ) );
    const RfPunctual* p = s.punctuals;
    assert_true( p->kind == RF_PUNCTUAL_PLANE && p->ellipse && p->half[0] == 0.5f && p->half[1] == 0.25f );
    assert_true( near( p->tan_spread, 1 ) && near( p->spread_scale, 4.659792 ) ); // 1 / ( 1 − π/4 )
    assert_true( fabsf( p->direction.y + 1.0f ) < 1e-6f && fabsf( p->across.x - 1.0f ) < 1e-6f );
    rf_destroy_scene( &s );
    s = load_ok( "", LAMP_NODE, LIGHTS( "{\"type\":\"point\",\"extras\":7}" ) );
    assert_true( s.punctuals->radius == 0.0f );
    rf_destroy_scene( &s );
    assert_fails( "", LAMP_NODE, SIZED( "point", "\"angle\":1" ), "angle" );
    assert_fails( "", LAMP_NODE, SIZED( "point", "\"radius\":-1" ), "lights[0].extras.reframe.radius: must be" );
    assert_fails( "", LAMP_NODE, SIZED( "point", "\"shape\":\"star\",\"size\":[1,1]" ), "shape" );
    assert_fails( "", LAMP_NODE, SIZED( "point", "\"shape\":\"ellipse\"" ), "size" );
    assert_fails( "", LAMP_NODE, SIZED( "point", "\"shape\":\"ellipse\",\"size\":[1,0]" ), "size" );
    assert_fails( "", LAMP_NODE, SIZED( "directional", "\"radius\":1" ), "radius" );
}

#define INSTANCED( text ) "{\"mesh\":0,\"translation\":[5,0,0],\"extensions\":{\"EXT_mesh_gpu_instancing\":{" text "}}}"

TEST( test_instances_are_read )
{
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

#define GLOSSY( members ) EXTENSIONS( "\"KHR_materials_pbrSpecularGlossiness\":{" members "}" )

TEST( test_glossiness )
{
    RfScene s =
        load_ok( GLOSSY( "\"diffuseFactor\":[0.8,0.4,0.2,1],\"specularFactor\":[0.5,0.25,0.125],\"glossinessFactor\":0.4" ), MESH,
                 ",\"extensionsRequired\":[\"KHR_materials_pbrSpecularGlossiness\"]" );
    const RfMaterial* m = s.materials;
    assert_int_equal( m->kind, RF_BSDF_GGX );
    assert_true( near( m->diffuse.x, 0.8 ) && near( m->diffuse.z, 0.2 ) );
    assert_true( near( m->specular.x, 0.5 ) && near( m->specular.y, 0.25 ) && near( m->specular.z, 0.125 ) );
    assert_true( near( m->f90, 1.0 ) && near( m->coat_f0, 0.5 ) && near( m->coat_f90, 1.0 ) && near( m->alpha, 0.36 ) );
    rf_destroy_scene( &s );
    s = load_ok( GLOSSY( "" ), MESH, "" ); // all white, as smooth as can be
    m = s.materials;
    assert_true( near( m->diffuse.x, 1.0 ) && near( m->specular.x, 1.0 ) && m->alpha == RF_MIN_ALPHA );
    rf_destroy_scene( &s );
    assert_fails( GLOSSY( "\"glossinessFactor\":2" ), MESH, "", "SpecularGlossiness: glossinessFactor is 2, it must be 0 to 1" );
    assert_fails( GLOSSY( "\"glossinessFactor\":\"much\"" ), MESH, "", "SpecularGlossiness: glossinessFactor must be a number" );
    assert_fails( GLOSSY( "\"diffuseFactor\":7" ), MESH, "", "SpecularGlossiness: diffuseFactor" );
    assert_fails( GLOSSY( "\"specularFactor\":[5,0,0]" ), MESH, "", "SpecularGlossiness: specularFactor is 5" );
    assert_fails( EXTENSIONS( "\"KHR_materials_pbrSpecularGlossiness\":7" ), MESH, "", "SpecularGlossiness must be an object" );
}

// Two meshes: one with a mapping for each variant, one without.
#define VARIANTS( mappings )                                                                                                     \
    "\"extensions\":{\"KHR_materials_variants\":{\"variants\":[{\"name\":\"noon\"},{\"name\":\"night\"}]}},"                     \
    "\"extensionsRequired\":[\"KHR_materials_variants\"],\"materials\":[{\"name\":\"plain\"},{\"name\":\"pale\"},"               \
    "{\"name\":\"dark\"}],\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":"  \
    "0,"                                                                                                                         \
    "\"extensions\":{\"KHR_materials_variants\":{\"mappings\":[" mappings                                                        \
    "]}}},{\"attributes\":{\"POSITION\":0},\"material\":0}]}]"

static RfResult load_variant( const char* rest, const char* variant, RfScene* scene, RfError* error )
{
    GltfBuilder b = { 0 };
    GltfFolder folder = make_folder();
    RfGltfOptions options = { .variant = variant };
    add_gltf_floats( &b, "VEC3", 3, 3, s_corners );
    RfResult result = rf_load_gltf_with( write_gltf( &b, &folder, rest ), &options, scene, NULL, error );
    remove_folder( &folder );
    return result;
}

TEST( test_variants )
{
    static const char* const s_rest = VARIANTS( "{\"material\":1,\"variants\":[0]},{\"material\":2,\"variants\":[1]}" );
    static const char* const s_names[] = { NULL, "noon", "night" };
    uint64_t hashes[3];
    RfError error = { 0 };
    for ( uint32_t i = 0; i < 3; ++i )
    {
        RfScene s;
        assert_int_equal( load_variant( s_rest, s_names[i], &s, &error ), RF_OK );
        assert_true( s.triangles.count == 2 && s.triangles.material[0] == i && s.triangles.material[1] == 0 );
        assert_int_equal( s.variant_count, 2 );
        assert_string_equal( s.variants[1], "night" );
        hashes[i] = s.content_hash;
        rf_destroy_scene( &s );
    }
    assert_true( hashes[0] != hashes[1] && hashes[1] != hashes[2] && hashes[0] != hashes[2] );

    // one without a name is chosen by that under which it is listed
    RfScene unnamed;
    static const char* const s_unnamed =
        "\"extensions\":{\"KHR_materials_variants\":{\"variants\":[{\"name\":\"\"}]}},\"nodes\":[]";
    assert_int_equal( load_variant( s_unnamed, "KHR_materials_variants.variants[0]", &unnamed, &error ), RF_OK );
    rf_destroy_scene( &unnamed );

    static const char* const s_faults[][3] = {
        { VARIANTS( "" ), "dusk", "KHR_materials_variants: none is called 'dusk': there are 'noon', 'night'" },
        { "\"nodes\":[]", "dusk", "KHR_materials_variants: none is called 'dusk': there are none" },
        { VARIANTS( "{\"variants\":[0]}" ), "noon", "KHR_materials_variants.mappings[0]: material is missing" },
        { VARIANTS( "{\"variants\":[0],\"material\":3}" ), "noon", "mappings[0]: material is 3, but there are 3 materials" },
        { VARIANTS( "7" ), "noon", "mappings[0]" },
        { "\"extensions\":{\"KHR_materials_variants\":{\"variants\":[{}]}}", NULL, "KHR_materials_variants.variants[0]: name" },
        { "\"extensions\":{\"KHR_materials_variants\":{\"variants\":[7]}}", "x", "KHR_materials_variants.variants[0]" },
    };
    for ( size_t i = 0; i < sizeof s_faults / sizeof s_faults[0]; ++i )
    {
        RfScene s;
        assert_int_not_equal( load_variant( s_faults[i][0], s_faults[i][1], &s, &error ), RF_OK );
        if ( strstr( error.text, s_faults[i][2] ) == NULL )
            fail_msg( "'%s' does not say '%s'", error.text, s_faults[i][2] );
    }
}
