// A corpus of small glTF files, one for each feature of the format that they can use: animations with every sampler and
// target; what is read without being drawn, and what is ignored with one warning. Accessors, materials, textures and
// geometry have their own tests.
#include "support/scene_files.h"
#include "support/test.h"

#include "gltf/gltf.h"
#include "scene/movement.h"
#include "scene/camera.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// ---- Animations ---------------------------------------------------------------

typedef struct Keys
{
    const char* interpolation;
    const char* path;
    int components;
    float values[36]; // three keys; CUBICSPLINE: in-tangent, value, out-tangent
} Keys;

// By the specification's appendix C, at t of [0, 1] of a segment `length` long.
static double spline( double t, double length, double v0, double out0, double v1, double in1 )
{
    double t2 = t * t, t3 = t2 * t;
    return ( 2 * t3 - 3 * t2 + 1 ) * v0 + length * ( t3 - 2 * t2 + t ) * out0 + ( -2 * t3 + 3 * t2 ) * v1 +
           length * ( t3 - t2 ) * in1;
}

static RfMat4 world_at( const Keys* keys, double time )
{
    static const float s_times[] = { 1, 2, 4 };
    GltfBuilder b = { 0 };
    bool cubic = keys->interpolation[0] == 'C';
    add_gltf_floats( &b, "SCALAR", 1, 3, s_times );
    add_gltf_floats( &b, keys->components == 4 ? "VEC4" : "VEC3", keys->components, cubic ? 9 : 3, keys->values );
    char rest[1024];
    snprintf(
        rest, sizeof rest,
        "\"nodes\":[{\"children\":[1]},{\"camera\":0}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1}}],"
        "\"animations\":[{\"samplers\":[{\"input\":0,\"output\":1,\"interpolation\":\"%s\"}],\"channels\":[{\"sampler\":0,"
        "\"target\":{\"node\":0,\"path\":\"%s\"}}]}]",
        keys->interpolation, keys->path );
    RfScene scene = gltf_load_built( &b, rest );
    assert_int_equal( scene.camera_count, 1 );
    assert_true( scene.cameras[0].animated && scene.cameras[0].start == 1.0 && scene.cameras[0].end == 4.0 );
    bool jumps = keys->interpolation[0] == 'S' && keys->path[0] != 's'; // a scale moves no camera at its origin
    assert_int_equal( rf_camera_shots( scene.cameras ), jumps ? 3 : 1 );
    RfMat4 world;
    rf_node_world_matrix( &scene, 1, time, &world ); // by its parent
    rf_destroy_scene( &scene );
    return world;
}

TEST( test_translations_and_scales )
{
    static const char* const s_paths[] = { "translation", "scale" };
    for ( int p = 0; p < 2; ++p )
    {
        Keys step = { "STEP", s_paths[p], 3, { 1, 2, 3, 4, 6, 8, 3, 5, 7 } },
             linear = { "LINEAR", s_paths[p], 3, { 1, 2, 3, 4, 6, 8, 3, 5, 7 } };
        Keys cubic = { "CUBICSPLINE", s_paths[p], 3, { 9, 9, 9, 1, 2,  3, 0, 1, -1, 1, 0, 2, 4, 6,
                                                       8, 2, 2, 2, -1, 0, 1, 3, 5,  7, 9, 9, 9 } };
        static const double s_times[] = { 0, 1, 1.25, 2, 3, 3.5, 4, 9 };
        for ( int k = 0; k < 8; ++k )
        {
            double t = fmin( fmax( s_times[k], 1 ), 4 ), part = t < 2 ? t - 1 : ( t - 2 ) / 2;
            int key = t < 2 ? 0 : 1;
            RfMat4 a = world_at( &step, s_times[k] ), b = world_at( &linear, s_times[k] ), c = world_at( &cubic, s_times[k] );
            for ( int i = 0; i < 3; ++i )
            {
                int at = p == 0 ? 12 + i : 5 * i;
                double v0 = step.values[3 * key + i], v1 = step.values[3 * key + 3 + i];
                gltf_assert_near( (float)a.m[at], part == 1 ? v1 : v0 );
                gltf_assert_near( (float)b.m[at], v0 + ( v1 - v0 ) * part );
                const float* from = cubic.values + 9 * key + i;
                gltf_assert_near( (float)c.m[at], spline( part, key + 1, from[3], from[6], from[12], from[9] ) );
            }
        }
    }
}

// Turns about z by 0, 90 and 270 degrees; the third with its sign turned around,
// which is the same rotation and must not change the way.
TEST( test_rotations_take_the_short_way )
{
    const float h = 0.70710678f;
    Keys step = { "STEP", "rotation", 4, { 0, 0, 0, 1, 0, 0, h, h, 0, 0, -h, h } }, linear = step,
         cubic = { "CUBICSPLINE", "rotation", 4, { 0 } };
    linear.interpolation = "LINEAR";
    for ( int key = 0; key < 3; ++key )
        memcpy( cubic.values + 12 * key + 4, step.values + 4 * key, 4 * sizeof( float ) );
    RfMat4 m = world_at( &step, 1.9 );
    gltf_assert_near( (float)m.m[0], 1 );
    m = world_at( &step, 2 );
    gltf_assert_near( (float)m.m[1], 1 );
    m = world_at( &linear, 1.5 );
    gltf_assert_near( (float)m.m[0], h );
    gltf_assert_near( (float)m.m[1], h );
    m = world_at( &linear, 2.5 ); // from +90 to −90: either way around, by its quarter
    gltf_assert_near( fabsf( (float)m.m[1] ), h );
    m = world_at( &linear, 0 );
    gltf_assert_near( (float)m.m[0], 1 );
    // without tangents: half a turn's quaternions, mixed by 3t² − 2t³ and made unit
    m = world_at( &cubic, 1.25 );
    double w = 3 * 0.0625 - 2 * 0.015625, z = w * (double)h, real = 1 - w + w * (double)h, angle = 2 * atan2( z, real );
    gltf_assert_near( (float)m.m[0], cos( angle ) );
    gltf_assert_near( (float)m.m[1], sin( angle ) );
}

// Rotations as exporters quantise them.
TEST( test_quantized_rotations )
{
    static const float s_times[] = { 0, 1 };
    static const int16_t s_turns[] = { 0, 0, 0, 32767, 0, 0, 23170, 23170 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "SCALAR", 1, 2, s_times );
    add_gltf_accessor( &b, 5122, "VEC4", 2, s_turns, sizeof s_turns, ",\"normalized\":true" );
    RfScene scene = gltf_load_built( &b, "\"nodes\":[{}],\"animations\":[{\"samplers\":[{\"input\":0,\"output\":1}],"
                                         "\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"rotation\"}}]}]" );
    RfMat4 m;
    rf_node_world_matrix( &scene, 0, 1.0, &m );
    gltf_assert_near( (float)m.m[1], 1 );
    rf_destroy_scene( &scene );
}

// ---- Cameras, scenes, and what is left out -------------------------------------

TEST( test_cameras_by_name )
{
    GltfBuilder b = { 0 };
    RfScene scene = gltf_load_built(
        &b, "\"scene\":1,\"scenes\":[{\"nodes\":[0]},{\"nodes\":[1,2]}],\"nodes\":[{\"name\":\"elsewhere\",\"camera\":0},"
            "{\"name\":\"wide\",\"camera\":0},{\"name\":\"tele\",\"camera\":1}],\"cameras\":[{\"type\":\"perspective\","
            "\"perspective\":{\"yfov\":1,\"znear\":0.1}},"
            "{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.25}}]" );
    assert_int_equal( scene.camera_count, 2 );
    int index;
    RfError error;
    assert_int_equal( rf_find_camera( &scene, "tele", &index, &error ), RF_OK );
    gltf_assert_near( (float)scene.cameras[index].yfov, 0.25 );
    assert_int_not_equal( rf_find_camera( &scene, "elsewhere", &index, &error ), RF_OK );
    assert_non_null( strstr( error.text, "elsewhere" ) );
    rf_destroy_scene( &scene );
}

typedef struct Notice
{
    const char* warning; // the only one
    uint32_t triangles;
    const char* json; // 0 positions of a triangle, 1 times
} Notice;

#define MESH( members ) "\"nodes\":[{\"name\":\"it\",\"mesh\":0}],\"meshes\":[{\"primitives\":[" members "]}]"
#define TRIANGLE "{\"attributes\":{\"POSITION\":0}}"
#define PAINT( extension )                                                                                                       \
    MESH( "{\"attributes\":{\"POSITION\":0},\"material\":0}" )                                                                   \
    ",\"materials\":[{\"name\":\"paint\",\"extensions\":{" extension "}},{\"extensions\":{" extension "}}]"
#define SCATTER ",\"extensionsUsed\":[\"KHR_materials_volume_scatter\"]"

TEST( test_what_is_left_out )
{
    static const Notice s_notices[] = {
        { "points and lines are not drawn: meshes[0].primitives[1]", 1,
          MESH( TRIANGLE ",{\"attributes\":{\"POSITION\":0},\"mode\":0},{\"attributes\":{\"POSITION\":0},\"mode\":1}" ) },
        { "points and lines are not drawn: meshes[0].primitives[0]", 1,
          MESH( "{\"attributes\":{\"POSITION\":0},\"mode\":2},{\"attributes\":{\"POSITION\":0},\"mode\":3}," TRIANGLE ) },
        { "has no POSITION: it is left out", 1, MESH( "{\"attributes\":{}},{\"attributes\":{}}," TRIANGLE ) },
        { "KHR_materials_volume_scatter is not supported yet: meshes[0]: dense bodies are rendered opaque", 1,
          MESH( "{\"attributes\":{\"POSITION\":0},\"extensions\":{\"KHR_materials_volume_scatter\":{}}}" ) SCATTER },
        { "KHR_materials_volume_scatter is not supported yet: texture 'wood'", 1,
          MESH(
              TRIANGLE ) ",\"textures\":[{},{\"name\":\"wood\",\"extensions\":{\"KHR_materials_volume_scatter\":{}}}]" SCATTER },
        { "KHR_materials_volume_scatter is not supported yet: samplers[0]", 1,
          MESH( TRIANGLE ) ",\"samplers\":[{\"extensions\":{\"KHR_materials_volume_scatter\":{}}}]" SCATTER },
        { "KHR_materials_volume_scatter is not supported yet: light 'sun'", 1,
          MESH( TRIANGLE ) ",\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"directional\",\"name\":\"sun\","
                           "\"extensions\":{\"KHR_materials_volume_scatter\":{}}}]}}" SCATTER },
        { "KHR_materials_volume_scatter is not supported yet: material 'paint'", 1,
          MESH( TRIANGLE ) ",\"materials\":[{\"name\":\"paint\",\"pbrMetallicRoughness\":{\"extensions\":"
                           "{\"KHR_materials_volume_scatter\":{}}}}]" SCATTER },
        { "KHR_materials_volume_scatter is not supported yet: the file", 1,
          MESH( TRIANGLE ) ",\"extensions\":{\"KHR_materials_volume_scatter\":{}}" SCATTER },
        { "extension EXT_unheard_of is unknown: what it adds is left out", 1, // nothing of a node outside the scene
          "\"nodes\":[{\"mesh\":0},{\"extensions\":{\"KHR_materials_volume_scatter\":{}}}],\"scenes\":[{\"nodes\":[0]}],"
          "\"meshes\":[{"
          "\"primitives\":[" TRIANGLE "]}],\"extensionsUsed\":[\"KHR_materials_volume_scatter\",\"EXT_unheard_of\"]" },
        { "extension CESIUM_primitive_outline is unknown: what it adds to meshes[0] is left out", 1,
          MESH( "{\"attributes\":{\"POSITION\":0},\"extensions\":{\"CESIUM_primitive_outline\":{}}}" ) ",\"extensionsUsed\":["
                                                                                                       "\"CESIUM_primitive_"
                                                                                                       "outline\"]" },
        { "extension EXT_materials_bump is unknown: what it adds to material 'paint' is left out", 1,
          PAINT( "\"EXT_materials_bump\":{}" ) ",\"extensionsUsed\":[\"EXT_materials_bump\"]" },
        { "EXT_lights_ies is not supported yet: node 'it': it shines without its profile", 0,
          "\"nodes\":[{\"name\":\"it\",\"extensions\":{\"EXT_lights_ies\":{\"light\":0}}}],\"extensionsUsed\":[\"EXT_lights_"
          "ies\"]" },
        { "extension EXT_unheard_of is unknown: what it adds is left out", 1,
          MESH( TRIANGLE ) ",\"extensionsUsed\":[\"EXT_unheard_of\"]" },
        { "extension EXT_unheard_of is unknown", 1, // nothing of metadata
          MESH( TRIANGLE ) ",\"extensionsUsed\":[\"KHR_materials_ior\",\"KHR_xmp_json_ld\",\"EXT_unheard_of\"],"
                           "\"extensionsRequired\":"
                           "[\"MSFT_lod\"]" },
    };
    static const float s_positions[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 }, s_times[] = { 0, 1, 2 };
    for ( size_t i = 0; i < sizeof s_notices / sizeof s_notices[0]; ++i )
    {
        GltfBuilder b = { 0 };
        add_gltf_floats( &b, "VEC3", 3, 3, s_positions );
        add_gltf_floats( &b, "SCALAR", 1, 3, s_times );
        RfScene scene = gltf_load_built( &b, s_notices[i].json );
        gltf_assert_warned( s_notices[i].warning );
        const char* end = strchr( gltf_warnings, '\n' );
        if ( end == NULL || end[1] != 0 )
            fail_msg( "more than one warning: %s", gltf_warnings );
        assert_int_equal( scene.triangles.count, s_notices[i].triangles );
        rf_destroy_scene( &scene );
    }
}

// A file that names thousands does not fill the log.
TEST( test_many_unknown_extensions )
{
    char rest[2048] = "\"extensionsUsed\":[";
    for ( int i = 0; i < 40; ++i )
        sprintf( rest + strlen( rest ), "%s\"EXT_%d\"", i > 0 ? "," : "", i );
    strcat( rest, "]" );
    GltfBuilder b = { 0 };
    RfScene scene = gltf_load_built( &b, rest );
    int lines = 0;
    for ( const char* c = gltf_warnings; *c != 0; ++c )
        lines += *c == '\n';
    assert_int_equal( lines, 32 );
    rf_destroy_scene( &scene );
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
