// Materials that glTF cannot carry as they are, from Blender to a picture: small scenes made inside Blender
// (support/blender_materials.py) are exported, rendered, and held against Cycles by their mean. Skipped where Blender
// or its numpy is missing.
#include "support/blender_pictures.h"
#include "support/test.h"

#include "scene/textured.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAKE BLENDER "--factory-startup --python-exit-code 9 -P " REFRAME_SOURCE_DIR "/tests/support/blender_materials.py -- . "

TEST( test_means_are_those_of_cycles )
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
                   { "curtains", false } };
    bool is_4 = blender_major() >= 4;
    if ( !enter_with_blender() )
        skip();
    assert_int_equal(
        cli_run( MAKE "procedural images mapped glass transparent emission no_material groups lamps principled mixed_glass "
                      "for_eevee rough_principled curtains "
                      "--samples 256 --size " SIZE " > log 2>&1" )
            ->status,
        0 );
    for ( size_t i = 0; i < sizeof scenes / sizeof scenes[0]; ++i )
    {
        const CliResult* done = cli_run( BLENDER "%s.blend -P " REFRAME_SOURCE_DIR
                                                 "/scripts/blender/export.py -- %s.glb --bake 128 --bake-cache cache",
                                         scenes[i].name, scenes[i].name );
        assert_int_equal( done->status, 0 );
        assert_null( strstr( done->err, "Traceback" ) );
        assert_null( strstr( done->err, "not understood" ) );
        assert_true( scenes[i].is_baked == ( strstr( done->out, "baked" ) != NULL ) );
        // a bulb as bright as a sphere, near to the ceiling, takes light back; a disc that is dimmer there makes up for it in 3.4
        bool is_dimmed = is_4 && strcmp( scenes[i].name, "mixed_glass" ) == 0;
        if ( is_dimmed )
            assert_non_null(
                strstr( done->err, "'POINT': a sphere here, which takes up to 69 % of the light that what is near" ) );
        compare( scenes[i].name, is_dimmed ? 0.93 : 0.98, 1.02 );
    }
    // a second time nothing is baked, and the same comes out
    const CliResult* again = cli_run( EXPORT( "procedural" ) "--bake 128 --overwrite" );
    assert_int_equal( again->status, 0 );
    assert_non_null( strstr( again->out, "from the cache" ) );
    RfScene scene;
    load( "curtains.glb", &scene );
    assert_int_equal( find_material( &scene, "curtain" )->kind, RF_BSDF_TRANSLUCENT );
    assert_int_equal( find_material( &scene, "leaf" )->kind, RF_BSDF_TRANSLUCENT );
    rf_destroy_scene( &scene );
    load( "glass.glb", &scene );
    const RfMaterial* glass = find_material( &scene, "glass" );
    assert_true( glass->kind == RF_BSDF_GLASS && !glass->thin && fabsf( glass->ior - 1.45f ) < 1e-5f );
    rf_destroy_scene( &scene );
    load( "no_material.glb", &scene );
    const RfMaterial* grey = find_material( &scene, "no material" );
    assert_true( grey->kind == RF_BSDF_LAMBERT && fabsf( grey->diffuse.x - 0.8f ) < 1e-5f );
    rf_destroy_scene( &scene );
    cli_leave();
}

// Diffuse and gloss of two colours are one surface, as bright as in Cycles. Each surface alone is within a per cent; the
// mean of a closed room of them shows ten times that.
TEST( test_mixtures_of_gloss )
{
    static const char* const scenes[] = { "shares_of_gloss", "gloss_by_fresnel", "furnace" };
    if ( !enter_with_blender() )
        skip();
    assert_int_equal( cli_run( MAKE "shares_of_gloss gloss_by_fresnel furnace --samples 256 --size " SIZE " > log 2>&1" )->status,
                      0 );
    for ( size_t i = 0; i < sizeof scenes / sizeof scenes[0]; ++i )
    {
        const CliResult* done = cli_run( BLENDER "%s.blend -P " REFRAME_SOURCE_DIR
                                                 "/scripts/blender/export.py -- %s.glb --bake 64 --bake-cache cache",
                                         scenes[i], scenes[i] );
        assert_int_equal( done->status, 0 );
        assert_null( strstr( done->out, "baked" ) ); // images are carried unchanged
        assert_null( strstr( done->err, "mean of the two" ) );
        assert_true( ( i == 1 ) ==
                     ( strstr( done->err, "'tinted', node 'Mix Shader': the colour of its reflection: at grazing angles as "
                                          "bright in all colours as in the brightest" ) != NULL ) );
        compare( scenes[i], 0.98, 1.02 );
    }
    assert_true( mean_of( "furnace.r.exr" ) < 1.0005 );
    cli_leave();
}

TEST( test_what_is_left_out_is_named )
{
    static const char* const said[] = {
        "'Sphere': material 'skin', node 'Principled BSDF': subsurface scattering",
        "'Sphere': material 'skin', node 'Principled BSDF': sheen",
        "'Cube.001': material 'fog', node 'Principled Volume': volume",
        "'Cube.003': material 'toon', node 'Toon BSDF': toon shading",
    };
    if ( !enter_with_blender() )
        skip();
    assert_int_equal( cli_run( MAKE "left_out > log 2>&1" )->status, 0 );
    const CliResult* done = cli_run( EXPORT( "left_out" ) "--bake 64 > log" );
    assert_int_equal( done->status, 0 );
    for ( size_t i = 0; i < sizeof said / sizeof said[0]; ++i )
        expect_line( done->err, said[i] );
    RfScene scene;
    load( "left_out.glb", &scene );
    assert_true( find_material( &scene, "rough" )->textured->refs[RF_TEXTURE_NORMAL].texture >= 0 );
    rf_destroy_scene( &scene );
    const CliResult* info = cli_run( "$R info left_out.glb" );
    for ( size_t i = 0; i < sizeof said / sizeof said[0]; ++i )
        expect_line( info->out, said[i] );
    cli_expect( cli_run( "$R info left_out.glb --json info.json --quiet" ), 0, NULL );
    json_t* json = cli_read_json( "info.json" );
    assert_int_equal( json_array_size( json_object_get( json, "export_warnings" ) ), sizeof said / sizeof said[0] );
    json_decref( json );
    done = cli_run( EXPORT( "left_out" ) "--no-bake --overwrite > log" );
    assert_int_equal( done->status, 0 );
    expect_line( done->err, "material 'rough', node 'Bump': normal varies and is not baked (--no-bake)" );
    done = cli_run( EXPORT( "left_out" ) "--bake 7 --overwrite > log" );
    assert_int_equal( done->status, 2 );
    cli_leave();
}

// What lights a scene counts, where the camera is shown something else; and glass that lets light pass by a trick is a
// pane, which lets pass what Fresnel's equations leave, where Cycles' shadow rays lose nothing.
TEST( test_looks_of_other_rays )
{
    static const char* const said[] = {
        "'Grid': material 'dimmed', node 'Light Path': shines differently to the camera: taken as it lights the scene",
        "'Grid.001': material 'unseen', node 'Light Path': hidden from the camera, but lights the scene: seen by all rays",
        "'Cube.001': material 'window', node 'Light Path': glass that lets shadow rays pass: taken as a thin pane",
        "'Cube.002': material 'glass': glass without a shadow: taken as a thin pane",
        "'Plane': material 'facade', node 'Mix Shader': the colour of its reflection: taken as white",
    };
    if ( !enter_with_blender() )
        skip();
    assert_int_equal( cli_run( MAKE "other_rays --samples 256 --size " SIZE " > log 2>&1" )->status, 0 );
    const CliResult* done = cli_run( EXPORT( "other_rays" ) "--bake 64 > log" );
    assert_int_equal( done->status, 0 );
    for ( size_t i = 0; i < sizeof said / sizeof said[0]; ++i )
        expect_line( done->err, said[i] );
    assert_null( strstr( done->err, "seen straight on" ) ); // Fresnel's factor is that of the pane
    compare( "other_rays", 0.8, 1.0 );
    RfScene scene;
    load( "other_rays.glb", &scene );
    static const char* const panes[] = { "window", "glass", "facade" };
    for ( size_t i = 0; i < sizeof panes / sizeof panes[0]; ++i )
    {
        const RfMaterial* pane = find_material( &scene, panes[i] );
        assert_true( pane->kind == RF_BSDF_GLASS && pane->thin );
        assert_true( fabsf( pane->ior - ( i == 2 ? 1.4f : 1.45f ) ) < 1e-5f );
    }
    const RfMaterial* marble = find_material( &scene, "marble" );
    assert_true( marble->kind == RF_BSDF_GLASS && !marble->thin && fabsf( marble->ior - 1.35f ) < 1e-5f );
    rf_destroy_scene( &scene );
    cli_leave();
}

static void expect_glass( const RfScene* scene, const char* name, bool is_thin )
{
    const RfMaterial* found = find_material( scene, name );
    if ( found->kind != RF_BSDF_GLASS || found->thin != is_thin )
        fail_msg( "'%s' is not %s glass", name, is_thin ? "thin" : "solid" );
}

// A thin box of glass is two panes, through which lamps and the sun light a room; what refracts, or has something on its
// walls or in it, stays a body.
TEST( test_thin_boxes_of_glass )
{
    static const char* const thin[] = { "window", "cover", "dense" };
    static const char* const solid[] = { "wedge", "lens", "thick", "strip", "tank", "water", "mirror", "paperweight" };
    if ( !enter_with_blender() )
        skip();
    assert_int_equal( cli_run( MAKE "panes odd_glass --samples 1024 --size " SIZE " > log 2>&1" )->status, 0 );
    const CliResult* done = cli_run( EXPORT( "panes" ) );
    expect_line( done->err, "material 'window': glass as a thin box: its sides are taken as thin panes, without refraction" );
    compare( "panes", 0.98, 1.02 );
    RfScene scene;
    load( "panes.glb", &scene );
    for ( size_t i = 0; i < sizeof thin / sizeof thin[0]; ++i )
        expect_glass( &scene, thin[i], true );
    rf_destroy_scene( &scene );
    done = cli_run( EXPORT( "odd_glass" ) );
    assert_int_equal( done->status, 0 );
    assert_null( strstr( done->err, "thin box" ) );
    load( "odd_glass.glb", &scene );
    for ( size_t i = 0; i < sizeof solid / sizeof solid[0]; ++i )
        expect_glass( &scene, solid[i], false );
    rf_destroy_scene( &scene );
    cli_leave();
}

// Layers of Blender 4, which reflect as much as in its Cycles, or are named.
TEST( test_surfaces_of_blender_4 )
{
    static const char* const said[] = {
        "material 'film', node 'Principled BSDF': a thin film: up to 12 % darker",
        "material 'skin', node 'Principled BSDF': subsurface scattering: taken as diffuse",
        "material 'clay', node 'Principled BSDF': its diffuse roughness (Oren-Nayar): taken as Lambert",
        "material 'bottle', node 'Principled BSDF': glass in part: the rest has no gloss of its own",
        "material 'cloth', node 'Principled BSDF': sheen: as bright as in Blender in even light",
        "material 'satin', node 'Sheen BSDF': sheen: as bright as in Blender in even light",
        "material 'scratched', node 'Principled BSDF': roughness varies, and is taken as 0.5 for its brightness",
    };
    if ( blender_major() < 4 || !enter_with_blender() )
        skip();
    assert_int_equal( cli_run( MAKE "layered named --samples 256 --size " SIZE " > log 2>&1" )->status, 0 );
    const CliResult* done = cli_run( EXPORT( "layered" ) "--bake 64" );
    assert_int_equal( done->status, 0 );
    assert_null( strstr( done->out, "baked" ) );
    assert_null( strstr( done->err, "warning" ) );
    compare( "layered", 0.98, 1.02 );
    RfScene scene;
    load( "layered.glb", &scene );
    assert_true( find_material( &scene, "copper" )->specular.x > 0.8f );
    rf_destroy_scene( &scene );
    done = cli_run( EXPORT( "named" ) "--bake 64 > log" );
    assert_int_equal( done->status, 0 );
    for ( size_t i = 0; i < sizeof said / sizeof said[0]; ++i )
        expect_line( done->err, said[i] );
    cli_leave();
}
