// What the reader makes of movement: joints and weights of every type, animations that contend, what cannot be rendered yet,
// and files that are broken.
#include "support/scene_files.h"
#include "support/test.h"

#include "gltf/gltf.h"
#include "scene/changes.h"
#include "scene/deformation.h"
#include "scene/movement.h"
#include "scene/pose.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// 0 a triangle, 1 times, 2 places, 3 floats of its vertices with four numbers each.
static const float s_triangle[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
static const float s_times[] = { 0, 1 }, s_moves[] = { 0, 0, 0, 4, 0, 0 };
static const float s_fours[] = { 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0 };

static GltfBuilder make_triangle( void )
{
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 3, s_triangle );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_times );
    add_gltf_floats( &b, "VEC3", 3, 2, s_moves );
    add_gltf_floats( &b, "VEC4", 4, 3, s_fours );
    return b;
}

#define MESH( attributes, more ) "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0" attributes "}" more "}]}]"
#define MOVE( node ) "{\"sampler\":0,\"target\":{\"node\":" node ",\"path\":\"translation\"}}"
#define SAMPLERS( input, output, more ) "\"samplers\":[{\"input\":" input ",\"output\":" output more "}]"
#define ANIMATION( name, channels ) "{\"name\":\"" name "\"," SAMPLERS( "1", "2", "" ) ",\"channels\":[" channels "]}"
#define POINTER( pointer )                                                                                                       \
    "{\"sampler\":0,\"target\":{\"path\":\"pointer\",\"extensions\":{\"KHR_animation_pointer\":{\"pointer\":\"" pointer "\"}}}}"

// ---- Skins ----------------------------------------------------------------------

// Two joints, of which the second moves by 4 in x.
#define SKINNED( skin, attributes )                                                                                              \
    "\"nodes\":[{\"mesh\":0,\"skin\":0},{},{}],\"skins\":[{\"joints\":[1,2]" skin                                                \
    "}]," MESH( attributes, "" ) ","                                                                                             \
                                 "\"animations\":[" ANIMATION( "wave", MOVE( "2" ) ) "]"

static void assert_x( const RfScene* scene, int vertex, double want )
{
    RfPosedScene pose = { 0 };
    RfError error;
    assert_int_equal( rf_pose_scene( scene, 1.0, &pose, &error ), RF_OK );
    const RfPlacement* placement = pose.scene.placements + pose.scene.still_placement_count;
    float got = pose.scene.meshes[placement->mesh].triangles.positions[3 * vertex];
    if ( !( fabs( (double)got - want ) < 1e-5 ) )
        fail_msg( "vertex %d: x is %g, wants %g", vertex, (double)got, want );
    rf_destroy_pose( &pose );
}

TEST( test_joints_and_weights_of_each_type )
{
    // each vertex: so much of the second joint
    static const uint8_t s_joints[] = { 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0 };
    static const uint16_t s_long_joints[] = { 0, 1, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0 };
    static const float s_real[] = { 0.75f, 0.25f, 0, 0, 1, 0, 0, 0, 0.2f, 0.2f, 0, 0 };
    static const uint8_t s_bytes[] = { 191, 64, 0, 0, 255, 0, 0, 0, 100, 100, 0, 0 };
    static const uint16_t s_shorts[] = { 49151, 16384, 0, 0, 65535, 0, 0, 0, 1000, 1000, 0, 0 };
    static const double s_share[] = { 64.0 / 255, 16384.0 / 65535, 0.25 };
    for ( int j = 0; j < 2; ++j )
    {
        for ( int w = 0; w < 3; ++w )
        {
            GltfBuilder b = make_triangle();
            if ( j == 0 )
                add_gltf_accessor( &b, 5121, "VEC4", 3, s_joints, sizeof s_joints, "" );
            else
                add_gltf_accessor( &b, 5123, "VEC4", 3, s_long_joints, sizeof s_long_joints, "" );
            if ( w == 0 )
                add_gltf_accessor( &b, 5121, "VEC4", 3, s_bytes, sizeof s_bytes, ",\"normalized\":true" );
            else if ( w == 1 )
                add_gltf_accessor( &b, 5123, "VEC4", 3, s_shorts, sizeof s_shorts, ",\"normalized\":true" );
            else
                add_gltf_floats( &b, "VEC4", 4, 3, s_real );
            RfScene scene = gltf_load_built( &b, SKINNED( "", ",\"JOINTS_0\":4,\"WEIGHTS_0\":5" ) );
            assert_x( &scene, 0, 4 * s_share[w] );
            assert_x( &scene, 1, 1 + 4 );
            assert_x( &scene, 2, 4 * 0.5 ); // which are made to sum to 1
            gltf_assert_warned( "weights sum to" );
            rf_destroy_scene( &scene );
        }
    }
}

TEST( test_eight_joints )
{
    static const uint8_t s_first[] = { 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0 }, s_second[] = { 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1 };
    static const float s_parts[] = { .125f, .125f, .125f, .125f, .25f, .25f, .25f, .25f, 0, 0, 0, 0 };
    static const float s_rest[] = { .125f, .125f, .125f, .125f, 0, 0, 0, 0, .25f, .25f, .25f, .25f };
    for ( int more = 0; more < 2; ++more )
    {
        GltfBuilder b = make_triangle();
        add_gltf_accessor( &b, 5121, "VEC4", 3, s_first, sizeof s_first, "" );
        add_gltf_accessor( &b, 5121, "VEC4", 3, s_second, sizeof s_second, "" );
        add_gltf_floats( &b, "VEC4", 4, 3, s_parts );
        add_gltf_floats( &b, "VEC4", 4, 3, s_rest );
        RfScene scene = gltf_load_built(
            &b,
            more ? SKINNED( "", ",\"JOINTS_0\":4,\"JOINTS_1\":5,\"JOINTS_2\":4,\"WEIGHTS_0\":6,\"WEIGHTS_1\":7,\"WEIGHTS_2\":6" )
                 : SKINNED( "", ",\"JOINTS_0\":4,\"JOINTS_1\":5,\"WEIGHTS_0\":6,\"WEIGHTS_1\":7" ) );
        if ( more )
            gltf_assert_warned( "has JOINTS_2: each vertex follows the first eight of its joints" );
        else
            assert_string_equal( gltf_warnings, "" );
        assert_x( &scene, 0, 2 );
        assert_x( &scene, 1, 1 );
        assert_x( &scene, 2, 4 );
        rf_destroy_scene( &scene );
    }
}

// A vertex of which no joint has any.
TEST( test_vertices_without_weights )
{
    static const uint8_t s_joints[] = { 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0 };
    static const float s_weights[] = { 0, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0 };
    GltfBuilder b = make_triangle();
    add_gltf_accessor( &b, 5121, "VEC4", 3, s_joints, sizeof s_joints, "" );
    add_gltf_floats( &b, "VEC4", 4, 3, s_weights );
    RfScene scene = gltf_load_built( &b, SKINNED( "", ",\"JOINTS_0\":4,\"WEIGHTS_0\":5" ) );
    gltf_assert_warned( "has vertices without weights: they follow their first joint" );
    assert_x( &scene, 0, 4 );
    rf_destroy_scene( &scene );
}

// ---- Animations -----------------------------------------------------------------

#define TWO_NODES                                                                                                                \
    "\"nodes\":[{\"name\":\"a\",\"mesh\":0},{\"name\":\"b\",\"mesh\":0},{\"name\":\"c\",\"mesh\":0}]," MESH( "", "" )
#define CONTEND                                                                                                                  \
    TWO_NODES ",\"animations\":[" ANIMATION( "Walk", MOVE( "0" ) ) "," ANIMATION(                                                \
        "Run", MOVE( "0" ) "," MOVE( "1" ) ) "," ANIMATION( "Sway", MOVE( "2" ) ) "]"

TEST( test_animations_that_contend )
{
    GltfBuilder b = make_triangle();
    RfScene scene = gltf_load_built( &b, CONTEND );
    gltf_assert_warned( "animation 'Walk' is used: 'Run', which moves the same, is left out" );
    assert_int_equal( scene.placement_count, 2 ); // a and c
    assert_int_equal( scene.triangles.count, 1 );
    uint64_t hash = scene.content_hash;
    rf_destroy_scene( &scene );

    b = make_triangle();
    scene = gltf_load_with( write_gltf( &b, &gltf_folder, CONTEND ), &( RfGltfOptions ){ .animation = "Run" } );
    assert_string_equal( gltf_warnings, "" );
    assert_int_equal( scene.placement_count, 3 );
    assert_true( hash != scene.content_hash );
    rf_destroy_scene( &scene );

    RfGltfOptions options = { .animation = "Fly" };
    RfError error = { 0 };
    b = make_triangle();
    RfResult result = rf_load_gltf_with( write_gltf( &b, &gltf_folder, CONTEND ), &options, &scene, NULL, &error );
    assert_int_equal( result, RF_ERROR_USAGE );
    assert_non_null( strstr( error.text, "none is called 'Fly': there are 'Walk', 'Run', 'Sway'" ) );
}

// As where each object has animations of its own, of the same names.
TEST( test_animations_of_one_name )
{
    static const char s_file[] = TWO_NODES ",\"animations\":[" ANIMATION( "Idle", MOVE( "0" ) ) "," ANIMATION(
        "Jump", MOVE( "0" ) ) "," ANIMATION( "Idle", MOVE( "1" ) "," MOVE( "2" ) ) "," ANIMATION( "Jump", MOVE( "1" ) ) "]";
    GltfBuilder b = make_triangle();
    RfScene scene = gltf_load_built( &b, s_file );
    gltf_assert_warned( "animation 'Idle' is used: 'Jump', which move the same, are left out" );
    assert_int_equal( scene.placement_count, 3 );
    rf_destroy_scene( &scene );

    b = make_triangle(); // the second 'Idle', which moves c, moves b as well
    scene = gltf_load_with( write_gltf( &b, &gltf_folder, s_file ), &( RfGltfOptions ){ .animation = "Jump" } );
    assert_string_equal( gltf_warnings, "" );
    assert_int_equal( scene.placement_count, 2 );
    rf_destroy_scene( &scene );

    RfGltfOptions options = { .animation = "Fly" };
    RfError error = { 0 };
    b = make_triangle();
    RfResult result = rf_load_gltf_with( write_gltf( &b, &gltf_folder, s_file ), &options, &scene, NULL, &error );
    assert_int_equal( result, RF_ERROR_USAGE );
    assert_non_null( strstr( error.text, "there are 'Idle', 'Jump'" ) );
}

TEST( test_frozen )
{
    GltfBuilder b = make_triangle();
    RfScene scene = gltf_load_with( write_gltf( &b, &gltf_folder, CONTEND ), &( RfGltfOptions ){ .freeze = true } );
    assert_null( scene.movement );
    assert_int_equal( scene.placement_count, 0 );
    assert_int_equal( scene.triangles.count, 3 );
    assert_int_equal( scene.moving_count, 2 ); // b goes with the animation that is left out
    assert_true( scene.frozen );
    gltf_assert_warned( "'a', 'c' move or change: frozen as in the first frame" );
    rf_destroy_scene( &scene );
}

// A channel whose keys are equal moves nothing, and places all the same.
TEST( test_keys_that_are_equal )
{
    static const float s_same[] = { 5, 0, 0, 5, 0, 0 };
    GltfBuilder b = make_triangle();
    add_gltf_floats( &b, "VEC3", 3, 2, s_same );
    RfScene scene = gltf_load_built( &b, "\"nodes\":[{\"mesh\":0}]," MESH( "", "" ) ",\"animations\":[{" SAMPLERS(
                                             "1", "4", "" ) ",\"channels\":[" MOVE( "0" ) "]}]" );
    assert_null( scene.movement );
    gltf_assert_corner( &scene, 0, 5, 0, 0 );
    rf_destroy_scene( &scene );
}

TEST( test_targets_of_other_attributes )
{
    GltfBuilder b = make_triangle();
    RfScene scene = gltf_load_built( &b, "\"nodes\":[{\"mesh\":0,\"weights\":[1]}]," MESH(
                                             ",\"COLOR_0\":3", ",\"targets\":[{\"POSITION\":0,\"_own\":0,\"COLOR_0\":3}]" ) );
    gltf_assert_warned( "meshes[0].primitives[0].targets[0] changes COLOR_0, which stays as it is" );
    assert_null( strstr( gltf_warnings, "_own" ) );
    rf_destroy_scene( &scene );
}

TEST( test_pointers_to_nodes )
{
    GltfBuilder b = make_triangle();
    RfScene scene = gltf_load_built( &b, "\"nodes\":[{\"mesh\":0}]," MESH( "", "" ) ",\"animations\":[" ANIMATION(
                                             "", POINTER( "/nodes/0/translation" ) ) "]" );
    assert_int_equal( scene.unrendered_count, 0 );
    assert_x( &scene, 0, 0 ); // in its own space
    RfPosedScene pose = { 0 };
    assert_int_equal( rf_pose_scene( &scene, 1.0, &pose, NULL ), RF_OK );
    assert_true( pose.scene.placements[0].matrix.m[12] == 4.0 );
    rf_destroy_pose( &pose );
    rf_destroy_scene( &scene );
}

// ---- What cannot be rendered yet --------------------------------------------------

static void assert_unrendered( const RfScene* scene, const char* what, const char* why )
{
    for ( int i = 0; i < scene->unrendered_count; ++i )
    {
        if ( strcmp( scene->unrendered[i].what, what ) == 0 && strstr( scene->unrendered[i].why, why ) != NULL )
            return;
    }
    fail_msg( "%s is not among the %d listed: %s", what, scene->unrendered_count,
              scene->unrendered_count > 0 ? scene->unrendered[0].what : "none" );
}

#define NORMAL_SCALE "/materials/0/normalTexture/scale"

TEST( test_what_cannot_be_rendered )
{
    GltfBuilder b = make_triangle();
    RfScene scene = gltf_load_built(
        &b, "\"scenes\":[{\"nodes\":[0,1],\"extras\":{\"reframe\":{\"moving\":[\"smoke\",\"bulb\"]}}}],\"nodes\":[{\"name\":"
            "\"bulb\",\"mesh\":0},{\"name\":\"off\",\"extensions\":{\"KHR_lights_punctual\":{\"light\":0},"
            "\"KHR_node_visibility\":{\"visible\":false}}}],\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":"
            "\"point\"}]}},\"materials\":[{\"name\":\"glow\",\"emissiveFactor\":[1,1,1]}]," MESH(
                "", ",\"material\":0" ) ",\"animations\":[" ANIMATION( "all",
                                                                       MOVE( "0" ) "," MOVE( "1" ) "," POINTER(
                                                                           NORMAL_SCALE ) ) "]" );
    assert_int_equal( scene.unrendered_count, 2 ); // not the bulb, which moves and shines
    assert_unrendered( &scene, "material 'glow'", "animates '" NORMAL_SCALE "'" );
    assert_unrendered( &scene, "object 'smoke'", "where the file was made" );
    assert_int_equal( scene.punctual_count, 0 ); // it is hidden at all times
    assert_int_equal( scene.moving_count, 1 );
    RfChanging* changing; // the light of the bulb
    assert_int_equal( rf_list_changing( &scene, &changing ), 1 );
    assert_true( changing->kind == RF_CHANGING_MATERIAL && changing->shines && changing->what_count == 1 );
    assert_string_equal( changing->name, "glow" );
    assert_string_equal( changing->what[0], "place" );
    free( changing );
    rf_destroy_scene( &scene );
}

// ---- Broken files -----------------------------------------------------------------

typedef struct Broken
{
    const char* json;
    const char* part; // of the error
} Broken;

#define SHAPED( more, channels )                                                                                                 \
    "\"nodes\":[{\"mesh\":0" more "}]," MESH( "", ",\"targets\":[{\"POSITION\":0},{}]" ) ",\"animations\":[{" channels "}]"

// After those of make_triangle: 4 joints 0 and 1, 5 joint 2 with a weight, 6 two matrices, 7 one, 8 one with a bad row, 9 two fours,
// 10 negative weights, 11 a NaN, 12 two bytes, 13 a matrix of 9.
static GltfBuilder make_parts( void )
{
    static const uint8_t s_joints[] = { 0, 0, 0, 0, 1, 0, 0, 0, 0, 9, 9, 9 }, s_beyond[] = { 0, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0 };
    static const float s_binds[] = { 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1,
                                     1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1 };
    static const float s_bad[] = {
        1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1
    };
    static const float s_negative[] = { 1, 0, 0, 0, 2, -1, 0, 0, 1, 0, 0, 0 };
    static const uint8_t s_truth[] = { 1, 0 };
    const float nan_weights[] = { 1, 0, 0, 0, NAN, 0, 0, 0, 1, 0, 0, 0 };
    GltfBuilder b = make_triangle();
    add_gltf_accessor( &b, 5121, "VEC4", 3, s_joints, sizeof s_joints, "" );
    add_gltf_accessor( &b, 5121, "VEC4", 3, s_beyond, sizeof s_beyond, "" );
    add_gltf_floats( &b, "MAT4", 16, 2, s_binds );
    add_gltf_floats( &b, "MAT4", 16, 1, s_binds );
    add_gltf_floats( &b, "MAT4", 16, 2, s_bad );
    add_gltf_floats( &b, "VEC4", 4, 2, s_fours );
    add_gltf_floats( &b, "VEC4", 4, 3, s_negative );
    add_gltf_floats( &b, "VEC4", 4, 3, nan_weights );
    add_gltf_accessor( &b, 5121, "SCALAR", 2, s_truth, sizeof s_truth, "" );
    add_gltf_floats( &b, "MAT3", 9, 2, s_binds );
    return b;
}

#define SKIN_OF( skin )                                                                                                          \
    "\"nodes\":[{\"mesh\":0,\"skin\":0},{}],\"skins\":[{" skin "}]," MESH( ",\"JOINTS_0\":4,\"WEIGHTS_0\":3", "" )
#define TO_WEIGHTS "\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"weights\"}}]"

static const Broken s_broken[] = {
    { SKINNED( "", ",\"JOINTS_0\":5,\"WEIGHTS_0\":3" ), "nodes[0]: its mesh follows joint 2, but its skin has 2 joints" },
    { SKINNED( "", ",\"JOINTS_0\":4" ), "must have JOINTS_0 and WEIGHTS_0, or neither" },
    { SKINNED( "", "" ), "has no JOINTS_0, but a node has its mesh with a skin" },
    { SKINNED( "", ",\"JOINTS_0\":3,\"WEIGHTS_0\":3" ), "JOINTS_0 must be unsigned bytes or shorts" },
    { SKINNED( "", ",\"JOINTS_0\":4,\"WEIGHTS_0\":4" ), "WEIGHTS_0 must be floats or normalized" },
    { SKINNED( "", ",\"JOINTS_0\":4,\"WEIGHTS_0\":9" ), "WEIGHTS_0 has 2 elements, POSITION has 3" },
    { SKINNED( "", ",\"JOINTS_0\":4,\"WEIGHTS_0\":10" ), "a weight of a joint is -1" },
    { SKINNED( "", ",\"JOINTS_0\":4,\"WEIGHTS_0\":11" ), "accessors[11]: element 1, number 0 is not finite" },
    { SKINNED( "", ",\"JOINTS_0\":4,\"WEIGHTS_0\":0" ), "elements of 3 numbers, 4 are needed" },
    { SKINNED( ",\"inverseBindMatrices\":7", ",\"JOINTS_0\":4,\"WEIGHTS_0\":3" ), "has 1 elements for 2 joints" },
    { SKINNED( ",\"inverseBindMatrices\":8", ",\"JOINTS_0\":4,\"WEIGHTS_0\":3" ), "a last row other than 0 0 0 1" },
    { SKINNED( ",\"inverseBindMatrices\":13", ",\"JOINTS_0\":4,\"WEIGHTS_0\":3" ), "must be MAT4 of floats" },
    { SKINNED( ",\"inverseBindMatrices\":3", ",\"JOINTS_0\":4,\"WEIGHTS_0\":3" ), "must be MAT4 of floats" },
    { SKINNED( ",\"inverseBindMatrices\":99", ",\"JOINTS_0\":4,\"WEIGHTS_0\":3" ), "inverseBindMatrices is 99" },
    { SKIN_OF( "" ), "skins[0]: joints is missing" },
    { SKIN_OF( "\"joints\":[]" ), "joints must be 1 to 65536 nodes, got 0" },
    { SKIN_OF( "\"joints\":[7]" ), "joints[0] must be an index below 2" },
    { SKIN_OF( "\"joints\":[-1]" ), "joints[0] must be an index below 2" },
    { SKIN_OF( "\"joints\":[\"x\"]" ), "joints[0] must be an index below 2" },
    { SKIN_OF( "\"joints\":3" ), "joints must be an array" },
    { "\"nodes\":[{\"mesh\":0,\"skin\":3},{}],\"skins\":[{\"joints\":[1]}]," MESH( "", "" ), "skin is 3, but there are 1 skins" },
    { "\"nodes\":[{\"mesh\":0,\"skin\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":2}}}},{}],"
      "\"skins\":[{\"joints\":[1,1]}]," MESH( ",\"JOINTS_0\":4,\"WEIGHTS_0\":3", "" ),
      "instances with a skin are not read" },
    { SHAPED( "", SAMPLERS( "1", "1", "" ) "," TO_WEIGHTS ), "output accessors[1] has 2 elements, 4 are needed" },
    { SHAPED( "", SAMPLERS( "1", "2", "" ) "," TO_WEIGHTS ), "elements of 3 numbers, 1 are needed" },
    { SHAPED( ",\"weights\":[1]", SAMPLERS( "1", "1", "" ) ",\"channels\":[]" ), "weights must be 2 numbers, got 1" },
    { "\"nodes\":[{\"mesh\":0}]," MESH( "", "" ) ",\"animations\":[{" SAMPLERS( "1", "1", "" ) "," TO_WEIGHTS "}]",
      "animates the weights of nodes[0], which has no morph targets" },
    { "\"nodes\":[{\"mesh\":0,\"weights\":[1]}]," MESH( "", ",\"targets\":[{\"POSITION\":2}]" ),
      "targets[0]: POSITION has 2 elements, the primitive has 3" },
    { "\"nodes\":[{\"mesh\":0,\"weights\":[1]}]," MESH( "", ",\"targets\":[{\"POSITION\":3}]" ), "of 4 numbers, 3 are needed" },
    { "\"nodes\":[{\"mesh\":0,\"weights\":[1]}]," MESH( "", ",\"targets\":[5]" ), "targets[0]: must be an object" },
    { "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"targets\":[{}]},{\"attributes\":{"
      "\"POSITION\":0}}]}]",
      "has 0 targets, the primitives before it have 1" },
    { "\"nodes\":[{\"mesh\":0}]," MESH( "", "" ) ",\"animations\":[{" SAMPLERS( "1", "12", "" ) ",\"channels\":[" POINTER(
          "/nodes/0/extensions/KHR_node_visibility/visible" ) "]}]",
      "shows and hides nodes[0], whose interpolation must be STEP" },
    { "\"nodes\":[{}],\"animations\":[{" SAMPLERS( "1", "2", "" ) ",\"channels\":[" POINTER( "/nodes/4/scale" ) "]}]",
      "pointer '/nodes/4/scale' names a node that does not exist" },
    { "\"nodes\":[{}],\"animations\":[{" SAMPLERS( "1", "2",
                                                   "" ) ",\"channels\":[{\"sampler\":0,\"target\":{\"path\":\"pointer\"}}]}]",
      "target.extensions.KHR_animation_pointer is missing" },
    { "\"nodes\":[{\"extensions\":{\"KHR_node_visibility\":{\"visible\":1}}}]", "visible must be true or false" },
};

TEST( test_broken_files )
{
    for ( size_t i = 0; i < sizeof s_broken / sizeof s_broken[0]; ++i )
    {
        GltfBuilder b = make_parts();
        gltf_refuse_built( &b, s_broken[i].json, s_broken[i].part );
    }
}

// Joints without a weight are not looked at, and without inverse bind matrices they are the identity.
TEST( test_what_is_not_broken )
{
    GltfBuilder b = make_parts();
    RfScene scene = gltf_load_built( &b, SKINNED( "", ",\"JOINTS_0\":4,\"WEIGHTS_0\":3" ) );
    assert_x( &scene, 0, 0 );
    assert_x( &scene, 1, 5 );
    rf_destroy_scene( &scene );
}

// ---- Mutated files ----------------------------------------------------------------

static uint8_t* build_rich( size_t* size )
{
    GltfBuilder b = make_parts();
    return build_glb(
        &b,
        "\"nodes\":[{\"mesh\":0,\"skin\":0},{\"children\":[2]},{\"extensions\":{\"KHR_node_visibility\":{\"visible\":"
        "true}}},{\"mesh\":1,\"weights\":[0.5]},{\"mesh\":1,\"children\":[3]}],\"skins\":[{\"joints\":[1,2],"
        "\"inverseBindMatrices\":6}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":4,"
        "\"WEIGHTS_0\":3}}]},{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"targets\":[{\"POSITION\":0}]}]}],"
        "\"animations\":[{\"samplers\":[{\"input\":1,\"output\":2},{\"input\":1,\"output\":1},{\"input\":1,"
        "\"output\":12,\"interpolation\":\"STEP\"}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":"
        "\"translation\"}},{\"sampler\":0,\"target\":{\"node\":4,\"path\":\"scale\"}},{\"sampler\":1,\"target\":{"
        "\"node\":3,\"path\":\"weights\"}},{\"sampler\":2,\"target\":{\"path\":\"pointer\",\"extensions\":{"
        "\"KHR_animation_pointer\":{\"pointer\":\"/nodes/4/extensions/KHR_node_visibility/visible\"}}}}]}]",
        size );
}

static void pose_thrice( const RfScene* scene )
{
    for ( int k = 0; k < 3; ++k )
    {
        RfPosedScene pose = { 0 };
        RfError error = { 0 };
        RfResult result = rf_pose_scene( scene, 0.5 * k, &pose, &error );
        assert_true( result == RF_OK || error.text[0] != 0 );
        rf_destroy_pose( &pose );
    }
}

TEST( test_mutated_files )
{
    size_t size;
    uint8_t *bytes = build_rich( &size ), *mutated = malloc( size );
    RfScene scene = gltf_load( write_bytes( &gltf_folder, "a.glb", bytes, size ) );
    assert_int_equal( scene.placement_count, 3 );
    rf_destroy_scene( &scene );
    int loaded = 0;
    for ( uint64_t i = 0; i < 3000; ++i )
    {
        memcpy( mutated, bytes, size );
        size_t length = mutate_bytes( mutated, size, i );
        RfError error = { 0 };
        const char* path = write_bytes( &gltf_folder, "a.glb", mutated, length );
        if ( rf_load_gltf( path, &scene, NULL, &error ) == RF_OK )
        {
            pose_thrice( &scene );
            loaded += 1;
        }
        else if ( error.text[0] == 0 )
            fail_msg( "mutation %llu: an error without a text", (unsigned long long)i );
        rf_destroy_scene( &scene );
    }
    assert_true( loaded > 100 );
    free( mutated );
    free( bytes );
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
