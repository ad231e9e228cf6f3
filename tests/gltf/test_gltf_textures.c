// Textures of glTF: where images come from, how texture infos, samplers and transforms are
// read, colour spaces, second coordinates, vertex colours, alpha; and the error line of
// everything that can be wrong with them.
#include "support/image_files.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "gltf/gltf.h"
#include "image/decode.h"
#include "scene/textured.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static const float s_square[] = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 };
static const uint8_t s_pixels[] = { 255, 0, 0, 255, 0, 128, 0, 255, 0, 0, 64, 255, 200, 200, 200, 51 };

// Accessors and views: 0 positions, 1 first coordinates, 2 second ones, 3
// indices, 4 normals, 5 a PNG of 2 x 2.
static GltfBuilder make_square( void )
{
    static const float s_uv0[] = { 0, 1, 1, 1, 1, 0, 0, 0 }, s_uv1[] = { 0, 0, 0.25f, 0, 0.25f, 0.25f, 0, 0.25f };
    static const uint16_t s_indices[] = { 0, 1, 2, 0, 2, 3 };
    static const float s_normals[] = { 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1 };
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 4, s_square );
    add_gltf_floats( &b, "VEC2", 2, 4, s_uv0 );
    add_gltf_floats( &b, "VEC2", 2, 4, s_uv1 );
    add_gltf_u16( &b, 6, s_indices );
    add_gltf_floats( &b, "VEC3", 3, 4, s_normals );
    size_t size;
    uint8_t* png = encode_png( 2, 2, 4, s_pixels, &size );
    add_gltf_accessor( &b, 5121, "SCALAR", (int)size, png, size, "" );
    free( png );
    return b;
}

#define NODES                                                                                                                    \
    "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"TEXCOORD_0\":1,\"TEXCOORD_1\":2},"  \
    "\"indices\":3,\"material\":0}]}]"
#define IMAGE ",\"images\":[{\"bufferView\":5,\"mimeType\":\"image/png\"}]"
#define TEXTURE IMAGE ",\"textures\":[{\"source\":0}]"

// The material at the barycentrics of the first triangle, (0,1) (1,1) (1,0).
static RfMaterial at( const RfScene* scene, float u, float v )
{
    RfMaterial out;
    const RfMaterial* m = scene->materials + scene->triangles.material[0];
    assert_non_null( m->textured );
    rf_material_at( scene, m, 0, u, v, &out );
    return out;
}

TEST( test_colour_is_srgb_data_is_linear )
{
    GltfBuilder b = make_square();
    RfScene scene = gltf_load_built(
        &b, NODES IMAGE
        ",\"samplers\":[{\"magFilter\":9728,\"wrapS\":33071,\"wrapT\":33648}],"
        "\"textures\":[{\"source\":0,\"sampler\":0}],\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0.5,"
        "\"baseColorFactor\":[1,0.5,1,1],\"baseColorTexture\":{\"index\":0},\"metallicRoughnessTexture\":{\"index\":0}},"
        "\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":0},"
        "\"normalTexture\":{\"index\":0,\"scale\":0.25},\"occlusionTexture\":{\"index\":9}}]" );
    // one image, two colour spaces
    assert_int_equal( scene.texture_count, 2 );
    assert_int_equal( scene.textures[0].channels, 4 );
    assert_memory_equal( scene.textures[0].bytes, s_pixels, sizeof s_pixels );
    assert_null( scene.textures[0].floats );
    const RfTextured* t = scene.materials[0].textured;
    assert_int_equal( t->refs[RF_TEXTURE_BASE].texture, t->refs[RF_TEXTURE_EMISSIVE].texture );
    assert_int_equal( t->refs[RF_TEXTURE_METALLIC_ROUGHNESS].texture, t->refs[RF_TEXTURE_NORMAL].texture );
    assert_int_not_equal( t->refs[RF_TEXTURE_BASE].texture, t->refs[RF_TEXTURE_NORMAL].texture );
    assert_int_equal( t->refs[RF_TEXTURE_BASE].wrap[0], RF_WRAP_CLAMP );
    assert_int_equal( t->refs[RF_TEXTURE_BASE].wrap[1], RF_WRAP_MIRROR );
    assert_true( t->refs[RF_TEXTURE_BASE].nearest );
    gltf_assert_near( t->normal_scale, 0.25 );
    // upper right of the picture: (0, 128, 0) of 255; roughness G, metal B, both linear
    RfMaterial m = at( &scene, 0.1f, 0.8f );
    gltf_assert_near( m.alpha, 128.0 / 255.0 * 128.0 / 255.0 );
    gltf_assert_rgb( m.diffuse, 0, 0.5 * 0.21586050, 0 );
    gltf_assert_rgb( m.specular, 0.04, 0.04, 0.04 );
    // lower left: (0, 0, 64)
    m = at( &scene, 0.1f, 0.1f );
    double metal = 0.5 * 64.0 / 255.0, blue = 0.051269457;
    gltf_assert_rgb( m.diffuse, 0, 0, ( 1 - metal ) * blue );
    gltf_assert_rgb( m.specular, ( 1 - metal ) * 0.04, ( 1 - metal ) * 0.04, ( 1 - metal ) * 0.04 + metal * blue );
    gltf_assert_near( m.alpha, RF_MIN_ALPHA );
    gltf_assert_rgb( rf_emission_at( &scene, scene.materials, 0, 0.1f, 0.1f ), 0, 0, blue );
    assert_string_equal( gltf_warnings, "" );
    rf_destroy_scene( &scene );
}

// An image that is read is taken before the texture's own, one that is not is named.
TEST( test_other_images )
{
    static const uint8_t s_other[] = { 9, 9, 9, 255 };
    static const struct
    {
        const char *extension, *warning;
        bool taken;
    } s_cases[] = {
        { "EXT_texture_exr", "", true },
#ifdef REFRAME_WEBP
        { "EXT_texture_webp", "", true },
#else
        { "EXT_texture_webp", "EXT_texture_webp is not supported yet: texture 'textures[0]': its other image is used", false },
#endif
        { "KHR_texture_basisu", "KHR_texture_basisu is not supported yet: texture 'textures[0]': its other image is used",
          false },
        { "EXT_texture_avif", "EXT_texture_avif is not supported yet: texture 'textures[0]': its other image is used", false },
        { "MSFT_texture_dds", "MSFT_texture_dds is not supported yet: texture 'textures[0]': its other image is used", false },
    };
    for ( size_t i = 0; i < sizeof s_cases / sizeof s_cases[0]; ++i )
    {
        size_t size;
        GltfBuilder b = make_square();
        uint8_t* bytes = encode_png( 1, 1, 4, s_other, &size );
#ifdef REFRAME_WEBP
        if ( strcmp( s_cases[i].extension, "EXT_texture_webp" ) == 0 )
        {
            free( bytes );
            bytes = encode_webp( 1, 1, 4, false, s_other, &size );
        }
#endif
        add_gltf_accessor( &b, 5121, "SCALAR", (int)size, bytes, size, "" );
        free( bytes );
        char rest[1024];
        snprintf( rest, sizeof rest,
                  NODES ",\"images\":[{\"bufferView\":5},{\"bufferView\":6}],\"textures\":[{\"source\":0,\"extensions\":{\"%s\":"
                        "{\"source\":1}}}],\"materials\":[{\"emissiveTexture\":{\"index\":0}}],\"extensionsUsed\":[\"%s\"]",
                  s_cases[i].extension, s_cases[i].extension );
        RfScene scene = gltf_load_built( &b, rest );
        assert_int_equal( scene.texture_count, 1 );
        assert_int_equal( scene.textures[0].width, s_cases[i].taken ? 1 : 2 );
        assert_int_equal( scene.textures[0].bytes[0], s_cases[i].taken ? 9 : 255 );
        if ( s_cases[i].warning[0] == 0 )
            assert_string_equal( gltf_warnings, "" );
        else
            gltf_assert_warned( s_cases[i].warning );
        rf_destroy_scene( &scene );
    }
}

// Specular colour in RGB, sRGB, and glossiness in A.
TEST( test_glossiness_textures )
{
    GltfBuilder b = make_square();
    RfScene scene = gltf_load_built(
        &b, NODES IMAGE
        ",\"samplers\":[{\"magFilter\":9728}],\"textures\":[{\"source\":0,\"sampler\":0}],\"materials\":[{\"extensions\":{"
        "\"KHR_materials_pbrSpecularGlossiness\":{\"specularFactor\":[1,0.5,0.25],\"glossinessFactor\":0.8,"
        "\"diffuseTexture\":{\"index\":0},\"specularGlossinessTexture\":{\"index\":0}}}}]" );
    RfMaterial m = at( &scene, 0.8f, 0.1f ); // (200, 200, 200, 51)
    double grey = 0.57758044, roughness = 1.0 - 0.8 * 51.0 / 255.0;
    gltf_assert_rgb( m.specular, grey, 0.5 * grey, 0.25 * grey );
    gltf_assert_rgb( m.diffuse, grey, grey, grey );
    gltf_assert_near( m.alpha, roughness * roughness );
    assert_true( rf_roughness_varies( scene.materials ) && rf_may_throw_caustics( scene.materials ) );
    assert_string_equal( gltf_warnings, "" );
    rf_destroy_scene( &scene );
}

// What a material would be by its factors alone is what comes out of white textures.
TEST( test_white_textures_equal_factors )
{
    uint8_t white[4] = { 255, 255, 255, 255 };
    size_t size;
    uint8_t* png = encode_png( 1, 1, 4, white, &size );
    GltfBuilder b = make_square();
    int view = add_gltf_accessor( &b, 5121, "SCALAR", (int)size, png, size, "" );
    free( png );
    char rest[2048];
    snprintf(
        rest, sizeof rest,
        NODES
        ",\"images\":[{\"bufferView\":%d}],\"textures\":[{\"source\":0}],\"materials\":[{\"pbrMetallicRoughness\":"
        "{\"baseColorFactor\":[0.3,0.7,0.9,1],\"metallicFactor\":0.3,\"roughnessFactor\":0.37,\"baseColorTexture\":{\"index\":0},"
        "\"metallicRoughnessTexture\":{\"index\":0}},\"extensions\":{\"KHR_materials_specular\":{\"specularFactor\":0.6,"
        "\"specularColorFactor\":[1,0.5,0.2],\"specularTexture\":{\"index\":0},\"specularColorTexture\":{\"index\":0}}}}]",
        view );
    RfScene scene = gltf_load_built( &b, rest );
    RfMaterial m = at( &scene, 0.3f, 0.3f );
    assert_memory_equal( &m, scene.materials, sizeof m );
    rf_destroy_scene( &scene );
}

// What is no metal throws no caustics, however its roughness varies: its gloss may be smooth.
TEST( test_metals_of_varied_roughness )
{
    for ( int metallic = 0; metallic < 2; ++metallic )
    {
        GltfBuilder b = make_square();
        char rest[1024];
        snprintf( rest, sizeof rest,
                  NODES TEXTURE ",\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":%d,"
                                "\"metallicRoughnessTexture\":{\"index\":0}}}]",
                  metallic );
        RfScene scene = gltf_load_built( &b, rest );
        assert_true( rf_may_be_smooth( scene.materials ) );
        assert_int_equal( rf_may_throw_caustics( scene.materials ), metallic );
        rf_destroy_scene( &scene );
    }
}

TEST( test_transforms_and_second_coordinates )
{
    GltfBuilder b = make_square();
    RfScene scene = gltf_load_built(
        &b, NODES TEXTURE
        ",\"extensionsRequired\":[\"KHR_texture_transform\"],\"materials\":["
        "{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0,\"texCoord\":1}},\"emissiveTexture\":{\"index\":0,"
        "\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0,1],\"rotation\":1.57079632679,\"scale\":[0.5,0.5],\"texCoord\":"
        "1}}}}]" );
    const RfTextured* t = scene.materials[0].textured;
    assert_int_equal( t->refs[RF_TEXTURE_BASE].uv_set, 1 );
    assert_int_equal( t->refs[RF_TEXTURE_EMISSIVE].uv_set, 1 );
    // the extension's example: the lower left quarter of the image, turned
    float uv[2] = { 0.2f, 0.6f }, out[2];
    rf_transform_uv( t->refs + RF_TEXTURE_EMISSIVE, uv, out );
    gltf_assert_near( out[0], 0.3 );
    gltf_assert_near( out[1], 0.9 );
    gltf_assert_near( scene.triangles.uvs1[2 * scene.triangles.indices[2]], 0.25 );
    // all of the second set lies in the first texel: (255, 0, 0), linear filter to the left of its middle wraps
    RfTextureRef clamp = t->refs[RF_TEXTURE_BASE];
    clamp.wrap[0] = clamp.wrap[1] = RF_WRAP_CLAMP;
    scene.materials[0].textured->refs[RF_TEXTURE_BASE] = clamp;
    gltf_assert_rgb( at( &scene, 0.3f, 0.4f ).specular, 1, 0, 0 );
    rf_destroy_scene( &scene );
}

// VEC3 of normalized shorts and VEC4 of floats; primitives without keep theirs.
TEST( test_vertex_colours_multiply_in )
{
    static const uint16_t s_shorts[] = { 65535, 0, 0, 0, 0, 65535, 0, 0, 13107, 0, 0, 65535, 0, 0, 65535, 0 };
    static const float s_floats[] = { 2, -1, 0.5f, 0.25f, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1 };
    GltfBuilder b = make_square();
    add_gltf_accessor( &b, 5123, "VEC4", 4, s_shorts, sizeof s_shorts, ",\"normalized\":true" ); // 6
    add_gltf_floats( &b, "VEC4", 4, 4, s_floats );                                               // 7
    RfScene scene = gltf_load_built(
        &b, "\"nodes\":[{\"mesh\":0}],\"materials\":[{\"pbrMetallicRoughness\":{\"metallicFactor\":0,"
            "\"baseColorFactor\":[1,1,0.5,1]}}],\"meshes\":[{\"primitives\":["
            "{\"attributes\":{\"POSITION\":0,\"COLOR_0\":6},\"indices\":3,\"material\":0},{\"attributes\":{\"POSITION\":0},"
            "\"indices\":3,\"material\":0},"
            "{\"attributes\":{\"POSITION\":0,\"COLOR_0\":7},\"indices\":3},{\"attributes\":{\"POSITION\":0},\"indices\":3}]}]" );
    const RfTriangles* t = &scene.triangles;
    assert_non_null( t->colors );
    assert_non_null( scene.materials[0].textured );
    gltf_assert_rgb( at( &scene, 0.0f, 0.0f ).diffuse, 1, 0, 0 );
    gltf_assert_rgb( at( &scene, 0.0f, 1.0f ).diffuse, 0.2, 0, 0 );
    RfMaterial m;
    rf_material_at( &scene, scene.materials, 2, 0.2f, 0.2f, &m ); // of the primitive without
    gltf_assert_rgb( m.diffuse, 1, 1, 0.5 );
    const float* clamped = t->colors + 4 * (size_t)t->indices[12];
    gltf_assert_three( clamped, 1, 0, 0.5 );
    gltf_assert_near( clamped[3], 0.25 );
    rf_destroy_scene( &scene );
}

TEST( test_alpha_modes_are_read )
{
    GltfBuilder b = make_square();
    RfScene scene = gltf_load_built(
        &b, NODES TEXTURE ",\"materials\":[{\"name\":\"leaf\",\"alphaMode\":\"MASK\",\"alphaCutoff\":0.4,"
                          "\"pbrMetallicRoughness\":{\"baseColorFactor\":[1,1,1,0.5],\"baseColorTexture\":{\"index\":0}}}]" );
    const RfMaterial* m = scene.materials;
    assert_true( rf_is_masked( m ) );
    assert_true( rf_opacity_at( &scene, m, 0, 0.1f, 0.8f ) == 1.0f );  // (0.9, 0.2)
    assert_true( rf_opacity_at( &scene, m, 0, 0.5f, 0.25f ) == 0.0f ); // the lower right texel, alpha 0.2
    assert_string_equal( gltf_warnings, "" );
    rf_destroy_scene( &scene );

    scene = gltf_load_built( &b, NODES ",\"materials\":[{\"name\":\"ghost\",\"alphaMode\":\"BLEND\",\"pbrMetallicRoughness\":"
                                       "{\"baseColorFactor\":[1,1,1,0.3]}}]" );
    assert_string_equal( gltf_warnings, "" );
    assert_true( rf_is_blended( scene.materials ) && !rf_is_masked( scene.materials ) );
    assert_true( fabsf( rf_opacity_at( &scene, scene.materials, 0, 0.2f, 0.5f ) - 0.3f ) < 1e-6f );
    rf_destroy_scene( &scene );
    scene = gltf_load_built( &b, NODES ",\"materials\":[{\"alphaMode\":\"BLEND\"}]" ); // nothing to blend
    assert_null( scene.materials[0].textured );
    rf_destroy_scene( &scene );

    // nothing to cut: nothing is looked up
    scene = gltf_load_built( &b, NODES ",\"materials\":[{\"alphaMode\":\"MASK\"}]" );
    assert_null( scene.materials[0].textured );
    rf_destroy_scene( &scene );
}

// Tangents go with their node; a mirror changes the side of the bitangent.
TEST( test_tangents_follow_their_node )
{
    static const float s_tangents[] = { 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, 1 };
    GltfBuilder b = make_square();
    int tangents = add_gltf_floats( &b, "VEC4", 4, 4, s_tangents );
    for ( int mirrored = 0; mirrored < 2; ++mirrored )
    {
        char rest[1024];
        snprintf( rest, sizeof rest,
                  "\"nodes\":[{\"mesh\":0,\"rotation\":[0,0,0.7071067811865476,0.7071067811865476],\"scale\":[2,%d,1]}],"
                  "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,\"NORMAL\":4,\"TANGENT\":%d},\"indices\":3}]}]",
                  mirrored ? -1 : 1, tangents );
        RfScene scene = gltf_load_built( &b, rest );
        gltf_assert_three( scene.triangles.tangents, 0, 1, 0 );
        gltf_assert_near( scene.triangles.tangents[3], mirrored ? -1 : 1 );
        rf_destroy_scene( &scene );
    }
}

TEST( test_where_images_come_from )
{
    size_t size;
    uint8_t* png = encode_png( 2, 2, 4, s_pixels, &size );
    char* base64 = gltf_base64( png, size );
    static char rest[8192];
    snprintf( rest, sizeof rest,
              NODES ",\"images\":[{\"uri\":\"data:image/"
                    "png;base64,%s\"},{\"uri\":\"nowhere.png\"}],\"textures\":[{\"source\":0},{\"source\":1}],"
                    "\"materials\":[{\"emissiveTexture\":{\"index\":0}},{\"emissiveTexture\":{\"index\":1}}]",
              base64 );
    GltfBuilder b = make_square();
    RfScene scene = gltf_load_built( &b, rest ); // the second material is not used, nor is its image
    assert_int_equal( scene.texture_count, 1 );
    assert_memory_equal( scene.textures[0].bytes, s_pixels, sizeof s_pixels );
    rf_destroy_scene( &scene );

    // beside the file; its bytes are part of the scene's
    const char* external = NODES
        ",\"images\":[{\"uri\":\"b%20c.bin\"}],\"textures\":[{\"source\":0}],\"materials\":[{\"emissiveTexture\":{\"index\":0}}]";
    write_bytes( &gltf_folder, "b c.bin", png, size );
    scene = gltf_load_built( &b, external );
    uint64_t hash = scene.content_hash;
    assert_memory_equal( scene.textures[0].bytes, s_pixels, sizeof s_pixels );
    rf_destroy_scene( &scene );
    free( png );
    uint8_t other[4] = { 1, 2, 3, 4 };
    png = encode_png( 1, 1, 4, other, &size );
    write_bytes( &gltf_folder, "b c.bin", png, size );
    scene = gltf_load_built( &b, external );
    assert_true( scene.content_hash != hash );
    rf_destroy_scene( &scene );
    free( png );
    free( base64 );

    // elsewhere, as projects lie on disks: out of the folder, by backslashes, by a link
    char link[128];
    snprintf( link, sizeof link, "%s", folder_file( &gltf_folder, "a.bin" ) );
    assert_int_equal( symlink( folder_file( &gltf_folder, "b c.bin" ), link ), 0 );
    const char* folder = strrchr( gltf_folder.path, '/' ) + 1;
    for ( int i = 0; i < 3; ++i )
    {
        static const char* const s_uris[] = { "../%s/b%%20c.bin", "..\\\\%s%%5Cb c.bin", "../%s/a.bin" };
        char uri[200];
        snprintf( uri, sizeof uri, s_uris[i], folder );
        snprintf( rest, sizeof rest,
                  NODES ",\"images\":[{\"uri\":\"%s\"}],\"textures\":[{\"source\":0}],\"materials\":[{\"emissiveTexture\":{"
                        "\"index\":0}}]",
                  uri );
        scene = gltf_load_built( &b, rest );
        assert_memory_equal( scene.textures[0].bytes, other, sizeof other );
        rf_destroy_scene( &scene );
    }
}

// All are told at once, and may be left out: without its texture nothing shines.
TEST( test_images_that_cannot_be_read )
{
    GltfBuilder b = make_square();
    const char* rest =
        NODES ",\"images\":[{\"uri\":\"absent.png\"},{\"bufferView\":0},{\"bufferView\":5}],\"textures\":[{\"source\":0},{"
              "\"source\":1},"
              "{\"source\":2}],\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0},"
              "\"metallicRoughnessTexture\":{"
              "\"index\":0}},\"normalTexture\":{\"index\":2},\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":1}}]";
    RfScene scene;
    RfError error = { 0 };
    const char* path = write_gltf( &b, &gltf_folder, rest );
    assert_int_not_equal( rf_load_gltf( path, &scene, NULL, &error ), RF_OK );
    assert_int_equal( error.remedy, RF_REMEDY_ACCEPT_LOSSES );
    const char* first = strstr( error.text, "a.gltf: 2 textures cannot be read: images[0]: " );
    if ( first == NULL || strstr( first, "absent.png: cannot be opened: No such file" ) == NULL ||
         strstr( first, "; images[1]: not a PNG" ) == NULL )
        fail_msg( "%s", error.text );
    scene = gltf_load_with( path, &( RfGltfOptions ){ .accept_losses = true } );
    const RfMaterial* m = scene.materials + scene.triangles.material[0];
    assert_true( scene.loss_count == 2 && scene.texture_count == 1 &&
                 strncmp( scene.losses[1], "images[1]: not a PNG", 20 ) == 0 );
    assert_true( m->textured->refs[RF_TEXTURE_BASE].texture == -1 && m->textured->refs[RF_TEXTURE_NORMAL].texture == 0 );
    assert_true( m->emission.x == 0.0f && strstr( gltf_warnings, "images[1]: not a PNG" ) != NULL );
    rf_destroy_scene( &scene );
}

// 16 bits become floats, by the curve where they are colour.
TEST( test_deep_images_become_floats )
{
    uint16_t pixels[] = { 32768, 65535, 0 };
    size_t size;
    uint8_t* png = encode_png16( 1, 1, 3, pixels, &size );
    GltfBuilder b = make_square();
    int view = add_gltf_accessor( &b, 5121, "SCALAR", (int)size, png, size, "" );
    free( png );
    char rest[1024];
    snprintf( rest, sizeof rest,
              NODES
              ",\"images\":[{\"bufferView\":%d}],\"textures\":[{\"source\":0}],\"materials\":[{\"emissiveTexture\":{\"index\":0},"
              "\"normalTexture\":{\"index\":0}}]",
              view );
    RfScene scene = gltf_load_built( &b, rest );
    const RfTextured* t = scene.materials[0].textured;
    gltf_assert_near( scene.textures[t->refs[RF_TEXTURE_EMISSIVE].texture].floats[0],
                      (double)rf_srgb_to_linear( 32768.0f / 65535.0f ) );
    gltf_assert_near( scene.textures[t->refs[RF_TEXTURE_NORMAL].texture].floats[0], 32768.0 / 65535.0 );
    rf_destroy_scene( &scene );
}

typedef struct Fault
{
    RfResult code;
    const char* text; // in the error line
    const char* json; // after NODES
} Fault;

#define USE "\"materials\":[{\"emissiveTexture\":{\"index\":0}}]"

TEST( test_faults_are_one_line )
{
    static const Fault s_faults[] = {
        { RF_ERROR_FORMAT, "materials[0].emissiveTexture: index", ",\"materials\":[{\"emissiveTexture\":{}}]" },
        { RF_ERROR_FORMAT, "materials[0]: emissiveTexture must be", ",\"materials\":[{\"emissiveTexture\":3}]" },
        { RF_ERROR_FORMAT, "there are 1 textures", TEXTURE ",\"materials\":[{\"emissiveTexture\":{\"index\":1}}]" },
        { RF_ERROR_UNSUPPORTED, "texCoord is 2", TEXTURE ",\"materials\":[{\"emissiveTexture\":{\"index\":0,\"texCoord\":2}}]" },
        { RF_ERROR_FORMAT, "texCoord", TEXTURE ",\"materials\":[{\"emissiveTexture\":{\"index\":0,\"texCoord\":-1}}]" },
        { RF_ERROR_FORMAT, "KHR_texture_transform: scale",
          TEXTURE
          ",\"materials\":[{\"emissiveTexture\":{\"index\":0,\"extensions\":{\"KHR_texture_transform\":{\"scale\":[1]}}}}]" },
        { RF_ERROR_UNSUPPORTED, "KHR_texture_transform: offset is 1e+30, beyond what reframe reads: at most 1e+06",
          TEXTURE ",\"materials\":[{\"emissiveTexture\":{\"index\":0,\"extensions\":{\"KHR_texture_transform\":{\"offset\":[1e30,"
                  "0]}}}}]" },
        { RF_ERROR_FORMAT, "normalTexture: scale",
          TEXTURE ",\"materials\":[{\"normalTexture\":{\"index\":0,\"scale\":\"much\"}}]" },
        { RF_ERROR_FORMAT, "pbrMetallicRoughness.baseColorTexture: index",
          ",\"materials\":[{\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}}]" },
        { RF_ERROR_FORMAT, "KHR_materials_specular.specularTexture: index",
          ",\"materials\":[{\"extensions\":{\"KHR_materials_specular\":{\"specularTexture\":{\"index\":0}}}}]" },
        { RF_ERROR_UNSUPPORTED, "textures[0]: has no source",
          IMAGE ",\"textures\":[{\"extensions\":{\"X\":{\"source\":0}}}]," USE },
        { RF_ERROR_UNSUPPORTED,
          "textures[0]: KTX2 images are not supported: convert them by `npx @gltf-transform/cli ktxdecompress",
          IMAGE ",\"textures\":[{\"extensions\":{\"KHR_texture_basisu\":{\"source\":0}}}]," USE },
        { RF_ERROR_UNSUPPORTED, "textures[0]: AVIF images",
          IMAGE ",\"textures\":[{\"extensions\":{\"EXT_texture_avif\":{\"source\":0}}}]," USE },
        { RF_ERROR_UNSUPPORTED, "extensionsRequired: MSFT_texture_dds: DDS images are not supported",
          IMAGE ",\"extensionsRequired\":[\"MSFT_texture_dds\"],\"textures\":[{\"extensions\":{\"MSFT_texture_dds\":{\"source\":"
                "0}}}]," USE },
        { RF_ERROR_FORMAT, "textures[0]: source is 7", IMAGE ",\"textures\":[{\"source\":7}]," USE },
        { RF_ERROR_FORMAT, "textures[0]: sampler", IMAGE ",\"textures\":[{\"source\":0,\"sampler\":0}]," USE },
        { RF_ERROR_FORMAT, "samplers[0]: wrapS is 1",
          IMAGE ",\"samplers\":[{\"wrapS\":1}],\"textures\":[{\"source\":0,\"sampler\":0}]," USE },
        { RF_ERROR_FORMAT, "samplers[0]: wrapT must be",
          IMAGE ",\"samplers\":[{\"wrapT\":\"repeat\"}],\"textures\":[{\"source\":0,\"sampler\":0}]," USE },
        { RF_ERROR_FORMAT, "samplers[0]: magFilter is 9987",
          IMAGE ",\"samplers\":[{\"magFilter\":9987}],\"textures\":[{\"source\":0,\"sampler\":0}]," USE },
        { RF_ERROR_FORMAT, "images[0]: must have either", ",\"images\":[{}],\"textures\":[{\"source\":0}]," USE },
        { RF_ERROR_FORMAT, "images[0]: must have either",
          ",\"images\":[{\"bufferView\":5,\"uri\":\"a.png\"}],\"textures\":[{\"source\":0}]," USE },
        { RF_ERROR_FORMAT, "images[0]: bufferView", ",\"images\":[{\"bufferView\":50}],\"textures\":[{\"source\":0}]," USE },
        { RF_ERROR_FORMAT, "images[0]: not a PNG", ",\"images\":[{\"bufferView\":0}],\"textures\":[{\"source\":0}]," USE },
        { RF_ERROR_UNSUPPORTED, "images[0]: uri '\\etc\\a.png' begins with '/'",
          ",\"images\":[{\"uri\":\"\\\\etc\\\\a.png\"}],\"textures\":[{\"source\":0}]," USE },
        { RF_ERROR_UNSUPPORTED, "images[0]: uri '%5Cetc/a.png' begins with '/'",
          ",\"images\":[{\"uri\":\"%5Cetc/a.png\"}],\"textures\":[{\"source\":0}]," USE },
        { RF_ERROR_IO, "absent.png", ",\"images\":[{\"uri\":\"absent.png\"}],\"textures\":[{\"source\":0}]," USE },
        { RF_ERROR_UNSUPPORTED, "images[0]: uri 'https://a.org/b.png' is not fetched: download it",
          ",\"images\":[{\"uri\":\"https://a.org/b.png\"}],\"textures\":[{\"source\":0}]," USE },
        { RF_ERROR_FORMAT, "images[0]: uri has",
          ",\"images\":[{\"uri\":\"data:image/png;base64,a?\"}],\"textures\":[{\"source\":0}]," USE },
#ifdef REFRAME_WEBP
        { RF_ERROR_FORMAT, "textures[0].extensions.EXT_texture_webp: source is 1",
          IMAGE ",\"textures\":[{\"extensions\":{\"EXT_texture_webp\":{\"source\":1}}}]," USE },
        { RF_ERROR_FORMAT, "images[0]: damaged WebP data",
          ",\"images\":[{\"uri\":\"data:image/webp;base64,UklGRgAAAABXRUJQ\"}],\"textures\":[{\"source\":0}]," USE },
#else
        { RF_ERROR_UNSUPPORTED, "textures[0]: this Reframe was built without libwebp",
          IMAGE ",\"textures\":[{\"extensions\":{\"EXT_texture_webp\":{\"source\":0}}}]," USE },
        { RF_ERROR_UNSUPPORTED, "extensionsRequired: EXT_texture_webp: this Reframe was built without libwebp",
          IMAGE ",\"extensionsRequired\":[\"EXT_texture_webp\"],\"textures\":[{\"extensions\":{\"EXT_texture_webp\":{\"source\":"
                "0}}}]," USE },
#endif
        { RF_ERROR_FORMAT, "alphaMode", ",\"materials\":[{\"alphaMode\":\"GLOW\"}]" },
        { RF_ERROR_FORMAT, "alphaCutoff is -1", ",\"materials\":[{\"alphaMode\":\"MASK\",\"alphaCutoff\":-1}]" },
    };
    for ( size_t i = 0; i < sizeof s_faults / sizeof s_faults[0]; ++i )
    {
        GltfBuilder b = make_square();
        static char rest[4096];
        snprintf( rest, sizeof rest, "%s%s", NODES, s_faults[i].json );
        RfScene scene;
        RfError error = { 0 };
        RfResult result = rf_load_gltf( write_gltf( &b, &gltf_folder, rest ), &scene, NULL, &error );
        if ( result != s_faults[i].code || strstr( error.text, s_faults[i].text ) == NULL ||
             strstr( error.text, "a.gltf" ) == NULL )
            fail_msg( "got %s '%s', wanted %s '%s'", rf_result_name( result ), error.text, rf_result_name( s_faults[i].code ),
                      s_faults[i].text );
        assert_null( scene.textures );
    }
}

TEST( test_faults_of_vertices )
{
    static const char* const s_attributes[] = { "\"COLOR_0\":1", "\"COLOR_0\":6", "\"TEXCOORD_1\":0",
                                                "\"NORMAL\":4,\"TANGENT\":0" };
    static const char* const s_texts[] = { "COLOR_0 must be 3 or 4", "COLOR_0 must be 3 or 4", "2 are needed", "4 are needed" };
    static const uint8_t s_bytes[16] = { 0 };
    for ( int i = 0; i < 4; ++i )
    {
        GltfBuilder b = make_square();
        add_gltf_accessor( &b, 5121, "VEC4", 4, s_bytes, sizeof s_bytes, "" ); // 6: not normalized
        char rest[512];
        snprintf( rest, sizeof rest,
                  "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0,%s},\"indices\":3}]}]",
                  s_attributes[i] );
        RfScene scene;
        RfError error = { 0 };
        assert_int_equal( rf_load_gltf( write_gltf( &b, &gltf_folder, rest ), &scene, NULL, &error ), RF_ERROR_FORMAT );
        if ( strstr( error.text, s_texts[i] ) == NULL )
            fail_msg( "%s", error.text );
    }
}

// Pixels of floats: none that is no number, none so bright that its square is no float.
TEST( test_wild_floats_are_bounded )
{
    static const struct
    {
        float value;
        RfResult code;
        const char* material;
        const char* text;
    } s_cases[] = {
        { NAN, RF_ERROR_SCENE, "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}}",
          "images[0]: pixel (1, 0) is not finite: repair the image" },
        { INFINITY, RF_ERROR_SCENE, "\"normalTexture\":{\"index\":0}", "is not finite" },
        { 3e38f, RF_ERROR_UNSUPPORTED, "\"emissiveFactor\":[0,1,0],\"emissiveTexture\":{\"index\":0}",
          "materials[0]: emission with its texture is 3e+38, beyond what reframe reads: at most 1e+15" },
        { 1e10f, RF_ERROR_UNSUPPORTED,
          "\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":0},\"extensions\":{\"KHR_materials_emissive_strength\":{"
          "\"emissiveStrength\":1e6}}",
          "emission with its texture is 1e+16" },
        { 3e38f, RF_ERROR_UNSUPPORTED,
          "\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":0}},\"extensions\":{\"KHR_materials_unlit\":{}}",
          "emission with its texture is 3e+38" },
        { 1e14f, RF_OK, "\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":0}", "" },
        { 3e38f, RF_OK, "\"emissiveTexture\":{\"index\":0}", "" }, // times the factor's default, black
        { -1.0f, RF_OK, "\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":0}", "" },
    };
    for ( size_t i = 0; i < sizeof s_cases / sizeof s_cases[0]; ++i )
    {
        float pixels[12] = { 0, 0, 0, 0, s_cases[i].value };
        size_t size;
        uint8_t* exr = encode_exr( 2, 2, pixels, &size );
        write_bytes( &gltf_folder, "wild.exr", exr, size );
        free( exr );
        GltfBuilder b = make_square();
        char rest[1024];
        snprintf( rest, sizeof rest,
                  NODES ",\"images\":[{\"uri\":\"wild.exr\"}],\"textures\":[{\"source\":0}],\"materials\":[{%s}]",
                  s_cases[i].material );
        RfScene scene;
        RfError error = { 0 };
        assert_int_equal( rf_load_gltf( write_gltf( &b, &gltf_folder, rest ), &scene, NULL, &error ), s_cases[i].code );
        if ( s_cases[i].code == RF_OK )
            rf_destroy_scene( &scene );
        else if ( strstr( error.text, s_cases[i].text ) == NULL || strstr( error.text, "not valid glTF" ) != NULL )
            fail_msg( "%s", error.text );
    }
}

// Broken files that are full of textures: an error line or a scene.
TEST( test_mutations_never_crash )
{
    GltfBuilder b = make_square();
    size_t size;
    uint8_t* glb =
        build_glb( &b,
                   NODES IMAGE ",\"samplers\":[{\"magFilter\":9728,\"wrapS\":33071}],\"textures\":[{\"source\":0,\"sampler\":0}],"
                               "\"materials\":[{\"alphaMode\":\"MASK\",\"pbrMetallicRoughness\":{\"baseColorTexture\":{\"index\":"
                               "0,\"texCoord\":1},\"metallicRoughnessTexture\":"
                               "{\"index\":0,\"extensions\":{\"KHR_texture_transform\":{\"offset\":[0,1],\"rotation\":1.5,"
                               "\"scale\":[2,2]}}}},\"normalTexture\":{\"index\":0}}]",
                   &size );
    for ( uint64_t n = 0; n < 300; ++n )
    {
        uint8_t* copy = malloc( size );
        memcpy( copy, glb, size );
        size_t length = mutate_bytes( copy, size, n );
        RfScene scene;
        RfError error = { 0 };
        if ( rf_load_gltf( write_bytes( &gltf_folder, "a.glb", copy, length ), &scene, NULL, &error ) == RF_OK )
        {
            RfMaterial m;
            for ( uint32_t t = 0; t < scene.triangles.count; ++t )
            {
                const RfMaterial* material = scene.materials + scene.triangles.material[t];
                if ( material->textured != NULL )
                    rf_material_at( &scene, material, t, 0.3f, 0.3f, &m );
            }
            rf_destroy_scene( &scene );
        }
        else
            assert_true( error.text[0] != 0 );
        free( copy );
    }
    free( glb );
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
