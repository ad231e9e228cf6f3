// Values that change from frame to frame in Blender, whatever drives them: small scenes made inside Blender
// (support/blender_values.py) are exported, read at several frames, and rendered beside Cycles. Skipped where Blender or its
// numpy is missing.
#include "support/blender_run.h"
#include "support/test.h"

#include "gltf/gltf.h"
#include "reframe/image.h"
#include "scene/pose.h"
#include "scene/textured.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FRAMES 5

static void make_and_export( const char* scene, const char* options )
{
    cli_expect( cli_run( BLENDER_MAKE "blender_values.py -- %s %s > log 2>&1", options, scene ), 0, NULL );
    const CliResult* done = cli_run( BLENDER "%s.blend -P " BLENDER_SCRIPT "%s.glb --bake 64 --bake-cache cache", scene, scene );
    if ( done->status != 0 || strstr( done->err, "loss" ) != NULL || strstr( done->err, "not understood" ) != NULL )
        fail_msg( "%s: %s", scene, done->err );
}

static void load( const char* name, RfScene* scene )
{
    char path[512];
    snprintf( path, sizeof path, "%s/%s", cli_folder(), name );
    RfError error;
    RfLog log = { 0 };
    if ( rf_load_gltf( path, scene, &log, &error ) != RF_OK )
        fail_msg( "%s", error.text );
}

// As in a frame of Blender's, of which 1 is the first.
static void pose( const RfScene* scene, int frame, RfPosedScene* posed )
{
    RfError error;
    if ( rf_pose_scene( scene, ( frame - 1 ) / 24.0, posed, &error ) != RF_OK )
        fail_msg( "%s", error.text );
}

static const RfMaterial* find_material( const RfScene* scene, const char* name )
{
    for ( uint32_t i = 0; i < scene->material_count; ++i )
    {
        if ( strcmp( scene->materials[i].name, name ) == 0 )
            return scene->materials + i;
    }
    fail_msg( "there is no material '%s'", name );
    return NULL;
}

static void expect( const char* what, int frame, double found, double value )
{
    if ( !( fabs( found - value ) <= 1e-4 * ( 1.0 + fabs( value ) ) ) )
        fail_msg( "%s in frame %d: %g, not %g", what, frame, found, value );
}

// Linear from the first frame to the last.
static double between( int frame, double first, double last )
{
    return first + ( last - first ) * ( frame - 1 ) / ( FRAMES - 1 );
}

static const RfFactors* factors_of( const RfPosedScene* posed, const char* name )
{
    const RfMaterial* material = find_material( &posed->scene, name );
    assert_non_null( material->textured );
    return &material->textured->factors;
}

static void check_surfaces( const RfPosedScene* posed, int frame, double red )
{
    const RfMaterial* glow = find_material( &posed->scene, "glow" );
    expect( "red of the glow", frame, (double)glow->emission.x, between( frame, 0.0, 8.0 ) );
    expect( "blue of the glow", frame, (double)glow->emission.z, between( frame, 0.0, 2.0 ) );
    expect( "red of the paint", frame, factors_of( posed, "paint" )->base[0], red * between( frame, 1.0, 0.125 ) );
    expect( "roughness of steel", frame, factors_of( posed, "steel" )->roughness, between( frame, 0.2, 0.6 ) );
    expect( "alpha", frame, factors_of( posed, "fades" )->base[3], between( frame, 1.0, 0.2 ) );
    expect( "what is driven", frame, factors_of( posed, "driven" )->base[1], 0.1 * frame );
}

static double mean_in( const RfImage* image, int column, int row )
{
    double sum = 0.0;
    int width = image->width / 3, height = image->height / 2;
    for ( int y = row * height; y < ( row + 1 ) * height; ++y )
        for ( int x = 3 * column * width; x < 3 * ( column + 1 ) * width; ++x )
            sum += (double)image->rgb[(size_t)y * 3 * (size_t)image->width + (size_t)x];
    return sum / ( 3.0 * width * height );
}

// Each of six parts of the picture is as bright as by Cycles, in the first frame, the last, and between.
static void compare( const char* scene, double room )
{
    cli_expect(
        cli_run( "$R render %s.glb -o %s-####.exr --frames 1,3,5 --spp 64 --group 0 --tile 1 --filter box --float --quiet", scene,
                 scene ),
        0, NULL );
    for ( int frame = 1; frame <= FRAMES; frame += 2 )
    {
        RfImage image[2];
        for ( int i = 0; i < 2; ++i )
        {
            char path[512];
            RfError error;
            snprintf( path, sizeof path, i == 0 ? "%s/%s-%04d.exr" : "%s/%s-%d.exr", cli_folder(), scene, frame );
            if ( rf_read_exr( path, image + i, &error ) != RF_OK )
                fail_msg( "%s", error.text );
        }
        for ( int part = 0; part < 6; ++part )
        {
            double ours = mean_in( image, part % 3, part / 3 ), theirs = mean_in( image + 1, part % 3, part / 3 );
            if ( !( fabs( ours - theirs ) <= room * theirs + 1e-3 ) )
                fail_msg( "%s: part %d of frame %d: %.4f, not %.4f", scene, part, frame, ours, theirs );
        }
        rf_destroy_image( image );
        rf_destroy_image( image + 1 );
    }
}

TEST( test_numbers_of_shaders )
{
    if ( !enter_with_blender() )
        skip();
    make_and_export( "surfaces", "" );
    RfScene scene;
    load( "surfaces.glb", &scene );
    double red = 0.8;
    for ( int frame = 1; frame <= FRAMES; ++frame )
    {
        RfPosedScene posed = { 0 };
        pose( &scene, frame, &posed );
        if ( frame == 1 )
            red = factors_of( &posed, "paint" )->base[0]; // whose diffuse part is a little darker in Blender 3
        check_surfaces( &posed, frame, red );
        rf_destroy_pose( &posed );
    }
    assert_true( fabs( red - 0.8 ) < 0.01 );
    rf_destroy_scene( &scene );
    cli_leave();
}

TEST( test_pictures_that_change )
{
    if ( !enter_with_blender() )
        skip();
    make_and_export( "pictures", "--samples 64" );
    compare( "pictures", 0.05 );
    make_and_export( "movie", "--samples 16" );
    compare( "movie", 0.05 );
    cli_leave();
}

static void check_sky( const RfPosedScene* posed, int frame )
{
    double strength = between( frame, 1.0, 0.25 );
    RfVec3 radiance = posed->scene.environment.radiance;
    expect( "red of the sky", frame, (double)radiance.x, strength * between( frame, 0.2, 0.8 ) );
    expect( "blue of the sky", frame, (double)radiance.z, strength * between( frame, 0.8, 0.0 ) );
}

static void check_frames( const char* scene, void ( *check )( const RfPosedScene* posed, int frame ) )
{
    RfScene loaded;
    load( scene, &loaded );
    for ( int frame = 1; frame <= FRAMES; ++frame )
    {
        RfPosedScene posed = { 0 };
        pose( &loaded, frame, &posed );
        check( &posed, frame );
        rf_destroy_pose( &posed );
    }
    rf_destroy_scene( &loaded );
}

TEST( test_worlds )
{
    if ( !enter_with_blender() )
        skip();
    make_and_export( "dusk", "" );
    check_frames( "dusk.glb", check_sky );
    make_and_export( "panorama", "--samples 64" );
    compare( "panorama", 0.03 );
    make_and_export( "sun", "--samples 64" );
    compare( "sun", 0.03 );
    assert_int_equal( cli_run( BLENDER_MAKE "blender_values.py -- rises > log 2>&1" )->status, 0 );
    const CliResult* done = cli_run( BLENDER "rises.blend -P " BLENDER_SCRIPT "rises.glb > log" );
    assert_int_equal( done->status, 1 );
    assert_non_null( strstr( done->err, "blender-export: loss: world 'world' changes otherwise than in strength, in its one "
                                        "colour, or by a turn about the vertical: taken as in the first frame\n" ) );
    cli_leave();
}

// By watts: of the lamps that are points in the file.
static void check_lamps( const RfPosedScene* posed, int frame )
{
    int found = 0;
    for ( int i = 0; i < posed->scene.punctual_count; ++i )
    {
        const RfPunctual* lamp = posed->scene.punctuals + i;
        double watts = 4.0 * 3.14159265358979 * (double)lamp->intensity.x;
        if ( strncmp( lamp->name, "bulb", 4 ) == 0 )
            expect( "red of the bulb", frame, watts, between( frame, 0.0, 20.0 ) * between( frame, 1.0, 0.2 ) );
        else if ( strncmp( lamp->name, "driven", 6 ) == 0 )
            expect( "what nodes drive", frame, watts, 10.0 * frame / 5.0 );
        else if ( strncmp( lamp->name, "spot", 4 ) == 0 )
            expect( "cone", frame, acos( (double)lamp->cos_outer ), between( frame, 0.2, 0.4 ) );
        ++found;
    }
    assert_true( found >= 3 );
}

TEST( test_lamps )
{
    if ( !enter_with_blender() )
        skip();
    make_and_export( "lamps", "--samples 64" );
    check_frames( "lamps.glb", check_lamps );
    compare( "lamps", 0.05 );
    cli_leave();
}
