// Meshes that many nodes use, or that EXT_mesh_gpu_instancing places, are in memory once; what emits, what may be a mirror and
// what cannot be placed are triangles of the world. Broken placements end in an error of one line.
#include "support/scene_files.h"
#include "support/test.h"

#include "gltf/gltf.h"
#include "light/light.h"
#include "scene/placement.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define TRIANGLES 2000
#define PLACES 400

// Accessors: 0 positions of a square's corners, 1 indices of 2000 triangles, of which there are two, 2 the values.
static GltfBuilder make_builder_of( const float* values )
{
    static const float s_corners[] = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 };
    static const uint8_t s_square[] = { 0, 1, 2, 0, 2, 3 };
    GltfBuilder b = { 0 };
    uint8_t indices[3 * TRIANGLES];
    for ( int i = 0; i < 3 * TRIANGLES; ++i )
        indices[i] = s_square[i % 6];
    add_gltf_floats( &b, "VEC3", 3, 4, s_corners );
    add_gltf_accessor( &b, 5121, "SCALAR", 3 * TRIANGLES, indices, sizeof indices, "" );
    add_gltf_floats( &b, "VEC3", 3, PLACES, values );
    return b;
}

// Of translations.
static GltfBuilder make_builder( void )
{
    float places[3 * PLACES];
    for ( int i = 0; i < PLACES; ++i )
    {
        places[3 * i] = 2.0f * (float)i;
        places[3 * i + 1] = (float)( i % 7 );
        places[3 * i + 2] = -1.0f;
    }
    return make_builder_of( places );
}

#define PRIMITIVE "{\"attributes\":{\"POSITION\":0},\"indices\":1%s}"
#define INSTANCES( attributes )                                                                                                  \
    "\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"],"                                                                          \
    "\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":{\"attributes\":{" attributes "}}}}],"                   \
    "\"scenes\":[{\"nodes\":[0]}],\"scene\":0"

static void check_square( const RfScene* scene, uint32_t triangle, double x, double y, double z )
{
    RfVec3 p = rf_triangle_corner( scene, triangle, 0 );
    assert_true( fabs( (double)p.x - x ) < 1e-5 && fabs( (double)p.y - y ) < 1e-5 && fabs( (double)p.z - z ) < 1e-5 );
}

static void check_all_placed( const RfScene* scene )
{
    assert_int_equal( scene->mesh_count, 1 );
    assert_int_equal( scene->placement_count, PLACES );
    assert_int_equal( scene->still_placement_count, PLACES );
    assert_int_equal( scene->triangles.count, 0 );
    assert_int_equal( rf_triangle_count( scene ), TRIANGLES * PLACES );
    assert_int_equal( scene->instance_count, PLACES );
    assert_int_equal( scene->meshes[0].uses, PLACES );
    for ( uint32_t i = 0; i < PLACES; ++i )
    {
        check_square( scene, TRIANGLES * i, 2.0 * i, i % 7, -1.0 );
        check_square( scene, TRIANGLES * i + TRIANGLES - 2, 2.0 * i, i % 7, -1.0 );
        assert_ptr_equal( rf_locate_triangle( scene, TRIANGLES * i + 7 ).placement, scene->placements + i );
        assert_int_equal( rf_locate_triangle( scene, TRIANGLES * i + 7 ).index, 7 );
    }
    gltf_assert_rgb( scene->bounds_min, 0, 0, -1 );
    gltf_assert_rgb( scene->bounds_max, 2 * PLACES - 1, 7, -1 );
}

TEST( test_instances_of_the_extension_are_placed )
{
    GltfBuilder b = make_builder();
    char rest[4096];
    snprintf( rest, sizeof rest, INSTANCES( "\"TRANSLATION\":2" ) ",\"meshes\":[{\"primitives\":[" PRIMITIVE "]}]", "" );
    RfScene scene = gltf_load_built( &b, rest );
    check_all_placed( &scene );
    RfSceneInfo info;
    assert_int_equal( rf_scene_info( &scene, &info, NULL ), RF_OK );
    assert_int_equal( info.triangles, TRIANGLES * PLACES );
    assert_int_equal( info.stored_triangles, TRIANGLES );
    rf_destroy_scene( &scene );
}

TEST( test_meshes_of_many_nodes_are_placed )
{
    static char rest[32768];
    GltfBuilder b = make_builder();
    size_t at = (size_t)snprintf( rest, sizeof rest, "\"meshes\":[{\"primitives\":[" PRIMITIVE "]}],\"nodes\":[", "" );
    for ( int i = 0; i < PLACES; ++i )
        at += (size_t)snprintf( rest + at, sizeof rest - at, "%s{\"mesh\":0,\"translation\":[%d,%d,-1]}", i > 0 ? "," : "", 2 * i,
                                i % 7 );
    at += (size_t)snprintf( rest + at, sizeof rest - at, "],\"scene\":0,\"scenes\":[{\"nodes\":[0" );
    for ( int i = 1; i < PLACES; ++i )
        at += (size_t)snprintf( rest + at, sizeof rest - at, ",%d", i );
    snprintf( rest + at, sizeof rest - at, "]}]" );
    RfScene scene = gltf_load_built( &b, rest );
    check_all_placed( &scene );
    rf_destroy_scene( &scene );
}

// A mesh of four primitives: grey, a lamp, a mirror, a second grey.
TEST( test_lamps_and_mirrors_stay_in_world_space )
{
    static const uint8_t s_square[] = { 0, 1, 2, 0, 2, 3 };
    GltfBuilder b = make_builder();
    add_gltf_accessor( &b, 5121, "SCALAR", 6, s_square, sizeof s_square, "" );
    char rest[4096];
    snprintf( rest, sizeof rest,
              INSTANCES( "\"TRANSLATION\":2" ) ",\"meshes\":[{\"primitives\":[" PRIMITIVE
                                               ",{\"attributes\":{\"POSITION\":0},\"indices\":3,\"material\":0},"
                                               "{\"attributes\":{\"POSITION\":0},\"indices\":3,\"material\":1}," PRIMITIVE "]}],"
                                               "\"materials\":[{\"emissiveFactor\":[1,1,1]},"
                                               "{\"extras\":{\"reframe\":{\"bsdf\":\"mirror\",\"specular\":[1,1,1]}}},{}]",
              "", ",\"material\":2" );
    RfScene scene = gltf_load_built( &b, rest );
    assert_int_equal( scene.placement_count, PLACES );
    assert_int_equal( scene.meshes[0].triangles.count, 2 * TRIANGLES );
    assert_int_equal( scene.triangles.count, 4 * PLACES );
    assert_int_equal( scene.instance_count, 4 * PLACES );
    RfLights lights;
    assert_int_equal( rf_collect_lights( &scene, &lights, NULL ), RF_OK );
    assert_int_equal( lights.triangle_count, 2 * PLACES );
    rf_destroy_lights( &lights );
    rf_destroy_scene( &scene );
}

// By scales: instance 0 has none of its size left, 1 is a sheet and 2 mirrored, which is no harm, 3 too small.
TEST( test_what_cannot_be_placed_is_baked )
{
    float scales[3 * PLACES];
    for ( int i = 0; i < 3 * PLACES; ++i )
        scales[i] = 1.0f;
    scales[0] = scales[1] = scales[2] = 0.0f;
    scales[5] = 1e-4f;
    scales[6] = -2.0f;
    scales[9] = scales[10] = scales[11] = 1e-8f;
    GltfBuilder b = make_builder_of( scales );
    char rest[4096];
    snprintf( rest, sizeof rest, INSTANCES( "\"SCALE\":2" ) ",\"meshes\":[{\"primitives\":[" PRIMITIVE "]}]", "" );
    RfScene scene = gltf_load_built( &b, rest );
    assert_int_equal( scene.placement_count, PLACES - 2 );
    assert_int_equal( scene.triangles.count, TRIANGLES );
    assert_int_equal( scene.instance_count, PLACES );
    gltf_assert_warned( "2000 triangles without area are dropped, the first in meshes[0].primitives[0] of nodes[0]" );
    RfTriangleAt at = rf_locate_triangle( &scene, 2 * TRIANGLES ); // after the small one, and the sheet
    assert_true( rf_mat4_det3( &at.placement->matrix ) < 0.0 );
    rf_destroy_scene( &scene );
}

TEST( test_few_or_small_meshes_are_baked )
{
    GltfBuilder b = { 0 };
    static const float s_corners[] = { 0, 0, 0, 1, 0, 0, 1, 1, 0 };
    float places[3 * PLACES] = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 3, s_corners );
    add_gltf_floats( &b, "VEC3", 3, PLACES, places );
    RfScene scene = gltf_load_built( &b, INSTANCES( "\"TRANSLATION\":1" ) ",\"meshes\":[{\"primitives\":[{\"attributes\":{"
                                                                          "\"POSITION\":0}}]}]" );
    assert_int_equal( scene.placement_count, 0 );
    assert_int_equal( scene.triangles.count, PLACES );
    rf_destroy_scene( &scene );
}

// Each instance of a node that moves is one that moves.
TEST( test_instances_that_move )
{
    GltfBuilder b = make_builder();
    static const float s_times[] = { 0, 1 }, s_heights[] = { 0, 0, 0, 0, 1, 0 };
    add_gltf_floats( &b, "SCALAR", 1, 2, s_times );
    add_gltf_floats( &b, "VEC3", 3, 2, s_heights );
    char rest[4096];
    snprintf( rest, sizeof rest,
              INSTANCES( "\"TRANSLATION\":2" ) ",\"meshes\":[{\"primitives\":[" PRIMITIVE "]}],"
                                               "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,"
                                               "\"path\":\"translation\"}}],\"samplers\":[{\"input\":3,\"output\":4}]}]",
              "" );
    RfScene scene = gltf_load_built( &b, rest );
    assert_int_equal( scene.placement_count, PLACES );
    assert_int_equal( scene.still_placement_count, 0 );
    assert_int_equal( scene.mesh_count, 1 );
    assert_int_equal( scene.triangles.count, 0 );
    rf_destroy_scene( &scene );
}

static void check_refused( GltfBuilder* b, const char* rest, const char* part )
{
    RfScene scene;
    RfError error;
    RfResult result = rf_load_gltf( write_gltf( b, &gltf_folder, rest ), &scene, NULL, &error );
    assert_int_not_equal( result, RF_OK );
    if ( strstr( error.text, part ) == NULL || strchr( error.text, '\n' ) != NULL )
        fail_msg( "'%s' is not in: %s", part, error.text );
}

TEST( test_broken_placements_are_refused )
{
    char rest[4096];
    float bad[] = { 1, NAN, 0, 0, 0, 0 };
    GltfBuilder b = make_builder();
    add_gltf_floats( &b, "VEC3", 3, 2, bad );
    snprintf( rest, sizeof rest, INSTANCES( "\"TRANSLATION\":3" ) ",\"meshes\":[{\"primitives\":[" PRIMITIVE "]}]", "" );
    check_refused( &b, rest, "accessors[3]" );
    // a count that no buffer has to back
    b = make_builder();
    size_t at = strlen( b.accessors );
    snprintf( b.accessors + at, sizeof b.accessors - at, ",{\"componentType\":5126,\"count\":4000000,\"type\":\"VEC3\"}" );
    b.count += 1;
    check_refused( &b, rest, "place more than 4294967294 triangles" );
    // far out
    b = make_builder();
    snprintf(
        rest, sizeof rest,
        "\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"],\"nodes\":[{\"translation\":[1e16,0,0],\"mesh\":0,\"extensions\":{"
        "\"EXT_mesh_gpu_instancing\":{\"attributes\":{\"TRANSLATION\":2}}}}],\"scenes\":[{\"nodes\":[0]}],\"scene\":0,"
        "\"meshes\":[{\"primitives\":[" PRIMITIVE "]}]",
        "" );
    check_refused( &b, rest, "a vertex is at 1e+16, beyond 1e+15" );
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
