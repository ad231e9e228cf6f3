// EXT_ and KHR_meshopt_compression: views hold what was compressed, and broken ones are refused in one line.
#include "support/scene_files.h"
#include "support/test.h"

#include "gltf/gltf.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define POINTS 40 // a strip of squares
#define FACES ( POINTS - 2 )

// Broken files per run.
#define MUTATIONS 400

static float s_positions[3 * POINTS];
static uint16_t s_indices[3 * FACES];

static void make_strip( void )
{
    for ( int i = 0; i < POINTS; ++i )
        memcpy( s_positions + 3 * i, ( float[3] ){ (float)( i / 2 ), (float)( i % 2 ), 0.25f * (float)( i % 3 ) }, 12 );
    for ( uint16_t f = 0; f < FACES; ++f )
    {
        const uint16_t odd = f % 2, corners[3] = { f, (uint16_t)( f + 1 + odd ), (uint16_t)( f + 2 - odd ) };
        memcpy( s_indices + 3 * f, corners, 6 );
    }
}

#define MESH( primitive ) "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{" primitive "}]}]"
#define STRIP MESH( "\"attributes\":{\"POSITION\":0},\"indices\":1" )

// The same triangles in the same order; the mode TRIANGLES may begin each at another corner.
static void assert_strip( const RfScene* scene )
{
    assert_int_equal( scene->triangles.count, FACES );
    for ( int f = 0; f < FACES; ++f )
    {
        double least = INFINITY;
        for ( int turn = 0; turn < 3; ++turn )
        {
            double most = 0.0;
            for ( int c = 0; c < 9; ++c )
            {
                const float* got = scene->triangles.positions + 3 * scene->triangles.indices[3 * f + c / 3];
                const float* want = s_positions + 3 * s_indices[3 * f + ( c / 3 + turn ) % 3];
                most = fmax( most, fabs( (double)got[c % 3] - (double)want[c % 3] ) );
            }
            least = fmin( least, most );
        }
        if ( least != 0.0 )
            fail_msg( "triangle %d is off by %g", f, least );
    }
}

// A view that another holds compressed.
typedef struct PackedView
{
    const char* extension;
    const char* mode;
    const char* filter; // further members, or ""
    int count, stride;
    const uint8_t* bytes;
    size_t size;
} PackedView;

static void add_view( GltfBuilder* b, const PackedView* v )
{
    char* text = b->views + strlen( b->views );
    sprintf( text,
             "%s{\"buffer\":0,\"byteLength\":%d%s,\"extensions\":{\"%s\":{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu,"
             "\"byteStride\":%d,\"count\":%d,\"mode\":\"%s\"%s}}}",
             b->count > 0 ? "," : "", v->count * v->stride, v->stride == 8 ? ",\"byteStride\":8" : "", v->extension, b->bin_size,
             v->size, v->stride, v->count, v->mode, v->filter );
    memcpy( b->bin + b->bin_size, v->bytes, v->size );
    b->bin_size += v->size;
}

static void add_accessor( GltfBuilder* b, const char* text )
{
    sprintf( b->accessors + strlen( b->accessors ), "%s{\"bufferView\":%d,%s}", b->count > 0 ? "," : "", b->count, text );
    b->count += 1;
}

#ifdef REFRAME_MESHOPT

#include <meshoptimizer.h>

static size_t pack_values( const void* values, size_t count, size_t stride, uint8_t* out )
{
    meshopt_encodeVertexVersion( 0 );
    return meshopt_encodeVertexBuffer( out, 8192, values, count, stride );
}

static void add_positions( GltfBuilder* b, const char* extension, const char* filter, const void* values )
{
    uint8_t bytes[8192];
    size_t size = pack_values( values, POINTS, 12, bytes );
    PackedView view = { extension, "ATTRIBUTES", filter, POINTS, 12, bytes, size };
    add_view( b, &view );
    add_accessor( b, "\"componentType\":5126,\"count\":40,\"type\":\"VEC3\"" );
}

static void add_indices( GltfBuilder* b, const char* extension, bool triangles, int stride )
{
    uint8_t bytes[8192];
    unsigned int words[3 * FACES];
    for ( int i = 0; i < 3 * FACES; ++i )
        words[i] = s_indices[i];
    size_t size = triangles ? meshopt_encodeIndexBuffer( bytes, sizeof bytes, words, 3 * FACES )
                            : meshopt_encodeIndexSequence( bytes, sizeof bytes, words, 3 * FACES );
    PackedView view = { extension, triangles ? "TRIANGLES" : "INDICES", "", 3 * FACES, stride, bytes, size };
    add_view( b, &view );
    add_accessor( b, stride == 2 ? "\"componentType\":5123,\"count\":114,\"type\":\"SCALAR\""
                                 : "\"componentType\":5125,\"count\":114,\"type\":\"SCALAR\"" );
}

#define EXT "EXT_meshopt_compression"
#define KHR "KHR_meshopt_compression"

static GltfBuilder make_packed( const char* extension, int stride )
{
    GltfBuilder b = { 0 };
    add_positions( &b, extension, "", s_positions );
    add_indices( &b, extension, stride == 4, stride );
    return b;
}

TEST( test_meshes )
{
    for ( int i = 0; i < 4; ++i )
    {
        GltfBuilder b = make_packed( i < 2 ? EXT : KHR, i % 2 == 0 ? 2 : 4 );
        RfScene scene =
            gltf_load_built( &b, STRIP ",\"extensionsRequired\":[\"EXT_meshopt_compression\",\"KHR_meshopt_compression\"]" );
        assert_string_equal( gltf_warnings, "" );
        assert_strip( &scene );
        rf_destroy_scene( &scene );
    }
}

// 2^e·m, of which these need no rounding: what comes out is exact.
TEST( test_exponential_filter )
{
    int32_t packed[3 * POINTS];
    for ( int i = 0; i < 3 * POINTS; ++i )
        packed[i] = (int32_t)( (uint32_t)-2 << 24 | ( (uint32_t)( 4.0f * s_positions[i] ) & 0xffffff ) );
    GltfBuilder b = { 0 };
    add_positions( &b, EXT, ",\"filter\":\"EXPONENTIAL\"", packed );
    add_indices( &b, EXT, true, 2 );
    RfScene scene = gltf_load_built( &b, STRIP );
    assert_strip( &scene );
    rf_destroy_scene( &scene );
}

static void add_normals( GltfBuilder* b, int stride )
{
    uint8_t bytes[8192];
    int16_t shorts[4 * POINTS];
    int8_t chars[4 * POINTS];
    for ( int i = 0; i < POINTS; ++i )
    {
        // (1, 2, −3)/√14 as an octahedron: (1/6, 1/3) of the upper half, turned over (specification, filter 1)
        memcpy( shorts + 4 * i, ( int16_t[4] ){ 21845, 27306, 32767, 0 }, 8 );
        memcpy( chars + 4 * i, ( int8_t[4] ){ 85, 106, 127, 0 }, 4 );
    }
    size_t size = pack_values( stride == 8 ? (const void*)shorts : chars, POINTS, (size_t)stride, bytes );
    PackedView view = { EXT, "ATTRIBUTES", ",\"filter\":\"OCTAHEDRAL\"", POINTS, stride, bytes, size };
    add_view( b, &view );
    if ( stride == 4 ) // of three bytes each
        sprintf( b->views + strlen( b->views ) - 1, ",\"byteStride\":4}" );
    add_accessor( b, stride == 8 ? "\"componentType\":5122,\"count\":40,\"type\":\"VEC3\",\"normalized\":true"
                                 : "\"componentType\":5120,\"count\":40,\"type\":\"VEC3\",\"normalized\":true" );
}

TEST( test_octahedral_filter )
{
    for ( int stride = 4; stride <= 8; stride += 4 )
    {
        GltfBuilder b = make_packed( EXT, 2 );
        add_normals( &b, stride );
        RfScene scene = gltf_load_built( &b, MESH( "\"attributes\":{\"POSITION\":0,\"NORMAL\":2},\"indices\":1" ) );
        const double want[3] = { 1.0 / sqrt( 14.0 ), 2.0 / sqrt( 14.0 ), -3.0 / sqrt( 14.0 ) };
        for ( int c = 0; c < 3; ++c )
            assert_true( fabs( (double)scene.triangles.normals[c] - want[c] ) < ( stride == 8 ? 1e-4 : 0.02 ) );
        rf_destroy_scene( &scene );
    }
}

// An animated rotation, by 90° about z: (0, 0, √½, √½), of which w is left out.
TEST( test_quaternion_filter )
{
    static const float s_times[] = { 0, 1 };
    // √2 times the component, of 32767; the last is 32767 with the index of the largest, 3
    static const int16_t s_turns[] = { 0, 0, 0, 32767, 0, 0, 32767, 32767 };
    uint8_t bytes[8192];
    GltfBuilder b = make_packed( EXT, 2 );
    size_t size = pack_values( s_turns, 2, 8, bytes );
    PackedView view = { EXT, "ATTRIBUTES", ",\"filter\":\"QUATERNION\"", 2, 8, bytes, size };
    add_view( &b, &view );
    char* stride = strstr( b.views, ",\"byteStride\":8,\"ext" ); // of views of animations there is none
    memmove( stride, stride + 15, strlen( stride + 15 ) + 1 );
    add_accessor( &b, "\"componentType\":5122,\"count\":2,\"type\":\"VEC4\",\"normalized\":true" );
    size = pack_values( s_times, 2, 4, bytes );
    view = ( PackedView ){ EXT, "ATTRIBUTES", "", 2, 4, bytes, size };
    add_view( &b, &view );
    add_accessor( &b, "\"componentType\":5126,\"count\":2,\"type\":\"SCALAR\"" );
    RfScene scene =
        gltf_load_built( &b, STRIP ",\"animations\":[{\"samplers\":[{\"input\":3,\"output\":2}],\"channels\":[{\"sampler\":0,"
                                   "\"target\":{\"node\":0,\"path\":\"rotation\"}}]}]" );
    RfPosedScene pose = gltf_pose_at( &scene, 1.0 );
    double at[3];
    gltf_find_placed_corner( &pose.scene, FACES - 1, 0, at );
    const float* p = s_positions + 3 * s_indices[3 * ( FACES - 1 )];
    assert_true( fabs( at[0] + (double)p[1] ) < 1e-3 && fabs( at[1] - (double)p[0] ) < 2e-3 );
    rf_destroy_pose( &pose );
    rf_destroy_scene( &scene );
}

// Numbers of the specification's formulas, by hand: 8 bits (K = 8), 6 bits (K = 6) and 16 bits (K = 12).
TEST( test_color_filter )
{
    // Y 100, Co 20, Cg −30, alpha 0x40 of 7 bits: r = 100 + 20 + 30 = 150, g = 70, b = 100 − 20 + 30 = 110, a = 128
    // Y 20, Co −3, Cg 5, alpha 0x1f of 5 bits below bit 5: r 12, g 25, b 18, a 63, each times 255/63
    static const uint8_t s_small[][4] = { { 100, 20, (uint8_t)-30, 0xc0 }, { 20, (uint8_t)-3, 5, 0x3f } };
    static const double s_small_want[][4] = { { 150, 70, 110, 128 }, { 49, 101, 73, 255 } };
    // Y 2000, Co 100, Cg −200, alpha 0x2aa of 11 bits: r 2300, g 1800, b 2100, a 1364, each times 65535/4095
    static const uint16_t s_large[] = { 2000, 100, (uint16_t)-200, 0xaaa };
    static const double s_large_want[] = { 36808, 28807, 33608, 21829 };
    for ( int k = 0; k < 3; ++k )
    {
        uint8_t bytes[8192], colors[8 * POINTS];
        int stride = k < 2 ? 4 : 8;
        for ( int i = 0; i < POINTS; ++i )
            memcpy( colors + i * stride, k < 2 ? (const void*)s_small[k] : s_large, (size_t)stride );
        GltfBuilder b = make_packed( KHR, 2 );
        size_t size = pack_values( colors, POINTS, (size_t)stride, bytes );
        PackedView view = { KHR, "ATTRIBUTES", ",\"filter\":\"COLOR\"", POINTS, stride, bytes, size };
        add_view( &b, &view );
        add_accessor( &b, k < 2 ? "\"componentType\":5121,\"count\":40,\"type\":\"VEC4\",\"normalized\":true"
                                : "\"componentType\":5123,\"count\":40,\"type\":\"VEC4\",\"normalized\":true" );
        RfScene scene = gltf_load_built( &b, MESH( "\"attributes\":{\"POSITION\":0,\"COLOR_0\":2},\"indices\":1" ) );
        for ( int c = 0; c < 4; ++c )
            gltf_assert_near( scene.triangles.colors[4 * ( POINTS - 1 ) + c],
                              k < 2 ? s_small_want[k][c] / 255.0 : s_large_want[c] / 65535.0 );
        rf_destroy_scene( &scene );
    }
}

TEST( test_faults )
{
    static const struct
    {
        const char *from, *to, *part; // in the text of the first view
    } s_faults[] = {
        { "\"ATTRIBUTES\"", "\"POINTS\"", "mode 'POINTS' must be one of ATTRIBUTES, TRIANGLES, INDICES" },
        { "\"mode\":\"ATTRIBUTES\"", "\"mode\":\"ATTRIBUTES\",\"filter\":\"BLUR\"",
          "filter 'BLUR' must be one of NONE, OCTAHEDRAL, QUATERNION, EXPONENTIAL, COLOR" },
        { "\"mode\":\"ATTRIBUTES\"", "\"mode\":\"ATTRIBUTES\",\"filter\":\"COLOR\"",
          "byteStride must be 4 or 8 with this filter" },
        { "\"mode\":\"ATTRIBUTES\"", "\"mode\":\"ATTRIBUTES\",\"filter\":\"QUATERNION\"", "byteStride must be 8 with" },
        { "\"mode\":\"ATTRIBUTES\"", "\"x\":0", "mode is missing" },
        { "\"byteStride\":12", "\"byteStride\":0", "byteStride must be 2 to 256" },
        { "\"byteStride\":12", "\"byteStride\":10", "byteStride must be a multiple of 4" },
        { "\"count\":40", "\"count\":41", "byteLength is 480, but 41 elements of 12" },
        { "\"count\":40", "\"count\":4000000", "bytes cannot hold 4000000 elements" },
        { "\"mode\":\"ATTRIBUTES\"", "\"mode\":\"TRIANGLES\"", "byteStride must be 2 or 4" },
        { "{\"buffer\":0,\"byteOffset\":0,", "{\"buffer\":0,\"byteOffset\":9999,", "bytes 9999 + " },
        { "{\"buffer\":0,\"byteOffset\":0,", "{\"buffer\":0,\"byteOffset\":2,",
          "are not 40 elements that meshoptimizer decodes" },
    };
    for ( size_t i = 0; i < sizeof s_faults / sizeof s_faults[0]; ++i )
    {
        GltfBuilder b = make_packed( KHR, 2 );
        char* at = strstr( b.views, s_faults[i].from );
        size_t from = strlen( s_faults[i].from ), to = strlen( s_faults[i].to );
        memmove( at + to, at + from, strlen( at + from ) + 1 );
        memcpy( at, s_faults[i].to, to );
        gltf_refuse_built( &b, STRIP, s_faults[i].part );
    }
    GltfBuilder b = { 0 };
    add_positions( &b, EXT, ",\"filter\":\"COLOR\"", s_positions );
    memcpy( strstr( b.views, "\"byteStride\":12" ), "\"byteStride\": 4", 15 );
    gltf_refuse_built( &b, STRIP, "is of KHR_meshopt_compression only" );
}

// Version 1 of the attributes: all deltas zero, so every element is that of the tail (KHR_meshopt_compression, mode 0).
TEST( test_newer_attributes )
{
    uint8_t bytes[1 + 3 + 9 + 15] = { 0xa1, 0xaa, 0xaa, 0xaa };
    float corner[3] = { 1, 2, 3 };
    memcpy( bytes + 4 + 9, corner, 12 );
    PackedView view = { KHR, "ATTRIBUTES", "", POINTS, 12, bytes, sizeof bytes };
    GltfBuilder b = { 0 };
    add_view( &b, &view );
    add_accessor( &b, "\"componentType\":5126,\"count\":40,\"type\":\"VEC3\"" );
    add_indices( &b, KHR, true, 2 );
    if ( MESHOPTIMIZER_VERSION < 230 )
    {
        gltf_refuse_built( &b, STRIP, "has attributes of version 1, which meshoptimizer decodes since 0.23" );
        gltf_refuse_built( &b, STRIP, "unpack the file by `npx @gltf-transform/cli copy in.glb out.glb`" );
        return;
    }
    RfScene scene = gltf_load_built( &b, STRIP );
    rf_destroy_scene( &scene );
}

TEST( test_broken_bytes )
{
    uint32_t number = 1;
    for ( int i = 0; i < MUTATIONS; ++i )
    {
        GltfBuilder b = make_packed( EXT, i % 2 == 0 ? 2 : 4 );
        for ( int k = 0; k <= i % 3; ++k )
        {
            number = number * 1664525u + 1013904223u;
            b.bin[( number >> 8 ) % b.bin_size] = (uint8_t)( number >> 24 );
        }
        RfScene scene;
        RfError error = { 0 };
        RfResult result = rf_load_gltf( write_gltf( &b, &gltf_folder, STRIP ), &scene, NULL, &error );
        assert_true( result == RF_OK || ( error.text[0] != 0 && strchr( error.text, '\n' ) == NULL ) );
        rf_destroy_scene( &scene );
    }
}

#endif

// The file with another buffer after the first, of which the views of the builder are.
static const char* write_with_buffer( GltfBuilder* b, const char* buffer, const char* rest )
{
    static char s_json[32768];
    char* data = gltf_base64( b->bin, b->bin_size );
    snprintf(
        s_json, sizeof s_json,
        "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":%zu,\"uri\":\"data:;base64,%s\"},%s],\"bufferViews\":[%s],"
        "\"accessors\":[%s],%s}",
        b->bin_size, data, buffer, b->views, b->accessors, rest );
    free( data );
    return write_bytes( &gltf_folder, "a.gltf", s_json, strlen( s_json ) );
}

static void name_buffer( GltfBuilder* b, int buffer )
{
    for ( char* at = b->views; ( at = strstr( at, "{\"buffer\":0,\"byteLength\"" ) ) != NULL; ++at )
        at[10] = (char)( '0' + buffer );
}

static void expect_error( const char* path, const char* part )
{
    RfScene scene;
    RfError error = { 0 };
    assert_true( rf_load_gltf( path, &scene, NULL, &error ) != RF_OK );
    if ( strstr( error.text, part ) == NULL )
        fail_msg( "wants '%s': %s", part, error.text );
}

// Buffers of what is compressed elsewhere need no bytes; without the library they are what is read.
TEST( test_fallback_buffers )
{
#ifdef REFRAME_MESHOPT
    static const char* const s_buffers[] = {
        "{\"byteLength\":9000}", "{\"byteLength\":9000,\"extensions\":{\"EXT_meshopt_compression\":{\"fallback\":true}}}",
        "{\"byteLength\":9000,\"uri\":\"absent.bin\",\"extensions\":{\"EXT_meshopt_compression\":{\"fallback\":true}}}"
    };
    for ( size_t i = 0; i < sizeof s_buffers / sizeof s_buffers[0]; ++i )
    {
        GltfBuilder b = make_packed( EXT, 2 );
        name_buffer( &b, 1 );
        RfScene scene =
            gltf_load( write_with_buffer( &b, s_buffers[i], STRIP ",\"extensionsUsed\":[\"EXT_meshopt_compression\"]" ) );
        assert_strip( &scene );
        rf_destroy_scene( &scene );
    }
    GltfBuilder b = make_packed( EXT, 2 );
    name_buffer( &b, 1 );
    expect_error( write_with_buffer( &b, s_buffers[0], STRIP ), "buffers[1]: has no uri" );
    memcpy( strstr( b.views, "EXT_" ), "XXX_", 4 );
    expect_error( write_with_buffer( &b, s_buffers[1], STRIP ), "buffers[1]: has no uri" );
#else
    char buffer[8192], data[4096];
    GltfBuilder b = { .bin_size = 4 };
    const uint8_t bytes[4] = { 0 };
    PackedView view = { "EXT_meshopt_compression", "ATTRIBUTES", "", POINTS, 12, bytes, 4 };
    add_view( &b, &view );
    add_accessor( &b, "\"componentType\":5126,\"count\":40,\"type\":\"VEC3\"" );
    name_buffer( &b, 1 );
    char* text = gltf_base64( (const uint8_t*)s_positions, sizeof s_positions );
    snprintf( data, sizeof data, "%s", text );
    free( text );
    snprintf( buffer, sizeof buffer,
              "{\"byteLength\":480,\"uri\":\"data:;base64,%s\",\"extensions\":{\"EXT_meshopt_compression\":{\"fallback\":true}}}",
              data );
#define POSITIONS MESH( "\"attributes\":{\"POSITION\":0},\"mode\":5" )
    RfScene scene = gltf_load( write_with_buffer( &b, buffer, POSITIONS ",\"extensionsUsed\":[\"EXT_meshopt_compression\"]" ) );
    gltf_assert_warned( "EXT_meshopt_compression needs meshoptimizer, which this build of reframe lacks: the uncompressed" );
    assert_strip( &scene );
    rf_destroy_scene( &scene );
    expect_error( write_with_buffer( &b, "{\"byteLength\":480}", POSITIONS ",\"extensionsUsed\":[\"EXT_meshopt_compression\"]" ),
                  "bufferViews[0]: EXT_meshopt_compression needs meshoptimizer, which this build of reframe lacks: unpack the" );
    expect_error( write_with_buffer( &b, buffer, POSITIONS ",\"extensionsRequired\":[\"KHR_meshopt_compression\"]" ),
                  "KHR_meshopt_compression needs meshoptimizer, which this build of reframe lacks: unpack the file by `npx" );
#endif
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )

int main( void )
{
    make_strip();
    return run_listed_tests();
}
