// What scripts/blender/export.py makes of lamps that shine to each side otherwise: IES files, whose candela Cycles takes at the angles of
// the file, and spots, by its formulas. Skipped where Blender or its numpy is missing.
#include "gltf/gltf.h"
#include "light/punctual.h"
#include "support/blender_run.h"

#define PI 3.14159265358979324
#define WATT ( 4.0 * PI / 177.83 ) // of a lamp, for a candela of a file

// The red intensity in a direction of Blender's world.
static double intensity( const RfPunctual* lamp, double x, double y, double z )
{
    RfVec3 d = rf_normalize( rf_vec3( (float)x, (float)z, (float)-y ) );
    return (double)lamp->intensity.x * (double)rf_lamp_falloff( lamp, d );
}

// By the angles of the file, of a lamp that is not turned.
static double at( const RfPunctual* lamp, double v, double h )
{
    double down = v * PI / 180.0, turn = h * PI / 180.0;
    return intensity( lamp, -sin( down ) * sin( turn ), -sin( down ) * cos( turn ), -cos( down ) );
}

static void assert_near( double got, double want )
{
    if ( !( fabs( got - want ) <= 0.005 * want + 1e-3 ) )
        fail_msg( "%.6g instead of %.6g", got, want );
}

static void check_lamps( const RfScene* scene, bool is_4 )
{
    double one = 10.0 * WATT; // W/sr for each candela
    const RfPunctual *inside = find_lamp( scene, "inside" ), *outside = find_lamp( scene, "outside" ),
                     *mapped = find_lamp( scene, "mapped" ), *spot = find_lamp( scene, "spot" ),
                     *wide = find_lamp( scene, "wide" );
    assert_near( at( inside, 30, 90 ), 2.0 * one * 90.0 );
    assert_near( at( inside, 60, 180 ), 2.0 * one * 30.0 );
    assert_near( at( inside, 60, 270 ), 2.0 * one * 10.0 );
    assert_near( at( inside, 95, 90 ), 0.0 );
    assert_true( inside->intensity.y == 0.5f * inside->intensity.x );
    // turned by 90 degrees counter-clockwise, seen from above: what was towards -y is towards x
    assert_near( intensity( outside, sin( PI / 6.0 ), 0, -cos( PI / 6.0 ) ), one * 80.0 );
    assert_near( intensity( outside, 0, -sin( PI / 3.0 ), -cos( PI / 3.0 ) ), one * 70.0 );
    // the mapping turns what is looked up: from -y to x, which is 270 degrees
    assert_near( at( mapped, 30, 0 ), one * 20.0 );
    // where a smooth step is a half: half way between the cosines of the edge and of the axis
    double half = 0.5 * ( 1.0 + cos( PI / 3.0 ) );
    assert_near( at( spot, acos( half ) * 180.0 / PI, 123 ), 10.0 * 0.5 * ( is_4 ? 1.0 : half ) );
    assert_near( at( spot, 0, 0 ), 10.0 );
    // scaled along x, to which the cone is wider in Blender 4: (2, 0, -2) in its space is (1, 0, -2)
    double own = ( 0.5 * ( 1.0 + cos( PI / 4.0 ) ) - 1e-9 ), down = acos( own );
    assert_near( intensity( wide, 0, sin( down ), -cos( down ) ), 10.0 * 0.5 * ( is_4 ? 1.0 : own ) );
    assert_near( intensity( wide, ( is_4 ? 2.0 : 1.0 ) * sin( down ), 0, -cos( down ) ), 10.0 * 0.5 * ( is_4 ? 1.0 : own ) );
}

BLENDER_TEST( test_profiles_are_those_of_cycles )
{
    blender_make( "profiles lamps" );
    assert_null( strstr( blender_exported( "lamps", "" )->err, "warning" ) );
    AUTO_SCENE scene = convert_load( "lamps.glb" );
    check_lamps( &scene, blender_is_4() );
}

BLENDER_TEST( test_what_has_no_profile_is_lost_by_name )
{
    blender_make( "profiles lost" );
    const CliResult* done = blender_export( "lost", "" );
    assert_int_equal( done->status, 1 );
    static const char* const told[] = {
        "'panel': lamp, node 'IES Texture': its IES file is taken as the same to all sides: a lamp of the type area has no "
        "profile",
        "'sideways': lamp, node 'IES Texture': its IES file is taken as the same to all sides: only photometry of type C",
        "'missing': lamp, node 'IES Texture': its IES file is taken as the same to all sides: 'none.ies' cannot be read",
        "'dimmed': lamp, node 'IES Texture': its IES file is taken as the same to all sides: the light is not in proportion to "
        "it",
        "'gobo': lamp, node 'Vector Math': varies or is not known here: the lamp is taken without its nodes",
    };
    EXPECT_ALL_SAID( done->err, told );
}
