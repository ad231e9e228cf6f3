// A corpus of small broken glTF files, one for each fault that the reader can report and
// that test_gltf_faults, test_gltf_materials and test_gltf_textures do not cover: each
// gives an error line that names the file, the object and the fault. Not here: limits that
// take gigabytes to reach, and failed allocations.
#include "support/image_files.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "gltf/gltf.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// Accessors, each with a view of its own: 0 positions, 1 normals, 2 indices, 3
// times, 4 three numbers three times, 5 quaternions of which [1] is zero, 6 good
// ones, 7 and 8 three and four numbers, [1] not finite, 9 pairs, 10 signed indices.
static GltfBuilder make_parts( void )
{
    static const float s_positions[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0 }, s_normals[] = { 0, 0, 1, 0, 0, 1, 0, 0, 1 };
    static const float s_times[] = { 0, 1, 2 }, s_zero[] = { 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 1 };
    static const float s_turns[] = { 0, 0, 0, 1, 0, 1, 0, 0, 0, 0, 0, 1 }, s_pairs[] = { 0, 0, 1, 0, 0, 1 };
    static const float s_broken[] = { 0, 0, 0, 1, 1, NAN, 0, 0, 0, 1, 0, 0 };
    static const uint16_t s_indices[] = { 0, 1, 2 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 3, s_positions );
    add_gltf_floats( &b, "VEC3", 3, 3, s_normals );
    add_gltf_u16( &b, 3, s_indices );
    add_gltf_floats( &b, "SCALAR", 1, 3, s_times );
    add_gltf_floats( &b, "VEC3", 3, 3, s_positions );
    add_gltf_floats( &b, "VEC4", 4, 3, s_zero );
    add_gltf_floats( &b, "VEC4", 4, 3, s_turns );
    add_gltf_floats( &b, "VEC3", 3, 3, s_broken );
    add_gltf_floats( &b, "VEC4", 4, 3, s_broken );
    add_gltf_floats( &b, "VEC2", 2, 3, s_pairs );
    add_gltf_accessor( &b, 5122, "SCALAR", 3, s_indices, sizeof s_indices, "" );
    return b;
}

typedef struct Fault
{
    RfResult code;
    const char* text;      // in the error line
    const char* json;      // members of the document after views and accessors
    const char* accessors; // more of them, from 11 on, or NULL
    const char* views;     // likewise
} Fault;

static void expect_failure( const char* path, const Fault* fault )
{
    RfScene scene;
    RfError error = { 0 };
    RfResult result = rf_load_gltf( path, &scene, NULL, &error );
    if ( result == RF_OK )
        fail_msg( "loads, instead of '%s'", fault->text );
    if ( result != fault->code || strstr( error.text, fault->text ) == NULL || strstr( error.text, gltf_folder.path ) == NULL ||
         strchr( error.text, '\n' ) != NULL )
        fail_msg( "%s '%s', wanted %s '%s'", rf_result_name( result ), error.text, rf_result_name( fault->code ), fault->text );
    assert_null( scene.path );
    assert_null( scene.materials );
}

static void expect_faults( const Fault* faults, size_t count )
{
    for ( size_t i = 0; i < count; ++i )
    {
        GltfBuilder b = make_parts();
        strcat( b.accessors, faults[i].accessors != NULL ? faults[i].accessors : "" );
        strcat( b.views, faults[i].views != NULL ? faults[i].views : "" );
        expect_failure( write_gltf( &b, &gltf_folder, faults[i].json ), faults + i );
    }
}
#define EXPECT_FAULTS( faults ) expect_faults( faults, sizeof( faults ) / sizeof( faults )[0] )

#define PRIMITIVE( members ) "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{" members "}]}]"
#define POSITION( accessor ) PRIMITIVE( "\"attributes\":{\"POSITION\":" #accessor "}" )
#define BAD RF_ERROR_FORMAT

TEST( test_broken_accessors )
{
    static const Fault s_faults[] = {
        { BAD, "accessors[11]: count is missing", POSITION( 11 ), ",{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\"}",
          NULL },
        { BAD, "accessors[11]: count must be", POSITION( 11 ),
          ",{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":1.5}", NULL },
        { BAD, "accessors[11]: componentType is missing", POSITION( 11 ), ",{\"bufferView\":0,\"type\":\"VEC3\",\"count\":3}",
          NULL },
        { BAD, "accessors[11]: componentType must be", POSITION( 11 ),
          ",{\"bufferView\":0,\"componentType\":5130,\"type\":\"VEC3\",\"count\":3}", NULL },
        { BAD, "accessors[11]: type must be a string", POSITION( 11 ),
          ",{\"bufferView\":0,\"componentType\":5126,\"type\":3,\"count\":3}", NULL },
        { BAD, "accessors[11]: type ''", POSITION( 11 ), ",{\"bufferView\":0,\"componentType\":5126,\"count\":3}", NULL },
        { BAD, "type 'MAT3'", POSITION( 11 ), ",{\"bufferView\":0,\"componentType\":5126,\"type\":\"MAT3\",\"count\":1}", NULL },
        { BAD, "normalized must be true or false", POSITION( 11 ),
          ",{\"bufferView\":0,\"componentType\":5121,\"type\":\"VEC3\",\"count\":3,\"normalized\":1}", NULL },
        { BAD, "normalized needs components of 8", POSITION( 11 ),
          ",{\"bufferView\":0,\"componentType\":5125,\"type\":\"VEC3\",\"count\":3,\"normalized\":true}", NULL },
        { BAD, "accessors[11]: bufferView is 99", POSITION( 11 ),
          ",{\"bufferView\":99,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}", NULL },
        { BAD, "accessors[11]: byteOffset must be", POSITION( 11 ),
          ",{\"bufferView\":0,\"byteOffset\":-1,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}", NULL },
        { RF_ERROR_UNSUPPORTED, "20000000 elements without a bufferView", POSITION( 11 ),
          ",{\"componentType\":5126,\"type\":\"VEC3\",\"count\":20000000}", NULL },
        { BAD, "bufferViews[11]: byteStride must be", POSITION( 11 ),
          ",{\"bufferView\":11,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}",
          ",{\"buffer\":0,\"byteLength\":36,\"byteStride\":2}" },
        { BAD, "byteStride is 8, but the elements have 12", POSITION( 11 ),
          ",{\"bufferView\":11,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}",
          ",{\"buffer\":0,\"byteLength\":36,\"byteStride\":8}" },
        { BAD, "bufferViews[11]: buffer is missing", POSITION( 11 ),
          ",{\"bufferView\":11,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}", ",{\"byteLength\":36}" },
        { BAD, "bufferViews[11]: byteLength is missing", POSITION( 11 ),
          ",{\"bufferView\":11,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}", ",{\"buffer\":0}" },
        { BAD, "are outside buffers[0]", POSITION( 11 ),
          ",{\"bufferView\":11,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}",
          ",{\"buffer\":0,\"byteOffset\":400000,\"byteLength\":36}" },
        { BAD, "are outside bufferViews[11]", POSITION( 11 ),
          ",{\"bufferView\":11,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3}", ",{\"buffer\":0,\"byteLength\":35}" },
    };
    EXPECT_FAULTS( s_faults );
}

#define SPARSE( members ) ",{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,\"sparse\":{" members "}}"

TEST( test_broken_sparse_accessors )
{
    static const Fault s_faults[] = {
        { BAD, "sparse must be an object", POSITION( 11 ),
          ",{\"bufferView\":0,\"componentType\":5126,\"type\":\"VEC3\",\"count\":3,\"sparse\":1}", NULL },
        { BAD, "sparse: count is missing", POSITION( 11 ), SPARSE( "\"indices\":{}" ), NULL },
        { BAD, "sparse: count must be", POSITION( 11 ), SPARSE( "\"count\":4" ), NULL },
        { BAD, "sparse: indices is missing", POSITION( 11 ), SPARSE( "\"count\":1" ), NULL },
        { BAD, "sparse: indices must be an object", POSITION( 11 ), SPARSE( "\"count\":1,\"indices\":2" ), NULL },
        { BAD, "sparse: componentType is missing", POSITION( 11 ), SPARSE( "\"count\":1,\"indices\":{\"bufferView\":2}" ), NULL },
        { BAD, "indices must have an unsigned componentType", POSITION( 11 ),
          SPARSE( "\"count\":1,\"indices\":{\"bufferView\":2,\"componentType\":5126}" ), NULL },
        { BAD, "sparse.indices: bufferView is missing", POSITION( 11 ),
          SPARSE( "\"count\":1,\"indices\":{\"componentType\":5123}" ), NULL },
        { BAD, "sparse.indices: bytes 4 + 4 are outside", POSITION( 11 ),
          SPARSE( "\"count\":2,\"indices\":{\"bufferView\":2,\"byteOffset\":4,\"componentType\":5123}" ), NULL },
        { BAD, "sparse: values is missing", POSITION( 11 ),
          SPARSE( "\"count\":1,\"indices\":{\"bufferView\":2,\"componentType\":5123}" ), NULL },
        { BAD, "indices[1] is 0: they must increase", POSITION( 11 ),
          SPARSE( "\"count\":3,\"indices\":{\"bufferView\":5,\"componentType\":5125},\"values\":{\"bufferView\":0}" ), NULL },
    };
    EXPECT_FAULTS( s_faults );
}

TEST( test_broken_primitives )
{
    static const Fault s_faults[] = {
        { BAD, "primitives must be an array", "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":{}}]", NULL, NULL },
        { BAD, "attributes must be an object", PRIMITIVE( "\"attributes\":[]" ), NULL, NULL },
        { BAD, "accessors[7]: element 1, number 2 is not finite", PRIMITIVE( "\"attributes\":{\"POSITION\":0,\"NORMAL\":7}" ),
          NULL, NULL },
        { BAD, "accessors[8]: element 1, number 1 is not finite", PRIMITIVE( "\"attributes\":{\"POSITION\":0,\"COLOR_0\":8}" ),
          NULL, NULL },
        { BAD, "accessors[8]: element 1", PRIMITIVE( "\"attributes\":{\"POSITION\":0,\"NORMAL\":1,\"TANGENT\":8}" ), NULL, NULL },
        { BAD, "2 are needed", PRIMITIVE( "\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":0}" ), NULL, NULL },
        { BAD, "indices accessors[3] must be unsigned", PRIMITIVE( "\"attributes\":{\"POSITION\":0},\"indices\":3" ), NULL,
          NULL },
        { BAD, "indices accessors[10] must be unsigned", PRIMITIVE( "\"attributes\":{\"POSITION\":0},\"indices\":10" ), NULL,
          NULL },
        { BAD, "indices accessors[11] must be unsigned", PRIMITIVE( "\"attributes\":{\"POSITION\":0},\"indices\":11" ),
          ",{\"bufferView\":2,\"componentType\":5123,\"type\":\"SCALAR\",\"count\":3,\"normalized\":true}", NULL },
        { BAD, "indices is 12", PRIMITIVE( "\"attributes\":{\"POSITION\":0},\"indices\":12" ), NULL, NULL },
        { BAD, "material must be an integer", PRIMITIVE( "\"attributes\":{\"POSITION\":0},\"material\":\"red\"" ), NULL, NULL },
        { BAD, "nodes[0]: mesh is -1", "\"nodes\":[{\"mesh\":-1}],\"meshes\":[{}]", NULL, NULL },
    };
    EXPECT_FAULTS( s_faults );
}

#define ANIMATION( text ) "\"nodes\":[{}],\"animations\":[{" text "}]"
#define CHANNEL( sampler, path )                                                                                                 \
    ANIMATION( "\"samplers\":[{" sampler "}],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"" path "\"}}]" )

TEST( test_broken_animations )
{
    static const Fault s_faults[] = {
        { BAD, "animations[0]: channels must be an array", ANIMATION( "\"channels\":1" ), NULL, NULL },
        { BAD, "animations[0]: samplers must be an array", ANIMATION( "\"samplers\":1" ), NULL, NULL },
        { BAD, "animations[0].channels[0]: must be an object", ANIMATION( "\"channels\":[1]" ), NULL, NULL },
        { BAD, "channels[0]: target is missing", ANIMATION( "\"channels\":[{}]" ), NULL, NULL },
        { BAD, "channels[0]: target must be an object", ANIMATION( "\"channels\":[{\"target\":1}]" ), NULL, NULL },
        { BAD, "channels[0]: path is missing", ANIMATION( "\"channels\":[{\"target\":{}}]" ), NULL, NULL },
        { BAD, "channels[0]: sampler is missing", ANIMATION( "\"channels\":[{\"target\":{\"node\":0,\"path\":\"scale\"}}]" ),
          NULL, NULL },
        { BAD, "channels[0]: sampler must be",
          ANIMATION( "\"samplers\":[{}],\"channels\":[{\"sampler\":1,\"target\":{\"node\":0,\"path\":\"scale\"}}]" ), NULL,
          NULL },
        { BAD, "animations[0].samplers[0]: must be an object",
          ANIMATION( "\"samplers\":[1],\"channels\":[{\"sampler\":0,\"target\":{\"node\":0,\"path\":\"scale\"}}]" ), NULL, NULL },
        { BAD, "samplers[0]: interpolation must be a string", CHANNEL( "\"interpolation\":1", "scale" ), NULL, NULL },
        { BAD, "samplers[0]: output is missing", CHANNEL( "\"input\":3", "scale" ), NULL, NULL },
        { BAD, "samplers[0]: input is 40", CHANNEL( "\"input\":40,\"output\":4", "scale" ), NULL, NULL },
        { BAD, "accessors[4] has elements of 3 numbers, 4 are needed", CHANNEL( "\"input\":3,\"output\":4", "rotation" ), NULL,
          NULL },
        { BAD, "accessors[6] has elements of 4 numbers, 3 are needed", CHANNEL( "\"input\":3,\"output\":6", "translation" ), NULL,
          NULL },
        { BAD, "output 1 is not a unit quaternion", CHANNEL( "\"input\":3,\"output\":5", "rotation" ), NULL, NULL },
        { BAD, "accessors[7]: element 1", CHANNEL( "\"input\":3,\"output\":7", "translation" ), NULL, NULL },
        { BAD, "output accessors[4] has 3 elements, 9 are needed",
          CHANNEL( "\"input\":3,\"output\":4,\"interpolation\":\"CUBICSPLINE\"", "translation" ), NULL, NULL },
    };
    EXPECT_FAULTS( s_faults );
}

#define INSTANCES( json )                                                                                                        \
    "\"nodes\":[{\"mesh\":0,\"extensions\":{\"EXT_mesh_gpu_instancing\":" json                                                   \
    "}}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0}}]}]"
#define LIGHT( lights, node )                                                                                                    \
    "\"extensions\":{\"KHR_lights_punctual\":" lights "},\"nodes\":[{" node                                                      \
    "\"extensions\":{\"KHR_lights_punctual\":{\"light\":0}}}]"

TEST( test_broken_nodes )
{
    static const Fault s_faults[] = {
        { BAD, "EXT_mesh_gpu_instancing must be an object", INSTANCES( "1" ), NULL, NULL },
        { BAD, "EXT_mesh_gpu_instancing: attributes is missing", INSTANCES( "{}" ), NULL, NULL },
        { BAD, "must have at least one of TRANSLATION", INSTANCES( "{\"attributes\":{}}" ), NULL, NULL },
        { BAD, "accessors[5]: element 1 is not a unit quaternion", INSTANCES( "{\"attributes\":{\"ROTATION\":5}}" ), NULL, NULL },
        { BAD, "accessors[8]: element 1", INSTANCES( "{\"attributes\":{\"ROTATION\":8}}" ), NULL, NULL },
        { BAD, "accessors[7]: element 1", INSTANCES( "{\"attributes\":{\"TRANSLATION\":7}}" ), NULL, NULL },
        { BAD, "accessors[7]: element 1", INSTANCES( "{\"attributes\":{\"SCALE\":7}}" ), NULL, NULL },
        { BAD, "KHR_lights_punctual.lights[0]: must be an object", LIGHT( "{\"lights\":[1]}", "" ), NULL, NULL },
        { BAD, "KHR_lights_punctual has no lights", LIGHT( "{\"lights\":[]}", "" ), NULL, NULL },
        { BAD, "lights must be an array", LIGHT( "{\"lights\":{}}", "" ), NULL, NULL },
        { BAD, "lights[0]: name must be a string", LIGHT( "{\"lights\":[{\"type\":\"point\",\"name\":1}]}", "" ), NULL, NULL },
        { BAD, "its light has no direction", LIGHT( "{\"lights\":[{\"type\":\"directional\"}]}", "\"scale\":[0,0,0]," ), NULL,
          NULL },
        { BAD, "nodes[0]: children must be an array", "\"nodes\":[{\"children\":0}]", NULL, NULL },
        { BAD, "nodes[0]: scale must be an array", "\"nodes\":[{\"scale\":2}]", NULL, NULL },
        { BAD, "nodes[0]: translation must be numbers only", "\"nodes\":[{\"translation\":[0,\"1\",0]}]", NULL, NULL },
        { BAD, "scenes[0]: nodes must be an array", "\"nodes\":[{}],\"scenes\":[{\"nodes\":0}]", NULL, NULL },
        { BAD, "scenes[0]: nodes[0]", "\"nodes\":[{}],\"scenes\":[{\"nodes\":[5]}]", NULL, NULL },
        { BAD, "nodes[0]: camera is 3", "\"nodes\":[{\"camera\":3}],\"cameras\":[{}]", NULL, NULL },
        { BAD, "cameras[0]: type is missing", "\"nodes\":[{\"camera\":0}],\"cameras\":[{}]", NULL, NULL },
        { BAD, "cameras[0]: perspective is missing", "\"nodes\":[{\"camera\":0}],\"cameras\":[{\"type\":\"perspective\"}]", NULL,
          NULL },
        { BAD, "cameras[0]: aspectRatio is 0, it must be more than 0",
          "\"nodes\":[{\"camera\":0}],\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":1,\"aspectRatio\":0}}]",
          NULL, NULL },
        { BAD, "cameras[0]: name must be a string",
          "\"nodes\":[{\"camera\":0}],\"cameras\":[{\"name\":1,\"type\":\"perspective\",\"perspective\":{\"yfov\":1}}]", NULL,
          NULL },
        { BAD, "document: nodes must be an array", "\"nodes\":{}", NULL, NULL },
        { BAD, "extensionsUsed must be an array", "\"extensionsUsed\":{}", NULL, NULL },
    };
    EXPECT_FAULTS( s_faults );
}

#define EXTENSION( json ) "\"materials\":[{\"extensions\":{" json "}}]"

TEST( test_broken_materials )
{
    static const Fault s_faults[] = {
        { BAD, "pbrMetallicRoughness must be an object", "\"materials\":[{\"pbrMetallicRoughness\":1}]", NULL, NULL },
        { BAD, "baseColorFactor must be numbers only",
          "\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,\"1\"]}}]", NULL, NULL },
        { BAD, "roughnessFactor must be a number", "\"materials\":[{\"pbrMetallicRoughness\":{\"roughnessFactor\":true}}]", NULL,
          NULL },
        { BAD, "doubleSided must be true or false", "\"materials\":[{\"doubleSided\":0}]", NULL, NULL },
        { BAD, "alphaMode must be a string", "\"materials\":[{\"alphaMode\":0}]", NULL, NULL },
        { BAD, "alphaCutoff must be a number", "\"materials\":[{\"alphaCutoff\":\"0\"}]", NULL, NULL },
        { BAD, "materials[0]: name must be a string", "\"materials\":[{\"name\":0}]", NULL, NULL },
        { BAD, "extensions must be an object", "\"materials\":[{\"extensions\":0}]", NULL, NULL },
        { BAD, "KHR_materials_specular must be an object", EXTENSION( "\"KHR_materials_specular\":1" ), NULL, NULL },
        { BAD, "specularFactor is 2", EXTENSION( "\"KHR_materials_specular\":{\"specularFactor\":2}" ), NULL, NULL },
        { BAD, "specularColorFactor is -1, it must be 0 or more",
          EXTENSION( "\"KHR_materials_specular\":{\"specularColorFactor\":[1,-1,1]}" ), NULL, NULL },
        { BAD, "specularColorFactor must be 3", EXTENSION( "\"KHR_materials_specular\":{\"specularColorFactor\":[1]}" ), NULL,
          NULL },
        { BAD, "KHR_materials_ior must be an object", EXTENSION( "\"KHR_materials_ior\":1.5" ), NULL, NULL },
        { BAD, "emissiveStrength must be a number", EXTENSION( "\"KHR_materials_emissive_strength\":{\"emissiveStrength\":[]}" ),
          NULL, NULL },
        { BAD, "KHR_materials_emissive_strength must be an object", EXTENSION( "\"KHR_materials_emissive_strength\":5" ), NULL,
          NULL },
        { BAD, "transmissionFactor is -1", EXTENSION( "\"KHR_materials_transmission\":{\"transmissionFactor\":-1}" ), NULL,
          NULL },
        { BAD, "KHR_materials_transmission must be an object", EXTENSION( "\"KHR_materials_transmission\":1" ), NULL, NULL },
        { BAD, "KHR_materials_volume must be an object", EXTENSION( "\"KHR_materials_volume\":1" ), NULL, NULL },
        { BAD, "attenuationDistance must be a number", EXTENSION( "\"KHR_materials_volume\":{\"attenuationDistance\":\"far\"}" ),
          NULL, NULL },
        { BAD, "clearcoatRoughnessFactor must be a number",
          EXTENSION( "\"KHR_materials_clearcoat\":{\"clearcoatRoughnessFactor\":\"0\"}" ), NULL, NULL },
        { BAD, "emissiveTexture: index is missing", "\"materials\":[{\"emissiveTexture\":{}}]", NULL, NULL },
        { BAD, "emissiveTexture must be an object", "\"materials\":[{\"emissiveTexture\":0}]", NULL, NULL },
        { BAD, "normalTexture: scale must be a number",
          "\"textures\":[{\"source\":0}],\"images\":[{}],\"materials\":[{\"normalTexture\":{\"index\":0,\"scale\":[]}}]", NULL,
          NULL },
        { BAD, "offset must be 2",
          "\"textures\":[{\"source\":0}],\"images\":[{}],\"materials\":[{\"emissiveTexture\":{\"index\":0,\"extensions\":{\"KHR_"
          "texture_transform\":{\"offset\":[0]}}}}]",
          NULL, NULL },
        { RF_ERROR_UNSUPPORTED, "beyond what reframe reads: at most 1e+06",
          "\"textures\":[{\"source\":0}],\"images\":[{}],\"materials\":[{\"emissiveTexture\":{\"index\":0,\"extensions\":{\"KHR_"
          "texture_transform\":{\"scale\":[1e9,1]}}}}]",
          NULL, NULL },
    };
    EXPECT_FAULTS( s_faults );
}

// A pixel of an image that is no number.
TEST( test_broken_pixels )
{
    float rgb[12] = { 0.5f, 0.5f, 0.5f, 0.5f, INFINITY, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f, 0.5f };
    size_t size;
    uint8_t* exr = encode_exr( 2, 2, rgb, &size );
    GltfBuilder b = make_parts();
    add_gltf_accessor( &b, 5121, "SCALAR", (int)size, exr, size, "" ); // 11
    free( exr );
    const Fault fault = { RF_ERROR_SCENE, "images[0]: pixel (1, 0) is not finite", NULL, NULL, NULL };
    expect_failure(
        write_gltf(
            &b, &gltf_folder,
            PRIMITIVE(
                "\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":9},\"material\":0" ) ",\"images\":[{\"bufferView\":11}],"
                                                                                    "\"textures\":[{\"source\":0}],\"materials\":"
                                                                                    "[{\"emissiveFactor\":[1,1,1],"
                                                                                    "\"emissiveTexture\":{\"index\":0}}]" ),
        &fault );
}

TEST( test_broken_containers )
{
    // a header alone; a chunk whose own header is cut off
    uint8_t bytes[64] = "glTF\2\0\0\0\14\0\0\0";
    const Fault none = { BAD, "has no JSON chunk", NULL, NULL, NULL },
                cut = { BAD, "GLB chunk 1: the file ends inside its header", NULL, NULL, NULL };
    expect_failure( write_bytes( &gltf_folder, "a.glb", bytes, 12 ), &none );
    GltfBuilder b = { 0 };
    size_t size;
    uint8_t* glb = build_glb( &b, "", &size ); // ends in an empty chunk of 8 bytes
    glb[8] = (uint8_t)( size - 3 );
    expect_failure( write_bytes( &gltf_folder, "a.glb", glb, size - 3 ), &cut );
    free( glb );
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
