// Hard cases of cameras: whatever the path does, pictures are finite and nothing crashes.
#include "support/render_support.h"
#include "support/test.h"

#define EYES 5
#define WIDTH 12
#define HEIGHT 9

static RfVec3 up( void ) { return rf_vec3( 0, 1, 0 ); }

// Eyes from `from` in steps of `step`, all along `forward`.
static void row_of_eyes( RfEye* eyes, RfVec3 from, RfVec3 step, RfVec3 forward, double yfov )
{
    for ( int i = 0; i < EYES; ++i )
        eyes[i] = rf_make_eye( rf_madd( from, step, (float)i ), forward, up(), yfov, WIDTH, HEIGHT );
}

static double check_room( const char* what, const RfEye* eyes, int count )
{
    double sum = 0.0;
    for ( int kind = ROOM_DIFFUSE; kind <= ROOM_GGX; ++kind )
    {
        AUTO_SCENE scene = make_room( (RoomKind)kind );
        sum += check_sane( what, &scene, eyes, count ) / 3.0;
    }
    return sum;
}

TEST( test_camera_inside_a_closed_box )
{
    RfEye eyes[EYES];
    // inside the block on the floor: no light gets in
    row_of_eyes( eyes, rf_vec3( 0, 0.2f, 0 ), rf_vec3( 0.02f, 0, 0 ), rf_vec3( 0.3f, 0.1f, -1 ), 0.9 );
    assert_true( check_room( "in the block", eyes, EYES ) == 0.0 );
    // inside an emitter that is bright on both sides
    SceneBuilder b = { 0 };
    add_box( &b, add_material( &b, make_light( 2.0f, true ) ), rf_vec3( -1, -1, -1 ), rf_vec3( 1, 1, 1 ), false );
    AUTO_SCENE scene = finish_scene( &b );
    row_of_eyes( eyes, rf_vec3( 0, 0, 0 ), rf_vec3( 0.02f, 0, 0 ), rf_vec3( 0, 0, -1 ), 0.9 );
    double mean = check_sane( "in an emitter", &scene, eyes, EYES );
    assert_true( fabs( mean - 2.0 * 2.9 / 3.0 ) < 1e-4 );
}

TEST( test_eyes_on_surfaces )
{
    RfEye eyes[EYES];
    row_of_eyes( eyes, rf_vec3( -0.3f, 0, 1.2f ), rf_vec3( 0.1f, 0, 0 ), rf_vec3( 0, 0.3f, -1 ), 0.9 );
    check_room( "on the floor", eyes, EYES );
    row_of_eyes( eyes, rf_vec3( 0, 1, 2 ), rf_vec3( 0.1f, 0, 0 ), rf_vec3( 0, 0, -1 ), 0.9 );
    check_room( "on the wall", eyes, EYES );
    row_of_eyes( eyes, rf_vec3( 0, 1.5f, 0 ), rf_vec3( 0.02f, -0.01f, 0 ), rf_vec3( 0, 0.2f, -1 ), 1.5 );
    check_room( "into the sphere", eyes, EYES );
    row_of_eyes( eyes, rf_vec3( 0, 1, 1.9f ), rf_vec3( 0, 0, 0.05f ), rf_vec3( 0, 0, -1 ), 0.9 );
    check_room( "through the wall", eyes, EYES );
    row_of_eyes( eyes, rf_vec3( -0.2f, 2.95f, 0 ), rf_vec3( 0.1f, 0, 0 ), rf_vec3( 0.1f, -1, 0 ), 0.9 );
    check_room( "in the light panel", eyes, EYES );
    row_of_eyes( eyes, rf_vec3( -0.2f, 2.95f, 1.2f ), rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, -1 ), 0.9 );
    check_room( "light edge-on", eyes, EYES );
    row_of_eyes( eyes, rf_vec3( 0, 0, 1.9f ), rf_vec3( 0, 0, -0.1f ), rf_vec3( 0, 0, -1 ), 0.6 );
    check_room( "along the floor", eyes, EYES );
}

// One eye of the group lies in the plane of what the others see, exactly.
TEST( test_eyes_in_a_surfaces_plane )
{
    RfMaterial materials[] = { make_lambert( 0.5f, 0.5f, 0.5f ), make_phong( 0.2f, 0.6f, 40.0f ), make_metal( 0.9f, 0.1f ) };
    for ( int m = 0; m < 3; ++m )
    {
        SceneBuilder b = { 0 };
        uint32_t light = add_material( &b, make_light( 10.0f, true ) );
        add_quad( &b, add_material( &b, materials[m] ), rf_vec3( -1, 0, 1 ), rf_vec3( 1, 0, 1 ), rf_vec3( 1, 0, -1 ),
                  rf_vec3( -1, 0, -1 ) );
        add_quad( &b, light, rf_vec3( -1, 1, -1 ), rf_vec3( 1, 1, -1 ), rf_vec3( 1, 2, -1 ), rf_vec3( -1, 2, -1 ) );
        AUTO_SCENE scene = finish_scene( &b );
        RfEye eyes[EYES];
        row_of_eyes( eyes, rf_vec3( 0, 0.02f, 2 ), rf_vec3( 0, -0.01f, 0 ), rf_vec3( 0, 0, -1 ), 0.6 ); // eye 2 at y = 0
        check_sane( "in the plane", &scene, eyes, EYES );
        for ( int i = 0; i < EYES; ++i )
            eyes[i].origin.y = 0.0f;
        check_sane( "all in the plane", &scene, eyes, EYES );
        row_of_eyes( eyes, rf_vec3( 0.1f, 1e-20f, 0.3f ), rf_vec3( 0, 0.1f, 0 ), rf_vec3( 0, -1, -1e-3f ),
                     0.9 ); // as good as on it
        check_sane( "on the plane", &scene, eyes, EYES );
    }
}

TEST( test_odd_image_sizes )
{
    static const int sizes[][2] = { { 1, 1 }, { 1, 200 }, { 65, 1 }, { 33, 3 } };
    for ( int k = 0; k < 4; ++k )
    {
        RfEye eyes[EYES];
        orbit_eyes( eyes, EYES, 3.0f, sizes[k][0], sizes[k][1] );
        assert_true( check_room( "odd size", eyes, EYES ) > 0.0 );
        check_room( "one frame", eyes, 1 );
        check_room( "two frames", eyes, 2 );
    }
}

TEST( test_extreme_fields_of_view )
{
    const double degree = (double)RF_PI / 180.0;
    RfEye eyes[EYES];
    row_of_eyes( eyes, rf_vec3( 0, 1.2f, 1.7f ), rf_vec3( 0.05f, 0, 0 ), rf_vec3( 0, 0, -1 ), 170.0 * degree );
    assert_true( check_room( "170 degrees", eyes, EYES ) > 0.0 );
    row_of_eyes( eyes, rf_vec3( 0, 1.2f, 1.7f ), rf_vec3( 0.05f, 0, 0 ), rf_vec3( 0, 0, -1 ), 179.99 * degree );
    check_room( "179.99 degrees", eyes, EYES );
    row_of_eyes( eyes, rf_vec3( 0, 1.2f, 1.7f ), rf_vec3( 1e-5f, 0, 0 ), rf_vec3( 0, 0, -1 ), 0.01 * degree );
    assert_true( check_room( "0.01 degrees", eyes, EYES ) > 0.0 );
    orbit_eyes( eyes, EYES, 72.0f, WIDTH, HEIGHT ); // all around
    check_room( "far apart", eyes, EYES );
    orbit_eyes( eyes, EYES, 0.0f, WIDTH, HEIGHT );
    check_room( "all the same", eyes, EYES );
}

TEST( test_nothing_to_see_is_black )
{
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    RfScene empty = { 0 };
    assert_true( check_sane( "no triangles", &empty, eyes, EYES ) == 0.0 );
    SceneBuilder b = { 0 };
    add_box( &b, add_material( &b, make_plastic( 0.5f, 0.3f ) ), rf_vec3( -2, 0, -2 ), rf_vec3( 2, 3, 2 ), true );
    AUTO_SCENE dark = finish_scene( &b );
    assert_true( check_sane( "no lights", &dark, eyes, EYES ) == 0.0 );
    SceneBuilder away = { 0 };
    add_box( &away, add_material( &away, make_light( 1.0f, true ) ), rf_vec3( -2, 0, 20 ), rf_vec3( 2, 3, 22 ), true );
    AUTO_SCENE behind = finish_scene( &away );
    assert_true( check_sane( "all behind", &behind, eyes, EYES ) == 0.0 );
}
