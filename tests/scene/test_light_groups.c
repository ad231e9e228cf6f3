// Light groups: tags of lamps, nodes, materials and the sky, materials that are in several groups, and what a render may ask for.
#include "support/cli_run.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "scene/light_groups.h"
#include "scene/movement.h"
#include "scene/placement.h"
#include "scene/pose.h"

#define TAG( name ) "\"extras\":{\"reframe\":{\"light_group\":\"" name "\"}}"
#define LAMP( name, more ) "{\"type\":\"point\",\"name\":\"" name "\"" more "}"
#define USES( light ) "\"extensions\":{\"KHR_lights_punctual\":{\"light\":" light "}}"
#define MATERIAL( name, more ) "{\"name\":\"" name "\"" more "}"
#define PRIMITIVE( material ) "{\"attributes\":{\"POSITION\":0},\"material\":" material "}"

// Nodes 0 to 2: a bulb with a socket in two groups and in none; 3: another mesh with the bulb's material, in a group of its own;
// 4 to 6: lamps.
#define SKY "\"extras\":{\"reframe\":{\"environment\":{\"radiance\":[1,1,1],\"light_group\":\"sky\"}}}"
#define BULB MATERIAL( "bulb", ",\"emissiveFactor\":[1,1,1]" )
#define LIGHTS( list ) "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[" list "]}}"
#define MESHES "{\"primitives\":[" PRIMITIVE( "0" ) "," PRIMITIVE( "1" ) "]},{\"primitives\":[" PRIMITIVE( "0" ) "]}"
#define BULBS "{\"mesh\":0," TAG( "key" ) "},{\"mesh\":0," TAG( "fill" ) "},{\"mesh\":0},{\"mesh\":1," TAG( "rim" ) "}"
#define LAMPS "{" USES( "0" ) "},{" USES( "0" ) "," TAG( "fill" ) "},{" USES( "1" ) "}"
#define ROOM( more )                                                                                                             \
    "\"scenes\":[{\"nodes\":[0,1,2,3,4,5,6]," SKY "}],\"materials\":[" BULB                                                      \
    "," MATERIAL( "socket", "" ) "],\"meshes\":[" MESHES "],\"nodes\":[" BULBS "," LAMPS                                         \
                                 "]," LIGHTS( LAMP( "Desk", "," TAG( "key" ) ) "," LAMP( "Spare", "" ) ) more

static GltfBuilder make_triangle( void )
{
    static const float s_triangle[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 }, s_at[] = { 1, 3 }, s_strengths[] = { 2, 4 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 3, s_triangle );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_at );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_strengths );
    return b;
}

static const char* name_of( const RfScene* scene, uint16_t tag ) { return tag > 0 ? scene->light_groups[tag - 1] : "none"; }

static void expect_light( const RfScene* scene, int index, const char* kind, const char* name, const char* group, bool shines )
{
    RfLightInfo light;
    assert_true( rf_scene_light( scene, index, &light ) );
    assert_string_equal( light.kind, kind );
    assert_string_equal( light.name, name );
    assert_string_equal( light.group >= 0 ? scene->light_groups[light.group] : "none", group );
    assert_int_equal( light.shines, shines );
}

TEST( test_a_material_in_several_groups_is_split )
{
    GltfBuilder b = make_triangle();
    AUTO_SCENE scene = gltf_load_built( &b, ROOM( "" ) );
    assert_int_equal( scene.material_count, 5 );
    assert_int_equal( scene.light_group_count, 4 );
    const char* const groups[] = { "none", "none", "key", "fill", "rim" };
    for ( uint32_t i = 0; i < 5; ++i )
    {
        assert_string_equal( scene.materials[i].name, i == 1 ? "socket" : "bulb" );
        assert_string_equal( name_of( &scene, scene.materials[i].light_group ), groups[i] );
        assert_true( ( scene.materials[i].emission.x == 1.0f ) == ( i != 1 ) );
    }
    // four bulbs of all groups and three sockets, whichever order the meshes are in
    int counts[5] = { 0 };
    for ( uint32_t i = 0; i < rf_triangle_count( &scene ); ++i )
        counts[rf_material_of( &scene, i )] += 1;
    const int wanted[5] = { 1, 3, 1, 1, 1 };
    assert_memory_equal( counts, wanted, sizeof wanted );
    expect_light( &scene, 0, "lamp", "Desk", "key", true );
    expect_light( &scene, 1, "lamp", "Desk", "fill", true ); // its node's goes first
    expect_light( &scene, 2, "lamp", "Spare", "none", true );
    expect_light( &scene, 4, "material", "socket", "none", false );
    expect_light( &scene, 8, "sky", "environment", "sky", true );
    RfLightInfo light;
    assert_false( rf_scene_light( &scene, 9, &light ) );
}

// Of one group, a material is what it was.
TEST( test_a_material_in_one_group_is_kept )
{
    GltfBuilder b = make_triangle();
    AUTO_SCENE scene = gltf_load_built(
        &b, "\"scenes\":[{\"nodes\":[0,1]}],\"materials\":[" MATERIAL(
                "bulb", ",\"emissiveFactor\":[1,1,1],\"extras\":{\"reframe\":{\"bsdf\":\"lambert\","
                        "\"diffuse\":[0.5,0.5,0.5],\"light_group\":\"own\"}}" ) "],\"meshes\":[{"
                                                                                "\"primitives\":[" PRIMITIVE(
                                                                                    "0" ) "]}],\"nodes\":[{"
                                                                                          "\"mesh\":0," TAG(
                                                                                              "key" ) "},"
                                                                                                      "{\"mesh\":"
                                                                                                      "0," TAG( "key" ) "}]" );
    assert_int_equal( scene.material_count, 1 );
    assert_int_equal( scene.materials[0].kind, RF_BSDF_LAMBERT );
    assert_string_equal( name_of( &scene, scene.materials[0].light_group ), "key" );
}

#define DIMS                                                                                                                     \
    ",\"animations\":[{\"samplers\":[{\"input\":1,\"output\":2}],\"channels\":[{\"sampler\":0,\"target\":{\"path\":\"pointer\"," \
    "\"extensions\":{\"KHR_animation_pointer\":{\"pointer\":\"/materials/0/extensions/KHR_materials_emissive_strength/"          \
    "emissiveStrength\"}}}}]}]"

TEST( test_copies_change_as_well )
{
    GltfBuilder b = make_triangle();
    AUTO_SCENE scene = gltf_load_built( &b, ROOM( DIMS ) );
    assert_int_equal( scene.movement->material_count, 4 );
    AUTO_POSE pose = gltf_pose_at( &scene, 2.0 );
    for ( uint32_t i = 0; i < 5; ++i )
        gltf_assert_near( pose.scene.materials[i].emission.y, i == 1 ? 0.0 : 3.0 );
}

static void expect_groups( const RfScene* scene, const char* asked, const char* names, const char* lights )
{
    AUTO_BY( rf_destroy_light_groups ) RfLightGroups groups;
    RfError error = { 0 };
    char text[400] = "";
    if ( rf_find_light_groups( scene, asked, &groups, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    for ( int i = 0; i < groups.count; ++i )
        snprintf( text + strlen( text ), sizeof text - strlen( text ), "%s%s", i > 0 ? "," : "", groups.names[i] );
    assert_string_equal( text, names );
    // of the lamps, the materials and the sky, one digit each
    text[0] = '\0';
    for ( int i = 0; i < scene->punctual_count; ++i )
        snprintf( text + strlen( text ), 8, "%d", groups.punctual[i] );
    for ( uint32_t i = 0; i < scene->material_count; ++i )
        snprintf( text + strlen( text ), 8, "%d", groups.material[i] );
    snprintf( text + strlen( text ), 8, "%d", groups.sky );
    assert_string_equal( text, lights );
}

static void expect_refused( const RfScene* scene, const char* asked, const char* part )
{
    RfLightGroups groups;
    RfError error = { 0 };
    assert_int_equal( rf_find_light_groups( scene, asked, &groups, &error ), RF_ERROR_USAGE );
    if ( strstr( error.text, part ) == NULL )
        fail_msg( "'%s' gave '%s' instead of '%s'", asked, error.text, part );
    assert_null( groups.punctual );
}

TEST( test_groups_that_a_render_asks_for )
{
    GltfBuilder b = make_triangle();
    AUTO_SCENE scene = gltf_load_built( &b, ROOM( "" ) );
    // lamps Desk, Desk, Spare; materials bulb, socket, bulb of key, fill, rim; the sky
    expect_groups( &scene, "all", "key,fill,rim,sky,rest",
                   "014440123"
                   "" );
    expect_groups( &scene, "lamps", "Desk,Spare,bulb,environment", "001202223" );
    expect_groups( &scene, "fill", "fill,rest", "101111011" );
    expect_groups( &scene, "fill,Desk,environment", "fill,Desk,environment,rest", "103333032" );
    RfLightGroups none;
    assert_int_equal( rf_find_light_groups( &scene, NULL, &none, NULL ), RF_OK );
    assert_int_equal( none.count, 0 );
    expect_refused( &scene, "fil",
                    "no light group or light is called 'fil': did you mean 'fill'? there are 'key', 'fill', 'rim', "
                    "'sky', 'Desk'" );
    expect_refused( &scene, "fill,key,fill", "light group 'fill' is given twice" );
    expect_refused( &scene, "rest", "'rest' cannot be asked for" );
    expect_refused( &scene, "fill,", "is called ''" );
}

// What is dark is not in "all", but may be asked for; seventeen lamps are too many.
TEST( test_dark_groups_and_too_many )
{
    char text[4096], *end = text;
    GltfBuilder b = make_triangle();
    RfScene scene = gltf_load_built(
        &b, "\"scenes\":[{\"nodes\":[0,1]}],\"nodes\":[{" USES( "0" ) "},{" USES(
                "1" ) "}],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":"
                      "[" LAMP( "On", "," TAG( "key" ) ) "," LAMP( "Off", ",\"intensity\":0," TAG( "dark" ) ) "]}}" );
    expect_groups( &scene, "all", "key", "000" );
    expect_groups( &scene, "lamps", "On", "000" );
    expect_refused( &scene, "key,On", "light 'On' is in light group 'key' already" );
    expect_groups( &scene, "dark", "dark,rest", "101" );
    rf_destroy_scene( &scene );
    b = make_triangle();
    scene = gltf_load_built(
        &b, "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{" USES( "0" ) "}],\"extensions\":{"
                                                                    "\"KHR_lights_punctual\":{\"lights\":[" LAMP(
                                                                        "Off", ",\"intensity\":0," TAG( "dark" ) ) "]}}" );
    expect_groups( &scene, "all", "rest", "00" );
    rf_destroy_scene( &scene );
    end += sprintf( end, "\"scenes\":[{\"nodes\":[0" );
    for ( int i = 1; i < 17; ++i )
        end += sprintf( end, ",%d", i );
    end += sprintf( end, "]}],\"nodes\":[" );
    for ( int i = 0; i < 17; ++i )
        end += sprintf( end, "%s{" USES( "%d" ) "}", i > 0 ? "," : "", i );
    end += sprintf( end, "],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[" );
    for ( int i = 0; i < 17; ++i )
        end += sprintf( end, "%s" LAMP( "L%d", "" ), i > 0 ? "," : "", i );
    sprintf( end, "]}}" );
    b = make_triangle();
    scene = gltf_load_built( &b, text );
    expect_refused( &scene, "lamps", "more than 16 light groups, after 'L0', 'L1'" );
    expect_refused( &scene, "all", "has no light groups" );
    expect_groups( &scene, "L3,L5", "L3,L5,rest", "222021222222222222" );
    rf_destroy_scene( &scene );
}

TEST( test_tags_must_be_names )
{
    static const char* const wrong[] = { "\"a,b\"", "\"\"", "7", "\"a\\nb\"",
                                         "\"1234567890123456789012345678901234567890123456789012345678901234\"" };
    for ( size_t i = 0; i < sizeof wrong / sizeof wrong[0]; ++i )
    {
        char text[512];
        GltfBuilder b = make_triangle();
        snprintf( text, sizeof text, "\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{\"extras\":{\"reframe\":{\"light_group\":%s}}}]",
                  wrong[i] );
        gltf_refuse_built( &b, text, "nodes[0].extras.reframe.light_group: must be a name of 1 to 63 bytes without commas" );
        b = make_triangle();
        snprintf( text, sizeof text,
                  "\"scenes\":[{\"nodes\":[]}],\"materials\":[{\"extras\":{\"reframe\":{\"light_group\":%s}}}]", wrong[i] );
        gltf_refuse_built( &b, text, "materials[0].extras.reframe.light_group" );
    }
}

// Scene files tag lamps, materials and the sky, and files that they place bring their own.
TEST( test_scene_files_tag_lights )
{
    RfScene scene;
    RfError error = { 0 };
    write_room( "" );
    write_text( "lamp.gltf",
                "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{" USES(
                    "0" ) "}],"
                          "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[" LAMP( "Torch", "," TAG( "fill" ) ) "]}}}" );
    if ( try_members( "\"materials\":{\"vase\":{\"bsdf\":\"gltf\",\"light_group\":\"key\"},\"lamp\":{\"light_group\":\"fill\"},"
                      "\"wood floor\":{\"light_group\":\"rim\",\"bsdf\":\"lambert\",\"diffuse\":[0,0,0]}},"
                      "\"environment\":{\"radiance\":[1,1,1],\"light_group\":\"sky\"},"
                      "\"objects\":[{\"file\":\"lamp.gltf\"}]",
                      &scene, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    assert_string_equal( name_of( &scene, scene.materials[0].light_group ), "key" );
    assert_string_equal( name_of( &scene, scene.materials[1].light_group ), "rim" );
    assert_string_equal( name_of( &scene, scene.materials[2].light_group ), "fill" );
    assert_string_equal( name_of( &scene, scene.materials[4].light_group ), "fill" );
    assert_string_equal( name_of( &scene, scene.environment.light_group ), "sky" );
    assert_int_equal( scene.punctual_count, 1 );
    assert_string_equal( name_of( &scene, scene.punctuals[0].light_group ), "fill" );
    assert_int_equal( scene.light_group_count, 4 );
    rf_destroy_scene( &scene );
    assert_int_equal( try_members( "\"materials\":{\"vase\":{\"light_group\":\"\"}}", &scene, &error ), RF_ERROR_SCENE );
    // the glTF's own sky
    static const char tag[] = "\"environment\":{\"light_group\":\"dusk\"}";
    assert_int_equal( try_members( tag, &scene, &error ), RF_ERROR_SCENE );
    assert_non_null( strstr( error.text, "scene.json: environment: the scene has none" ) );
    write_text( "room.gltf", "{\"asset\":{\"version\":\"2.0\"},\"scenes\":[{\"nodes\":[]," SKY "}]}" );
    assert_int_equal( try_members( tag, &scene, &error ), RF_OK );
    assert_string_equal( name_of( &scene, scene.environment.light_group ), "dusk" );
    assert_true( scene.environment.radiance.x == 1.0f );
    rf_destroy_scene( &scene );
}

static int enter( void** state ) { return gltf_enter( state ) != 0 ? 1 : cli_enter_group( state ); }

static int leave( void** state ) { return cli_leave_group( state ) != 0 ? 1 : gltf_leave( state ); }

SHARED_BY_TESTS( enter, leave )
