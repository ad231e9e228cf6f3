// Geometry as the glTF reader takes it: accessors, meshes, transforms, containers.

#include "support/scene_files.h"
#include "support/test.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const float s_square[] = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 };
static const float s_up[] = { 0, 0, 2, 0, 0, 1, 0, 0, 0, 0, 0, 1 };

// Accessors: 0 positions of a unit square, 1 its normals (one too long, one
// zero), 2 indices of two triangles.
static GltfBuilder make_square( void )
{
    static const uint16_t s_indices[] = { 0, 1, 2, 0, 2, 3 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 4, s_square );
    add_gltf_floats( &b, "VEC3", 3, 4, s_up );
    add_gltf_u16( &b, 6, s_indices );
    return b;
}

#define SMOOTH "{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":2}"
#define MESH( primitives ) "\"meshes\":[{\"primitives\":[" primitives "]}]"

TEST( test_smooth_normals_are_read )
{
    GltfBuilder b = make_square();
    RfScene scene = gltf_load_built( &b, "\"nodes\":[{\"mesh\":0,\"translation\":[10,0,0],\"scale\":[2,4,1]}]," MESH( SMOOTH ) );
    assert_int_equal( scene.triangles.count, 2 );
    assert_int_equal( scene.triangles.vertex_count, 4 );
    assert_int_equal( scene.instance_count, 1 );
    assert_null( scene.triangles.uvs );
    gltf_assert_corner( &scene, 2, 12, 4, 0 );
    for ( int i = 0; i < 6; ++i )
        gltf_assert_normal( &scene, i, 0, 0, 1 );
    gltf_assert_rgb( scene.bounds_min, 10, 0, 0 );
    gltf_assert_rgb( scene.bounds_max, 12, 4, 0 );
    assert_string_equal( scene.materials[scene.triangles.material[0]].name, "default" );
    assert_string_equal( gltf_warnings, "" );
    assert_true( scene.content_hash != 0 );
    rf_destroy_scene( &scene );
}

TEST( test_flat_meshes_get_face_normals )
{
    GltfBuilder b = make_square();
    RfScene scene = gltf_load_built( &b, "\"nodes\":[{\"mesh\":0}]," MESH( "{\"attributes\":{\"POSITION\":0},\"indices\":2}" ) );
    assert_int_equal( scene.triangles.vertex_count, 6 );
    for ( int i = 0; i < 6; ++i )
        gltf_assert_normal( &scene, i, 0, 0, 1 );
    rf_destroy_scene( &scene );
}

// A mirrored square still faces +z, with its corners counter-clockwise seen
// from there; so does one with flat normals.
TEST( test_mirrored_meshes_face_as_before )
{
    static const char* const s_primitives[] = { MESH( SMOOTH ), MESH( "{\"attributes\":{\"POSITION\":0},\"indices\":2}" ) };
    for ( int kind = 0; kind < 2; ++kind )
    {
        char rest[512];
        snprintf( rest, sizeof rest, "\"nodes\":[{\"mesh\":0,\"scale\":[-1,1,1]}],%s", s_primitives[kind] );
        GltfBuilder b = make_square();
        RfScene scene = gltf_load_built( &b, rest );
        const RfTriangles* t = &scene.triangles;
        const float *p = t->positions + 3 * t->indices[0], *q = t->positions + 3 * t->indices[1],
                    *r = t->positions + 3 * t->indices[2];
        gltf_assert_near( ( q[0] - p[0] ) * ( r[1] - p[1] ) - ( q[1] - p[1] ) * ( r[0] - p[0] ), 1.0 );
        gltf_assert_normal( &scene, 0, 0, 0, 1 );
        rf_destroy_scene( &scene );
    }
}

// Normals under a squeeze lean the other way than positions do.
TEST( test_nonuniform_normals )
{
    static const float s_positions[] = { 0, 1, 0, 1, 0, 0, 1, 0, -1 };
    static const float s_normals[] = { 1, 1, 0, 1, 1, 0, 1, 1, 0 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 3, s_positions );
    add_gltf_floats( &b, "VEC3", 3, 3, s_normals );
    RfScene scene = gltf_load_built(
        &b, "\"nodes\":[{\"mesh\":0,\"scale\":[2,1,-1]}]," MESH( "{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}}" ) );
    gltf_assert_normal( &scene, 0, 1 / sqrt( 5.0 ), 2 / sqrt( 5.0 ), 0 );
    rf_destroy_scene( &scene );
}

TEST( test_strips_and_fans_keep_their_side )
{
    static const float s_strip[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0 };
    GltfBuilder b = make_square();
    add_gltf_floats( &b, "VEC3", 3, 5, s_strip ); // 3
    RfScene scene = gltf_load_built(
        &b, "\"nodes\":[{\"mesh\":0}]," MESH( "{\"attributes\":{\"POSITION\":3},\"mode\":5},"
                                              "{\"attributes\":{\"POSITION\":0},\"mode\":6},"
                                              "{\"attributes\":{\"POSITION\":0},\"mode\":1},{\"attributes\":{}}" ) );
    assert_int_equal( scene.triangles.count, 5 );
    assert_int_equal( scene.instance_count, 2 );
    for ( int i = 0; i < 15; ++i )
        gltf_assert_normal( &scene, i, 0, 0, 1 );
    gltf_assert_warned( "points and lines are not drawn: meshes[0].primitives[2]" );
    gltf_assert_warned( "meshes[0].primitives[3] has no POSITION" );
    rf_destroy_scene( &scene );
}

TEST( test_degenerate_triangles )
{
    static const uint16_t s_indices[] = { 0, 1, 1, 0, 1, 2, 3, 3, 3 };
    GltfBuilder b = make_square();
    add_gltf_u16( &b, 9, s_indices ); // 3
    RfScene scene = gltf_load_built( &b, "\"nodes\":[{\"mesh\":0},{\"mesh\":0,\"scale\":[1,0,1]}]," MESH(
                                             "{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":3}" ) );
    assert_int_equal( scene.triangles.count, 1 );
    assert_int_equal( scene.triangles.vertex_count, 4 );
    for ( uint32_t v = 0; v < 4; ++v )
        gltf_assert_three( scene.triangles.normals + 3 * v, 0, 0, 1 );
    gltf_assert_warned( "5 triangles without area are dropped, the first in meshes[0].primitives[0] of nodes[0]" );
    rf_destroy_scene( &scene );
}

// Quantised positions, normalised UVs with a stride, sparse over zeros.
TEST( test_every_accessor_kind_is_read )
{
    static const int16_t s_positions[] = { 0, 0, 0, 4, 0, 0, 0, -4, 0 };
    static const uint8_t s_uvs[] = { 255, 0, 9, 9, 0, 51, 9, 9, 102, 204 };
    static const uint8_t s_places[] = { 1, 2 };
    static const float s_values[] = { 1, 0, 0, 0, 1, 0 };
    GltfBuilder b = { 0 };
    add_gltf_accessor( &b, 5122, "VEC3", 3, s_positions, sizeof s_positions, "" );
    add_gltf_accessor( &b, 5121, "VEC2", 3, s_uvs, sizeof s_uvs, ",\"normalized\":true" );
    add_gltf_accessor( &b, 5121, "SCALAR", 2, s_places, sizeof s_places, "" );
    add_gltf_floats( &b, "VEC3", 3, 2, s_values );
    strcat( b.accessors, ",{\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,\"sparse\":{\"count\":2,\"indices\":"
                         "{\"bufferView\":2,\"componentType\":5121},\"values\":{\"bufferView\":3}}}" );
    char* view = strstr( b.views, "\"byteLength\":10" );
    assert_non_null( view );
    char rest[4096];
    snprintf( rest, sizeof rest, ",\"byteStride\":4%s", view + 15 );
    strcpy( view + 15, rest );
    RfScene scene = gltf_load_built( &b, "\"extensionsRequired\":[\"KHR_mesh_quantization\"],\"nodes\":[{\"mesh\":0}]," MESH(
                                             "{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1}},"
                                             "{\"attributes\":{\"POSITION\":4}}" ) );
    assert_int_equal( scene.triangles.count, 2 );
    gltf_assert_corner( &scene, 2, 0, -4, 0 );
    gltf_assert_corner( &scene, 4, 1, 0, 0 );
    const float* uv = scene.triangles.uvs;
    const double want[] = { 1, 0, 0, 0.2, 0.4, 0.8, 0, 0 };
    for ( int i = 0; i < 8; ++i )
        gltf_assert_near( uv[i], want[i] );
    rf_destroy_scene( &scene );
}

// Primitives that share accessors take only the vertices they use.
TEST( test_shared_vertices_are_taken_once )
{
    static const uint16_t s_indices[] = { 3, 0, 2 };
    GltfBuilder b = make_square();
    add_gltf_u16( &b, 3, s_indices ); // 3
    RfScene scene =
        gltf_load_built( &b, "\"nodes\":[{\"mesh\":0}]," MESH( "{\"attributes\":{\"POSITION\":0,\"NORMAL\":1},\"indices\":3}" ) );
    assert_int_equal( scene.triangles.vertex_count, 3 );
    gltf_assert_corner( &scene, 0, 0, 1, 0 );
    gltf_assert_corner( &scene, 1, 0, 0, 0 );
    rf_destroy_scene( &scene );
}

TEST( test_hierarchy_and_scenes )
{
    const char* nodes = "\"nodes\":[{\"children\":[1],\"translation\":[1,0,0]},{\"mesh\":0,\"name\":\"leaf\",\"matrix\":"
                        "[0,1,0,0,-1,0,0,0,0,0,1,0,0,5,0,1]},{\"mesh\":0}]," MESH( SMOOTH );
    char rest[1024];
    GltfBuilder b = make_square();
    RfScene scene = gltf_load_built( &b, nodes );
    assert_int_equal( scene.triangles.count, 4 );
    gltf_assert_corner( &scene, 1, 1, 0, 0 ); // roots come first
    gltf_assert_corner( &scene, 7, 1, 6, 0 );
    assert_string_equal( scene.nodes[1].name, "leaf" );
    assert_int_equal( scene.nodes[1].parent, 0 );
    rf_destroy_scene( &scene );

    snprintf( rest, sizeof rest, "\"scene\":1,\"scenes\":[{\"nodes\":[2]},{\"nodes\":[0]}],%s", nodes );
    scene = gltf_load_built( &b, rest );
    assert_int_equal( scene.triangles.count, 2 );
    gltf_assert_corner( &scene, 0, 1, 5, 0 );
    rf_destroy_scene( &scene );
}

TEST( test_containers_agree )
{
    const char* rest = "\"nodes\":[{\"mesh\":0}]," MESH( SMOOTH );
    GltfBuilder b = make_square();
    uint64_t hashes[3];
    for ( int kind = 0; kind < 3; ++kind )
    {
        const char* path;
        size_t size;
        if ( kind == 0 )
            path = write_gltf( &b, &gltf_folder, rest );
        else if ( kind == 1 )
        {
            // sniffed by its first bytes, whatever the name says
            uint8_t* glb = build_glb( &b, rest, &size );
            path = write_bytes( &gltf_folder, "a.gltf", glb, size );
            free( glb );
        }
        else
        {
            write_bytes( &gltf_folder, "b c.bin", b.bin, b.bin_size );
            const char* json = build_gltf_json( &b, "b%20c.bin", rest );
            path = write_bytes( &gltf_folder, "a.gltf", json, strlen( json ) );
        }
        RfScene scene = gltf_load( path );
        assert_int_equal( scene.triangles.count, 2 );
        gltf_assert_corner( &scene, 2, 1, 1, 0 );
        hashes[kind] = scene.content_hash;
        rf_destroy_scene( &scene );
    }
    // the bytes of an external buffer count too
    b.bin[0] ^= 1;
    write_bytes( &gltf_folder, "b c.bin", b.bin, b.bin_size );
    RfScene scene = gltf_load( folder_file( &gltf_folder, "a.gltf" ) );
    assert_true( scene.content_hash != hashes[2] );
    rf_destroy_scene( &scene );
}

TEST( test_empty_scenes_are_scenes )
{
    GltfBuilder b = { 0 };
    RfScene scene = gltf_load_built( &b, "" );
    assert_int_equal( scene.triangles.count, 0 );
    gltf_assert_rgb( scene.bounds_max, 0, 0, 0 );
    assert_int_equal( scene.camera_count, 0 );
    rf_destroy_scene( &scene );
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
