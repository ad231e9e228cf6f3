// A corpus of small glTF files, one for each feature of the format that they can use:
// accessors of every component type, packed, strided and sparse; animations with every
// sampler and target; what is read without being drawn, and what is ignored with one
// warning. Materials, textures and geometry have their own tests.
#include "support/gltf_checks.h"

#include "scene/animation.h"
#include "scene/camera.h"
#include "scene/gltf/gltf.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

// ---- Accessors --------------------------------------------------------------

static const struct
{
    int type, size;
    double most; // what normalized divides by; 0: not allowed
} s_types[] = { { 5120, 1, 127 }, { 5121, 1, 255 }, { 5122, 2, 32767 }, { 5123, 2, 65535 }, { 5125, 4, 0 }, { 5126, 4, 0 } };

static void put_component( uint8_t* at, int type, int value )
{
    float real = (float)value;
    int32_t word = value;
    if ( type == 5126 )
        memcpy( at, &real, 4 );
    else // little-endian, as this machine is
        memcpy( at, &word, type == 5120 || type == 5121 ? 1 : type == 5125 ? 4 : 2 );
}

enum
{
    PACKED,
    STRIDED,
    SPARSE,
    SPARSE_ZEROS,
    LAYOUTS
};

// Three elements, none on a line with the others; signed types have a −7.
static int value_of( int type, int e, int c )
{
    bool is_signed = type == 5120 || type == 5122 || type == 5126;
    return e == 2 && c == 0 ? ( is_signed ? -7 : 9 ) : ( c + 1 ) * e + c;
}

static int add_values( GltfBuilder* b, int kind, int components, const char* shape, const char* normalized, int layout,
                       int index_type )
{
    uint8_t bytes[128] = { 0 }, index[4] = { 2 }, value[16] = { 0 };
    int type = s_types[kind].type, size = s_types[kind].size, stride = layout == STRIDED ? 20 : components * size;
    for ( int e = 0; e < 3; ++e )
    {
        for ( int c = 0; c < components; ++c )
            put_component( bytes + e * stride + c * size, type, layout == SPARSE && e == 2 ? 1 : value_of( type, e, c ) );
    }
    for ( int c = 0; c < components; ++c )
        put_component( value + c * size, type, value_of( type, 2, c ) );
    if ( layout == PACKED )
        return add_gltf_accessor( b, type, shape, 3, bytes, (size_t)( 3 * stride ), normalized );
    if ( layout == STRIDED )
    {
        int place = add_gltf_accessor( b, type, shape, 3, bytes, (size_t)( 2 * stride + components * size ), normalized );
        char* end = strrchr( b->views, '}' );
        assert_non_null( end );
        strcpy( end, ",\"byteStride\":20}" );
        return place;
    }
    int indices = add_gltf_accessor( b, index_type, "SCALAR", 1, index, sizeof index, "" );
    int values = add_gltf_accessor( b, type, shape, 1, value, (size_t)( components * size ), "" );
    char more[256];
    snprintf( more, sizeof more,
              "%s,\"sparse\":{\"count\":1,\"indices\":{\"bufferView\":%d,\"componentType\":%d},\"values\":{\"bufferView\":%d}}",
              normalized, indices, index_type, values );
    if ( layout == SPARSE )
        return add_gltf_accessor( b, type, shape, 3, bytes, (size_t)( 3 * stride ), more );
    // no view beneath: zeros, and a view that nothing uses, to keep the numbers in step
    int place = add_gltf_accessor( b, 5121, "SCALAR", 1, bytes, 1, "" );
    char* start = strrchr( b->accessors, '{' );
    assert_non_null( start );
    sprintf( start, "{\"componentType\":%d,\"count\":3,\"type\":\"%s\"%s}", type, shape, more );
    return place;
}

static double expected( int kind, bool normalized, int layout, int e, int c )
{
    double value = layout == SPARSE_ZEROS && e < 2 ? 0.0 : value_of( s_types[kind].type, e, c );
    return normalized ? fmax( value / s_types[kind].most, -1.0 ) : value;
}

#define PRIMITIVE                                                                                                                \
    "\"nodes\":[{\"mesh\":0}],\"extensionsRequired\":[\"KHR_mesh_quantization\"],\"meshes\":[{\"primitives\":[{\"attributes\":"

// Positions (shown by the corners of a flat triangle) and coordinates.
static void check_accessor( int kind, bool normalized, int layout, int index_type )
{
    GltfBuilder b = { 0 };
    const char* more = normalized ? ",\"normalized\":true" : "";
    int p = add_values( &b, kind, 3, "VEC3", more, layout, index_type ),
        uv = add_values( &b, kind, 2, "VEC2", more, layout, index_type );
    char rest[512];
    snprintf( rest, sizeof rest, PRIMITIVE "{\"POSITION\":%d,\"TEXCOORD_0\":%d,\"TEXCOORD_1\":%d}}]}]", p, uv, uv );
    RfScene scene = gltf_load_built( &b, rest );
    if ( layout == SPARSE_ZEROS ) // two corners are one: no area
    {
        assert_int_equal( scene.triangles.count, 0 );
        rf_destroy_scene( &scene );
        return;
    }
    assert_int_equal( scene.triangles.count, 1 );
    for ( int e = 0; e < 3; ++e )
    {
        gltf_assert_corner( &scene, e, expected( kind, normalized, layout, e, 0 ), expected( kind, normalized, layout, e, 1 ),
                            expected( kind, normalized, layout, e, 2 ) );
        for ( int c = 0; c < 2; ++c )
        {
            gltf_assert_near( scene.triangles.uvs[2 * e + c], expected( kind, normalized, layout, e, c ) );
            gltf_assert_near( scene.triangles.uvs1[2 * e + c], expected( kind, normalized, layout, e, c ) );
        }
    }
    assert_string_equal( gltf_warnings, "" );
    rf_destroy_scene( &scene );
}

static void test_every_accessor_type_is_read( void** state )
{
    (void)state;
    static const int s_index_types[] = { 5121, 5123, 5125 };
    for ( int kind = 0; kind < 6; ++kind )
    {
        for ( int normalized = 0; normalized <= ( s_types[kind].most > 0.0 ); ++normalized )
        {
            for ( int layout = 0; layout < LAYOUTS; ++layout )
            {
                for ( int i = 0; i < ( layout >= SPARSE ? 3 : 1 ); ++i )
                    check_accessor( kind, normalized, layout, s_index_types[i] );
            }
        }
    }
}

// Sparse over zeros, which have no area above, as coordinates.
static void test_sparse_over_zeros_is_read( void** state )
{
    (void)state;
    static const float s_positions[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    for ( int kind = 0; kind < 6; ++kind )
    {
        GltfBuilder b = { 0 };
        int p = add_gltf_floats( &b, "VEC3", 3, 3, s_positions ), uv = add_values( &b, kind, 2, "VEC2", "", SPARSE_ZEROS, 5123 );
        char rest[512];
        snprintf( rest, sizeof rest, PRIMITIVE "{\"POSITION\":%d,\"TEXCOORD_0\":%d}}]}]", p, uv );
        RfScene scene = gltf_load_built( &b, rest );
        for ( int i = 0; i < 6; ++i )
            gltf_assert_near( scene.triangles.uvs[i], expected( kind, false, SPARSE_ZEROS, i / 2, i % 2 ) );
        rf_destroy_scene( &scene );
    }
}

// Colours are floats or normalized unsigned, of three or four; nothing else.
static void test_every_colour_type_is_read( void** state )
{
    (void)state;
    static const float s_positions[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 };
    int read = 0;
    for ( int kind = 0; kind < 6; ++kind )
    {
        for ( int normalized = 0; normalized <= ( s_types[kind].most > 0.0 ); ++normalized )
        {
            for ( int components = 2; components <= 4; ++components )
            {
                static const char* const s_shapes[] = { "VEC2", "VEC3", "VEC4" };
                GltfBuilder b = { 0 };
                int p = add_gltf_floats( &b, "VEC3", 3, 3, s_positions );
                int color = add_values( &b, kind, components, s_shapes[components - 2], normalized ? ",\"normalized\":true" : "",
                                        STRIDED, 0 );
                char rest[512];
                snprintf( rest, sizeof rest, PRIMITIVE "{\"POSITION\":%d,\"COLOR_0\":%d}}]}]", p, color );
                RfScene scene;
                RfError error = { 0 };
                RfResult result = rf_load_gltf( write_gltf( &b, &gltf_folder, rest ), &scene, NULL, &error );
                bool good = components > 2 && ( s_types[kind].type == 5126 || ( normalized && kind % 2 == 1 ) );
                assert_int_equal( result, good ? RF_OK : RF_ERROR_FORMAT );
                read += good;
                for ( int i = 0; good && i < 12; ++i )
                {
                    double want = i % 4 < components ? expected( kind, normalized, STRIDED, i / 4, i % 4 ) : 1.0;
                    gltf_assert_near( scene.triangles.colors[i], fmin( fmax( want, 0.0 ), 1.0 ) );
                }
                if ( !good )
                    assert_non_null( strstr( error.text, "COLOR_0 wants 3 or 4" ) );
                rf_destroy_scene( &scene );
            }
        }
    }
    assert_int_equal( read, 6 );
}

static void test_every_index_type( void** state )
{
    (void)state;
    static const float s_square[] = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 };
    for ( int kind = 1; kind < 5; kind += kind == 3 ? 1 : 2 )
    {
        uint8_t bytes[12] = { 0 };
        static const int s_corners[] = { 3, 1, 2 };
        for ( int i = 0; i < 3; ++i )
            put_component( bytes + i * s_types[kind].size, s_types[kind].type, s_corners[i] );
        GltfBuilder b = { 0 };
        int p = add_gltf_floats( &b, "VEC3", 3, 4, s_square );
        int indices = add_gltf_accessor( &b, s_types[kind].type, "SCALAR", 3, bytes, (size_t)( 3 * s_types[kind].size ), "" );
        char rest[512];
        snprintf( rest, sizeof rest, PRIMITIVE "{\"POSITION\":%d},\"indices\":%d}]}]", p, indices );
        RfScene scene = gltf_load_built( &b, rest );
        gltf_assert_corner( &scene, 0, 0, 1, 0 );
        gltf_assert_corner( &scene, 1, 1, 0, 0 );
        gltf_assert_corner( &scene, 2, 1, 1, 0 );
        rf_destroy_scene( &scene );
    }
}

// What gltfpack and Blender write: quantised normals with a stride, tangents of
// bytes, the scale in the node.
static void test_quantized_meshes_are_read( void** state )
{
    (void)state;
    static const uint16_t s_positions[] = { 0, 0, 0, 0, 65535, 0, 0, 0, 0, 65535, 0, 0 };
    static const int8_t s_normals[] = { 0, 0, 127, 0, 0, 0, 127, 0, 0, 0, 127, 0 },
                        s_tangents[] = { 127, 0, 0, -127, 127, 0, 0, -127, 127, 0, 0, -127 };
    GltfBuilder b = { 0 };
    add_gltf_accessor( &b, 5123, "VEC3", 3, s_positions, sizeof s_positions, ",\"normalized\":true" );
    strcpy( strrchr( b.views, '}' ), ",\"byteStride\":8}" );
    add_gltf_accessor( &b, 5120, "VEC3", 3, s_normals, sizeof s_normals, ",\"normalized\":true" );
    strcpy( strrchr( b.views, '}' ), ",\"byteStride\":4}" );
    add_gltf_accessor( &b, 5120, "VEC4", 3, s_tangents, sizeof s_tangents, ",\"normalized\":true" );
    RfScene scene =
        gltf_load_built( &b, "\"extensionsUsed\":[\"KHR_mesh_quantization\"],\"extensionsRequired\":[\"KHR_mesh_quantization\"],"
                             "\"nodes\":[{\"mesh\":0,\"scale\":[3,3,3],\"translation\":[1,0,0]}],\"meshes\":[{\"primitives\":[{"
                             "\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":2}}]}]" );
    gltf_assert_corner( &scene, 1, 4, 0, 0 );
    gltf_assert_corner( &scene, 2, 1, 3, 0 );
    gltf_assert_normal( &scene, 2, 0, 0, 1 );
    gltf_assert_three( scene.triangles.tangents, 1, 0, 0 );
    gltf_assert_near( scene.triangles.tangents[3], -1 );
    assert_string_equal( gltf_warnings, "" );
    rf_destroy_scene( &scene );
}

// Two buffers: one in the text, one beside it.
static void test_two_buffers_are_read( void** state )
{
    (void)state;
    static const float s_positions[] = { 0, 0, 0, 1, 0, 0, 0, 1, 5 };
    static const uint16_t s_indices[] = { 2, 0, 1, 0 };
    char* text = gltf_base64( (const uint8_t*)s_indices, sizeof s_indices );
    write_bytes( &gltf_folder, "b c.bin", s_positions, sizeof s_positions );
    char json[2048];
    snprintf(
        json, sizeof json,
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":8,\"uri\":\"data:application/gltf-buffer;base64,%s\"},"
        "{\"byteLength\":36,\"uri\":\"b%%20c.bin\"}],\"bufferViews\":[{\"buffer\":1,\"byteLength\":36},{\"buffer\":0,"
        "\"byteLength\":6}],\"accessors\":["
        "{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\"},{\"bufferView\":1,\"componentType\":5123,"
        "\"count\":3,\"type\":\"SCALAR\"}],"
        "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1}]}]}",
        text );
    free( text );
    RfScene scene = gltf_load( write_bytes( &gltf_folder, "a.gltf", json, strlen( json ) ) );
    gltf_assert_corner( &scene, 0, 0, 1, 5 );
    gltf_assert_corner( &scene, 2, 1, 0, 0 );
    rf_destroy_scene( &scene );
}

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
    RfMat4 world;
    rf_node_world_matrix( &scene, 1, time, &world ); // by its parent
    rf_destroy_scene( &scene );
    return world;
}

static void test_translations_and_scales( void** state )
{
    (void)state;
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
static void test_rotations_take_the_short_way( void** state )
{
    (void)state;
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
static void test_quantized_rotations( void** state )
{
    (void)state;
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

static void test_cameras_by_name( void** state )
{
    (void)state;
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
#define MOVES( target )                                                                                                          \
    "\"nodes\":[{}],\"animations\":[{\"samplers\":[{\"input\":1,\"output\":0}],\"channels\":[{\"sampler\":0,\"target\":{" target \
    "}},{\"sampler\":0,\"target\":{" target "}}]}]"

static void test_what_is_left_out( void** state )
{
    (void)state;
    static const Notice s_notices[] = {
        { "points and lines are not drawn: meshes[0].primitives[1]", 1,
          MESH( TRIANGLE ",{\"attributes\":{\"POSITION\":0},\"mode\":0},{\"attributes\":{\"POSITION\":0},\"mode\":1}" ) },
        { "points and lines are not drawn: meshes[0].primitives[0]", 1,
          MESH( "{\"attributes\":{\"POSITION\":0},\"mode\":2},{\"attributes\":{\"POSITION\":0},\"mode\":3}," TRIANGLE ) },
        { "morph targets are not supported: meshes[0].primitives[0] keeps its base shape", 1,
          MESH( "{\"attributes\":{\"POSITION\":0},\"targets\":[{\"POSITION\":0}]}" ) ",\"animations\":[]" },
        { "skins are not supported: node 'it' keeps its rest pose", 1,
          "\"nodes\":[{\"name\":\"it\",\"mesh\":0,\"skin\":0}],\"skins\":[{\"joints\":[0]}],\"meshes\":[{\"primitives\":"
          "[" TRIANGLE "]}]" },
        { "has no POSITION: it is left out", 1, MESH( "{\"attributes\":{}},{\"attributes\":{}}," TRIANGLE ) },
        { "'it' moves or changes in the file, but only cameras move here", 1,
          MESH( TRIANGLE ) ",\"animations\":[{\"samplers\":[{\"input\":1,\"output\":0}],\"channels\":[{\"sampler\":0,\"target\":{"
                           "\"node\":0,\"path\":\"translation\"}}]}]" },
        { "'it' moves or changes in the file, but only cameras move here", 0,
          "\"extensions\":{\"KHR_lights_punctual\":{\"lights\":[{\"type\":\"point\"}]}},\"nodes\":[{\"name\":\"it\","
          "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}],"
          "\"animations\":[{\"samplers\":[{\"input\":1,\"output\":0}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,"
          "\"path\":\"translation\"}}]}]" },
        { "KHR_animation_pointer is not supported: what animations[0].channels[0] moves stands still", 0,
          MOVES(
              "\"path\":\"pointer\",\"extensions\":{\"KHR_animation_pointer\":{\"pointer\":\"/materials/0/emissiveFactor\"}}" ) },
        { "morph targets are not supported: what animations[0].channels[0] moves", 0,
          MOVES( "\"path\":\"weights\",\"node\":0" ) },
        { "KHR_materials_sheen is not supported yet: material 'paint'", 1, PAINT( "\"KHR_materials_sheen\":{}" ) },
        { "KHR_materials_anisotropy is not supported yet: material 'paint'", 1, PAINT( "\"KHR_materials_anisotropy\":{}" ) },
        { "KHR_materials_iridescence is not supported yet: material 'paint'", 1, PAINT( "\"KHR_materials_iridescence\":{}" ) },
        { "KHR_materials_dispersion is not supported yet: material 'paint'", 1, PAINT( "\"KHR_materials_dispersion\":{}" ) },
        { "KHR_materials_pbrSpecularGlossiness is not supported yet: material 'paint'", 1,
          PAINT( "\"KHR_materials_pbrSpecularGlossiness\":{}" ) },
        { "extension KHR_materials_variants is unknown: what it adds to meshes[0] is left out", 1,
          MESH(
              "{\"attributes\":{\"POSITION\":0},\"extensions\":{\"KHR_materials_variants\":{\"mappings\":[]}}}" ) ",\"extensionsU"
                                                                                                                  "sed\":[\"KHR_"
                                                                                                                  "materials_"
                                                                                                                  "variants\","
                                                                                                                  "\"KHR_"
                                                                                                                  "materials_"
                                                                                                                  "sheen\"]" },
        { "extension KHR_materials_diffuse_transmission is unknown: what it adds to material 'paint' is left out", 1,
          PAINT( "\"KHR_materials_diffuse_transmission\":{}" ) ",\"extensionsUsed\":[\"KHR_materials_diffuse_transmission\"]" },
        { "extension EXT_lights_ies is unknown: what it adds to node 'it' is left out", 0,
          "\"nodes\":[{\"name\":\"it\",\"extensions\":{\"EXT_lights_ies\":{\"light\":0}}}],\"extensionsUsed\":[\"EXT_lights_"
          "ies\"]" },
        { "extension KHR_draco_mesh_compression is unknown: what it adds is left out", 1,
          MESH( TRIANGLE ) ",\"extensionsUsed\":[\"KHR_draco_mesh_compression\"]" },
        { "extension KHR_xmp_json_ld is unknown", 1,
          MESH( TRIANGLE ) ",\"extensionsUsed\":[\"KHR_materials_ior\",\"KHR_xmp_json_ld\"]" },
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
static void test_many_unknown_extensions( void** state )
{
    (void)state;
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

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_every_accessor_type_is_read ),
        cmocka_unit_test( test_sparse_over_zeros_is_read ),
        cmocka_unit_test( test_every_colour_type_is_read ),
        cmocka_unit_test( test_every_index_type ),
        cmocka_unit_test( test_quantized_meshes_are_read ),
        cmocka_unit_test( test_two_buffers_are_read ),
        cmocka_unit_test( test_translations_and_scales ),
        cmocka_unit_test( test_rotations_take_the_short_way ),
        cmocka_unit_test( test_quantized_rotations ),
        cmocka_unit_test( test_cameras_by_name ),
        cmocka_unit_test( test_what_is_left_out ),
        cmocka_unit_test( test_many_unknown_extensions ),
    };
    return cmocka_run_group_tests( tests, gltf_enter, gltf_leave );
}
