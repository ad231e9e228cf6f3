// Textures of glTF's material extensions (transmission, volume, clear coat), and the
// tangents that the reader makes where a file has none: against those of a sphere, and
// where texture coordinates are mirrored.
#include "support/image_files.h"
#include "support/scene_files.h"
#include "support/test.h"

#include "gltf/gltf.h"
#include "scene/leave_out.h"
#include "scene/textured.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const uint8_t s_pixels[] = { 255, 0, 0, 255, 0, 128, 0, 255, 0, 0, 64, 255, 200, 200, 200, 51 };

// Accessors and views: 0 positions of a square, 1 coordinates with (0, 0) at its
// upper left, 2 the same twice as large, 3 indices, 4 normals, 5 a PNG of 2 x 2.
static GltfBuilder make_square( void )
{
    static const float s_square[] = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0 }, s_normals[] = { 0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1 };
    static const float s_uv0[] = { 0, 1, 1, 1, 1, 0, 0, 0 }, s_uv1[] = { 0, 2, 2, 2, 2, 0, 0, 0 };
    static const uint16_t s_indices[] = { 0, 1, 2, 0, 2, 3 };
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

#define MESH( attributes )                                                                                                       \
    "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0" attributes                           \
    "},\"indices\":3,\"material\":0}]}]"
#define IMAGE ",\"images\":[{\"bufferView\":5}],\"samplers\":[{\"magFilter\":9728}],\"textures\":[{\"source\":0,\"sampler\":0}]"
#define ALL_UVS ",\"NORMAL\":4,\"TEXCOORD_0\":1,\"TEXCOORD_1\":2"
#define MATERIAL( json ) MESH( ALL_UVS ) IMAGE ",\"materials\":[{" json "}]"

// The material a tenth away from the lower left, lower right and upper right corner.
static RfMaterial at( const RfScene* scene, int corner )
{
    static const float s_at[3][2] = { { 0.1f, 0.1f }, { 0.8f, 0.1f }, { 0.1f, 0.8f } };
    RfMaterial out;
    assert_non_null( scene->materials[0].textured );
    rf_material_at( scene, scene->materials, 0, s_at[corner][0], s_at[corner][1], &out );
    return out;
}

static RfScene load_material( const char* json )
{
    GltfBuilder b = make_square();
    return gltf_load_built( &b, json );
}

TEST( test_transmission_textures )
{
    RfScene scene = load_material(
        MATERIAL( "\"pbrMetallicRoughness\":{\"metallicFactor\":0,\"roughnessFactor\":0.5},\"extensions\":{"
                  "\"KHR_materials_transmission\":{\"transmissionFactor\":0.5,\"transmissionTexture\":{\"index\":0}}}" ) );
    const double lower_right = 0.5 * 200.0 / 255.0;
    RfMaterial m = at( &scene, 1 );
    assert_true( m.kind == RF_BSDF_GLASS && m.thin );
    gltf_assert_rgb( m.tint, lower_right, lower_right, lower_right );
    gltf_assert_rgb( m.diffuse, 1 - lower_right, 1 - lower_right, 1 - lower_right );
    m = at( &scene, 0 ); // no red in it: paint
    assert_true( m.kind == RF_BSDF_GLASS );
    gltf_assert_rgb( m.tint, 0, 0, 0 );
    gltf_assert_rgb( m.diffuse, 1, 1, 1 );
    gltf_assert_rgb( m.specular, 0, 0, 0 );
    assert_string_equal( gltf_warnings, "" );
    rf_destroy_scene( &scene );

    // turned and on the second coordinates; metal by a texture, though the factor says all is
    scene = load_material(
        MATERIAL( "\"pbrMetallicRoughness\":{\"metallicRoughnessTexture\":{\"index\":0}},\"extensions\":{\"KHR_materials_ior\":{"
                  "\"ior\":1.3},"
                  "\"KHR_materials_transmission\":{\"transmissionFactor\":1,\"transmissionTexture\":{\"index\":0,\"texCoord\":1,"
                  "\"extensions\":{\"KHR_texture_transform\":{\"scale\":[0.5,0.5],\"offset\":[0.5,0]}}}}}" ) );
    m = at( &scene, 0 ); // there its look-up is that of the lower right, and metal is 64 of 255
    double metal = 64.0 / 255.0, through = 200.0 / 255.0;
    gltf_assert_near( m.ior, 1.3 );
    gltf_assert_near( m.tint.x, through * ( 1 - metal ) );
    gltf_assert_near( m.diffuse.y, ( 1 - through ) * ( 1 - metal ) );
    gltf_assert_near( m.specular.z, metal );
    gltf_assert_near( m.f90, metal );
    gltf_assert_near( m.alpha, 0 );
    rf_destroy_scene( &scene );

    // a factor of 0 leaves nothing to look up
    scene =
        load_material( MATERIAL( "\"extensions\":{\"KHR_materials_transmission\":{\"transmissionTexture\":{\"index\":0}}}" ) );
    assert_true( scene.materials[0].kind == RF_BSDF_GGX && scene.texture_count == 0 );
    assert_null( scene.materials[0].textured );
    rf_destroy_scene( &scene );
}

// A coat that is added leaves the model glTF's: textures vary all of it, and base and coat are those of constant factors.
TEST( test_textures_of_added_coats )
{
#define ADDED( more ) MATERIAL( "\"extras\":{\"reframe\":{\"coat\":\"added\"}},\"pbrMetallicRoughness\":{" more "}" )
    RfScene scene = load_material( ADDED( "\"baseColorFactor\":[0.5,0.5,0.5,1],\"baseColorTexture\":{\"index\":0},"
                                          "\"metallicRoughnessTexture\":{\"index\":0}" ) );
    RfMaterial m = at( &scene, 1 ), constant = { 0 };
    assert_int_equal( scene.materials[0].textured->model, RF_TEXTURED_COATED );
    RfFactors factors = scene.materials[0].textured->factors;
    double grey = 0.5 * pow( ( 200.0 / 255.0 + 0.055 ) / 1.055, 2.4 );
    factors.base[0] = factors.base[1] = factors.base[2] = grey;
    factors.roughness = factors.metallic = 200.0 / 255.0;
    rf_derive_lobes( &factors, &constant );
    gltf_assert_near( m.diffuse.x, constant.diffuse.x );
    gltf_assert_near( m.specular.x, constant.specular.x );
    gltf_assert_near( m.alpha, constant.alpha );
    assert_true( m.coat_f0 == 0.0f && m.coat_f90 == 0.0f ); // nothing is taken from so dark a base
    rf_destroy_scene( &scene );
}

// A rough coat loses light between its facets, and leaves so much more to the base that it is added to.
TEST( test_rough_added_coats_leave_more )
{
#define WHITE_COAT( roughness )                                                                                                  \
    MATERIAL( "\"extras\":{\"reframe\":{\"coat\":\"added\"}},\"pbrMetallicRoughness\":{\"baseColorFactor\":[0.5,0.5,0.5,1],"     \
              "\"metallicFactor\":0,\"roughnessFactor\":" roughness                                                              \
              "},\"extensions\":{\"KHR_materials_specular\":{\"specularColorFactor\":[25,25,25]}}" )
    RfScene scene = load_material( WHITE_COAT( "1" ) );
    assert_true( scene.materials[0].specular.x == 1.0f && scene.materials[0].coat_f0 == 0.0f );
    rf_destroy_scene( &scene );
    scene = load_material( WHITE_COAT( "0.1" ) );
    assert_true( scene.materials[0].coat_f0 > 0.9f ); // hardly anything is left
    rf_destroy_scene( &scene );
}

// A body's thickness is that of its mesh: the texture changes nothing.
TEST( test_thickness_textures_change_nothing )
{
    RfScene scene = load_material( MATERIAL( "\"pbrMetallicRoughness\":{\"metallicFactor\":0},\"extensions\":{\"KHR_materials_"
                                             "transmission\":{\"transmissionFactor\":1},"
                                             "\"KHR_materials_volume\":{\"thicknessFactor\":0.1,\"thicknessTexture\":{\"index\":"
                                             "0},\"attenuationDistance\":2,\"attenuationColor\":[0.5,1,1]}}" ) );
    assert_true( scene.materials[0].kind == RF_BSDF_GLASS && !scene.materials[0].thin );
    gltf_assert_near( scene.materials[0].absorption.x, log( 2.0 ) / 2.0 );
    assert_null( scene.materials[0].textured );
    assert_int_equal( scene.texture_count, 0 );
    assert_string_equal( gltf_warnings, "" );
    rf_destroy_scene( &scene );
}

TEST( test_clearcoat_textures )
{
    RfScene scene = load_material( MATERIAL(
        "\"normalTexture\":{\"index\":0},\"extensions\":{\"KHR_materials_clearcoat\":{\"clearcoatFactor\":0.5,"
        "\"clearcoatRoughnessFactor\":0.8,\"clearcoatTexture\":{\"index\":0},\"clearcoatRoughnessTexture\":{\"index\":0},"
        "\"clearcoatNormalTexture\":{\"index\":0,\"texCoord\":1,\"scale\":0.5,\"extensions\":{\"KHR_texture_transform\":{"
        "\"scale\":[0.5,0.5]}}}}}" ) );
    RfMaterial m = at( &scene, 1 );
    assert_int_equal( m.kind, RF_BSDF_COATED );
    gltf_assert_near( m.clearcoat, 0.5 * 200.0 / 255.0 );
    double roughness = 0.8 * 200.0 / 255.0;
    gltf_assert_near( m.clearcoat_alpha, roughness * roughness );
    m = at( &scene, 0 );
    gltf_assert_near( m.clearcoat, 0 );
    gltf_assert_near( m.clearcoat_alpha, RF_MIN_ALPHA );
    // lower right: x, y and z are all 145 of 255; the coat's x and y are half of that
    RfVec3 up = rf_vec3( 0, 0, 1 );
    double lean = 145.0 / 255.0, coat = sqrt( 1.5 ) * lean;
    RfVec3 n = rf_normal_at( &scene, scene.materials, 0, 0.8f, 0.1f, up, up );
    gltf_assert_rgb( n, 1 / sqrt( 3.0 ), 1 / sqrt( 3.0 ), 1 / sqrt( 3.0 ) );
    n = rf_coat_normal_at( &scene, scene.materials, 0, 0.8f, 0.1f, up, up );
    gltf_assert_rgb( n, 0.5 * lean / coat, 0.5 * lean / coat, lean / coat );
    rf_destroy_scene( &scene );

    // bumps below do not turn the normal of a coat without a texture of its own
    scene = load_material(
        MATERIAL( "\"normalTexture\":{\"index\":0},\"extensions\":{\"KHR_materials_clearcoat\":{\"clearcoatFactor\":1}}" ) );
    n = rf_coat_normal_at( &scene, scene.materials, 0, 0.8f, 0.1f, up, up );
    gltf_assert_rgb( n, 0, 0, 1 );
    rf_destroy_scene( &scene );

    // no coat, no textures of it
    scene = load_material( MATERIAL( "\"extensions\":{\"KHR_materials_clearcoat\":{\"clearcoatTexture\":{\"index\":0}}}" ) );
    assert_true( scene.materials[0].kind == RF_BSDF_GGX && scene.texture_count == 0 );
    rf_destroy_scene( &scene );
}

TEST( test_sheen )
{
    RfScene scene = load_material(
        MATERIAL( "\"extensions\":{\"KHR_materials_sheen\":{\"sheenColorFactor\":[1,0.5,0],\"sheenRoughnessFactor\":0.8,"
                  "\"sheenColorTexture\":{\"index\":0},\"sheenRoughnessTexture\":{\"index\":0}}}" ) );
    RfMaterial m = at( &scene, 1 ), other = at( &scene, 0 );
    assert_int_equal( m.kind, RF_BSDF_SHEEN );
    double sheen = pow( ( 200.0 / 255.0 + 0.055 ) / 1.055, 2.4 );
    gltf_assert_rgb( m.sheen, sheen, 0.5 * sheen, 0 );
    gltf_assert_near( m.sheen_alpha, 0.0256 );
    gltf_assert_rgb( other.sheen, 0, 0, 0 );
    gltf_assert_near( other.sheen_alpha, 0.64 );
    rf_destroy_scene( &scene );

    static const struct
    {
        const char* extensions;
        RfBsdfKind kind;
        float alpha;
    } s_cases[] = {
        { "\"KHR_materials_sheen\":{\"sheenColorFactor\":[0,0.5,0]}", RF_BSDF_SHEEN, RF_MIN_SHEEN_ALPHA },
        { "\"KHR_materials_sheen\":{\"sheenColorFactor\":[0,0.5,0],\"sheenRoughnessFactor\":1},"
          "\"KHR_materials_clearcoat\":{\"clearcoatFactor\":1}",
          RF_BSDF_LAYERED, 1.0f },
        { "\"KHR_materials_sheen\":{\"sheenRoughnessFactor\":1,\"sheenColorTexture\":{\"index\":0}}", RF_BSDF_GGX, 1.0f },
        { "\"KHR_materials_sheen\":{\"sheenColorFactor\":[0,0.5,0]},\"KHR_materials_transmission\":{\"transmissionFactor\":1}",
          RF_BSDF_GLASS, RF_MIN_SHEEN_ALPHA },
    };
    for ( size_t i = 0; i < sizeof s_cases / sizeof *s_cases; ++i )
    {
        char rest[2048];
        snprintf( rest, sizeof rest, MATERIAL( "\"pbrMetallicRoughness\":{\"metallicFactor\":0},\"extensions\":{%s}" ),
                  s_cases[i].extensions );
        scene = load_material( rest );
        assert_int_equal( scene.materials[0].kind, s_cases[i].kind );
        gltf_assert_near( scene.materials[0].sheen_alpha, (double)s_cases[i].alpha );
        assert_int_equal( scene.texture_count, 0 );
        if ( s_cases[i].kind == RF_BSDF_GLASS )
            gltf_assert_warned( "sheen over glass is not supported" );
        else
            assert_string_equal( gltf_warnings, "" );
        rf_destroy_scene( &scene );
    }
}

TEST( test_anisotropy_and_films )
{
    RfScene scene = load_material(
        MATERIAL( "\"extensions\":{\"KHR_materials_anisotropy\":{\"anisotropyStrength\":0.5,\"anisotropyRotation\":"
                  "1.5707963267948966,\"anisotropyTexture\":{\"index\":0}},\"KHR_materials_iridescence\":{"
                  "\"iridescenceFactor\":0.5,\"iridescenceIor\":1.7,\"iridescenceThicknessMinimum\":200,"
                  "\"iridescenceThicknessMaximum\":500,\"iridescenceTexture\":{\"index\":0},"
                  "\"iridescenceThicknessTexture\":{\"index\":0}}}" ) );
    RfMaterial m = at( &scene, 1 ), other = at( &scene, 0 );
    double light = 200.0 / 255.0, half = sqrt( 0.5 );
    assert_int_equal( m.kind, RF_BSDF_LAYERED );
    gltf_assert_near( m.anisotropy, 0.5 * light );
    gltf_assert_rgb( rf_vec3( m.stretch_x, m.stretch_y, 0 ), -half, half, 0 ); // (1, 1), turned by a quarter
    gltf_assert_near( m.film, 0.5 * light );
    gltf_assert_near( m.film_ior, 1.7 );
    gltf_assert_near( m.film_thickness, 200.0 + 300.0 * light );
    gltf_assert_near( other.anisotropy, 0.5 * 64.0 / 255.0 );
    gltf_assert_rgb( rf_vec3( other.stretch_x, other.stretch_y, 0 ), half, -half, 0 );
    gltf_assert_near( other.film, 0 );
    gltf_assert_near( other.film_thickness, 200 );
    rf_destroy_scene( &scene );

    static const struct
    {
        const char *metal, *extensions;
        RfBsdfKind kind;
        float thickness;
    } s_cases[] = {
        { "0", "\"KHR_materials_anisotropy\":{\"anisotropyStrength\":1}", RF_BSDF_ANISOTROPIC, 0.0f },
        { "0", "\"KHR_materials_anisotropy\":{\"anisotropyTexture\":{\"index\":0}}", RF_BSDF_GGX, 400.0f },
        { "0", "\"KHR_materials_iridescence\":{\"iridescenceFactor\":1}", RF_BSDF_IRIDESCENT, 400.0f },
        // perfect mirrors without a film
        { "1,\"roughnessFactor\":0", "\"KHR_materials_iridescence\":{}", RF_BSDF_GLASS, 400.0f },
        { "1,\"roughnessFactor\":0", "\"KHR_materials_iridescence\":{\"iridescenceFactor\":1}", RF_BSDF_SPECTRAL, 400.0f },
        { "0,\"roughnessFactor\":0.5",
          "\"KHR_materials_transmission\":{\"transmissionFactor\":1},\"KHR_materials_dispersion\":{\"dispersion\":1}",
          RF_BSDF_GLASS, 400.0f }, // without an inside
        { "0,\"roughnessFactor\":0.5",
          "\"KHR_materials_transmission\":{\"transmissionFactor\":1},\"KHR_materials_volume\":{\"thicknessFactor\":1},"
          "\"KHR_materials_dispersion\":{\"dispersion\":1}",
          RF_BSDF_SPECTRAL, 400.0f },
        { "0", "\"KHR_materials_iridescence\":{\"iridescenceFactor\":1},\"KHR_materials_clearcoat\":{\"clearcoatFactor\":1}",
          RF_BSDF_LAYERED, 400.0f },
    };
    for ( size_t i = 0; i < sizeof s_cases / sizeof *s_cases; ++i )
    {
        char rest[2048];
        snprintf( rest, sizeof rest, MATERIAL( "\"pbrMetallicRoughness\":{\"metallicFactor\":%s},\"extensions\":{%s}" ),
                  s_cases[i].metal, s_cases[i].extensions );
        scene = load_material( rest );
        assert_int_equal( scene.materials[0].kind, s_cases[i].kind );
        gltf_assert_near( scene.materials[0].film_thickness, (double)s_cases[i].thickness );
        assert_true( scene.materials[0].alpha >= RF_MIN_ALPHA || s_cases[i].kind >= RF_BSDF_FIRST_SPECULAR );
        assert_string_equal( gltf_warnings, "" );
        rf_destroy_scene( &scene );
    }
}

// By the coordinates of the texture that u grows along; at right angles to a shading normal that leans; turned by the factor.
TEST( test_directions_of_anisotropy )
{
    RfScene scene = load_material( MATERIAL( "\"extensions\":{\"KHR_materials_anisotropy\":{\"anisotropyStrength\":1}}" ) );
    const RfMaterial* m = scene.materials;
    RfVec3 n = rf_normalize( rf_vec3( 0.3f, 0.2f, 1.0f ) ), up = rf_vec3( 0, 0, 1 );
    RfVec3 along = rf_stretch_at( &scene, m, 0, 0.8f, 0.1f, up ), leaned = rf_stretch_at( &scene, m, 0, 0.8f, 0.1f, n );
    gltf_assert_near( rf_dot( along, along ), 1 );
    assert_true( fabsf( rf_dot( along, up ) ) < 1e-6f && fabsf( rf_dot( leaned, n ) ) < 1e-6f );
    RfMaterial turned = *m;
    turned.stretch_x = 0.0f;
    turned.stretch_y = 1.0f;
    RfVec3 across = rf_stretch_at( &scene, &turned, 0, 0.8f, 0.1f, up );
    gltf_assert_rgb( across, -(double)along.y, along.x, 0 );
    rf_destroy_scene( &scene );

    scene = load_material( MESH( "" ) ",\"materials\":[{\"name\":\"brushed\",\"extensions\":{"
                                      "\"KHR_materials_anisotropy\":{\"anisotropyStrength\":1}}}]" );
    gltf_assert_warned( "neither tangents nor texture coordinates: the anisotropy of material 'brushed'" );
    along = rf_stretch_at( &scene, scene.materials, 0, 0.8f, 0.1f, n );
    assert_true( fabsf( rf_dot( along, n ) ) < 1e-6f && fabsf( rf_dot( along, along ) - 1.0f ) < 1e-6f );
    rf_destroy_scene( &scene );
}

TEST( test_faults_are_one_line )
{
    static const char* const s_faults[][2] = {
        { "KHR_materials_transmission.transmissionTexture: index is missing",
          "\"KHR_materials_transmission\":{\"transmissionTexture\":{}}" },
        { "KHR_materials_volume.thicknessTexture: index is 7", "\"KHR_materials_volume\":{\"thicknessTexture\":{\"index\":7}}" },
        { "KHR_materials_clearcoat.clearcoatTexture: texCoord is 2",
          "\"KHR_materials_clearcoat\":{\"clearcoatTexture\":{\"index\":0,\"texCoord\":2}}" },
        { "clearcoatRoughnessTexture must be an object", "\"KHR_materials_clearcoat\":{\"clearcoatRoughnessTexture\":0}" },
        { "sheenColorFactor is 2, it must be 0 to 1", "\"KHR_materials_sheen\":{\"sheenColorFactor\":[0,0,2]}" },
        { "anisotropyStrength is 2, it must be 0 to 1", "\"KHR_materials_anisotropy\":{\"anisotropyStrength\":2}" },
        { "iridescenceIor is 0.5, it must be 1 to 100", "\"KHR_materials_iridescence\":{\"iridescenceIor\":0.5}" },
        { "iridescenceThicknessMaximum is -1, it must be 0 to 100000",
          "\"KHR_materials_iridescence\":{\"iridescenceThicknessMaximum\":-1}" },
        { "sheenRoughnessTexture must be an object", "\"KHR_materials_sheen\":{\"sheenRoughnessTexture\":0}" },
        { "clearcoatNormalTexture: scale must be",
          "\"KHR_materials_clearcoat\":{\"clearcoatNormalTexture\":{\"index\":0,\"scale\":\"1\"}}" },
    };
    for ( size_t i = 0; i < sizeof s_faults / sizeof s_faults[0]; ++i )
    {
        char rest[2048];
        snprintf( rest, sizeof rest, MATERIAL( "\"extensions\":{%s}" ), s_faults[i][1] );
        GltfBuilder b = make_square();
        RfScene scene;
        RfError error = { 0 };
        RfResult result = rf_load_gltf( write_gltf( &b, &gltf_folder, rest ), &scene, NULL, &error );
        if ( result == RF_OK || strstr( error.text, s_faults[i][0] ) == NULL )
            fail_msg( "'%s' for '%s'", error.text, s_faults[i][0] );
    }
}

#define BUMPS IMAGE ",\"materials\":[{\"normalTexture\":{\"index\":0}}]"

// u' along x and, where the image is turned by a quarter, along y.
TEST( test_tangents_follow_the_transform )
{
    RfScene scene = load_material( MESH( ALL_UVS ) BUMPS );
    for ( uint32_t v = 0; v < 4; ++v )
    {
        gltf_assert_three( scene.triangles.tangents + 4 * v, 1, 0, 0 );
        gltf_assert_near( scene.triangles.tangents[4 * v + 3], 1 );
    }
    assert_int_equal( scene.triangles.vertex_count, 4 );
    rf_destroy_scene( &scene );
    scene = load_material( MESH( ALL_UVS ) IMAGE ",\"materials\":[{\"normalTexture\":{\"index\":0,\"texCoord\":1,\"extensions\":{"
                                                 "\"KHR_texture_transform\":{\"rotation\":1.5707963267948966}}}}]" );
    // u' = v there, which runs down
    gltf_assert_three( scene.triangles.tangents, 0, -1, 0 );
    rf_destroy_scene( &scene );
    // no texture of normals, no normals or no coordinates: none
    scene = load_material( MESH( ALL_UVS ) ",\"materials\":[{}]" );
    assert_null( scene.triangles.tangents );
    rf_destroy_scene( &scene );
    scene = load_material( MESH( ",\"NORMAL\":4" ) BUMPS );
    assert_null( scene.triangles.tangents );
    rf_destroy_scene( &scene );
}

// The picture on the right half mirrors that on the left: the vertices of the
// middle become two, one for each side.
TEST( test_mirrored_coordinates_split_vertices )
{
    static const float s_positions[] = { -1, 0, 0, 0, 0, 0, 1, 0, 0, -1, 1, 0, 0, 1, 0, 1, 1, 0 };
    static const float s_uvs[] = { 0, 1, 1, 1, 0, 1, 0, 0, 1, 0, 0, 0 };
    static const uint16_t s_indices[] = { 0, 1, 4, 0, 4, 3, 1, 2, 5, 1, 5, 4 };
    float normals[18] = { 0 };
    for ( int i = 0; i < 6; ++i )
        normals[3 * i + 2] = 1.0f;
    GltfBuilder b = make_square();
    int p = add_gltf_floats( &b, "VEC3", 3, 6, s_positions ), n = add_gltf_floats( &b, "VEC3", 3, 6, normals );
    int uv = add_gltf_floats( &b, "VEC2", 2, 6, s_uvs ), indices = add_gltf_u16( &b, 12, s_indices );
    char rest[1024];
    snprintf(
        rest, sizeof rest,
        "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d,\"TEXCOORD_0\":%d},"
        "\"indices\":%d,\"material\":0}]}]" BUMPS,
        p, n, uv, indices );
    RfScene scene = gltf_load_built( &b, rest );
    const RfTriangles* t = &scene.triangles;
    assert_int_equal( t->vertex_count, 8 );
    for ( size_t corner = 0; corner < 12; ++corner )
    {
        const uint32_t v = t->indices[corner];
        double side = corner < 6 ? 1 : -1;
        gltf_assert_three( t->tangents + 4 * (size_t)v, side, 0, 0 );
        gltf_assert_near( t->tangents[4 * (size_t)v + 3], side );
        const uint16_t from = s_indices[corner];
        gltf_assert_three( t->positions + 3 * (size_t)v, s_positions[3 * from], s_positions[3 * from + 1], 0 );
        gltf_assert_near( t->uvs[2 * (size_t)v], s_uvs[2 * from] );
    }
    // a bump to the right of the picture leans away from the middle on the right, too
    RfVec3 up = rf_vec3( 0, 0, 1 );
    RfVec3 left = rf_normal_at( &scene, scene.materials, 0, 0.8f, 0.1f, up, up ),
           right = rf_normal_at( &scene, scene.materials, 2, 0.1f, 0.1f, up, up );
    gltf_assert_rgb( left, 1 / sqrt( 3.0 ), 1 / sqrt( 3.0 ), 1 / sqrt( 3.0 ) );
    gltf_assert_rgb( right, -1 / sqrt( 3.0 ), 1 / sqrt( 3.0 ), 1 / sqrt( 3.0 ) );
    rf_destroy_scene( &scene );
}

enum
{
    COLUMNS = 24,
    ROWS = 8,
    GRID = ( COLUMNS + 1 ) * ( ROWS + 1 )
};

typedef struct Ball
{
    float positions[3 * GRID], uvs[2 * GRID];
    uint16_t indices[6 * COLUMNS * ROWS];
} Ball;

// A band of a sphere around y, u once around; positions are the normals. Every
// vertex sees the same to its left and right.
static Ball make_ball( void )
{
    Ball ball;
    for ( int i = 0; i < GRID; ++i )
    {
        double u = (double)( i % ( COLUMNS + 1 ) ) / COLUMNS, v = (double)( i / ( COLUMNS + 1 ) ) / ROWS;
        double a = 2.0 * 3.14159265358979 * ( i % ( COLUMNS + 1 ) == COLUMNS ? 0.0 : u ), up = 1.0 - 2.0 * v;
        ball.positions[3 * i] = (float)( cos( up ) * sin( a ) );
        ball.positions[3 * i + 1] = (float)sin( up );
        ball.positions[3 * i + 2] = (float)( cos( up ) * cos( a ) );
        ball.uvs[2 * i] = (float)u;
        ball.uvs[2 * i + 1] = (float)v;
    }
    for ( int q = 0; q < COLUMNS * ROWS; ++q )
    {
        int row = q / COLUMNS, column = q % COLUMNS, a = row * ( COLUMNS + 1 ) + column, b = a + COLUMNS + 1;
        const int corners[2][6] = { { a, b, b + 1, a, b + 1, a + 1 }, { a, b, a + 1, a + 1, b, b + 1 } };
        for ( int i = 0; i < 6; ++i )
            ball.indices[6 * q + i] = (uint16_t)corners[( row + column ) % 2][i];
    }
    return ball;
}

static double tangent_error( const RfTriangles* t, size_t v )
{
    const float *n = t->normals + 3 * v, *got = t->tangents + 4 * v;
    double length = sqrt( (double)( n[0] * n[0] + n[2] * n[2] ) ), want[3] = { n[2] / length, 0, -n[0] / length };
    gltf_assert_near( got[3], 1 );
    gltf_assert_near( got[0] * got[0] + got[1] * got[1] + got[2] * got[2], 1 );
    assert_true( fabs( (double)( got[0] * n[0] + got[1] * n[1] + got[2] * n[2] ) ) < 1e-6 ); // across the normal
    double dx = got[0] - want[0], dy = got[1] - want[1], dz = got[2] - want[2];
    return sqrt( dx * dx + dy * dy + dz * dz );
}

// On a sphere they run along its circles.
TEST( test_sphere_tangents_run_along_circles )
{
    static Ball ball;
    ball = make_ball();
    GltfBuilder b = make_square();
    int p = add_gltf_floats( &b, "VEC3", 3, GRID, ball.positions ), uv = add_gltf_floats( &b, "VEC2", 2, GRID, ball.uvs );
    int indices = add_gltf_u16( &b, 6 * COLUMNS * ROWS, ball.indices );
    char rest[1024];
    snprintf( rest, sizeof rest,
              "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d,"
              "\"TEXCOORD_0\":%d},\"indices\":%d,\"material\":0}]}]" BUMPS,
              p, p, uv, indices );
    RfScene scene = gltf_load_built( &b, rest );
    assert_int_equal( scene.triangles.vertex_count, GRID );
    double worst = 0.0;
    for ( size_t v = 0; v < GRID; ++v )
    {
        const float* at = scene.triangles.uvs + 2 * v;
        double error = tangent_error( &scene.triangles, v );
        bool inner = at[0] > 0.0f && at[0] < 1.0f && at[1] > 0.0f && at[1] < 1.0f;
        worst = inner && error > worst ? error : worst;
    }
    print_message( "sphere: tangents are at most %.4f off\n", worst );
    assert_true( worst < 2e-6 );
    rf_destroy_scene( &scene );
}

// Corners of the same place that the file lists apart share what they add up to;
// angles weigh.
TEST( test_same_vertices_and_angles )
{
    // two triangles at the origin: 90 degrees wide with u along x, 30 degrees with u along y
    const float c = 0.8660254f;
    float positions[] = { 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, -0.5f, c, 0 };
    // v' runs down: (u, v) = (x, −y), and for the second (y, x)
    float uvs[] = { 0, 0, 1, 0, 0, -1, 0, 0, 1, 0, c, -0.5f };
    float normals[18] = { 0 };
    for ( int i = 0; i < 6; ++i )
        normals[3 * i + 2] = 1.0f;
    positions[9] = -0.0f; // the same as 0
    GltfBuilder b = make_square();
    int p = add_gltf_floats( &b, "VEC3", 3, 6, positions ), n = add_gltf_floats( &b, "VEC3", 3, 6, normals );
    int uv = add_gltf_floats( &b, "VEC2", 2, 6, uvs );
    char rest[1024];
    snprintf(
        rest, sizeof rest,
        "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d,\"TEXCOORD_0\":%d},"
        "\"material\":0}]}]" BUMPS,
        p, n, uv );
    RfScene scene = gltf_load_built( &b, rest );
    const RfTriangles* t = &scene.triangles;
    assert_int_equal( t->vertex_count, 6 );
    double length = sqrt( 3.0 * 3.0 + 1.0 ); // weights of 90 and 30 degrees
    for ( size_t v = 0; v < 6; v += 3 )
    {
        gltf_assert_three( t->tangents + 4 * v, 3 / length, 1 / length, 0 );
        gltf_assert_near( t->tangents[4 * v + 3], 1 );
    }
    gltf_assert_three( t->tangents + 4, 1, 0, 0 );
    gltf_assert_three( t->tangents + 20, 0, 1, 0 );
    rf_destroy_scene( &scene );
}

// A metal that its factors make a mirror is a rough one where a texture says so.
TEST( test_mirror_with_a_roughness_texture )
{
    RfScene scene = load_material(
        MATERIAL( "\"pbrMetallicRoughness\":{\"roughnessFactor\":0.01,\"metallicRoughnessTexture\":{\"index\":0}}" ) );
    assert_int_equal( scene.materials[0].kind, RF_BSDF_GGX );
    gltf_assert_near( at( &scene, 0 ).alpha, RF_MIN_ALPHA );
    rf_destroy_scene( &scene );
    scene = load_material( MATERIAL( "\"pbrMetallicRoughness\":{\"roughnessFactor\":0.01}" ) );
    assert_int_equal( scene.materials[0].kind, RF_BSDF_GLASS );
    rf_destroy_scene( &scene );
}

// Triangles without area on the image take the tangents of others at the same
// vertices; with none there, they do without.
TEST( test_coordinates_without_area )
{
    static const float s_positions[] = { 0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 0, 0, 0, 1, 0, -1, 0, 0, 5, 5, 0, 6, 5, 0, 5, 6, 0 };
    static const float s_uvs[] = { 0, 0, 1, 0, 1, -1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0 };
    float normals[27] = { 0 };
    for ( int i = 0; i < 9; ++i )
        normals[3 * i + 2] = 1.0f;
    GltfBuilder b = make_square();
    int p = add_gltf_floats( &b, "VEC3", 3, 9, s_positions ), n = add_gltf_floats( &b, "VEC3", 3, 9, normals );
    int uv = add_gltf_floats( &b, "VEC2", 2, 9, s_uvs );
    char rest[1024];
    snprintf(
        rest, sizeof rest,
        "\"nodes\":[{\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":%d,\"NORMAL\":%d,\"TEXCOORD_0\":%d},"
        "\"material\":0}]}]" BUMPS,
        p, n, uv );
    RfScene scene = gltf_load_built( &b, rest );
    gltf_assert_three( scene.triangles.tangents + 12, 1, 0, 0 );
    gltf_assert_near( scene.triangles.tangents[15], 1 );
    for ( int i = 16; i < 36; ++i )
        gltf_assert_near( scene.triangles.tangents[i], 0 );
    RfVec3 up = rf_vec3( 0, 0, 1 ), normal = rf_normal_at( &scene, scene.materials, 2, 0.3f, 0.3f, up, up );
    gltf_assert_rgb( normal, 0, 0, 1 );
    rf_destroy_scene( &scene );
}

// Without normals: those of the faces, and tangents along their pictures.
TEST( test_tangents_of_flat_faces )
{
    RfScene scene = load_material( MESH( ",\"TEXCOORD_0\":1,\"TEXCOORD_1\":2" ) BUMPS );
    const RfTriangles* t = &scene.triangles;
    assert_int_equal( t->vertex_count, 6 );
    assert_non_null( t->tangents );
    for ( size_t v = 0; v < 6; ++v )
    {
        gltf_assert_three( t->normals + 3 * v, 0, 0, 1 );
        gltf_assert_three( t->tangents + 4 * v, 1, 0, 0 );
        gltf_assert_near( t->tangents[4 * v + 3], 1 );
    }
    gltf_assert_near( t->uvs[3], 1 );
    gltf_assert_near( t->uvs1[2 * 5 + 1], 0 );
    rf_destroy_scene( &scene );
}

// Floats of an EXR are taken as they are; a material that nothing has needs no image.
TEST( test_float_textures_are_taken_as_they_are )
{
    float rgb[12] = { 0.5f, 0.25f, 4.0f, 0, 0, 0, 0, 0, 0, 0, 0, -1.0f };
    size_t size;
    uint8_t* exr = encode_exr( 2, 2, rgb, &size );
    GltfBuilder b = make_square();
    int view = add_gltf_accessor( &b, 5121, "SCALAR", (int)size, exr, size, "" );
    free( exr );
    char rest[1024];
    snprintf(
        rest, sizeof rest,
        MESH( ALL_UVS ) ",\"images\":[{\"bufferView\":%d},{\"uri\":\"absent.png\"}],\"textures\":[{\"source\":0},{\"source\":1}],"
                        "\"materials\":["
                        "{\"emissiveFactor\":[1,1,1],\"emissiveTexture\":{\"index\":0}},{\"emissiveTexture\":{\"index\":1}}]",
        view );
    RfScene scene = gltf_load_built( &b, rest );
    assert_int_equal( scene.texture_count, 1 );
    gltf_assert_near( scene.textures[0].largest, 4 );
    gltf_assert_near( scene.textures[0].floats[11], 0 );
    assert_null( scene.materials[1].textured );
    rf_destroy_scene( &scene );
}

// Whatever an EXR has: strengths are 0 to 1, thicknesses between those of the file, directions unit vectors.
TEST( test_float_textures_of_layers_are_bounded )
{
    static const float s_values[][3] = { { 8.0f, -3.0f, 5.0f }, { 3e38f, 3e38f, 3e38f }, { -3e38f, 3e38f, -1.0f } };
    for ( int i = 0; i < 3; ++i )
    {
        const float* v = s_values[i];
        float rgb[12] = { v[0], v[1], v[2], v[0], v[1], v[2], v[0], v[1], v[2], v[0], v[1], v[2] };
        size_t size;
        uint8_t* exr = encode_exr( 2, 2, rgb, &size );
        GltfBuilder b = make_square();
        int view = add_gltf_accessor( &b, 5121, "SCALAR", (int)size, exr, size, "" );
        free( exr );
        char rest[2048];
        snprintf(
            rest, sizeof rest,
            MESH( ALL_UVS ) ",\"images\":[{\"bufferView\":%d}],\"textures\":[{\"source\":0}],\"materials\":[{\"extensions\":{"
                            "\"KHR_materials_anisotropy\":{\"anisotropyStrength\":0.5,\"anisotropyTexture\":{\"index\":0}},"
                            "\"KHR_materials_iridescence\":{\"iridescenceFactor\":0.5,\"iridescenceTexture\":{\"index\":0},"
                            "\"iridescenceThicknessTexture\":{\"index\":0}}}}]",
            view );
        RfScene scene = gltf_load_built( &b, rest );
        RfMaterial m = at( &scene, 0 );
        gltf_assert_near( m.anisotropy, v[2] > 0.0f ? 0.5 : 0.0 );
        gltf_assert_near( m.film, v[0] > 0.0f ? 0.5 : 0.0 );
        gltf_assert_near( m.film_thickness, v[1] > 0.0f ? 400.0 : 100.0 );
        RfVec3 along = rf_stretch_at( &scene, &m, 0, 0.1f, 0.1f, rf_vec3( 0, 0, 1 ) );
        gltf_assert_rgb( along, v[0] > 0.0f ? sqrt( 0.5 ) : -sqrt( 0.5 ), v[1] > 0.0f ? sqrt( 0.5 ) : -sqrt( 0.5 ), 0 );
        rf_destroy_scene( &scene );
    }
}

// What a base does not send through, by its texture, is its own: with the effect and without it.
TEST( test_base_beside_textured_transmission )
{
    RfScene scene = load_material( MATERIAL( "\"pbrMetallicRoughness\":{\"metallicFactor\":0},\"extensions\":{"
                                             "\"KHR_materials_diffuse_transmission\":{\"diffuseTransmissionFactor\":0.5,"
                                             "\"diffuseTransmissionTexture\":{\"index\":0}}}" ) );
    for ( int left_out = 0; left_out < 2; ++left_out )
    {
        if ( left_out )
            assert_int_equal( rf_choose_effects( &scene, 0, RF_EFFECT_BIT( RF_EFFECT_DIFFUSE_TRANSMISSION ), NULL ), RF_OK );
        RfMaterial m = at( &scene, 1 ), other = at( &scene, 0 );
        assert_int_equal( m.kind, left_out ? RF_BSDF_GGX : RF_BSDF_TRANSLUCENT );
        gltf_assert_near( m.diffuse.x, 1.0 - 0.5 * 51.0 / 255.0 );
        gltf_assert_near( other.diffuse.x, 0.5 );
    }
    rf_destroy_scene( &scene );
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
