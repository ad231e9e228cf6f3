// Scenes far from the origin are loaded around their middle: to the bit as if they were not, with eyes, lamps, bounds
// and matrices where they belong.
#include "support/scene_files.h"
#include "support/test.h"

#include "reframe/camera.h"
#include "scene/camera.h"
#include "scene/eye.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// A room of 4 m with a lamp, a camera that rises by 1 m, and everything under a node that is moved.
static RfScene load_moved( const char* root )
{
    static const float s_corners[] = { -2, 0, -2, 2, 0, -2, 2, 3.3f, 2, -2, 3.3f, 2 }, s_times[] = { 0, 1 },
                       s_heights[] = { 0.1f, 1.5f, 1.8f, 0.1f, 2.5f, 1.8f };
    static const uint16_t s_indices[] = { 0, 1, 2, 0, 2, 3 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 4, s_corners );
    add_gltf_u16( &b, 6, s_indices );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_times );
    add_gltf_floats( &b, "VEC3", 3, 2, s_heights );
    char rest[2048];
    snprintf( rest, sizeof rest,
              "\"nodes\":[{\"translation\":%s,\"children\":[1,2,3]},{\"mesh\":0},{\"camera\":0},"
              "{\"translation\":[0.3,2.7,0.1],\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}],"
              "\"scenes\":[{\"nodes\":[0]}],\"scene\":0,"
              "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],"
              "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1}}],"
              "\"animations\":[{\"channels\":[{\"sampler\":0,\"target\":{\"node\":2,\"path\":\"translation\"}}],"
              "\"samplers\":[{\"input\":2,\"output\":3}]}],"
              "\"extensionsUsed\":[\"KHR_lights_punctual\"],"
              "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\"}]}}",
              root );
    return gltf_load_built( &b, rest );
}

TEST( test_a_far_scene_is_the_same_to_the_bit )
{
    RfScene plain = load_moved( "[0,0,0]" ), far = load_moved( "[1e6,-2e6,5e5]" );
    assert_true( plain.origin[0] == 0.0 && plain.origin[1] == 0.0 && plain.origin[2] == 0.0 );
    assert_true( far.origin[0] == 1e6 && far.origin[1] == -2e6 && far.origin[2] == 5e5 );
    assert_memory_equal( far.triangles.positions, plain.triangles.positions, 6 * 3 * sizeof( float ) );
    // in doubles at a million metres
    gltf_assert_rgb( far.punctuals[0].position, 0.3, 2.7, 0.1 );
    RfPathOptions options = { .fps = { 24, 1 }, .width = 64, .height = 48 };
    RfCameraPath paths[2];
    assert_int_equal( rf_create_camera_path( &plain, &options, &paths[0], NULL ), RF_OK );
    assert_int_equal( rf_create_camera_path( &far, &options, &paths[1], NULL ), RF_OK );
    for ( int i = 0; i < paths[0].count; ++i )
    {
        RfVec3 a = paths[0].eyes[i].origin, b = paths[1].eyes[i].origin;
        assert_true( rf_length( rf_sub( a, b ) ) < 1e-6f );
    }
    RfSceneInfo info;
    assert_int_equal( rf_scene_info( &far, &info, NULL ), RF_OK );
    gltf_assert_near( (double)info.bounds_min.x - 1e6, -2.0 );
    gltf_assert_near( (double)info.bounds_max.z - 5e5, 2.0 );
    float world_to_camera[16], ndc[16];
    rf_eye_matrices_around( paths[1].eyes, paths[1].origin, world_to_camera, ndc );
    assert_true( fabs( (double)world_to_camera[12] + 1e6 + 0.1 ) < 0.1 && fabs( (double)world_to_camera[13] - 2e6 + 1.5 ) < 0.1 );
    for ( int i = 0; i < 2; ++i )
        rf_destroy_camera_path( paths + i );
    rf_destroy_scene( &plain );
    rf_destroy_scene( &far );
}

// Not where the camera is still near the origin, and the middle of the scene is not.
TEST( test_a_scene_near_its_camera_stays )
{
    RfScene near = load_moved( "[20,0,0]" ); // some 5 of its sizes away
    assert_true( near.origin[0] == 0.0 );
    rf_destroy_scene( &near );
    static const float s_corners[] = { -2, 0, -2, 2, 0, -2, 2, 3, 2, -2, 3, 2 };
    static const uint16_t s_indices[] = { 0, 1, 2, 0, 2, 3 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 4, s_corners );
    add_gltf_u16( &b, 6, s_indices );
    RfScene scene =
        gltf_load_built( &b, "\"nodes\":[{\"mesh\":0,\"translation\":[1000,0,0]},{\"camera\":0}],"
                             "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}],"
                             "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1}}]" );
    assert_true( scene.camera_count == 1 && scene.origin[0] == 0.0 );
    rf_destroy_scene( &scene );
}
