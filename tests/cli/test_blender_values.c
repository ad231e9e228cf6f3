// Values that change from frame to frame in Blender, whatever drives them: small scenes made inside Blender
// (support/blender_values.py) are exported, read at several frames, and rendered beside Cycles. Skipped where Blender or its
// numpy is missing.
#include "support/blender_run.h"

#include "gltf/gltf.h"
#include "reframe/image.h"
#include "scene/pose.h"
#include "scene/textured.h"

#define FRAMES 5

static void make_and_export( const char* scene, const char* options )
{
    blender_make( "values %s %s", options, scene );
    const CliResult* done = blender_exported( scene, "--bake 64" );
    if ( strstr( done->err, "loss" ) != NULL )
        fail_msg( "%s: %s", scene, done->err );
}

// As in a frame of Blender's, of which 1 is the first.
static void pose( const RfScene* scene, int frame, RfPosedScene* posed )
{
    RfError error;
    if ( rf_pose_scene( scene, ( frame - 1 ) / 24.0, posed, &error ) != RF_OK )
        fail_msg( "%s", error.text );
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

// Each of six parts of the picture is as bright as by Cycles, in the first frame, the last, and between.
// With `fades_in` the first frame is black.
static void compare( const char* scene, double room, bool fades_in )
{
    cli_expect(
        cli_run( "$R render %s.glb -o %s-####.exr --frames 1,3,5 --spp 64 --group 0 --tile 1 --filter box --float --quiet", scene,
                 scene ),
        0, NULL );
    for ( int frame = 1; frame <= FRAMES; frame += 2 )
    {
        char ours[80], theirs[80];
        snprintf( ours, sizeof ours, "%s-%04d.exr", scene, frame );
        snprintf( theirs, sizeof theirs, "%s-%d.exr", scene, frame );
        if ( fades_in && frame == 1 )
            assert_true( picture_mean( theirs ) == 0.0 && picture_mean( ours ) <= 1e-3 );
        else
            assert_true( picture_difference( ours, theirs, 3, 2 ).worst <= room );
    }
}

BLENDER_TEST( test_numbers_of_shaders )
{
    make_and_export( "surfaces", "" );
    AUTO_SCENE scene = convert_load( "surfaces.glb" );
    double red = 0.8;
    for ( int frame = 1; frame <= FRAMES; ++frame )
    {
        AUTO_POSE posed = { 0 };
        pose( &scene, frame, &posed );
        if ( frame == 1 )
            red = factors_of( &posed, "paint" )->base[0]; // whose diffuse part is a little darker in Blender 3
        check_surfaces( &posed, frame, red );
    }
    assert_true( fabs( red - 0.8 ) < 0.01 );
}

BLENDER_TEST( test_pictures_that_change )
{
    make_and_export( "pictures", "--samples 64" );
    compare( "pictures", 0.05, false );
    make_and_export( "movie", "--samples 16" );
    compare( "movie", 0.05, false );
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
    AUTO_SCENE loaded = convert_load( scene );
    for ( int frame = 1; frame <= FRAMES; ++frame )
    {
        AUTO_POSE posed = { 0 };
        pose( &loaded, frame, &posed );
        check( &posed, frame );
    }
}

BLENDER_TEST( test_worlds )
{
    make_and_export( "dusk", "" );
    check_frames( "dusk.glb", check_sky );
    make_and_export( "panorama", "--samples 64" );
    compare( "panorama", 0.03, true );
    make_and_export( "sun", "--samples 64" );
    compare( "sun", 0.03, false );
    blender_make( "values rises" );
    const CliResult* done = blender_export( "rises", "" );
    assert_int_equal( done->status, 1 );
    expect_said( done->err, "blender-export: loss: world 'world' changes otherwise than in strength, in its one colour, or by a "
                            "turn about the vertical: taken as in the first frame\n" );
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

BLENDER_TEST( test_lamps )
{
    make_and_export( "lamps", "--samples 64" );
    check_frames( "lamps.glb", check_lamps );
    compare( "lamps", 0.05, false );
}
