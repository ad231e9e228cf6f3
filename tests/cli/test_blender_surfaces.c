// Surfaces that extensions of glTF carry, and what depends on the angle, from Blender to a picture: small scenes made inside
// Blender (support/blender_surfaces.py) are exported, rendered, and held against Cycles by their mean. Skipped where Blender
// or its numpy is missing.
#include "support/blender_run.h"

#include "scene/textured.h"

// Makes a scene and its picture by Cycles, and exports it, which the exporter comments.
static const char* export_scene( const char* scene, const char* options )
{
    blender_make( "surfaces --samples 256 %s", scene );
    return blender_exported( scene, options )->err;
}

BLENDER_TEST( test_what_depends_on_the_angle )
{
    const char* said = export_scene( "by_angle", "--bake 64" );
    expect_said( said, "'wall', node 'Layer Weight': depends on where it is seen from: its mean is taken: in Blender 0.7" );
    expect_said( said, "'lacquer', node 'Mix Shader': a factor of its own for the angle: taken as Schlick's of the same mean" );
    expect_said( said, "'by hand', node 'Geometry': depends on where it is seen from: its mean is taken" );
    expect_said( said, "'steep', node 'Layer Weight': depends on where it is seen from: its mean is taken: in Blender 0.1" );
    expect_said( said, "'even', node 'Layer Weight': depends on where it is seen from: its mean is taken: in Blender 0.8" );
    expect_cycles_mean( "by_angle", 0.97, 1.03 );
}

BLENDER_TEST( test_fabrics )
{
    const char* said = export_scene( "fabrics", "--no-bake" );
    expect_said( said, "'velvet'" );
    expect_said( said, "sheen: as bright as in Blender in even light" );
    expect_cycles_mean( "fabrics", 0.97, 1.03 );
    AUTO_SCENE scene = convert_load( "fabrics.glb" );
    static const char* const names[] = { "cloth", "velvet", "plush" };
    for ( size_t i = 0; i < sizeof names / sizeof names[0]; ++i )
        assert_true( find_material( &scene, names[i] )->sheen.x > 0.05f );
    assert_true( find_material( &scene, "plush" )->diffuse.y > 0.4f );
}

// A displacement that is only a bump darkens what is seen and makes it uneven.
BLENDER_TEST( test_displacement_as_a_bump )
{
    const char* said = export_scene( "bumps", "--bake 256" );
    assert_null( strstr( said, "isplacement" ) );
    expect_cycles_mean( "bumps", 0.97, 1.03 );
    AUTO_SCENE scene = convert_load( "bumps.glb" );
    static const char* const names[] = { "wall", "vectors", "both" };
    for ( size_t i = 0; i < sizeof names / sizeof names[0]; ++i )
        assert_true( find_material( &scene, names[i] )->textured->refs[RF_TEXTURE_NORMAL].texture >= 0 );
}

static bool has_texture( const RfScene* scene, const char* name, RfTextureSlot slot )
{
    const RfTextured* textured = find_material( scene, name )->textured;
    return textured != NULL && textured->refs[slot].texture >= 0;
}

// Directions that are not those of the coordinates are a texture.
BLENDER_TEST( test_brushed_metal_and_coats )
{
    bool is_4 = blender_is_4();
    const char* said = export_scene( "brushed", "--bake 128" );
    expect_said( said, "'coat', node 'Principled BSDF': a clear coat with a normal of its own" );
    assert_true( is_4 == ( strstr( said, "'coat', node 'Principled BSDF': a thin film: up to" ) != NULL ) );
    expect_cycles_mean( "brushed", 0.97, 1.03 );
    AUTO_SCENE scene = convert_load( "brushed.glb" );
    assert_true( has_texture( &scene, "around", RF_TEXTURE_ANISOTROPY ) &&
                 has_texture( &scene, "turned", RF_TEXTURE_ANISOTROPY ) );
    assert_false( has_texture( &scene, "along", RF_TEXTURE_ANISOTROPY ) );
    assert_true( has_texture( &scene, "coat", RF_TEXTURE_CLEARCOAT_NORMAL ) );
    assert_true( ( find_material( &scene, "coat" )->film > 0.0f ) == is_4 );
    // widths of 0.16 by 1 - 0.6: along the coordinates, and across them
    const RfMaterial* along = find_material( &scene, "along" );
    float wide = along->alpha + ( 1.0f - along->alpha ) * along->anisotropy * along->anisotropy;
    assert_true( fabsf( along->alpha - 0.064f ) < 1e-3f && fabsf( wide - 0.4f ) < 1e-3f &&
                 fabsf( along->stretch_x - 1.0f ) < 1e-5f );
}

// What shines through has the texture of the base, or one of its own.
BLENDER_TEST( test_leaves )
{
    assert_null( strstr( export_scene( "leaves", "--bake 128" ), "warning" ) );
    expect_cycles_mean( "leaves", 0.98, 1.02 );
    AUTO_SCENE scene = convert_load( "leaves.glb" );
    static const char* const names[] = { "blind", "leaf" };
    for ( size_t i = 0; i < sizeof names / sizeof names[0]; ++i )
    {
        assert_int_equal( find_material( &scene, names[i] )->kind, RF_BSDF_TRANSLUCENT );
        assert_true( has_texture( &scene, names[i], RF_TEXTURE_BASE ) &&
                     has_texture( &scene, names[i], RF_TEXTURE_THROUGH_COLOR ) );
    }
}

// The picture is Cycles' to its noise: without displacement relMSE would be 0.26.
BLENDER_TEST( test_displacement_of_vertices )
{
    assert_null( strstr( export_scene( "displaced", "--bake 128" ), "warning" ) );
    expect_cycles_mean( "displaced", 0.97, 1.03 );
    cli_run( "$R compare displaced.r.exr displaced-1.exr --json error.json" );
    json_auto_t* json = cli_read_json( "error.json" );
    assert_true( json_number_value( json_object_get( json, "relmse" ) ) < 0.03 );
}
