// KHR_draco_mesh_compression: meshes are those that were compressed, and broken ones are refused in one line.
#include "support/draco_encode.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "gltf/draco_mesh.h"
#include "gltf/gltf.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SIDE 5 // of a bumpy square
#define POINTS ( SIDE * SIDE )
#define FACES ( 2 * ( SIDE - 1 ) * ( SIDE - 1 ) )

// Broken files per run.
#define MUTATIONS 400

typedef struct Square
{
    float positions[3 * POINTS], normals[3 * POINTS], uvs[2 * POINTS], weights[4 * POINTS];
    uint8_t colors[4 * POINTS], joints[4 * POINTS];
    uint32_t indices[3 * FACES];
} Square;

static Square s_square;

static void make_square( void )
{
    for ( int i = 0; i < POINTS; ++i )
    {
        float x = (float)( i % SIDE ), y = (float)( i / SIDE ), z = 0.25f * (float)( i * i % 7 );
        memcpy( s_square.positions + 3 * i, ( float[3] ){ x, y, z }, 12 );
        memcpy( s_square.normals + 3 * i, ( float[3] ){ 0.6f, i % 2 ? 0.0f : 0.8f, i % 2 ? 0.8f : 0.0f }, 12 );
        memcpy( s_square.uvs + 2 * i, ( float[2] ){ 0.25f * x, 0.125f * y }, 8 );
        memcpy( s_square.weights + 4 * i, ( float[4] ){ 0.25f, 0.75f, 0, 0 }, 16 );
        memcpy( s_square.colors + 4 * i, ( uint8_t[4] ){ (uint8_t)( 10 * i ), 255, (uint8_t)i, 128 }, 4 );
        memcpy( s_square.joints + 4 * i, ( uint8_t[4] ){ (uint8_t)( i % 2 ), 1, 0, 0 }, 4 );
    }
    for ( uint32_t f = 0; f < FACES; ++f )
    {
        uint32_t cell = f / 2, a = cell / ( SIDE - 1 ) * SIDE + cell % ( SIDE - 1 );
        const uint32_t corners[2][3] = { { a, a + 1, a + SIDE }, { a + 1, a + SIDE + 1, a + SIDE } };
        memcpy( s_square.indices + 3 * f, corners[f % 2], 12 );
    }
}

// Accessors of the square: 0 to 5 in the order of the attributes, 6 the indices. `packed`: without data.
static GltfBuilder build_square( bool packed )
{
    GltfBuilder b = { 0 };
    if ( packed )
    {
        sprintf( b.accessors,
                 "{\"componentType\":5126,\"count\":25,\"type\":\"VEC3\"},{\"componentType\":5126,\"count\":25,\"type\":"
                 "\"VEC3\"},{\"componentType\":5126,\"count\":25,\"type\":\"VEC2\"},{\"componentType\":5121,\"count\":25,"
                 "\"type\":\"VEC4\",\"normalized\":true},{\"componentType\":5121,\"count\":25,\"type\":\"VEC4\"},{"
                 "\"componentType\":5126,\"count\":25,\"type\":\"VEC4\"},{\"componentType\":5123,\"count\":96,\"type\":"
                 "\"SCALAR\"}" );
        b.count = 7;
        return b;
    }
    add_gltf_floats( &b, "VEC3", 3, POINTS, s_square.positions );
    add_gltf_floats( &b, "VEC3", 3, POINTS, s_square.normals );
    add_gltf_floats( &b, "VEC2", 2, POINTS, s_square.uvs );
    add_gltf_accessor( &b, 5121, "VEC4", POINTS, s_square.colors, sizeof s_square.colors, ",\"normalized\":true" );
    add_gltf_accessor( &b, 5121, "VEC4", POINTS, s_square.joints, sizeof s_square.joints, "" );
    add_gltf_floats( &b, "VEC4", 4, POINTS, s_square.weights );
    add_gltf_accessor( &b, 5125, "SCALAR", 3 * FACES, s_square.indices, sizeof s_square.indices, "" );
    return b;
}

#define LOOK "\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":2,\"COLOR_0\":3"
#define SKIN ",\"JOINTS_0\":4,\"WEIGHTS_0\":5"
#define MESH( primitive ) "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[" primitive "]}]"
#define DRACO( attributes ) "\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":0,\"attributes\":{" attributes "}}}"
#define REQUIRED ",\"extensionsRequired\":[\"KHR_draco_mesh_compression\"]"
#define PACKED( attributes ) "{\"attributes\":{" attributes "},\"indices\":6," DRACO( attributes ) "}"
#define PLAIN MESH( "{\"attributes\":{" LOOK "},\"indices\":6}" )

#ifdef REFRAME_DRACO

static DracoInput make_input( bool sequential, int bits )
{
    return ( DracoInput ){ .points = POINTS,
                           .faces = FACES,
                           .indices = s_square.indices,
                           .sequential = sequential,
                           .attribute_count = 6,
                           .attributes = { { 'p', 5126, 3, false, bits, s_square.positions },
                                           { 'n', 5126, 3, false, bits, s_square.normals },
                                           { 't', 5126, 2, false, bits, s_square.uvs },
                                           { 'c', 5121, 4, true, 0, s_square.colors },
                                           { 'j', 5121, 4, false, 0, s_square.joints },
                                           { 'w', 5126, 4, false, 0, s_square.weights } } };
}

// The square compressed, with this as its view.
static GltfBuilder pack( const DracoInput* input )
{
    GltfBuilder b = build_square( true );
    uint8_t* bytes = encode_draco( input, &b.bin_size );
    assert_non_null( bytes );
    assert_true( b.bin_size < sizeof b.bin );
    memcpy( b.bin, bytes, b.bin_size );
    free( bytes );
    sprintf( b.views, "{\"buffer\":0,\"byteLength\":%zu}", b.bin_size );
    return b;
}

static const float* corner( const RfTriangles* t, const float* values, int components, uint32_t triangle, int c )
{
    return values + (size_t)components * t->indices[3 * triangle + (uint32_t)c];
}

static double difference( const float* a, const float* b, int count )
{
    double most = 0.0;
    for ( int i = 0; i < count; ++i )
        most = fmax( most, fabs( (double)a[i] - (double)b[i] ) );
    return most;
}

// The largest difference of triangle a of one scene and b of the other, whose corners begin at `turn`.
static double compare( const RfTriangles* one, uint32_t a, const RfTriangles* other, uint32_t b, int turn )
{
    double most = 0.0;
    for ( int c = 0; c < 3; ++c )
    {
        int d = ( c + turn ) % 3;
        most = fmax( most, difference( corner( one, one->positions, 3, a, c ), corner( other, other->positions, 3, b, d ), 3 ) );
        most = fmax( most, difference( corner( one, one->normals, 3, a, c ), corner( other, other->normals, 3, b, d ), 3 ) );
        most = fmax( most, difference( corner( one, one->uvs, 2, a, c ), corner( other, other->uvs, 2, b, d ), 2 ) );
        most = fmax( most, difference( corner( one, one->colors, 4, a, c ), corner( other, other->colors, 4, b, d ), 4 ) );
    }
    return most;
}

// Every triangle of one scene is one of the other, with the same front; `ordered`: that of its number.
static void assert_same( const RfScene* one, const RfScene* other, double tolerance, bool ordered )
{
    assert_int_equal( one->triangles.count, other->triangles.count );
    for ( uint32_t a = 0; a < one->triangles.count; ++a )
    {
        double least = INFINITY;
        for ( uint32_t b = ordered ? a : 0; b < ( ordered ? a + 1 : one->triangles.count ); ++b )
        {
            for ( int turn = 0; turn < ( ordered ? 1 : 3 ); ++turn )
                least = fmin( least, compare( &one->triangles, a, &other->triangles, b, turn ) );
        }
        if ( !( least <= tolerance ) )
            fail_msg( "triangle %u is off by %g", a, least );
    }
}

TEST( test_mesh_is_that_which_was_compressed )
{
    GltfBuilder plain = build_square( false );
    RfScene want = gltf_load_built( &plain, PLAIN );
    assert_non_null( want.triangles.uvs );
    assert_non_null( want.triangles.colors );
    for ( int i = 0; i < 4; ++i )
    {
        bool sequential = i % 2 == 0;
        DracoInput input = make_input( sequential, i < 2 ? 0 : 12 );
        GltfBuilder b = pack( &input );
        RfScene got = gltf_load_built( &b, MESH( PACKED( LOOK ) ) REQUIRED );
        assert_string_equal( gltf_warnings, "" );
        assert_same( &want, &got, i < 2 ? 0.0 : 4.0 / 4096.0, sequential );
        rf_destroy_scene( &got );
    }
    rf_destroy_scene( &want );
}

#define POSE                                                                                                                     \
    "\"scenes\":[{\"nodes\":[0,1,2]}],\"nodes\":[{\"mesh\":0,\"skin\":0},{\"translation\":[0,2,0]},{\"rotation\":[0,0.6,0,0.8]}" \
    "],"                                                                                                                         \
    "\"skins\":[{\"joints\":[1,2]}],"
#define TARGET ",\"targets\":[{\"POSITION\":7}]"

// A skin and a morph target, posed: the order of the vertices is kept.
TEST( test_skins_and_targets )
{
    float deltas[3 * POINTS];
    for ( int i = 0; i < 3 * POINTS; ++i )
        deltas[i] = 0.125f * (float)( i % 5 );
    GltfBuilder plain = build_square( false );
    add_gltf_floats( &plain, "VEC3", 3, POINTS, deltas );
    RfScene want = gltf_load_built( &plain, POSE "\"meshes\":[{\"weights\":[0.5],\"primitives\":[{\"attributes\":{" LOOK SKIN
                                                 "},\"indices\":6" TARGET "}]}]" );
    DracoInput input = make_input( true, 0 );
    GltfBuilder b = pack( &input );
    size_t packed = ( b.bin_size + 3 ) / 4 * 4;
    memcpy( b.bin + packed, deltas, sizeof deltas );
    sprintf( b.views + strlen( b.views ), ",{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", packed, sizeof deltas );
    strcat( b.accessors, ",{\"bufferView\":1,\"componentType\":5126,\"count\":25,\"type\":\"VEC3\"}" );
    b.bin_size = packed + sizeof deltas;
    RfScene got = gltf_load_built( &b, POSE "\"meshes\":[{\"weights\":[0.5],\"primitives\":[{\"attributes\":{" LOOK SKIN
                                            "},\"indices\":6" TARGET "," DRACO( LOOK SKIN ) "}]}]" REQUIRED );
    assert_same( &want, &got, 0.0, true );
    assert_true( fabs( (double)got.triangles.positions[1] - (double)s_square.positions[1] ) > 0.1 ); // it is posed
    rf_destroy_scene( &want );
    rf_destroy_scene( &got );
}

// What real files get wrong, or may leave out.
TEST( test_what_is_read_all_the_same )
{
    static const struct
    {
        const char *json, *warning;
    } s_cases[] = {
        { MESH( PACKED( LOOK ) "," PACKED( LOOK ) ), "" },               // twice, decoded once
        { MESH( "{\"attributes\":{" LOOK "}," DRACO( LOOK ) "}" ), "" }, // no indices in the file
        { MESH( "{\"attributes\":{" LOOK "},\"indices\":6,\"mode\":5," DRACO( LOOK ) "}" ), "" },
        { MESH( PACKED( "\"POSITION\":0" ) ) ",\"materials\":[{}]", "" },
    };
    DracoInput input = make_input( true, 0 );
    for ( size_t i = 0; i < sizeof s_cases / sizeof s_cases[0]; ++i )
    {
        GltfBuilder b = pack( &input );
        RfScene scene = gltf_load_built( &b, s_cases[i].json );
        assert_string_equal( gltf_warnings, s_cases[i].warning );
        assert_int_equal( scene.triangles.count, i == 0 ? 2 * FACES : FACES );
        rf_destroy_scene( &scene );
    }
    GltfBuilder b = pack( &input );
    memcpy( strstr( b.accessors, "25" ), "31", 2 );
    RfScene scene = gltf_load_built( &b, MESH( PACKED( LOOK ) ) );
    gltf_assert_warned( "accessors[0] has a count of 31, its compressed mesh 25 vertices, which are taken" );
    rf_destroy_scene( &scene );
}

TEST( test_numbers_of_other_types )
{
    uint16_t shorts[4 * POINTS];
    for ( int i = 0; i < 4 * POINTS; ++i )
        shorts[i] = s_square.colors[i];
    DracoInput input = make_input( true, 0 );
    input.attributes[3] = ( DracoAttribute ){ 'c', 5123, 4, true, 0, shorts }; // the accessor says bytes
    GltfBuilder b = pack( &input );
    RfScene scene = gltf_load_built( &b, MESH( PACKED( LOOK ) ) );
    gltf_assert_near( scene.triangles.colors[4], 10.0 / 255.0 );
    rf_destroy_scene( &scene );

    input.attributes[3] = ( DracoAttribute ){ 'c', 5121, 4, true, 0, s_square.colors }; // the accessor says floats
    b = pack( &input );
    char* type = strstr( b.accessors, "5121" );
    memcpy( type, "5126", 4 );
    memset( strstr( type, ",\"normalized\":true" ), ' ', 18 );
    scene = gltf_load_built( &b, MESH( PACKED( LOOK ) ) );
    gltf_assert_near( scene.triangles.colors[4], 10.0 / 255.0 );
    rf_destroy_scene( &scene );

    shorts[0] = 256;
    input.attributes[3] = ( DracoAttribute ){ 'c', 5123, 4, true, 0, shorts };
    b = pack( &input );
    gltf_refuse_built( &b, MESH( PACKED( LOOK ) ), "accessors[3]: its compressed mesh has numbers that are not of" );
}

TEST( test_faults )
{
    static const struct
    {
        const char *json, *part;
    } s_faults[] = {
        { MESH( "{\"attributes\":{\"POSITION\":0}," DRACO( "\"POSITION\":9" ) "}" ), "POSITION has the id 9, which" },
        { MESH( "{\"attributes\":{\"POSITION\":0}," DRACO( "\"POSITION\":2" ) "}" ),
          "accessors[0]: has elements of 3 numbers, its compressed mesh of 2" },
        { MESH( "{\"attributes\":{\"POSITION\":0}," DRACO( "\"POSITION\":-1" ) "}" ),
          "KHR_draco_mesh_compression.attributes: POSITION must be 0 to" },
        { MESH( "{\"attributes\":{\"POSITION\":0},\"mode\":6," DRACO( "\"POSITION\":0" ) "}" ),
          "meshes[0].primitives[0]: mode must be 4 to 5" },
        { MESH( "{\"attributes\":{\"POSITION\":0},\"extensions\":{\"KHR_draco_mesh_compression\":{}}}" ),
          "meshes[0].primitives[0].extensions.KHR_draco_mesh_compression: bufferView is missing" },
        { MESH( "{\"attributes\":{\"POSITION\":0},\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":0}}}" ),
          "attributes is missing" },
        { MESH( "{\"attributes\":{\"POSITION\":0},\"extensions\":{\"KHR_draco_mesh_compression\":{\"bufferView\":3}}}" ),
          "bufferView is 3" },
        { MESH( "{\"attributes\":{\"POSITION\":0,\"NORMAL\":1}," DRACO(
              "\"POSITION\":0,\"NORMAL\":0" ) "},"
                                              "{\"attributes\":{\"POSITION\":0,\"COLOR_0\":3}," DRACO(
                                                  "\"POSITION\":0,\"COLOR_0\":0" ) "}" ),
          "accessors[3]: is of the same compressed mesh as accessors[0], but another type" },
    };
    DracoInput input = make_input( true, 0 );
    for ( size_t i = 0; i < sizeof s_faults / sizeof s_faults[0]; ++i )
    {
        GltfBuilder b = pack( &input );
        gltf_refuse_built( &b, s_faults[i].json, s_faults[i].part );
    }
    GltfBuilder b = pack( &input );
    char* end = strstr( b.accessors, "\"VEC3\"" ) + 6;
    memmove( end + 12, end, strlen( end ) + 1 );
    memcpy( end, ",\"sparse\":{}", 12 );
    gltf_refuse_built( &b, MESH( PACKED( LOOK ) ), "accessors[0]: is sparse" );
    input.cloud = true;
    b = pack( &input );
    gltf_refuse_built( &b, MESH( PACKED( LOOK ) ), "bufferViews[0]: holds points of Draco, not a mesh" );
}

// Bytes that are cut off or changed: one line, or a mesh; and never memory for what the bytes only promise.
TEST( test_broken_bytes )
{
    for ( int method = 0; method < 2; ++method )
    {
        DracoInput input = make_input( method == 0, 11 );
        GltfBuilder b = pack( &input );
        size_t size = b.bin_size;
        for ( size_t cut = 0; cut < size; cut += 7 )
        {
            GltfBuilder broken = b;
            sprintf( broken.views, "{\"buffer\":0,\"byteLength\":%zu}", cut + 1 );
            gltf_refuse_built( &broken, MESH( PACKED( LOOK ) ), "bufferViews[0]: " );
        }
        uint32_t number = 1;
        for ( int i = 0; i < MUTATIONS; ++i )
        {
            GltfBuilder broken = b;
            for ( int k = 0; k <= i % 3; ++k )
            {
                number = number * 1664525u + 1013904223u;
                broken.bin[11 + ( number >> 8 ) % ( size - 11 )] = (uint8_t)( number >> 24 );
            }
            RfScene scene;
            RfError error = { 0 };
            RfResult result = rf_load_gltf( write_gltf( &broken, &gltf_folder, MESH( PACKED( LOOK ) ) ), &scene, NULL, &error );
            assert_true( result == RF_OK || ( error.text[0] != 0 && strchr( error.text, '\n' ) == NULL ) );
            rf_destroy_scene( &scene );
        }
    }
}

// Views of the same few bytes: each counts, whether or not its attributes are taken.
TEST( test_memory_is_counted )
{
    uint8_t* bytes;
    size_t size;
    RfDracoMesh* mesh;
    DracoInput input = make_input( true, 0 );
    bytes = encode_draco( &input, &size );
    assert_int_equal( rf_draco_decode( bytes, size, FACES, 1 << 20, &mesh ), RF_DRACO_OK );
    assert_true( rf_draco_bytes( mesh ) >= 12 * FACES + ( 12 + 12 + 8 + 4 + 4 + 16 ) * POINTS );
    rf_draco_free( mesh );
    free( bytes );
}

// Few bytes that say what takes 10 GB.
TEST( test_limits )
{
    static const struct
    {
        uint8_t bytes[32];
        size_t size;
        const char* part;
    } s_cases[] = {
        // the edgebreaker: traversal, 300 million vertices and triangles, symbols
        { { 'D', 'R', 'A', 'C', 'O', 2, 2, 1, 1, 0, 0, 0, 0x80, 0xc6, 0x86, 0x8f, 1, 0x80, 0xc6, 0x86, 0x8f, 1, 0, 1, 0 },
          25,
          "unpacks to more than 4" },
        // sequential: a triangle of 2 billion points
        { { 'D', 'R', 'A', 'C', 'O', 2, 2, 1, 0, 0, 0, 1, 0x80, 0xa8, 0xd6, 0xb9, 7, 1, 0, 1, 2 }, 21, "unpacks to more than 4" },
        // sequential: a triangle of 12 million points, with an attribute of 100 64-bit numbers
        { { 'D', 'R', 'A', 'C', 'O', 2, 2, 1, 0, 0, 0, 1, 0x80, 0xb6, 0xdc, 5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 1, 1, 0 },
          32,
          "bufferViews[0]: " },
        { { 'D', 'R', 'A', 'C', 'O', 1, 2, 1, 1, 0, 0, 0, 3, 1, 0, 0, 0, 0, 0, 0 }, 20, "is not a mesh that Draco decodes" },
    };
    for ( size_t i = 0; i < sizeof s_cases / sizeof s_cases[0]; ++i )
    {
        GltfBuilder b = build_square( true );
        b.bin_size = s_cases[i].size;
        memcpy( b.bin, s_cases[i].bytes, b.bin_size );
        sprintf( b.views, "{\"buffer\":0,\"byteLength\":%zu}", b.bin_size );
        gltf_refuse_built( &b, MESH( PACKED( LOOK ) ), s_cases[i].part );
    }
}

#else

// Without the library: the uncompressed mesh, where there is one.
TEST( test_build_without_draco )
{
    GltfBuilder plain = build_square( false );
    RfScene scene = gltf_load_built( &plain, MESH( PACKED( LOOK ) ) ",\"extensionsUsed\":[\"KHR_draco_mesh_compression\"]" );
    gltf_assert_warned( "KHR_draco_mesh_compression needs Draco, which this build of reframe lacks: the uncompressed" );
    assert_int_equal( scene.triangles.count, FACES );
    rf_destroy_scene( &scene );
    GltfBuilder b = build_square( true );
    b.bin_size = 4;
    strcpy( b.views, "{\"buffer\":0,\"byteLength\":4}" );
    gltf_refuse_built( &b, MESH( PACKED( LOOK ) ), "needs Draco, which this build of reframe lacks: unpack the file by `npx" );
    gltf_refuse_built( &b, MESH( PACKED( LOOK ) ) REQUIRED, "extensionsRequired: KHR_draco_mesh_compression needs Draco" );
}

#endif

SHARED_BY_TESTS( gltf_enter, gltf_leave )

int main( void )
{
    make_square();
    return run_listed_tests();
}
