// Skins and morph targets at a moment, against closed forms, and files of others that have them.
#include "support/scene_files.h"
#include "support/test.h"

#include "scene/deformation.h"
#include "scene/movement.h"
#include "scene/placement.h"
#include "scene/pose.h"

#define HALF 0.70710678118654752

static const float s_times[] = { 0, 1 };

#define ONE_MESH( members ) "\"meshes\":[{\"primitives\":[" members "]}]"
#define LINEAR( node, path, times, values )                                                                                      \
    "\"animations\":[{\"samplers\":[{\"input\":" times ",\"output\":" values "}],\"channels\":[{\"sampler\":0,\"target\":{"      \
    "\"node\":" node ",\"path\":\"" path "\"}}]}]"

// ---- Skins ----------------------------------------------------------------------

// A strip along y in the plane x = 0, of vertices at heights 0, 1 and 2, whose upper half hangs on a joint at height 1.
static const float s_strip[] = { 0, 0, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 2, 0, 0, 2, 1 };
static const float s_across[] = { 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0 };
static const uint16_t s_strip_faces[] = { 0, 2, 1, 1, 2, 3, 2, 4, 3, 3, 4, 5 };
static const uint8_t s_strip_joints[] = { 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0 };
static const float s_strip_weights[] = { 1, 0, 0, 0, 1, 0, 0, 0, .5f, .5f, 0, 0, .5f, .5f, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0 };
static const float s_binds[] = {
    1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, -1, 0, 1
};

// 0 positions, 1 normals, 2 faces, 3 joints, 4 weights, 5 inverse binds, 6 times
static GltfBuilder make_strip( void )
{
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 6, s_strip );
    add_gltf_floats( &b, "VEC3", 3, 6, s_across );
    add_gltf_u16( &b, 12, s_strip_faces );
    add_gltf_accessor( &b, 5121, "VEC4", 6, s_strip_joints, sizeof s_strip_joints, "" );
    add_gltf_floats( &b, "VEC4", 4, 6, s_strip_weights );
    add_gltf_floats( &b, "MAT4", 16, 2, s_binds );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_times );
    return b;
}

// The node of the mesh is elsewhere, which a skin ignores; the joints stand at x = 3.
#define STRIP( animation )                                                                                                       \
    "\"nodes\":[{\"mesh\":0,\"skin\":0,\"name\":\"arm\",\"translation\":[0,0,99]},{\"children\":[2],\"translation\":[3,0,0]},"   \
    "{\"translation\":[0,1,0]}],\"skins\":[{\"joints\":[1,2],\"inverseBindMatrices\":5}]," ONE_MESH(                             \
        "{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"JOINTS_0\":3,\"WEIGHTS_0\":4},\"indices\":2}" ) animation

TEST( test_a_bent_arm )
{
    GltfBuilder b = make_strip();
    static const float s_turns[] = { 0, 0, 0, 1, 0, 0, (float)HALF, (float)HALF };
    add_gltf_floats( &b, "VEC4", 4, 2, s_turns );
    AUTO_SCENE scene = gltf_load_built( &b, STRIP( "," LINEAR( "2", "rotation", "6", "7" ) ) );
    assert_int_equal( scene.triangles.count, 0 );
    assert_int_equal( scene.placement_count, 1 );
    RfPosedScene pose = gltf_pose_at( &scene, 0.0 );
    for ( uint32_t i = 0; i < 12; ++i )
    {
        const float* p = s_strip + 3 * (size_t)s_strip_faces[i];
        gltf_assert_placed_corner( &pose.scene, i / 3, (int)( i % 3 ), 3.0, (double)p[1], (double)p[2] );
        gltf_assert_three( gltf_placed_normal( &pose.scene, i / 3, (int)( i % 3 ) ), 1, 0, 0 );
    }
    rf_destroy_pose( &pose );

    pose = gltf_pose_at( &scene, 1.0 ); // by 90 degrees about z: up becomes −x, across becomes up
    gltf_assert_placed_corner( &pose.scene, 0, 0, 3, 0, 0 );
    gltf_assert_placed_corner( &pose.scene, 0, 1, 3, 1, 0 );
    gltf_assert_placed_corner( &pose.scene, 2, 1, 2, 1, 0 );
    gltf_assert_placed_corner( &pose.scene, 3, 2, 2, 1, 1 );
    gltf_assert_three( gltf_placed_normal( &pose.scene, 0, 0 ), 1, 0, 0 );
    gltf_assert_three( gltf_placed_normal( &pose.scene, 0, 1 ), HALF, HALF, 0 );
    gltf_assert_three( gltf_placed_normal( &pose.scene, 2, 1 ), 0, 1, 0 );
    gltf_assert_rgb( pose.scene.meshes[pose.scene.placements[0].mesh].bounds_min, 2, 0, 0 );
    gltf_assert_rgb( pose.scene.meshes[pose.scene.placements[0].mesh].bounds_max, 3, 1, 1 );
    rf_destroy_pose( &pose );
}

// By linear blending, a twist of 180 degrees pinches the middle: there the matrix has no volume.
TEST( test_singular_skins )
{
    GltfBuilder b = make_strip();
    static const float s_twist[] = { 0, 0, 0, 1, 0, 1, 0, 0 };
    add_gltf_floats( &b, "VEC4", 4, 2, s_twist );
    RfScene scene = gltf_load_built( &b, STRIP( "," LINEAR( "2", "rotation", "6", "7" ) ) );
    RfPosedScene pose = gltf_pose_at( &scene, 1.0 );
    assert_true( pose.scene.placements[0].shown );
    gltf_assert_placed_corner( &pose.scene, 3, 0, 3, 1, 0 ); // (0, 1, 1) of one joint and (0, 1, −1) of the other
    const RfTriangles* t = &pose.scene.meshes[pose.scene.placements[0].mesh].triangles;
    for ( int i = 0; i < 4; ++i )
        assert_int_equal( t->indices[3 * i] == t->indices[3 * i + 1], i == 1 || i == 2 );
    gltf_assert_placed_corner( &pose.scene, 3, 2, 3, 2, -1 );
    gltf_assert_unit_normals( &pose.scene );
    rf_destroy_pose( &pose );
    rf_destroy_scene( &scene );

    b = make_strip();
    static const float s_scales[] = { 1, 1, 1, 0, 0, 0 };
    add_gltf_floats( &b, "VEC3", 3, 2, s_scales );
    scene = gltf_load_built( &b, STRIP( "," LINEAR( "1", "scale", "6", "7" ) ) );
    pose = gltf_pose_at( &scene, 1.0 );
    assert_false( pose.scene.placements[0].shown );
    gltf_assert_unit_normals( &pose.scene );
    rf_destroy_pose( &pose );
    rf_destroy_scene( &scene );
}

TEST( test_mirrored_skins_keep_their_outside )
{
    GltfBuilder b = make_strip();
    static const float s_scales[] = { 1, 1, 1, 1, 1, -1 };
    add_gltf_floats( &b, "VEC3", 3, 2, s_scales );
    AUTO_SCENE scene = gltf_load_built( &b, STRIP( "," LINEAR( "1", "scale", "6", "7" ) ) );
    AUTO_POSE pose = gltf_pose_at( &scene, 1.0 );
    for ( uint32_t i = 0; i < 4; ++i )
    {
        double p[3][3];
        for ( int c = 0; c < 3; ++c )
        {
            gltf_find_placed_corner( &pose.scene, i, c, p[c] );
            gltf_assert_three( gltf_placed_normal( &pose.scene, i, c ), 1, 0, 0 );
        }
        double across = ( p[1][1] - p[0][1] ) * ( p[2][2] - p[0][2] ) - ( p[1][2] - p[0][2] ) * ( p[2][1] - p[0][1] );
        assert_true( across > 0.0 );
    }
}

// A skin whose joints stand still is triangles like any others.
TEST( test_a_posed_figure_that_stands_still )
{
    GltfBuilder b = make_strip();
    AUTO_SCENE scene = gltf_load_built( &b, STRIP( "" ) );
    assert_null( scene.movement );
    assert_int_equal( scene.placement_count, 0 );
    assert_int_equal( scene.mesh_count, 0 );
    assert_int_equal( scene.triangles.count, 4 );
    gltf_assert_corner( &scene, 0, 3, 0, 0 );
    gltf_assert_corner( &scene, 11, 3, 2, 1 );
    gltf_assert_rgb( scene.bounds_max, 3, 2, 1 );
}

// Tangents turn with the joints; where these mirror, the bitangent stays on its side.
TEST( test_tangents_of_a_skin )
{
    static const float s_along[] = { 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, -1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 0, 0 };
    static const float s_turns[] = { 0, (float)HALF, 0, (float)HALF, 0, 0, 0, 1 }, s_scales[] = { 1, 1, 1, 1, 1, -1 };
    for ( int k = 0; k < 2; ++k )
    {
        GltfBuilder b = make_strip();
        add_gltf_floats( &b, "VEC4", 4, 2, s_turns );
        add_gltf_floats( &b, "VEC3", 3, 2, s_scales );
        add_gltf_floats( &b, "VEC4", 4, 6, s_along ); // 9
        char rest[2048];
        snprintf( rest, sizeof rest,
                  "\"nodes\":[{\"mesh\":0,\"skin\":0},{}],\"skins\":[{\"joints\":[1,1]}],"
                  "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":9,\"JOINTS_0\":3,"
                  "\"WEIGHTS_0\":4},\"indices\":2}]}],\"animations\":[{\"samplers\":[{\"input\":6,\"output\":%d}],\"channels\":[{"
                  "\"sampler\":0,\"target\":{\"node\":1,\"path\":\"%s\"}}]}]",
                  7 + k, k == 0 ? "rotation" : "scale" );
        AUTO_SCENE scene = gltf_load_built( &b, rest );
        AUTO_POSE pose = gltf_pose_at( &scene, k == 0 ? 0.0 : 1.0 );
        const RfTriangles* t = &pose.scene.meshes[pose.scene.placements[0].mesh].triangles;
        // vertices in the order of their first use: 0 2 1 3 4 5
        gltf_assert_three( t->tangents, k == 0, 0, k == 0 ? 0 : -1 );
        gltf_assert_near( t->tangents[3], k == 0 ? 1 : -1 );
        gltf_assert_near( t->tangents[7], k == 0 ? -1 : 1 );
        gltf_assert_three( t->tangents + 20, 0, 0, 0 ); // none in the file
        gltf_assert_near( t->tangents[23], 0 );
    }
}

// Far from the origin, where floats are a metre apart: the scene is loaded around another.
TEST( test_a_figure_far_out )
{
    GltfBuilder b = make_strip();
    static const float s_turns[] = { 0, 0, 0, 1, 0, 0, (float)HALF, (float)HALF };
    add_gltf_floats( &b, "VEC4", 4, 2, s_turns );
    AUTO_SCENE scene = gltf_load_built(
        &b, "\"nodes\":[{\"mesh\":0,\"skin\":0},{\"children\":[2],\"translation\":[10000000.125,0,0]},{\"translation\":[0,1,"
            "0]}],\"skins\":[{\"joints\":[1,2],\"inverseBindMatrices\":5}]," ONE_MESH(
                "{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":3,\"WEIGHTS_0\":4},\"indices\":2}" ) "," LINEAR( "2", "rotation",
                                                                                                               "6", "7" ) );
    assert_true( fabs( scene.origin[0] - 1e7 ) < 100.0 );
    AUTO_POSE pose = gltf_pose_at( &scene, 1.0 );
    gltf_assert_placed_corner( &pose.scene, 2, 1, 10000000.125 - scene.origin[0] - 1, 1, 0 );
}

// ---- Morph targets --------------------------------------------------------------

// A square of two triangles, 0; normals, 1; times, 2; target 3 lifts all, target 4, sparse, moves the corner (1, 1) onto (0, 0).
static GltfBuilder make_square( void )
{
    static const float s_square[] = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 };
    static const float s_up[] = { 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1 };
    static const float s_lift[] = { 0, 0, 2, 0, 0, 2, 0, 0, 2, 0, 0, 2 };
    static const float s_keys[] = { 0, 1, 3 };
    static const uint16_t s_index[] = { 2 };
    static const float s_moved[] = { -1, -1, 0 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 4, s_square );
    add_gltf_floats( &b, "VEC3", 3, 4, s_up );
    add_gltf_floats( &b, "SCALAR", 1, 3, s_keys );
    add_gltf_floats( &b, "VEC3", 3, 4, s_lift );
    add_gltf_u16( &b, 1, s_index );
    add_gltf_floats( &b, "VEC3", 3, 1, s_moved );
    // without a view of its own: zeros but for one
    strcat( b.accessors,
            ",{\"componentType\":5126,\"count\":4,\"type\":\"VEC3\",\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":4,"
            "\"componentType\":5123},\"values\":{\"bufferView\":5}}}" );
    return b; // accessor 6
}

#define SQUARE( more )                                                                                                           \
    "\"nodes\":[{\"mesh\":0,\"name\":\"sheet\",\"translation\":[0,0,5]" more "}],\"meshes\":[{\"weights\":[0.5,0],"              \
    "\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"mode\":6,\"targets\":[{\"POSITION\":3,\"NORMAL\":"          \
    "7},{\"POSITION\":6}]}]}]"
#define WEIGHTS( values, kind )                                                                                                  \
    "\"animations\":[{\"samplers\":[{\"input\":2,\"output\":" values ",\"interpolation\":\"" kind "\"}],\"channels\":["          \
    "{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"weights\"}}]}]"

// Builders number accessors by their views: those after the sparse one are one behind.
static int add_after_sparse( GltfBuilder* b, const char* type, int components, int count, const float* data )
{
    b->count += 1;
    strcat( b->views, ",{\"buffer\":0,\"byteLength\":4}" );
    return add_gltf_floats( b, type, components, count, data );
}

static GltfBuilder make_morph( int count, const float* weights )
{
    static const float s_lean[] = { 1, 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0 };
    GltfBuilder b = make_square();
    assert_int_equal( add_after_sparse( &b, "VEC3", 3, 4, s_lean ), 7 );
    assert_int_equal( add_gltf_floats( &b, "SCALAR", 1, count, weights ), 8 );
    return b;
}

TEST( test_morph_targets )
{
    static const float s_weights[] = { 0, 0, 1, 0, 0, 1 };
    GltfBuilder b = make_morph( 6, s_weights );
    AUTO_SCENE scene = gltf_load_built( &b, SQUARE( "" ) "," WEIGHTS( "8", "LINEAR" ) );
    assert_int_equal( scene.placement_count, 1 );
    assert_int_equal( scene.movement->movers[0].target_count, 2 );
    RfPosedScene pose = gltf_pose_at( &scene, 0.5 ); // half of the lift, whose normals lean by half
    gltf_assert_placed_corner( &pose.scene, 0, 0, 1, 0, 6 );
    gltf_assert_placed_corner( &pose.scene, 0, 1, 1, 1, 6 );
    gltf_assert_three( gltf_placed_normal( &pose.scene, 1, 1 ), 0.5 / sqrt( 1.25 ), 0, 1 / sqrt( 1.25 ) );
    rf_destroy_pose( &pose );

    pose = gltf_pose_at( &scene, 2.0 ); // half of both
    gltf_assert_placed_corner( &pose.scene, 0, 1, 0.5, 0.5, 6 );
    rf_destroy_pose( &pose );

    pose = gltf_pose_at( &scene, 3.0 ); // both triangles have collapsed, and the mesh is gone
    assert_false( pose.scene.placements[0].shown );
    gltf_assert_unit_normals( &pose.scene );
    rf_destroy_pose( &pose );
    assert_false( rf_scene_moves( &scene, 3.0, 4.0 ) );
}

TEST( test_weights_by_splines )
{
    // in-tangents, values, out-tangents of each key, each of two weights
    static const float s_spline[] = { 0, 0, 0.25f, 0, 1, 0, -1, 0, 0.5f, 0, 2, 0, 3, 0, 0, 0, 0, 0 };
    GltfBuilder b = make_morph( 18, s_spline );
    AUTO_SCENE scene = gltf_load_built( &b, SQUARE( "" ) "," WEIGHTS( "8", "CUBICSPLINE" ) );
    for ( int k = 0; k <= 12; ++k )
    {
        double time = 0.25 * k, length = time < 1 ? 1 : 2, t = time < 1 ? time : ( time - 1 ) / 2;
        const float* from = s_spline + ( time < 1 ? 2 : 8 );
        double w = ( 2 * t * t * t - 3 * t * t + 1 ) * (double)from[0] +
                   length * ( t * t * t - 2 * t * t + t ) * (double)from[2] + ( 3 * t * t - 2 * t * t * t ) * (double)from[6] +
                   length * ( t * t * t - t * t ) * (double)from[4];
        AUTO_POSE pose = gltf_pose_at( &scene, time );
        gltf_assert_placed_corner( &pose.scene, 0, 0, 1, 0, 5 + 2 * w );
    }
}

TEST( test_weights_at_rest )
{
    static const float s_none[] = { 0 };
    GltfBuilder b = make_morph( 1, s_none );
    RfScene scene = gltf_load_built( &b, SQUARE( "" ) );
    assert_null( scene.movement );
    assert_int_equal( scene.triangles.count, 2 );
    gltf_assert_corner( &scene, 0, 1, 0, 6 );
    rf_destroy_scene( &scene );
    b = make_morph( 1, s_none );
    scene = gltf_load_built( &b, SQUARE( ",\"weights\":[2,0],\"scale\":[1,1,2]" ) );
    gltf_assert_corner( &scene, 0, 1, 0, 13 );
    gltf_assert_normal( &scene, 0, 4 / sqrt( 17.0 ), 0, 1 / sqrt( 17.0 ) );
    rf_destroy_scene( &scene );
    b = make_morph( 1, s_none );
    scene = gltf_load_built( &b, SQUARE( ",\"weights\":[0,0]" ) );
    gltf_assert_corner( &scene, 0, 1, 0, 5 );
    rf_destroy_scene( &scene );
}

// A face on a head that turns: targets first, then the joints.
TEST( test_morph_targets_of_a_skin )
{
    static const float s_turns[] = { 0, 0, 0, 1, 0, 0, (float)HALF, (float)HALF };
    static const float s_wider[] = { 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 1, 0 }, s_half[] = { 0, 0.5f };
    GltfBuilder b = make_strip();
    add_gltf_floats( &b, "VEC4", 4, 2, s_turns );
    add_gltf_floats( &b, "VEC3", 3, 6, s_wider );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_half );
    AUTO_SCENE scene = gltf_load_built(
        &b, "\"nodes\":[{\"mesh\":0,\"skin\":0},{\"children\":[2],\"translation\":[3,0,0]},{\"translation\":[0,1,0]}],"
            "\"skins\":[{\"joints\":[1,2],\"inverseBindMatrices\":5}]," ONE_MESH(
                "{\"attributes\":{\"POSITION\":0,\"JOINTS_0\":3,\"WEIGHTS_0\":4},\"indices\":2,\"targets\":[{\"POSITION\":8}]"
                "}" ) ",\"animations\":[{\"samplers\":[{\"input\":6,\"output\":7},{\"input\":6,\"output\":9}],\"channels\":[{"
                      "\"sampler\":0,"
                      "\"target\":{\"node\":2,\"path\":\"rotation\"}},{\"sampler\":1,\"target\":{\"node\":0,\"path\":"
                      "\"weights\"}}]}]" );
    AUTO_POSE pose = gltf_pose_at( &scene, 1.0 );
    gltf_assert_placed_corner( &pose.scene, 2, 1, 1.5, 1, 0 );
    gltf_assert_placed_corner( &pose.scene, 3, 2, 1.5, 1, 1 );
}

// One of two triangles closes: the other stays, each with its number.
TEST( test_a_triangle_that_closes )
{
    static const float s_corners[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 2, 0, 0, 3, 0, 0, 2, 1, 0 };
    static const float s_closing[] = { 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, -1, 0 };
    static const float s_weights[] = { 0, 1 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 6, s_corners );
    add_gltf_floats( &b, "VEC3", 3, 6, s_closing );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_times );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_weights );
    AUTO_SCENE scene = gltf_load_built(
        &b, "\"nodes\":[{\"mesh\":0}]," ONE_MESH( "{\"attributes\":{\"POSITION\":0},\"targets\":[{\"POSITION\":1}]}" ) "," LINEAR(
                "0", "weights", "2", "3" ) );
    AUTO_POSE pose = gltf_pose_at( &scene, 1.0 );
    const RfTriangles* t = &pose.scene.meshes[pose.scene.placements[0].mesh].triangles;
    assert_true( pose.scene.placements[0].shown );
    assert_int_equal( t->count, 2 );
    assert_true( t->indices[0] != t->indices[1] );
    assert_true( t->indices[3] == t->indices[4] && t->indices[3] == t->indices[5] );
    gltf_assert_unit_normals( &pose.scene );
}

// By joints, and by weights that nobody means.
TEST( test_deformed_out_of_reach )
{
    static const float s_far[] = { 0, 0, 0, 0, 2e15f, 0 }, s_absurd[] = { 0, 0, 1e30f, 0, 3e38f, 0 };
    GltfBuilder b = make_strip();
    add_gltf_floats( &b, "VEC3", 3, 2, s_far );
    gltf_refuse_built( &b, STRIP( "," LINEAR( "2", "translation", "6", "7" ) ),
                       "object 'arm' at 0.5625 s: a vertex is at 1.125e+15" );
    b = make_morph( 6, s_absurd );
    gltf_refuse_built( &b, SQUARE( "" ) "," WEIGHTS( "8", "LINEAR" ), "object 'sheet' at 0.1875 s: a vertex is at 3.75e+29" );
}

// ---- Files of others -------------------------------------------------------------

// The path of a file in the folder `animated` of REFRAME_SCENES; the test is skipped where there is none.
static const char* animated( const char* name )
{
    static char s_path[1024];
    const char* folder = getenv( "REFRAME_SCENES" );
    snprintf( s_path, sizeof s_path, "%s/animated/%s", folder != NULL ? folder : "", name );
    FILE* file = folder != NULL ? fopen( s_path, "rb" ) : NULL;
    if ( file == NULL )
        skip();
    fclose( file );
    return s_path;
}

TEST( test_the_fox_walks )
{
    RfScene scene = gltf_load( animated( "Fox.glb" ) );
    gltf_assert_warned( "animation 'Survey' is used: 'Walk', 'Run', which move the same, are left out" );
    assert_int_equal( scene.placement_count, 1 );
    assert_int_equal( scene.unrendered_count, 0 );
    double survey = scene.movement->end;
    rf_destroy_scene( &scene );
    scene = gltf_load_with( animated( "Fox.glb" ), &( RfGltfOptions ){ .animation = "Walk" } );
    assert_string_equal( gltf_warnings, "" );
    assert_true( scene.movement->end != survey );
    for ( int k = 0; k <= 8; ++k )
    {
        AUTO_POSE pose = gltf_pose_at( &scene, scene.movement->end * k / 8 );
        const RfMesh* mesh = pose.scene.meshes + pose.scene.placements[0].mesh;
        RfVec3 size = rf_sub( mesh->bounds_max, mesh->bounds_min );
        assert_in_range( (int)size.z, 120, 200 ); // from nose to tail
        assert_in_range( (int)size.y, 60, 110 );
        assert_true( mesh->bounds_min.y > -10 );
        gltf_assert_unit_normals( &pose.scene );
    }
    rf_destroy_scene( &scene );
}

TEST( test_the_morph_stress_test )
{
    AUTO_SCENE scene = gltf_load_with( animated( "MorphStressTest.gltf" ), &( RfGltfOptions ){ .animation = "Pulse" } );
    assert_int_equal( scene.unrendered_count, 0 );
    assert_true( scene.movement->mover_count >= 1 && scene.movement->movers[0].target_count == 8 );
    assert_true( rf_scene_moves( &scene, 0.1, 0.9 ) );
    for ( int k = 0; k <= 8; ++k )
    {
        AUTO_POSE pose = gltf_pose_at( &scene, scene.movement->end * k / 8 );
        assert_true( pose.scene.placements[scene.still_placement_count].shown );
        gltf_assert_unit_normals( &pose.scene );
    }
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
