// Scenes at a moment, against closed forms: what turns, is hidden, flattened or far out, and many at once.
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

// ---- Rigid ----------------------------------------------------------------------

static const float s_box[] = { 0, 0, 0, 1, 0, 0, 1, 2, 0, 0, 2, 0, 0, 0, 3, 1, 0, 3, 1, 2, 3, 0, 2, 3 };
static const uint16_t s_box_faces[] = { 0, 2, 1, 0, 3, 2, 4, 5, 6, 4, 6, 7, 0, 1, 5, 0, 5, 4,
                                        3, 6, 2, 3, 7, 6, 0, 4, 7, 0, 7, 3, 1, 2, 6, 1, 6, 5 };

// 0 corners, 1 faces, 2 times; a floor of the first face stands still.
static GltfBuilder make_box( void )
{
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 8, s_box );
    add_gltf_u16( &b, 36, s_box_faces );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_times );
    return b;
}

#define BOX ONE_MESH( "{\"attributes\":{\"POSITION\":0},\"indices\":1}" )

static RfScene load_turning_box( void )
{
    GltfBuilder b = make_box();
    static const float s_turns[] = { 0, 0, 0, 1, 0, 0, (float)HALF, (float)HALF };
    add_gltf_floats( &b, "VEC4", 4, 2, s_turns );
    return gltf_load_built( &b, "\"nodes\":[{\"mesh\":0},{\"children\":[2],\"translation\":[10,0,0]},{\"name\":\"box\","
                                "\"mesh\":0,\"scale\":[1,1,2]}]," BOX "," LINEAR( "2", "rotation", "2", "3" ) );
}

TEST( test_a_turning_box )
{
    AUTO_SCENE scene = load_turning_box();
    assert_int_equal( scene.triangles.count, 12 );
    assert_int_equal( scene.triangle_count, 24 );
    assert_int_equal( scene.mesh_count, 1 );
    assert_int_equal( scene.placement_count, 1 );
    assert_int_equal( scene.still_placement_count, 0 );
    assert_int_equal( scene.placements[0].first, 12 );
    assert_int_equal( scene.placements[0].mover, 0 );
    assert_int_equal( scene.unrendered_count, 0 );
    assert_true( scene.movement->start == 0.0 && scene.movement->end == 1.0 );
    assert_string_equal( gltf_warnings, "" );
    for ( int k = -1; k <= 5; ++k )
    {
        double time = 0.25 * k, angle = fmin( fmax( time, 0.0 ), 1.0 ) * 1.57079632679489662;
        AUTO_POSE pose = gltf_pose_at( &scene, time );
        assert_true( pose.scene.placements[0].shown );
        for ( uint32_t i = 0; i < 36; ++i )
        {
            const float* p = s_box + 3 * (size_t)s_box_faces[i];
            double x = (double)p[0], y = (double)p[1];
            gltf_assert_placed_corner( &pose.scene, i / 3, (int)( i % 3 ), x, y, (double)p[2] );
            gltf_assert_placed_corner( &pose.scene, 12 + i / 3, (int)( i % 3 ), 10.0 + x * cos( angle ) - y * sin( angle ),
                                       x * sin( angle ) + y * cos( angle ), 2.0 * (double)p[2] );
        }
    }
}

TEST( test_when_a_scene_moves )
{
    AUTO_SCENE scene = load_turning_box();
    assert_true( rf_scene_moves( &scene, 0.25, 0.5 ) );
    assert_true( rf_scene_moves( &scene, 0.0, 1.0 ) );
    assert_false( rf_scene_moves( &scene, -1.0, 0.0 ) );
    assert_false( rf_scene_moves( &scene, 1.0, 7.0 ) );
    assert_false( rf_scene_moves( &scene, 0.5, 0.5 ) );
    uint64_t hash;
    RfError error;
    AUTO_POSE pose = gltf_pose_at( &scene, 0.75 );
    assert_int_equal( rf_moment_hash( &scene, 0.75, &hash, &error ), RF_OK );
    assert_true( hash == pose.hash );
}

TEST( test_memory_of_the_caller )
{
    AUTO_SCENE scene = load_turning_box();
    size_t bytes = rf_pose_bytes( &scene );
    assert_in_range( bytes, sizeof( RfPlacement ), 4096 );
    AUTO_POSE pose = { .memory = aligned_alloc( 64, bytes ) };
    RfError error;
    memset( pose.memory, 0xa5, bytes );
    for ( int k = 2; k >= 0; --k )
    {
        assert_int_equal( rf_pose_scene( &scene, 0.5 * k, &pose, &error ), RF_OK );
        assert_false( pose.owned );
    }
    gltf_assert_placed_corner( &pose.scene, 12, 1, 11, 2, 0 );
    AUTO_FREE void* memory = pose.memory;
}

TEST( test_a_still_scene_is_its_own_pose )
{
    GltfBuilder b = make_box();
    AUTO_SCENE scene = gltf_load_built( &b, "\"nodes\":[{\"mesh\":0}]," BOX );
    assert_null( scene.movement );
    assert_int_equal( rf_pose_bytes( &scene ), 0 );
    assert_false( rf_scene_moves( &scene, 0.0, 1.0 ) );
    AUTO_POSE pose = gltf_pose_at( &scene, 3.0 );
    assert_ptr_equal( pose.scene.triangles.positions, scene.triangles.positions );
}

static RfScene load_scaled_box( const float scales[6] )
{
    GltfBuilder b = make_box();
    add_gltf_floats( &b, "VEC3", 3, 2, scales );
    return gltf_load_built( &b, "\"nodes\":[{\"mesh\":0,\"name\":\"box\"}]," BOX "," LINEAR( "0", "scale", "2", "3" ) );
}

TEST( test_a_scale_of_zero_is_not_there )
{
    AUTO_SCENE scene = load_scaled_box( ( const float[] ){ 0, 0, 0, 1, 1, 1 } );
    RfPosedScene pose = gltf_pose_at( &scene, 0.0 );
    assert_false( pose.scene.placements[0].shown );
    rf_destroy_pose( &pose );
    pose = gltf_pose_at( &scene, 1e-3 );
    assert_true( pose.scene.placements[0].shown );
    assert_int_equal( pose.scene.placements[0].mesh, 0 );
    rf_destroy_pose( &pose );
}

// A cube that is flattened to a square keeps two of its faces, and those of no area meet no ray.
TEST( test_what_is_flattened )
{
    AUTO_SCENE scene = load_scaled_box( ( const float[] ){ 1, 1, 0, 1, 1, 1 } );
    RfPosedScene pose = gltf_pose_at( &scene, 0.0 );
    const RfPlacement* placement = pose.scene.placements;
    assert_true( placement->shown );
    const RfTriangles* t = &pose.scene.meshes[placement->mesh].triangles;
    assert_int_equal( t->count, 12 );
    for ( uint32_t i = 0; i < 12; ++i )
    {
        const uint32_t* corners = t->indices + 3 * (size_t)i;
        bool collapsed = corners[0] == corners[1] && corners[1] == corners[2];
        assert_int_equal( collapsed, i >= 4 );
        gltf_assert_three( gltf_placed_normal( &pose.scene, i, 0 ), 0, 0, i < 2 ? -1 : 1 ); // for collapsed ones: any
        if ( i >= 4 )
            continue;
        for ( int c = 0; c < 3; ++c )
        {
            const float* p = s_box + 3 * (size_t)s_box_faces[3 * i + (uint32_t)c];
            gltf_assert_placed_corner( &pose.scene, i, c, (double)p[0], (double)p[1], 0.0 );
        }
    }
    gltf_assert_unit_normals( &pose.scene );
    rf_destroy_pose( &pose );
    pose = gltf_pose_at( &scene, 1.0 );
    assert_int_equal( pose.scene.placements[0].mesh, 0 );
    rf_destroy_pose( &pose );
}

TEST( test_what_is_turned_inside_out )
{
    AUTO_SCENE scene = load_scaled_box( ( const float[] ){ 1, 1, 1, -1, 1, 1 } );
    RfPosedScene pose = gltf_pose_at( &scene, 1.0 );
    assert_true( rf_mat4_det3( &pose.scene.placements[0].matrix ) < 0.0 );
    gltf_assert_placed_corner( &pose.scene, 0, 2, -1, 0, 0 );
    rf_destroy_pose( &pose );
    pose = gltf_pose_at( &scene, 0.5 ); // flat: a rectangle in the plane of y and z
    assert_true( pose.scene.placements[0].shown );
    gltf_assert_placed_corner( &pose.scene, 8, 1, 0, 0, 3 );
    rf_destroy_pose( &pose );
}

TEST( test_out_of_reach )
{
    GltfBuilder b = make_box();
    static const float s_far[] = { 0, 0, 0, 3e15f, 0, 0 };
    add_gltf_floats( &b, "VEC3", 3, 2, s_far );
    gltf_refuse_built( &b, "\"nodes\":[{\"mesh\":0,\"name\":\"probe\"}]," BOX "," LINEAR( "0", "translation", "2", "3" ),
                       "object 'probe' at 0.375 s: a vertex is at 1.125e+15, beyond 1e+15: scale the scene down" );
}

// ---- Visibility -----------------------------------------------------------------

#define SHOWS( node, times, values )                                                                                             \
    "\"animations\":[{\"samplers\":[{\"input\":" times ",\"output\":" values ",\"interpolation\":\"STEP\"}],\"channels\":["      \
    "{\"sampler\":0,\"target\":{\"path\":\"pointer\",\"extensions\":{\"KHR_animation_pointer\":{\"pointer\":\"/nodes/" node      \
    "/extensions/KHR_node_visibility/visible\"}}}}]}]"
// A pause is the same to the last bit at all its times, so that its frames are rendered once.
TEST( test_a_pause )
{
    GltfBuilder b = make_box();
    static const float s_keys[] = { 0, 1, 2 }, s_places[] = { 0.1f, 0.7f, -0.3f, 0.1f, 0.7f, -0.3f, 7, 0, 0 };
    add_gltf_floats( &b, "SCALAR", 1, 3, s_keys );
    add_gltf_floats( &b, "VEC3", 3, 3, s_places );
    AUTO_SCENE scene = gltf_load_built( &b, "\"nodes\":[{\"mesh\":0}]," BOX "," LINEAR( "0", "translation", "3", "4" ) );
    for ( int i = 0; i < 48; ++i )
        assert_false( rf_scene_moves( &scene, 0.0, i / 48.0 ) );
    assert_true( rf_scene_moves( &scene, 0.0, 1.1 ) );
}

#define VISIBLE( value ) "\"extensions\":{\"KHR_node_visibility\":{\"visible\":" value "}}"

TEST( test_what_is_shown_at_times )
{
    GltfBuilder b = make_box();
    static const float s_keys[] = { 1, 2, 4 };
    static const uint8_t s_shown[] = { 1, 0, 1 };
    add_gltf_floats( &b, "SCALAR", 1, 3, s_keys );
    add_gltf_accessor( &b, 5121, "SCALAR", 3, s_shown, sizeof s_shown, "" );
    AUTO_SCENE scene = gltf_load_built(
        &b, "\"extensionsUsed\":[\"KHR_node_visibility\",\"KHR_animation_pointer\"],"
            "\"extensionsRequired\":[\"KHR_node_visibility\",\"KHR_animation_pointer\"],"
            "\"nodes\":[{\"children\":[1,2]," VISIBLE( "false" ) "},{\"mesh\":0," VISIBLE( "true" ) "},{\"mesh\":0," VISIBLE(
                "false" ) "},{\"mesh\":0," VISIBLE( "false" ) "}]," BOX "," SHOWS( "0", "3", "4" ) );
    assert_string_equal( gltf_warnings, "" );
    assert_int_equal( scene.triangles.count, 0 ); // 3 is never shown, nor is 2
    assert_int_equal( scene.placement_count, 1 );
    static const double s_at[] = { 0, 1, 1.999, 2, 3.999, 4, 5 };
    for ( int i = 0; i < 7; ++i )
    {
        AUTO_POSE pose = gltf_pose_at( &scene, s_at[i] );
        assert_int_equal( pose.scene.placements[0].shown, i < 3 || i > 4 );
    }
    AUTO_POSE full = { .in_shutter = true, .middle = 1.9 }; // of a shutter of an odd number of steps
    assert_int_equal( rf_pose_scene( &scene, 2.0, &full, NULL ), RF_OK );
    assert_true( full.scene.placements[0].shown );
    assert_true( rf_scene_moves( &scene, 1.5, 2.5 ) );
    assert_false( rf_scene_moves( &scene, 2.0, 3.5 ) );
    assert_false( rf_scene_moves( &scene, 1.5, 4.5 ) );
}

// ---- Many -----------------------------------------------------------------------

#define MANY 10000

// All are children of one that stands still, and each is as long as its number.
static char* write_many( void )
{
    char* text = malloc( 200 * MANY + 4096 );
    char* end = text + sprintf( text, "\"nodes\":[{\"children\":[1" );
    for ( int i = 2; i <= MANY; ++i )
        end += sprintf( end, ",%d", i );
    end += sprintf( end, "],\"translation\":[0,0,7]}" );
    for ( int i = 1; i <= MANY; ++i )
        end += sprintf( end, ",{\"mesh\":0,\"scale\":[%d,1,1]}", i );
    end += sprintf( end, "],\"animations\":[{\"samplers\":[{\"input\":1,\"output\":2}],\"channels\":[" );
    for ( int i = 1; i <= MANY; ++i )
        end += sprintf( end, "%s{\"sampler\":0,\"target\":{\"node\":%d,\"path\":\"translation\"}}", i > 1 ? "," : "", i );
    sprintf( end, "]}]," ONE_MESH( "{\"attributes\":{\"POSITION\":0}}" ) );
    return text;
}

TEST( test_ten_thousand_nodes )
{
    static const float s_triangle[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 }, s_moves[] = { 0, 0, 0, 8, 4, 0 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 3, s_triangle );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_times );
    add_gltf_floats( &b, "VEC3", 3, 2, s_moves );
    AUTO_FREE char* rest = write_many();
    AUTO_FREE char* data = gltf_base64( b.bin, b.bin_size );
    size_t size = strlen( rest ) + strlen( data ) + 4096;
    AUTO_FREE char* text = malloc( size );
    snprintf(
        text, size,
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%zu,\"uri\":\"data:;base64,%s\"}],\"bufferViews\":[%s],"
        "\"accessors\":[%s],%s}",
        b.bin_size, data, b.views, b.accessors, rest );
    AUTO_SCENE scene = gltf_load( write_bytes( &gltf_folder, "a.gltf", text, strlen( text ) ) );
    assert_int_equal( scene.mesh_count, 1 );
    assert_int_equal( scene.placement_count, MANY );
    AUTO_POSE pose = gltf_pose_at( &scene, 0.5 );
    for ( int i = 0; i < MANY; i += 7 )
        gltf_assert_placed_corner( &pose.scene, (uint32_t)i, 1, 5.0 + i, 2, 7 );
}

// Instances of a node that moves go with it.
TEST( test_instances_that_move )
{
    static const float s_places[] = { 0, 0, 0, 0, 0, 100 }, s_moves[] = { 0, 0, 0, 4, 0, 0 };
    GltfBuilder b = make_box();
    add_gltf_floats( &b, "VEC3", 3, 2, s_places );
    add_gltf_floats( &b, "VEC3", 3, 2, s_moves );
    AUTO_SCENE scene = gltf_load_built(
        &b, "\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":3}}}}]," BOX
            "," LINEAR( "0", "translation", "2", "4" ) );
    assert_int_equal( scene.mesh_count, 1 );
    assert_int_equal( scene.placement_count, 2 );
    assert_int_equal( scene.placements[1].first, 12 );
    AUTO_POSE pose = gltf_pose_at( &scene, 0.5 );
    gltf_assert_placed_corner( &pose.scene, 0, 2, 3, 0, 0 );
    gltf_assert_placed_corner( &pose.scene, 12, 2, 3, 0, 100 );
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
