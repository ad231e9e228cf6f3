// Materials that glTF cannot carry as they are, from Blender to a picture: small scenes made inside Blender
// (support/blender_materials.py) are exported, rendered, and held against Cycles by their mean. Skipped where Blender
// or its numpy is missing.
#include "support/blender_run.h"

#include "scene/textured.h"

BLENDER_TEST( test_means_are_those_of_cycles )
{
    static const struct
    {
        const char* name;
        bool is_baked;
    } scenes[] = { { "procedural", true },
                   { "images", false },
                   { "mapped", true },
                   { "glass", false },
                   { "transparent", true },
                   { "emission", true },
                   { "no_material", false },
                   { "groups", true },
                   { "lamps", false },
                   { "principled", false },
                   { "mixed_glass", false },
                   { "for_eevee", false },
                   { "rough_principled", false },
                   { "curtains", false },
                   { "veiled", true },
                   { "asked", false } };
    bool is_4 = blender_is_4();
    blender_make(
        "materials --samples 256 procedural images mapped glass transparent emission no_material groups lamps principled "
        "mixed_glass for_eevee rough_principled curtains veiled asked" );
    for ( size_t i = 0; i < sizeof scenes / sizeof scenes[0]; ++i )
    {
        const CliResult* done = blender_exported( scenes[i].name, "--bake 128" );
        assert_true( scenes[i].is_baked == ( strstr( done->out, "baked" ) != NULL ) );
        // a bulb as bright as a sphere, near to the ceiling, takes light back; a disc that is dimmer there makes up for it in 3.4
        bool is_dimmed = is_4 && strcmp( scenes[i].name, "mixed_glass" ) == 0;
        if ( is_dimmed )
            expect_said( done->err, "'POINT': a sphere here, which takes up to 69 % of the light that what is near" );
        // 1.8 % brighter in 3.4
        bool is_rough = blender_major() >= 5 && strcmp( scenes[i].name, "rough_principled" ) == 0;
        expect_cycles_mean( scenes[i].name, is_dimmed ? 0.93 : 0.98, is_rough ? 1.023 : 1.02 );
    }
    // a second time nothing is baked, and the same comes out
    expect_said( blender_exported( "procedural", "--bake 128 --overwrite" )->out, "from the cache" );
    // Blender's own limits, by which a closed room loses light
    expect_said( blender_exported( "asked", "--bake 128 --overwrite" )->err,
                 "light ends by limits in Blender (4 diffuse, 4 glossy bounces of 12, Filter Glossy, Clamp Indirect): all "
                 "of it is here, " );
    RfScene scene = convert_load( "curtains.glb" );
    assert_int_equal( find_material( &scene, "curtain" )->kind, RF_BSDF_TRANSLUCENT );
    assert_int_equal( find_material( &scene, "leaf" )->kind, RF_BSDF_TRANSLUCENT );
    rf_destroy_scene( &scene );
    scene = convert_load( "glass.glb" );
    const RfMaterial* glass = find_material( &scene, "glass" );
    assert_true( glass->kind == RF_BSDF_GLASS && !glass->thin && fabsf( glass->ior - 1.45f ) < 1e-5f );
    rf_destroy_scene( &scene );
    scene = convert_load( "no_material.glb" );
    const RfMaterial* grey = find_material( &scene, "no material" );
    bool is_lambert = grey->kind == RF_BSDF_LAMBERT && fabsf( grey->diffuse.x - 0.8f ) < 1e-5f;
    assert_true( is_lambert == ( blender_major() < 5 ) ); // then it is Principled
    rf_destroy_scene( &scene );
}

// A channel of the texture of roughness and metallic, in the left half and in the right one.
static void expect_numbers( const RfScene* scene, const char* name, int channel, int left, int right )
{
    int number = find_material( scene, name )->textured->refs[RF_TEXTURE_METALLIC_ROUGHNESS].texture;
    assert_true( number >= 0 );
    const RfTexture* found = &scene->textures[number];
    assert_true( found->width == 16 && found->height == 16 && found->bytes != NULL && found->channels >= 3 );
    for ( int x = 0; x < 16; ++x )
        assert_in_range( found->bytes[(size_t)( 16 * 3 + x ) * (size_t)found->channels + (size_t)channel] + 1 -
                             ( x < 8 ? left : right ),
                         0, 2 );
}

// Numbers that are channels of images need no bake, and what is made of an image alone has no finer one. The expected values are
// Cycles' luminance of the two colours, of which sRGB is made linear first.
BLENDER_TEST( test_numbers_of_images )
{
    blender_make( "materials --samples 256 packed" );
    const CliResult* done = blender_exported( "packed", "--bake 512" );
    expect_said( done->out, "baked 1 of 1: 'Cube.003' at 128x128: roughness: " );
    expect_cycles_mean( "packed", 0.98, 1.02 );
    AUTO_SCENE scene = convert_load( "packed.glb" );
    expect_numbers( &scene, "luminance", 1, 128, 120 );
    expect_numbers( &scene, "inverted", 1, 193, 197 );
    expect_numbers( &scene, "inverted", 2, 34, 8 );
    // where no face is, the mean of the faces; and nothing is mixed of both at their margins
    const RfTexture* bent =
        &scene.textures[find_material( &scene, "bent" )->textured->refs[RF_TEXTURE_METALLIC_ROUGHNESS].texture];
    for ( size_t i = 0; i < (size_t)bent->width * (size_t)bent->height; ++i )
        assert_in_range( bent->bytes[i * (size_t)bent->channels + 1], 55, 75 );
    expect_said( blender_exported( "packed", "--no-bake --overwrite" )->err,
                 "'bent', node 'Gamma': roughness varies and is not baked" );
}

// Diffuse and gloss of two colours are one surface, as bright as in Cycles. Each surface alone is within a per cent; the
// mean of a closed room of them shows ten times that.
BLENDER_TEST( test_mixtures_of_gloss )
{
    static const char* const scenes[] = { "shares_of_gloss", "gloss_by_fresnel", "furnace" };
    blender_make( "materials --samples 256 shares_of_gloss gloss_by_fresnel furnace" );
    for ( size_t i = 0; i < sizeof scenes / sizeof scenes[0]; ++i )
    {
        const CliResult* done = blender_exported( scenes[i], "--bake 64" );
        assert_null( strstr( done->out, "baked" ) ); // images are carried unchanged
        assert_null( strstr( done->err, "mean of the two" ) );
        assert_true( ( i == 1 ) ==
                     ( strstr( done->err, "'tinted', node 'Mix Shader': the colour of its reflection: at grazing angles as "
                                          "bright in all colours as in the brightest" ) != NULL ) );
        // the second is 1.9 % brighter in all versions, and Cycles' pictures differ by a tenth of that
        expect_cycles_mean( scenes[i], 0.98, i == 1 && blender_major() >= 5 ? 1.022 : 1.02 );
    }
    assert_true( picture_mean( "furnace.r.exr" ) < 1.0005 );
}

BLENDER_TEST( test_what_is_left_out_is_named )
{
    static const char* const said[] = {
        "'Sphere': material 'skin', node 'Principled BSDF': subsurface scattering",
        "'Sphere': material 'skin', node 'Principled BSDF': sheen",
        "'Cube.001': material 'fog', node 'Principled Volume': volume",
        "'Cube.003': material 'toon', node 'Toon BSDF': toon shading",
    };
    blender_make( "materials left_out" );
    const CliResult* done = blender_export( "left_out", "--bake 64" );
    assert_int_equal( done->status, 0 );
    EXPECT_ALL_SAID( done->err, said );
    AUTO_SCENE scene = convert_load( "left_out.glb" );
    assert_true( find_material( &scene, "rough" )->textured->refs[RF_TEXTURE_NORMAL].texture >= 0 );
    const CliResult* info = cli_run( "$R info left_out.glb" );
    EXPECT_ALL_SAID( info->out, said );
    cli_expect( cli_run( "$R info left_out.glb --json info.json --quiet" ), 0, NULL );
    json_auto_t* json = cli_read_json( "info.json" );
    assert_int_equal( json_array_size( json_object_get( json, "export_warnings" ) ), sizeof said / sizeof said[0] );
    done = blender_export( "left_out", "--no-bake --overwrite" );
    assert_int_equal( done->status, 0 );
    expect_said( done->err, "material 'rough', node 'Bump': normal varies and is not baked (--no-bake)" );
    done = blender_export( "left_out", "--bake 7 --overwrite" );
    assert_int_equal( done->status, 2 );
}

// What lights a scene counts, where the camera is shown something else; and glass that lets light pass by a trick is a
// pane, which lets pass what Fresnel's equations leave, where Cycles' shadow rays lose nothing.
BLENDER_TEST( test_looks_of_other_rays )
{
    static const char* const said[] = {
        "'Grid': material 'dimmed', node 'Light Path': shines differently to the camera: taken as it lights the scene",
        "'Grid.001': material 'unseen', node 'Light Path': hidden from the camera, but lights the scene: seen by all rays",
        "'Cube.001': material 'window', node 'Light Path': glass that lets shadow rays pass: taken as a thin pane",
        "'Cube.002': material 'glass': glass without a shadow: taken as a thin pane",
        "'Plane': material 'facade', node 'Mix Shader': the colour of its reflection: taken as white",
    };
    blender_make( "materials --samples 256 other_rays" );
    const CliResult* done = blender_export( "other_rays", "--bake 64" );
    assert_int_equal( done->status, 0 );
    EXPECT_ALL_SAID( done->err, said );
    assert_null( strstr( done->err, "seen straight on" ) ); // Fresnel's factor is that of the pane
    expect_cycles_mean( "other_rays", 0.8, 1.0 );
    AUTO_SCENE scene = convert_load( "other_rays.glb" );
    static const char* const panes[] = { "window", "glass", "facade" };
    for ( size_t i = 0; i < sizeof panes / sizeof panes[0]; ++i )
    {
        const RfMaterial* pane = find_material( &scene, panes[i] );
        assert_true( pane->kind == RF_BSDF_GLASS && pane->thin );
        assert_true( fabsf( pane->ior - ( i == 2 ? 1.4f : 1.45f ) ) < 1e-5f );
    }
    const RfMaterial* marble = find_material( &scene, "marble" );
    assert_true( marble->kind == RF_BSDF_GLASS && !marble->thin && fabsf( marble->ior - 1.35f ) < 1e-5f );
}

static void expect_glass( const RfScene* scene, const char* name, bool is_thin )
{
    const RfMaterial* found = find_material( scene, name );
    if ( found->kind != RF_BSDF_GLASS || found->thin != is_thin )
        fail_msg( "'%s' is not %s glass", name, is_thin ? "thin" : "solid" );
}

// A thin box of glass is two panes, through which lamps and the sun light a room; what refracts, or has something on its
// walls or in it, stays a body.
BLENDER_TEST( test_thin_boxes_of_glass )
{
    static const char* const thin[] = { "window", "cover", "dense" };
    static const char* const solid[] = { "wedge", "lens", "thick", "strip", "tank", "water", "mirror", "paperweight" };
    blender_make( "materials --samples 1024 panes odd_glass" );
    const CliResult* done = blender_export( "panes", "" );
    expect_said( done->err, "material 'window': glass as a thin box: its sides are taken as thin panes, without refraction" );
    expect_cycles_mean( "panes", 0.98, 1.02 );
    RfScene scene = convert_load( "panes.glb" );
    for ( size_t i = 0; i < sizeof thin / sizeof thin[0]; ++i )
        expect_glass( &scene, thin[i], true );
    rf_destroy_scene( &scene );
    done = blender_export( "odd_glass", "" );
    assert_int_equal( done->status, 0 );
    assert_null( strstr( done->err, "thin box" ) );
    scene = convert_load( "odd_glass.glb" );
    for ( size_t i = 0; i < sizeof solid / sizeof solid[0]; ++i )
        expect_glass( &scene, solid[i], false );
    rf_destroy_scene( &scene );
}

// Layers of Blender 4, which reflect as much as in its Cycles, or are named.
BLENDER_TEST( test_surfaces_of_blender_4 )
{
    static const char* const layered[] = {
        "material 'rough gold', node 'Principled BSDF': bright rough metal: under a lamp up to 10 %",
        "material 'copper', node 'Metallic BSDF': bright rough metal: under a lamp up to 10 %",
        "material 'varnish', node 'Principled BSDF': a clear coat: where light grazes up to 5 %",
    };
    static const char* const said[] = {
        "material 'film', node 'Principled BSDF': a thin film: up to 12 % darker",
        "material 'skin', node 'Principled BSDF': subsurface scattering: taken as diffuse",
        "material 'clay', node 'Principled BSDF': its diffuse roughness (Oren-Nayar): taken as Lambert: at most 20 %",
        "material 'bottle', node 'Principled BSDF': glass in part: the rest has no gloss of its own",
        "material 'cloth', node 'Principled BSDF': sheen: as bright as in Blender in even light",
        "material 'satin', node 'Sheen BSDF': sheen: as bright as in Blender in even light",
        "material 'scratched', node 'Principled BSDF': its colour: what it reflects differs from Blender's by up to",
    };
    if ( !blender_is_4() )
    {
        cli_leave();
        skip();
    }
    blender_make( "materials --samples 256 layered named" );
    const CliResult* done = blender_export( "layered", "--bake 64" );
    assert_int_equal( done->status, 0 );
    assert_null( strstr( done->out, "baked" ) );
    EXPECT_ALL_SAID( done->err, layered );
    assert_null( strstr( done->err, "reflects" ) );
    expect_cycles_mean( "layered", 0.98, 1.02 );
    AUTO_SCENE scene = convert_load( "layered.glb" );
    assert_true( find_material( &scene, "copper" )->specular.x > 0.8f );
    done = blender_export( "named", "--bake 64" );
    assert_int_equal( done->status, 0 );
    EXPECT_ALL_SAID( done->err, said );
}
