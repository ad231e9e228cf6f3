// Whose surfaces are: objects, assets, materials and their numbers, in world space, placed and moving, alone and in a scene file.
#include "support/cli_run.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "scene/placement.h"

static const float s_corners[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
static const float s_times[] = { 0, 1 };
static const float s_places[] = { 0, 0, 0, 1, 0, 0 };

#define TRIANGLE( material ) "{\"attributes\":{\"POSITION\":0},\"material\":" #material "}"

// A set of a chair with a leg of two materials, a stone without a name, and a door that moves. `leg` and `materials` have extras.
static void build( GltfBuilder* b, const char* leg, const char* materials, char* rest, size_t size )
{
    *b = ( GltfBuilder ){ 0 };
    add_gltf_floats( b, "VEC3", 3, 3, s_corners );
    add_gltf_floats( b, "SCALAR", 1, 2, s_times );
    add_gltf_floats( b, "VEC3", 3, 2, s_places );
    snprintf( rest, size,
              "\"animations\":[{\"samplers\":[{\"input\":1,\"output\":2}],\"channels\":[{\"sampler\":0,"
              "\"target\":{\"node\":4,\"path\":\"translation\"}}]}],"
              "\"meshes\":[{\"primitives\":[" TRIANGLE( 0 ) "]},{\"primitives\":[" TRIANGLE( 1 ) "," TRIANGLE(
                  0 ) "]}],"
                      "\"nodes\":[{\"name\":\"Set\",\"children\":[1,4]},{\"name\":\"Chair\",\"mesh\":0,\"children\":[2]},"
                      "{\"name\":\"Leg\",\"mesh\":1%s},{\"mesh\":0},{\"name\":\"Door\",\"mesh\":0}],"
                      "\"materials\":[%s]",
              leg, materials );
}

static const char* object_at( const RfScene* scene, uint32_t triangle )
{
    return rf_object_name( scene, rf_node_of_triangle( scene, triangle ) );
}

static const char* asset_at( const RfScene* scene, uint32_t triangle )
{
    return rf_asset_name( scene, rf_node_of_triangle( scene, triangle ) );
}

// Triangles are in the order of meshes: of mesh 0 the stone and the chair, then of mesh 1 the leg, then what moves.
static void expect_names( const RfScene* scene, uint32_t first, const char* const names[5], const char* const assets[5] )
{
    for ( uint32_t i = 0; i < 5; ++i )
    {
        uint32_t triangle = i < 4 ? first + i : rf_triangle_count( scene ) - 1;
        assert_string_equal( object_at( scene, triangle ), names[i] );
        assert_string_equal( asset_at( scene, triangle ), assets[i] );
    }
}

TEST( test_names_of_nodes )
{
    GltfBuilder b;
    char rest[4096];
    build( &b, "", "{\"name\":\"wood\"},{}", rest, sizeof rest );
    AUTO_SCENE scene = gltf_load_built( &b, rest );
    expect_names( &scene, 0, ( const char*[] ){ "nodes[3]", "Chair", "Leg", "Leg", "Door" },
                  ( const char*[] ){ "nodes[3]", "Set", "Set", "Set", "Set" } );
    float of_node[6], of_material[2];
    bool marked[6];
    rf_list_object_indices( &scene, of_node );
    rf_list_material_indices( &scene, of_material );
    for ( int n = 0; n < 6; ++n )
        assert_true( of_node[n] == (float)n );
    assert_true( of_material[0] == 1.0f && of_material[1] == 2.0f );
    rf_mark_objects( &scene, marked );
    assert_memory_equal( marked, ( ( bool[] ){ false, false, true, true, true, true } ), sizeof marked );
}

TEST( test_extras_go_first )
{
    GltfBuilder b;
    char rest[4096];
    build( &b, ",\"extras\":{\"reframe\":{\"object\":\"Leg.001\",\"asset\":\"Legs\",\"pass_index\":7}}",
           "{\"extras\":{\"reframe\":{\"pass_index\":3}}},"
           "{\"extras\":{\"reframe\":{\"bsdf\":\"mirror\",\"specular\":[1,1,1],\"pass_index\":4}}}",
           rest, sizeof rest );
    AUTO_SCENE scene = gltf_load_built( &b, rest );
    expect_names( &scene, 0, ( const char*[] ){ "nodes[3]", "Chair", "Leg.001", "Leg.001", "Door" },
                  ( const char*[] ){ "nodes[3]", "Set", "Legs", "Legs", "Set" } );
    float of_node[6], of_material[2];
    rf_list_object_indices( &scene, of_node );
    rf_list_material_indices( &scene, of_material );
    for ( int n = 0; n < 6; ++n )
        assert_true( of_node[n] == ( n == 3 ? 7.0f : 0.0f ) );
    assert_true( of_material[0] == 3.0f && of_material[1] == 4.0f );
    assert_int_equal( scene.materials[0].kind, RF_BSDF_GGX ); // as without extras
    build( &b, ",\"extras\":{\"reframe\":{\"asset\":\"\"}}", "{},{}", rest, sizeof rest );
    gltf_refuse_built( &b, rest, "nodes[2].extras.reframe: asset must not be empty" );
    build( &b, ",\"extras\":{\"reframe\":{\"pass_index\":-1}}", "{},{}", rest, sizeof rest );
    gltf_refuse_built( &b, rest, "pass_index must be 0 to 16777215" );
    build( &b, "", "{},{\"extras\":{\"reframe\":{\"pass_index\":\"a\"}}}", rest, sizeof rest );
    gltf_refuse_built( &b, rest, "materials[1].extras.reframe: pass_index must be an integer" );
}

// What is placed by a scene file belongs to the object that places it.
TEST_WITHIN( test_placed_files, cli_enter_group, cli_leave_group )
{
    GltfBuilder b;
    char rest[4096];
    AUTO_SCENE scene;
    RfError error = { 0 };
    size_t size;
    build( &b, "", "{},{}", rest, sizeof rest );
    AUTO_FREE uint8_t* bytes = build_glb( &b, rest, &size );
    cli_write( "set.glb", bytes, size );
    write_room( "" );
    if ( try_members( "\"objects\":[{\"file\":\"set.glb\",\"name\":\"Left\"},{\"file\":\"set.glb\"}]", &scene, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    uint32_t room = scene.triangles.count - 8;
    assert_string_equal( object_at( &scene, 0 ), asset_at( &scene, 0 ) );
    expect_names( &scene, room, ( const char*[] ){ "nodes[3]", "Chair", "Leg", "Leg", "Door" },
                  ( const char*[] ){ "Left", "Left", "Left", "Left", "set.glb" } );
    assert_string_equal( asset_at( &scene, room + 4 ), "set.glb" );
    assert_string_equal( asset_at( &scene, rf_triangle_count( &scene ) - 2 ), "Left" );
}

static void keep_line( void* user, const char* line )
{
    char* lines = user;
    size_t used = strlen( lines );
    snprintf( lines + used, 1024 - used, "%s\n", line + ( strrchr( line, '/' ) != NULL ? strrchr( line, '/' ) + 1 - line : 0 ) );
}

// Of plates that shine, "Twin" lies on the first one, "Shifted" and "Turned" partly; others are beside it, above, across, and back
// to back. "Flipped" lies on one that shines to both sides.
TEST( test_emitters_in_one_place )
{
    static const float s_plate[] = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 1, 1, 0, 0, 1, 0 };
    static const float s_flipped[] = { 1, 1, 0, 1, 0, 0, 0, 0, 0, 0, 1, 0, 1, 1, 0, 0, 0, 0 };
    char lines[1024] = "";
    RfLog log = { keep_line, lines, 0 };
    RfError error = { 0 };
    AUTO_SCENE scene;
    RfSceneInfo info;
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 6, s_plate );
    add_gltf_floats( &b, "VEC3", 3, 6, s_flipped );
    const char* path =
        write_gltf( &b, &gltf_folder,
                    "\"materials\":[{\"emissiveFactor\":[1,1,1]},{\"emissiveFactor\":[1,1,1],\"doubleSided\":true}],"
                    "\"meshes\":[{\"primitives\":[" TRIANGLE( 0 ) "]},{\"primitives\":[" TRIANGLE(
                        1 ) "]},"
                            "{\"primitives\":[{\"attributes\":{\"POSITION\":1},\"material\":1}]}],"
                            "\"nodes\":[{\"name\":\"Plate\",\"mesh\":0},{\"name\":\"Twin\",\"mesh\":0},"
                            "{\"name\":\"Shifted\",\"mesh\":0,\"translation\":[0.99,0.5,0]},"
                            "{\"name\":\"Turned\",\"mesh\":0,\"rotation\":[0,0,1,0],\"translation\":[0.5,0.1,0]},"
                            "{\"name\":\"Beside\",\"mesh\":0,\"translation\":[-1,1,0]},"
                            "{\"name\":\"Above\",\"mesh\":0,\"translation\":[0,0,1e-4]},"
                            "{\"name\":\"Across\",\"mesh\":0,\"rotation\":[0,0.1,0,0.99498743710662],\"translation\":[0,0,0.1]},"
                            "{\"name\":\"Back\",\"mesh\":0,\"rotation\":[0,1,0,0],\"translation\":[0.7,0.3,0]},"
                            "{\"name\":\"Sheet\",\"mesh\":1,\"translation\":[5,0,0]},{\"name\":\"Flipped\",\"mesh\":2,"
                            "\"translation\":[5,0,0]}]" );
    if ( rf_load_scene_with( path, &( RfSceneOptions ){ 0 }, &scene, &log, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    assert_string_equal(
        lines, "a.gltf: emitting triangles of 'Twin' lie on those of 'Plate', 2 are left out: delete or move them\n"
               "a.gltf: emitting triangles of 'Plate' and 'Shifted' overlap in one plane, so their light depends on "
               "the settings: move one\n"
               "a.gltf: emitting triangles of 'Plate' and 'Turned' overlap in one plane, so their light depends on the "
               "settings: move one\n"
               "a.gltf: emitting triangles of 'Flipped' lie on those of 'Sheet', 2 are left out: delete or move them\n" );
    assert_int_equal( rf_scene_info( &scene, &info, &error ), RF_OK );
    assert_int_equal( info.triangles, 20 );
    assert_int_equal( info.emitting_triangles, 16 );
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
