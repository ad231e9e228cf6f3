// What the glTF reader refuses: every fault is one line that names the file and the
// object, and no input makes it crash, hang or leak.

#include "support/scene_files.h"
#include "support/test.h"

#include "base/file.h"
#include "gltf/gltf.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

// Broken files per run; the environment's REFRAME_MUTATIONS asks for more.
#define MUTATIONS 300

static void check_text( const RfError* error, const char* object )
{
    if ( strstr( error->text, object ) == NULL || strchr( error->text, '\n' ) != NULL ||
         strstr( error->text, gltf_folder.path ) == NULL )
        fail_msg( "error line lacks '%s' or the file: %s", object, error->text );
}

static void expect_failure( const char* path, RfResult code, const char* object )
{
    RfScene scene;
    RfError error = { 0 };
    RfResult result = rf_load_gltf( path, &scene, NULL, &error );
    if ( result != code )
        fail_msg( "got %s instead of %s for '%s': %s", rf_result_name( result ), rf_result_name( code ), object, error.text );
    check_text( &error, object );
    assert_null( scene.path );
    assert_null( scene.triangles.positions );
    // NULL for both reports is allowed
    assert_int_equal( rf_load_gltf( path, &scene, NULL, NULL ), code );
}

// A triangle, its normals and indices: accessors 0 to 2.
static GltfBuilder make_triangle( void )
{
    static const float s_positions[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 }, s_normals[] = { 0, 0, 1, 0, 0, 1, 0, 0, 1 };
    static const uint16_t s_indices[] = { 0, 1, 2 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 3, s_positions );
    add_gltf_floats( &b, "VEC3", 3, 3, s_normals );
    add_gltf_u16( &b, 3, s_indices );
    return b;
}

typedef struct Fault
{
    RfResult code;
    const char* object; // in the error line
    const char* json;   // after the triangle's accessors
} Fault;

static void expect_faults( const Fault* faults, size_t count )
{
    for ( size_t i = 0; i < count; ++i )
    {
        GltfBuilder b = make_triangle();
        expect_failure( write_gltf( &b, &gltf_folder, faults[i].json ), faults[i].code, faults[i].object );
    }
}
#define EXPECT_FAULTS( faults ) expect_faults( faults, sizeof( faults ) / sizeof( faults )[0] )

TEST( test_faults_of_text )
{
    static const struct
    {
        RfResult code;
        const char *object, *text;
    } s_files[] = {
        { RF_ERROR_FORMAT, "line 2, column", "{\n\"asset\" 3}" },
        { RF_ERROR_FORMAT, "duplicate", "{\"asset\":{\"version\":\"2.0\"},\"asset\":{}}" },
        { RF_ERROR_FORMAT, "line 1", "" },
        { RF_ERROR_FORMAT, "document", "[]" },
        { RF_ERROR_FORMAT, "asset is missing", "{}" },
        { RF_ERROR_FORMAT, "version is missing", "{\"asset\":{}}" },
        { RF_ERROR_FORMAT, "version must be a string", "{\"asset\":{\"version\":2.0}}" },
        { RF_ERROR_UNSUPPORTED, "glTF 1.0", "{\"asset\":{\"version\":\"1.0\"}}" },
        { RF_ERROR_UNSUPPORTED, "2.1 or later", "{\"asset\":{\"version\":\"2.1\",\"minVersion\":\"2.1\"}}" },
        { RF_ERROR_FORMAT, "buffers[0]", "{\"asset\":{\"version\":\"2.0\"},\"buffers\":[{\"byteLength\":4}]}" },
    };
    for ( size_t i = 0; i < sizeof s_files / sizeof s_files[0]; ++i )
        expect_failure( write_bytes( &gltf_folder, "a.gltf", s_files[i].text, strlen( s_files[i].text ) ), s_files[i].code,
                        s_files[i].object );
    // deeper than the parser goes
    char deep[8192];
    memset( deep, '[', sizeof deep );
    expect_failure( write_bytes( &gltf_folder, "a.gltf", deep, sizeof deep ), RF_ERROR_FORMAT, "depth" );
}

TEST( test_faults_of_files )
{
    expect_failure( folder_file( &gltf_folder, "absent.gltf" ), RF_ERROR_IO, "absent.gltf" );
    expect_failure( gltf_folder.path, RF_ERROR_IO, "folder" );
    RfError error;
    uint8_t* bytes;
    size_t size;
    const char* path = write_bytes( &gltf_folder, "a.bin", "12345", 5 );
    assert_int_equal( rf_read_file( path, 4, &bytes, &size, &error ), RF_ERROR_UNSUPPORTED );
    assert_int_equal( rf_read_file( path, 5, &bytes, &size, &error ), RF_OK );
    assert_int_equal( size, 5 );
    uint64_t hash = rf_hash_bytes( RF_HASH_START, bytes, 5 );
    assert_true( hash != rf_hash_bytes( RF_HASH_START, bytes, 4 ) );
    assert_true( hash == rf_hash_bytes( RF_HASH_START, "12345", 5 ) );
    free( bytes );
    assert_int_equal( rf_read_file( "/dev/zero", 5, &bytes, &size, &error ), RF_ERROR_IO );
}

TEST( test_faults_of_uris )
{
    static const char* const s_uris[] = {
        "/etc/passwd",   "\\\\etc\\\\passwd", "C:\\\\a.bin", "file:a.bin", "http://host/a.bin",
        "%2Fetc/passwd", "%5Cetc/passwd",     "a%00.bin",    "a%4",        "",
    };
    for ( size_t i = 0; i < sizeof s_uris / sizeof s_uris[0]; ++i )
    {
        GltfBuilder b = make_triangle();
        const char* json = build_gltf_json( &b, s_uris[i], "" );
        expect_failure( write_bytes( &gltf_folder, "a.gltf", json, strlen( json ) ), RF_ERROR_UNSUPPORTED, "buffers[0]" );
    }
    static const char* const s_data[] = { "data:text/plain,abc", "data:;base64,AAA*", "data:;base64,AAAAA", "data:x" };
    for ( size_t i = 0; i < sizeof s_data / sizeof s_data[0]; ++i )
    {
        GltfBuilder b = make_triangle();
        const char* json = build_gltf_json( &b, s_data[i], "" );
        expect_failure( write_bytes( &gltf_folder, "a.gltf", json, strlen( json ) ), RF_ERROR_FORMAT, "buffers[0]" );
    }
    GltfBuilder b = make_triangle();
    const char* json = build_gltf_json( &b, "absent.bin", "" );
    expect_failure( write_bytes( &gltf_folder, "a.gltf", json, strlen( json ) ), RF_ERROR_IO, "absent.bin" );
}

TEST( test_faults_of_containers )
{
    GltfBuilder b = make_triangle();
    size_t size;
    uint8_t* glb = build_glb( &b, "", &size );
    for ( size_t cut = 4; cut < size; cut += 61 )
        expect_failure( write_bytes( &gltf_folder, "a.glb", glb, cut ), RF_ERROR_FORMAT, "GLB header" );
    glb[4] = 1;
    expect_failure( write_bytes( &gltf_folder, "a.glb", glb, size ), RF_ERROR_UNSUPPORTED, "version 1" );
    glb[4] = 2, glb[15] = 0x7f;
    expect_failure( write_bytes( &gltf_folder, "a.glb", glb, size ), RF_ERROR_FORMAT, "GLB chunk 0" );
    glb[15] = 0, glb[16] = 'X';
    expect_failure( write_bytes( &gltf_folder, "a.glb", glb, size ), RF_ERROR_FORMAT, "GLB chunk 0" );
    free( glb );
}

TEST( test_faults_of_extensions )
{
    static const Fault s_faults[] = {
        { RF_ERROR_UNSUPPORTED, "EXT_unheard_of", "\"extensionsRequired\":[\"KHR_materials_ior\",\"EXT_unheard_of\"]" },
        { RF_ERROR_UNSUPPORTED, "KHR_texture_basisu", "\"extensionsRequired\":[\"KHR_texture_basisu\"]" },
        { RF_ERROR_FORMAT, "extensionsRequired", "\"extensionsRequired\":[3]" },
        { RF_ERROR_FORMAT, "extensionsUsed", "\"extensionsUsed\":[{}]" },
    };
    EXPECT_FAULTS( s_faults );
}

TEST( test_faults_of_nodes )
{
    static const Fault s_faults[] = {
        { RF_ERROR_FORMAT, "own ancestors", "\"nodes\":[{\"children\":[1]},{\"children\":[0]}]" },
        { RF_ERROR_FORMAT, "own ancestors", "\"nodes\":[{\"children\":[0]}]" },
        { RF_ERROR_FORMAT, "nodes[1]: children[0]", "\"nodes\":[{\"children\":[2]},{\"children\":[2]},{}]" },
        { RF_ERROR_FORMAT, "nodes[0]: children[0]", "\"nodes\":[{\"children\":[1]}]" },
        { RF_ERROR_FORMAT, "nodes[0]: children[0]", "\"nodes\":[{\"children\":[\"0\"]}]" },
        { RF_ERROR_FORMAT, "scenes[0]: nodes[1]", "\"nodes\":[{\"children\":[1]},{}],\"scenes\":[{\"nodes\":[0,1]}]" },
        { RF_ERROR_FORMAT, "scenes[0]: nodes[1]", "\"nodes\":[{}],\"scenes\":[{\"nodes\":[0,0]}]" },
        { RF_ERROR_FORMAT, "scene is 1", "\"scene\":1,\"nodes\":[{}],\"scenes\":[{\"nodes\":[0]}]" },
        { RF_ERROR_FORMAT, "nodes[0]: mesh is 0", "\"nodes\":[{\"mesh\":0}]" },
        { RF_ERROR_FORMAT, "translation must be 3", "\"nodes\":[{\"translation\":[1,2]}]" },
        { RF_ERROR_FORMAT, "nodes[0]: rotation", "\"nodes\":[{\"rotation\":[0,0,0,0]}]" },
        { RF_ERROR_FORMAT, "both a matrix", "\"nodes\":[{\"scale\":[1,1,1],\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}]" },
        { RF_ERROR_FORMAT, "last row", "\"nodes\":[{\"matrix\":[1,0,0,1,0,1,0,0,0,0,1,0,0,0,0,1]}]" },
        { RF_ERROR_FORMAT, "nodes: [0]", "\"nodes\":[7]" },
        { RF_ERROR_FORMAT, "name must be a string", "\"nodes\":[{\"name\":7}]" },
        { RF_ERROR_FORMAT, "cameras[0]: yfov is 4",
          "\"nodes\":[{\"camera\":0}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":4}}]" },
        { RF_ERROR_FORMAT, "cameras[0]: yfov is missing",
          "\"nodes\":[{\"camera\":0}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":{}}]" },
        { RF_ERROR_FORMAT, "cameras[0]: type", "\"nodes\":[{\"camera\":0}],\"cameras\":[{\"type\":\"fisheye\"}]" },
    };
    EXPECT_FAULTS( s_faults );
}

TEST( test_deep_nodes_do_not_overflow )
{
    char* json = calloc( 1, 200000 );
    char* at = json + sprintf( json, "{\"asset\":{\"version\":\"2.0\"},\"nodes\":[{}" );
    for ( int i = 1; i < 5000; ++i )
        at += sprintf( at, ",{\"children\":[%d]}", i - 1 );
    strcpy( at, "]}" );
    expect_failure( write_bytes( &gltf_folder, "a.gltf", json, strlen( json ) ), RF_ERROR_UNSUPPORTED, "levels deep" );
    free( json );
}

#define NODE "\"nodes\":[{\"mesh\":0}],"
#define PRIMITIVE( members ) NODE "\"meshes\":[{\"primitives\":[{" members "}]}]"

TEST( test_faults_of_meshes )
{
    static const Fault s_faults[] = {
        { RF_ERROR_FORMAT, "meshes[0]: primitives is missing", NODE "\"meshes\":[{}]" },
        { RF_ERROR_FORMAT, "meshes[0].primitives[0]", NODE "\"meshes\":[{\"primitives\":[1]}]" },
        { RF_ERROR_FORMAT, "attributes is missing", PRIMITIVE( "\"mode\":4" ) },
        { RF_ERROR_FORMAT, "mode must be", PRIMITIVE( "\"mode\":9" ) },
        { RF_ERROR_FORMAT, "POSITION is 3", PRIMITIVE( "\"attributes\":{\"POSITION\":3}" ) },
        { RF_ERROR_FORMAT, "POSITION must be an integer", PRIMITIVE( "\"attributes\":{\"POSITION\":\"0\"}" ) },
        { RF_ERROR_FORMAT, "accessors[2] has elements of 1", PRIMITIVE( "\"attributes\":{\"POSITION\":2}" ) },
        { RF_ERROR_FORMAT, "accessors[0] has elements of 3", PRIMITIVE( "\"attributes\":{\"POSITION\":0},\"indices\":0" ) },
        { RF_ERROR_FORMAT, "material is 0", PRIMITIVE( "\"attributes\":{\"POSITION\":0},\"material\":0" ) },
        { RF_ERROR_SCENE, "beyond",
          "\"nodes\":[{\"mesh\":0,\"scale\":[1e300,1e300,1]}],"
          "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]" },
    };
    EXPECT_FAULTS( s_faults );
}

static void expect_accessor_fault( GltfBuilder* b, const char* object, const char* attributes )
{
    char rest[256];
    snprintf( rest, sizeof rest, PRIMITIVE( "%s" ), attributes );
    expect_failure( write_gltf( b, &gltf_folder, rest ), RF_ERROR_FORMAT, object );
}

TEST( test_faults_of_accessors )
{
    float values[12] = { 0, 0, 0, 1, 0, 0, 0, NAN, 0, 1, 1, 1 };
    uint16_t indices[] = { 0, 1, 4 };
    GltfBuilder b = make_triangle();
    add_gltf_floats( &b, "VEC3", 3, 4, values );                                        // 3
    add_gltf_u16( &b, 3, indices );                                                     // 4
    add_gltf_u16( &b, 2, indices );                                                     // 5
    add_gltf_accessor( &b, 5126, "VEC3", 4, values, 47, "" );                           // 6: a byte short
    add_gltf_accessor( &b, 5126, "VEC3", 3, values, 36, ",\"byteOffset\":9000000000" ); // 7
    add_gltf_accessor( &b, 5124, "VEC3", 3, values, 36, "" );                           // 8: no such type
    add_gltf_accessor( &b, 5126, "VEC3", 3, values, 36, ",\"normalized\":true" );       // 9
    add_gltf_accessor( &b, 5126, "VEC3", 2147483647, values, 36, "" );                  // 10
    add_gltf_accessor( &b, 5126, "VEC9", 3, values, 36, "" );                           // 11
    add_gltf_accessor( &b, 5126, "VEC3", 3, values, 36,
                       ",\"sparse\":{\"count\":2,\"indices\":{\"bufferView\":4,\"componentType\":5123},"
                       "\"values\":{\"bufferView\":2}}" ); // 12: values too short
    add_gltf_accessor( &b, 5126, "VEC3", 3, values, 36,
                       ",\"sparse\":{\"count\":3,\"indices\":{\"bufferView\":4,\"componentType\":5123},"
                       "\"values\":{\"bufferView\":3}}" );    // 13: index 4 of 3
    add_gltf_accessor( &b, 5126, "VEC3", 0, values, 36, "" ); // 14
    expect_accessor_fault( &b, "accessors[3]: element 2, number 1", "\"attributes\":{\"POSITION\":3},\"indices\":2" );
    expect_accessor_fault( &b, "index 2 is 4", "\"attributes\":{\"POSITION\":0},\"indices\":4" );
    expect_accessor_fault( &b, "2 corners", "\"attributes\":{\"POSITION\":0},\"indices\":5" );
    expect_accessor_fault( &b, "NORMAL has 4", "\"attributes\":{\"POSITION\":0,\"NORMAL\":3}" );
    expect_accessor_fault( &b, "accessors[6]", "\"attributes\":{\"POSITION\":6}" );
    expect_accessor_fault( &b, "accessors[7]", "\"attributes\":{\"POSITION\":7}" );
    expect_accessor_fault( &b, "accessors[8]: componentType", "\"attributes\":{\"POSITION\":8}" );
    expect_accessor_fault( &b, "accessors[9]: normalized", "\"attributes\":{\"POSITION\":9}" );
    expect_accessor_fault( &b, "accessors[10]", "\"attributes\":{\"POSITION\":10}" );
    expect_accessor_fault( &b, "accessors[11]: type", "\"attributes\":{\"POSITION\":11}" );
    expect_accessor_fault( &b, "accessors[12].sparse", "\"attributes\":{\"POSITION\":12}" );
    expect_accessor_fault( &b, "accessors[13].sparse", "\"attributes\":{\"POSITION\":13}" );
    expect_accessor_fault( &b, "accessors[14]: count", "\"attributes\":{\"POSITION\":14}" );
}

TEST( test_faults_of_materials )
{
    static const Fault s_faults[] = {
        { RF_ERROR_FORMAT, "materials[0].pbrMetallicRoughness: metallicFactor is 2",
          "\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":2}}]" },
        { RF_ERROR_FORMAT, "baseColorFactor must be 4", "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1]}}]" },
        { RF_ERROR_FORMAT, "emissiveFactor", "\"materials\":[{\"emissiveFactor\":[0,0,-1]}]" },
        { RF_ERROR_UNSUPPORTED, "emissiveStrength is 1e+16, beyond what reframe reads: at most 1e+15",
          "\"materials\":[{\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":1e16}}}]" },
        { RF_ERROR_FORMAT, "emissiveStrength is -1",
          "\"materials\":[{\"extensions\":{\"KHR_materials_emissive_strength\":{\"emissiveStrength\":-1}}}]" },
        { RF_ERROR_FORMAT, "ior is 0.5", "\"materials\":[{\"extensions\":{\"KHR_materials_ior\":{\"ior\":0.5}}}]" },
        { RF_ERROR_FORMAT, "alphaMode", "\"materials\":[{\"alphaMode\":\"GLOW\"}]" },
        { RF_ERROR_SCENE, "materials[0].extras.reframe.shine",
          "\"materials\":[{\"extras\":{\"reframe\":{\"bsdf\":\"phong\",\"shine\":1}}}]" },
        { RF_ERROR_SCENE, "materials[0].extras.reframe: must be", "\"materials\":[{\"extras\":{\"reframe\":3}}]" },
        { RF_ERROR_SCENE, "materials[0].extras.reframe: must have coat \"added\"",
          "\"materials\":[{\"extras\":{\"reframe\":{\"coat\":\"layered\"}}}]" },
        { RF_ERROR_SCENE, "materials[0].extras.reframe: must have coat \"added\"",
          "\"materials\":[{\"extras\":{\"reframe\":{\"coat\":1}}}]" },
        { RF_ERROR_SCENE, "materials[0].extras.reframe: must have coat \"added\"",
          "\"materials\":[{\"extras\":{\"reframe\":{\"coat\":null}}}]" },
        { RF_ERROR_SCENE, "materials[0].extras.reframe: must have coat \"added\"",
          "\"materials\":[{\"extras\":{\"reframe\":{\"coat\":[\"added\"]}}}]" },
        { RF_ERROR_SCENE, "materials[0].extras.reframe: must have coat \"added\"",
          "\"materials\":[{\"extras\":{\"reframe\":{\"coat\":\"added\",\"ior\":1.5}}}]" },
        { RF_ERROR_SCENE, "materials[0].extras.reframe.coat: unknown key",
          "\"materials\":[{\"extras\":{\"reframe\":{\"bsdf\":\"lambert\",\"diffuse\":[0,0,0],\"coat\":\"added\"}}}]" },
        { RF_ERROR_SCENE, "materials[0].extras.reframe: diffuse + specular",
          "\"materials\":[{\"extras\":{\"reframe\":{\"bsdf\":\"phong\",\"diffuse\":[0.6,0,0],\"specular\":[0.5,0,0],"
          "\"exponent\":10}}}]" },
        { RF_ERROR_SCENE, "exponent: must be",
          "\"materials\":[{\"extras\":{\"reframe\":{\"bsdf\":\"phong\",\"diffuse\":[0,0,0],\"specular\":[0,0,0],"
          "\"exponent\":1e7}}}]" },
        { RF_ERROR_SCENE, "reframe.diffuse: is missing", "\"materials\":[{\"extras\":{\"reframe\":{\"bsdf\":\"lambert\"}}}]" },
    };
    EXPECT_FAULTS( s_faults );
}

#define CHANNEL( sampler, target )                                                                                               \
    "\"nodes\":[{},{\"matrix\":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1]}],\"animations\":[{\"samplers\":[{" sampler                     \
    "}],\"channels\":[{\"sampler\":0,\"target\":{" target "}}]}]"

TEST( test_faults_of_animations )
{
    static const Fault s_faults[] = {
        { RF_ERROR_FORMAT, "samplers[0]: interpolation",
          CHANNEL( "\"interpolation\":\"SMOOTH\"", "\"node\":0,\"path\":\"scale\"" ) },
        { RF_ERROR_FORMAT, "input is missing", CHANNEL( "\"output\":0", "\"node\":0,\"path\":\"scale\"" ) },
        { RF_ERROR_FORMAT, "accessors[0] has elements of 3",
          CHANNEL( "\"input\":0,\"output\":0", "\"node\":0,\"path\":\"scale\"" ) },
        { RF_ERROR_FORMAT, "must be floats", CHANNEL( "\"input\":2,\"output\":0", "\"node\":0,\"path\":\"scale\"" ) },
        { RF_ERROR_FORMAT, "which has a matrix", CHANNEL( "\"input\":2,\"output\":0", "\"node\":1,\"path\":\"scale\"" ) },
        { RF_ERROR_FORMAT, "channels[0]: target.path", CHANNEL( "\"input\":2", "\"node\":0,\"path\":\"color\"" ) },
        { RF_ERROR_FORMAT, "channels[0]: node is 7", CHANNEL( "\"input\":2", "\"node\":7,\"path\":\"scale\"" ) },
    };
    EXPECT_FAULTS( s_faults );

    static const float s_times[][3] = { { 0, 1, 1 }, { 2, 1, 3 }, { -1, 0, 1 }, { 0, 1, INFINITY } };
    static const float s_values[12] = { 1, 1, 1, 1, 1, 1, 1, 1, 1 };
    for ( size_t i = 0; i < 4; ++i )
    {
        GltfBuilder b = { 0 };
        add_gltf_floats( &b, "SCALAR", 1, 3, s_times[i] );
        add_gltf_floats( &b, "VEC3", 3, 3, s_values );
        const char* rest = CHANNEL( "\"input\":0,\"output\":1", "\"node\":0,\"path\":\"scale\"" );
        expect_failure( write_gltf( &b, &gltf_folder, rest ), RF_ERROR_FORMAT, "accessors[0]" );
        rest = CHANNEL( "\"input\":0,\"output\":1,\"interpolation\":\"CUBICSPLINE\"", "\"node\":0,\"path\":\"scale\"" );
        if ( i == 0 )
        {
            static const float s_good[] = { 0, 1, 2 };
            memcpy( b.bin, s_good, sizeof s_good );
            expect_failure( write_gltf( &b, &gltf_folder, rest ), RF_ERROR_FORMAT, "accessors[1] has 3 elements, 9" );
        }
    }
}

// A file that touches every part of the reader, for the mutations.
static uint8_t* make_everything( size_t* size )
{
    static const float s_times[] = { 0, 0.5f, 1 }, s_moves[] = { 0, 0, 0, 1, 1, 1, 2, 2, 2 };
    static const float s_uvs[] = { 0, 0, 1, 0, 0, 1 };
    GltfBuilder b = make_triangle();
    add_gltf_floats( &b, "VEC2", 2, 3, s_uvs );
    add_gltf_floats( &b, "SCALAR", 1, 3, s_times );
    add_gltf_floats( &b, "VEC3", 3, 3, s_moves );
    add_gltf_accessor( &b, 5126, "VEC3", 3, s_moves, 36,
                       ",\"sparse\":{\"count\":3,\"indices\":{\"bufferView\":2,\"componentType\":5123},"
                       "\"values\":{\"bufferView\":0}}" );
    return build_glb( &b,
                      "\"scene\":0,\"scenes\":[{\"nodes\":[0,2]}],\"nodes\":[{\"children\":[1],\"scale\":[-1,1,2]},"
                      "{\"mesh\":0,\"rotation\":[0,0.6,0,0.8]},{\"camera\":0,\"translation\":[0,0,5]}],"
                      "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TEXCOORD_0\":3},"
                      "\"indices\":2,\"material\":0},{\"attributes\":{\"POSITION\":6},\"mode\":5}]}],"
                      "\"materials\":[{\"doubleSided\":true,\"emissiveFactor\":[1,1,1],\"pbrMetallicRoughness\":"
                      "{\"baseColorFactor\":[0.5,0.5,0.5,1],\"metallicFactor\":0.25,\"roughnessFactor\":0.5},"
                      "\"extensions\":{\"KHR_materials_ior\":{\"ior\":1.4},\"KHR_materials_specular\":"
                      "{\"specularFactor\":0.5},\"KHR_materials_emissive_strength\":{\"emissiveStrength\":10}}},"
                      "{\"extras\":{\"reframe\":{\"bsdf\":\"phong\",\"diffuse\":[0.1,0.2,0.3],"
                      "\"specular\":[0.5,0.5,0.5],\"exponent\":60}}}],"
                      "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.7}}],"
                      "\"animations\":[{\"samplers\":[{\"input\":4,\"output\":5}],\"channels\":[{\"sampler\":0,"
                      "\"target\":{\"node\":2,\"path\":\"translation\"}}]}]",
                      size );
}

static void run_mutations( const uint8_t* original, size_t size, uint64_t count )
{
    uint8_t* bytes = malloc( size );
    int loaded = 0;
    for ( uint64_t i = 0; i < count; ++i )
    {
        memcpy( bytes, original, size );
        size_t cut = mutate_bytes( bytes, size, i + 1 );
        RfScene scene;
        RfError error = { 0 };
        RfResult result = rf_load_gltf( write_bytes( &gltf_folder, "a.glb", bytes, cut ), &scene, NULL, &error );
        assert_true( result == RF_OK || error.text[0] != 0 );
        loaded += result == RF_OK;
        rf_destroy_scene( &scene );
    }
    free( bytes );
    // mutations that hit nothing but values must still load: the test is alive
    assert_true( loaded > 0 );
}

TEST( test_mutations_never_crash )
{
    size_t size;
    uint8_t* glb = make_everything( &size );
    RfScene scene;
    RfError error = { 0 };
    RfResult result = rf_load_gltf( write_bytes( &gltf_folder, "a.glb", glb, size ), &scene, NULL, &error );
    assert_string_equal( error.text, "" );
    assert_int_equal( result, RF_OK );
    rf_destroy_scene( &scene );
    const char* many = getenv( "REFRAME_MUTATIONS" );
    run_mutations( glb, size, many != NULL ? (uint64_t)atoll( many ) : MUTATIONS );
    free( glb );
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
