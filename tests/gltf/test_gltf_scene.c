// The rest of a glTF scene as the reader takes it: materials, cameras, animations,
// warnings; and scenes of others where REFRAME_SCENES names their folder.

#include "support/scene_files.h"
#include "support/test.h"

#include "gltf/gltf.h"
#include "scene/camera.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#ifndef REFRAME_SOURCE_DIR
#define REFRAME_SOURCE_DIR "."
#endif

static const float s_square[] = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 };

#define MESH( primitives ) "\"meshes\":[{\"primitives\":[" primitives "]}]"

TEST( test_materials_are_read )
{
    GltfBuilder b = { 0 };
    RfScene scene = gltf_load_built(
        &b, "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.25,1,1],\"metallicFactor\":0.5,"
            "\"roughnessFactor\":0.5}},"
            "{\"name\":\"matte\",\"doubleSided\":true,\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":0},"
            "\"emissiveFactor\":[1,0.5,0],\"extensions\":{\"KHR_materials_specular\":{\"specularFactor\":0},"
            "\"KHR_materials_emissive_strength\":{\"emissiveStrength\":200}}},"
            "{\"pbrMetallicRoughness\":{\"metallicFactor\":0},\"extensions\":{\"KHR_materials_ior\":{\"ior\":3},"
            "\"KHR_materials_specular\":{\"specularFactor\":0.5,\"specularColorFactor\":[1,0.5,9]}}},"
            "{\"pbrMetallicRoughness\":{\"metallicFactor\":0},\"extensions\":{\"KHR_materials_ior\":{\"ior\":0}}},"
            "{\"extras\":{\"reframe\":{\"bsdf\":\"phong\",\"diffuse\":[0.1,0.2,0.3],\"specular\":[0.9,0.5,0.5],"
            "\"exponent\":60}},\"emissiveFactor\":[0,0,1]},"
            "{\"extras\":{\"reframe\":{\"bsdf\":\"lambert\",\"diffuse\":[0.1,0.2,0.3]}}},{\"extras\":7}]" );
    const RfMaterial* m = scene.materials;
    assert_int_equal( scene.material_count, 7 );
    assert_string_equal( m[0].name, "materials[0]" );
    assert_int_equal( m[0].kind, RF_BSDF_GGX );
    gltf_assert_rgb( m[0].diffuse, 0.25, 0.125, 0.5 );
    gltf_assert_rgb( m[0].specular, 0.27, 0.145, 0.52 );
    gltf_assert_near( m[0].f90, 1.0 );
    gltf_assert_near( m[0].coat_f0, 0.04 );
    gltf_assert_near( m[0].coat_f90, 1.0 );
    gltf_assert_near( m[0].alpha, 0.25 );
    assert_int_equal( m[1].kind, RF_BSDF_LAMBERT );
    assert_true( m[1].double_sided );
    gltf_assert_rgb( m[1].emission, 200, 100, 0 );
    gltf_assert_near( m[1].alpha, (double)RF_MIN_ALPHA );
    gltf_assert_rgb( m[2].specular, 0.125, 0.0625, 0.5 );
    gltf_assert_near( m[2].f90, 0.5 );
    gltf_assert_near( m[2].coat_f0, 0.5 );
    gltf_assert_rgb( m[3].specular, 1, 1, 1 );
    assert_int_equal( m[4].kind, RF_BSDF_PHONG );
    gltf_assert_rgb( m[4].specular, 0.9, 0.5, 0.5 );
    gltf_assert_rgb( m[4].emission, 0, 0, 1 );
    gltf_assert_near( m[4].exponent, 60.0 );
    assert_int_equal( m[5].kind, RF_BSDF_LAMBERT );
    gltf_assert_rgb( m[5].diffuse, 0.1, 0.2, 0.3 );
    assert_int_equal( m[6].kind, RF_BSDF_GGX );
    rf_destroy_scene( &scene );
}

TEST( test_warnings_are_said_once )
{
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 4, s_square );
    add_gltf_floats( &b, "VEC3", 3, 4, s_square );
    RfScene scene = gltf_load_built(
        &b, "\"extensionsUsed\":[\"KHR_materials_ior\",\"KHR_materials_volume_scatter\",\"EXT_unheard_of\"],"
            "\"materials\":[{\"name\":\"A\",\"alphaMode\":\"BLEND\","
            "\"extensions\":{\"KHR_materials_volume_scatter\":{},\"KHR_materials_transmission\":{\"transmissionFactor\":1},\"KHR_"
            "materials_clearcoat\":{\"clearcoatFactor\":1}},\"pbrMetallicRoughness\":{\"metallicFactor\":0}},{\"name\":\"B\","
            "\"alphaMode\":\"MASK\","
            "\"occlusionTexture\":{\"index\":0},\"extensions\":{\"KHR_materials_volume_scatter\":{}}}],"
            "\"nodes\":[{\"mesh\":0},{\"name\":\"lamp\",\"extensions\":{\"KHR_animation_pointer\":{}}}]," MESH(
                "{\"attributes\":{\"POSITION\":0,\"COLOR_0\":1},\"mode\":6,\"targets\":[]}" ) );
    gltf_assert_warned( "a clear coat over glass or a mirror is not supported: material 'A'" );
    gltf_assert_warned( "KHR_materials_volume_scatter is not supported yet: material 'A'" );
    gltf_assert_warned( "EXT_unheard_of is unknown" );
    int lines = 0;
    for ( const char* c = gltf_warnings; *c != 0; ++c )
        lines += *c == '\n';
    assert_int_equal( lines, 3 );
    rf_destroy_scene( &scene );
}

// Accessors: 0 times 1, 2; 1 translations; 2 rotations.
static GltfBuilder make_motion( void )
{
    static const float s_times[] = { 1, 2 }, s_moves[] = { 0, 0, 0, 4, 0, 0 };
    static const float s_turns[] = { 0, 0, 0, 1, 0, 2, 0, 0 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "SCALAR", 1, 2, s_times );
    add_gltf_floats( &b, "VEC3", 3, 2, s_moves );
    add_gltf_floats( &b, "VEC4", 4, 2, s_turns );
    add_gltf_floats( &b, "VEC3", 3, 4, s_square );
    return b;
}

TEST( test_cameras_are_read )
{
    GltfBuilder b = make_motion();
    RfScene scene = gltf_load_built(
        &b, "\"nodes\":[{\"name\":\"Dolly\",\"children\":[1]},{\"name\":\"Shot\",\"camera\":0,\"translation\":[0,1,0]},"
            "{\"name\":\"Shot\",\"camera\":0},{\"camera\":0},{\"camera\":1,\"name\":\"flat\"},{\"camera\":2},"
            "{\"name\":\"Shot#2\",\"camera\":0}],"
            "\"cameras\":[{\"name\":\"Lens\",\"type\":\"perspective\",\"perspective\":{\"yfov\":0.5}},"
            "{\"type\":\"orthographic\",\"orthographic\":{\"xmag\":4,\"ymag\":2,\"zfar\":9,\"znear\":0}},{\"type\":"
            "\"perspective\",\"perspective\":{\"yfov\":0.75}}],"
            "\"animations\":[{\"samplers\":[{\"input\":0,\"output\":1},{\"input\":0,\"output\":2}],\"channels\":["
            "{\"sampler\":1,\"target\":{\"node\":1,\"path\":\"rotation\"}},"
            "{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}},"
            "{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"translation\"}}]}]" );
    assert_int_equal( scene.camera_count, 6 );
    const char* const names[] = { "Shot", "Lens", "flat", "camera", "Shot#2", "Shot#3" };
    for ( int i = 0; i < 6; ++i )
        assert_string_equal( scene.cameras[i].name, names[i] );
    gltf_assert_warned( "animations[0].channels[2] moves node 'Dolly'" );
    assert_int_equal( scene.channel_count, 2 );
    assert_int_equal( scene.channels[0].node, 0 );

    int moving;
    RfError error;
    assert_int_equal( rf_find_camera( &scene, NULL, &moving, &error ), RF_OK );
    const RfCamera* camera = scene.cameras + moving;
    assert_int_equal( camera->node, 1 );
    assert_true( camera->animated && camera->start == 1.0 && camera->end == 2.0 );
    assert_false( scene.cameras[0].animated );
    RfEye eye;
    assert_int_equal(
        rf_camera_eye( &( RfCameraSampling ){ &scene, scene.cameras + moving, NULL, { 1, 1 }, 10, 10 }, 1.5, &eye, &error ),
        RF_OK );
    gltf_assert_rgb( eye.origin, 2, 1, 0 );
    gltf_assert_rgb( eye.forward, -1, 0, 0 );
    rf_destroy_scene( &scene );
}

// All of the file goes by the centre, which is beyond what floats tell apart.
TEST( test_centre_of_cesium )
{
    GltfBuilder b = make_motion();
    RfScene scene = gltf_load_built(
        &b, "\"nodes\":[{\"mesh\":0,\"translation\":[0,0.25,0]}]," MESH(
                "{\"attributes\":{\"POSITION\":3},\"mode\":6}" ) ",\"extensions\":{\"CESIUM_RTC\":{\"center\":[4000000.125,0,-"
                                                                 "3000000]}},\"extensionsUsed\":[\"CESIUM_RTC\"],"
                                                                 "\"extensionsRequired\":[\"CESIUM_RTC\"]" );
    assert_true( scene.origin[0] + (double)scene.bounds_min.x == 4000000.125 );
    assert_true( scene.origin[1] + (double)scene.bounds_min.y == 0.25 );
    rf_destroy_scene( &scene );
    gltf_refuse_built( &b, "\"extensions\":{\"CESIUM_RTC\":{}}", "CESIUM_RTC: center is missing" );
}

TEST( test_frozen_mesh_is_taken_at_its_first_key )
{
    GltfBuilder b = make_motion();
    static const float s_moves[] = { 7, 0, 0, 8, 0, 0 };
    add_gltf_floats( &b, "VEC3", 3, 2, s_moves ); // 4
    const char* path = write_gltf(
        &b, &gltf_folder,
        "\"nodes\":[{\"children\":[1],\"translation\":[99,0,0]},{\"name\":\"door\",\"mesh\":0}]," MESH(
            "{\"attributes\":{\"POSITION\":3},\"mode\":6}" ) ",\"animations\":[{\"samplers\":[{\"input\":0,\"output\":4}],"
                                                             "\"channels\":[{\"sampler\":0,"
                                                             "\"target\":{\"node\":0,\"path\":\"translation\"}}]}]" );
    RfScene scene = gltf_load_with( path, &( RfGltfOptions ){ .freeze = true } );
    gltf_assert_rgb( scene.bounds_min, 7, 0, 0 );
    gltf_assert_warned( "'door' moves or changes: frozen as in the first frame" );
    rf_destroy_scene( &scene );
}

// A scene that lists a node, but not its parent, which would put it elsewhere.
TEST( test_root_with_parent )
{
    static const float s_positions[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 3, s_positions );
    RfScene scene = gltf_load_built( &b, "\"scenes\":[{\"nodes\":[1]}],\"nodes\":[{\"name\":\"up\",\"translation\":[0,9,0],"
                                         "\"children\":[1]},{\"name\":\"it\",\"translation\":[2,0,0],\"mesh\":0}]," MESH(
                                             "{\"attributes\":{\"POSITION\":0}}" ) );
    gltf_assert_warned( "scenes[0] has node 'it', but not its parent 'up': it is placed without it" );
    gltf_assert_corner( &scene, 1, 3, 0, 0 );
    rf_destroy_scene( &scene );
}

TEST( test_scenes_of_others_are_read )
{
    static const struct
    {
        const char* file;
        uint32_t triangles, instances;
        float power; // of the brightest emitter's red
        int textures;
    } s_scenes[] = {
        { "veach-ajar.glb", 382628, 22, 1000.0f, 4 },
        { "veach-bidir.glb", 11544, 14, 12048.2f, 0 },
    };
    const char* folder = getenv( "REFRAME_SCENES" );
    if ( folder == NULL )
        skip();
    for ( int i = 0; i < 2; ++i )
    {
        char path[4096];
        snprintf( path, sizeof path, "%s/%s", folder, s_scenes[i].file );
        RfScene scene = gltf_load( path );
        assert_int_equal( scene.triangles.count, s_scenes[i].triangles );
        assert_int_equal( scene.instance_count, s_scenes[i].instances );
        float brightest = 0.0f;
        for ( uint32_t m = 0; m < scene.material_count; ++m )
            brightest = rf_maxf( brightest, scene.materials[m].emission.x );
        assert_true( fabsf( brightest - s_scenes[i].power ) < 0.1f );
        int camera;
        RfCameraFrames frames;
        RfError error;
        assert_int_equal( rf_find_camera( &scene, "Camera", &camera, &error ), RF_OK );
        assert_int_equal( rf_camera_frames( &scene, scene.cameras + camera, 24.0, &frames, &error ), RF_OK );
        assert_int_equal( frames.count, 48 );
        assert_string_equal( gltf_warnings, "" );
        int glass = 0;
        for ( uint32_t m = 0; m < scene.material_count; ++m )
            glass += scene.materials[m].kind == RF_BSDF_GLASS && scene.materials[m].ior == 1.5f && !scene.materials[m].thin;
        assert_int_equal( glass, 1 );
        assert_int_equal( scene.texture_count, s_scenes[i].textures );
        rf_destroy_scene( &scene );
    }
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
