// A corpus of small glTF files with accessors of every component type, packed, strided and sparse.
#include "support/scene_files.h"
#include "support/test.h"

#include "gltf/gltf.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

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

TEST( test_every_accessor_type_is_read )
{
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
TEST( test_sparse_over_zeros_is_read )
{
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
TEST( test_every_colour_type_is_read )
{
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
                    assert_non_null( strstr( error.text, "COLOR_0 must be 3 or 4" ) );
                rf_destroy_scene( &scene );
            }
        }
    }
    assert_int_equal( read, 6 );
}

TEST( test_every_index_type )
{
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
TEST( test_quantized_meshes_are_read )
{
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
TEST( test_two_buffers_are_read )
{
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

SHARED_BY_TESTS( gltf_enter, gltf_leave )
