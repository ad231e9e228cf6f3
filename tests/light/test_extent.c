// Lamps with size: their light samples have the irradiance of closed forms and of quadratures over what shines, near and far, and
// bounded weights; pictures of them are those of emissive geometry.
#include "light/extent.h"
#include "light/light.h"
#include "light/punctual.h"
#include "support/render_support.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"

#include "base/random.h"

#define PI 3.14159265358979324

typedef RfExtentSample ( *Draw )( const RfPunctual* lamp, RfVec3 from, const float u[2] );

static RfExtentSample sample_sun( const RfPunctual* lamp, RfVec3 from, const float u[2] )
{
    (void)from;
    return rf_sample_sun( lamp, u );
}

// Irradiance of a surface at `from`, over the intensity, by stratified samples; `most`: the largest weight.
static double irradiance( Draw sample, const RfPunctual* lamp, RfVec3 from, RfVec3 normal, double* most )
{
    enum
    {
        ROWS = 400
    };
    double sum = 0.0;
    *most = 0.0;
    for ( int i = 0; i < ROWS * ROWS; ++i )
    {
        float u[2] = { ( (float)( i % ROWS ) + 0.5f ) / ROWS, ( (float)( i / ROWS ) + 0.5f ) / ROWS };
        RfExtentSample s = sample( lamp, from, u );
        if ( !( s.weight > 0.0f ) )
            continue;
        assert_true( fabsf( rf_length( s.wi ) - 1.0f ) < 1e-5f );
        sum += (double)( s.weight * rf_maxf( rf_dot( normal, s.wi ), 0.0f ) );
        *most = fmax( *most, (double)s.weight );
    }
    return sum / ( ROWS * ROWS );
}

static void check( const char* what, double got, double expected, double tolerance )
{
    printf( "%-40s %.6g, expected %.6g\n", what, got, expected );
    if ( !( fabs( got - expected ) <= tolerance * expected + 1e-9 ) )
        fail_msg( "%s: %g instead of %g", what, got, expected );
}

TEST( test_balls )
{
    RfPunctual lamp = make_point_light( rf_vec3( 1, 2, 3 ), 1.0f );
    RfVec3 tilted = rf_normalize( rf_vec3( 0, 0.8f, 0.3f ) ), up = rf_vec3( 0, 1, 0 );
    double cosine = (double)tilted.y, most;
    lamp.radius = 0.1f;
    static const double s_far[] = { 0.11, 0.2, 1.0, 50.0 };
    for ( int soft = 0; soft < 2; ++soft )
    {
        lamp.soft = soft;
        for ( int i = 0; i < 4; ++i )
        {
            double d = s_far[i], d2 = d * d + ( soft ? 0.01 : 0.0 );
            RfVec3 from = rf_vec3( 1, (float)( 2.0 - d ), 3 );
            check( soft ? "disc that faces it" : "ball", irradiance( rf_sample_ball, &lamp, from, up, &most ), 1.0 / d2, 2e-4 );
            assert_true( most <= 200.0 && most <= 2.0 / d2 * 1.0001 );
            if ( i > 1 ) // all of it above the horizon
                check( "tilted", irradiance( rf_sample_ball, &lamp, from, tilted, &most ), cosine / d2, 2e-4 );
            RfExtentSample s = rf_sample_ball( &lamp, from, ( float[2] ){ 0.3f, 0.6f } );
            RfVec3 at = rf_sub( rf_madd( from, s.wi, s.distance ), lamp.position );
            check( "at its surface", (double)( soft ? -at.y / lamp.radius : rf_length( at ) / lamp.radius ), soft ? 0.0 : 1.0,
                   1e-3 );
        }
    }
    lamp.soft = false;
    RfVec3 within = rf_vec3( 1, 1.95f, 3 );
    check( "within a ball", irradiance( rf_sample_ball, &lamp, within, up, &most ), 100.0, 1e-3 );
}

TEST( test_suns )
{
    RfVec3 up = rf_vec3( 0, 1, 0 ), none = rf_vec3( 0, 0, 0 );
    RfPunctual sun = make_point_light( none, 1.0f );
    double most;
    sun.kind = RF_PUNCTUAL_DIRECTIONAL;
    static const double s_angles[] = { 0.001, 0.5, 10.0, 90.0 };
    for ( int i = 0; i < 4; ++i )
    {
        double sine = sin( s_angles[i] * PI / 720.0 );
        sun.versine = (float)( 2.0 * sine * sine );
        sun.direction = rf_vec3( 0, -1, 0 );
        check( "sun", irradiance( sample_sun, &sun, none, up, &most ), 1.0, 1e-4 );
        sun.direction = rf_vec3( 0.6f, -0.8f, 0 );
        if ( i < 3 )
            check( "low sun", irradiance( sample_sun, &sun, none, up, &most ), 0.8, 1e-3 );
        assert_true( most < 2.0 );
    }
}

static RfPunctual make_plane( bool ellipse, double spread )
{
    RfPunctual plane = make_point_light( rf_vec3( 1, 2, 3 ), 1.0f );
    plane.kind = RF_PUNCTUAL_PLANE;
    plane.direction = rf_vec3( 0, 0, 1 );
    plane.across = rf_vec3( 0, 1, 0 );
    plane.half[0] = 0.6f;
    plane.half[1] = 0.2f;
    plane.ellipse = ellipse;
    double half = spread * PI / 360.0;
    if ( spread < 180.0 )
    {
        plane.tan_spread = (float)tan( half );
        plane.spread_scale = (float)( 1.0 / ( tan( half ) - half ) );
    }
    return plane;
}

// By area.
static double quadrature( const RfPunctual* plane, RfVec3 from, RfVec3 normal )
{
    enum
    {
        ROWS = 3000
    };
    double sum = 0.0;
    RfVec3 up = rf_plane_up( plane );
    for ( int i = 0; i < ROWS * ROWS; ++i )
    {
        float x = 2.0f * ( (float)( i % ROWS ) + 0.5f ) / ROWS - 1.0f, y = 2.0f * ( (float)( i / ROWS ) + 0.5f ) / ROWS - 1.0f;
        if ( plane->ellipse && x * x + y * y > 1.0f )
            continue;
        RfVec3 p = rf_madd( rf_madd( plane->position, plane->across, x * plane->half[0] ), up, y * plane->half[1] );
        RfVec3 way = rf_sub( p, from );
        double d = (double)rf_length( way ), cosine = -(double)rf_dot( plane->direction, way ) / d;
        double spread =
            plane->tan_spread > 0.0f
                ? fmax( (double)plane->tan_spread - sqrt( 1.0 - cosine * cosine ) / cosine, 0.0 ) * (double)plane->spread_scale
                : 1.0;
        sum += fmax( (double)rf_dot( normal, way ) / d, 0.0 ) * cosine * spread / ( d * d );
    }
    return sum * 4.0 * (double)plane->half[0] * (double)plane->half[1] / ( ROWS * (double)ROWS ) / rf_plane_area( plane );
}

TEST( test_planes )
{
    static const float s_places[][3] = {
        { 1, 2, 3.02f }, { 1.1f, 2.5f, 3.2f }, { 1.5f, 3, 3.4f }, { 1.2f, 2.3f, 9 }, { 1, 2, 8000 }
    };
    for ( int k = 0; k < 30; ++k )
    {
        RfPunctual plane = make_plane( k % 2, k / 10 == 0 ? 180.0 : k / 10 == 1 ? 120.0 : 30.0 );
        const float* p = s_places[k / 2 % 5];
        RfVec3 from = rf_vec3( p[0], p[1], p[2] ), to = rf_normalize( rf_sub( plane.position, from ) );
        char what[64];
        snprintf( what, sizeof what, "%s, spread %d, place %d", k % 2 ? "ellipse" : "rectangle", k / 10, k / 2 % 5 );
        double most, got = irradiance( rf_sample_plane, &plane, from, to, &most );
        check( what, got, quadrature( &plane, from, to ), 4e-3 );
        // a hemisphere of its radiance, at most
        assert_true( most <= 2.0 * PI * 1.001 / rf_plane_area( &plane ) * (double)rf_spread_falloff( &plane, 1.0f ) );
        RfExtentSample behind = rf_sample_plane( &plane, rf_vec3( p[0], p[1], 6.0f - p[2] ), ( float[2] ){ 0.3f, 0.4f } );
        assert_true( behind.weight == 0.0f );
    }
    // the flux does not depend on the spread: a narrow one is so much brighter on the axis
    RfPunctual narrow = make_plane( false, 30.0 );
    double sum = 0.0;
    for ( int i = 0; i < 100000; ++i )
    {
        double cosine = ( i + 0.5 ) * 1e-5;
        sum += 2.0 * PI * cosine * (double)rf_spread_falloff( &narrow, (float)cosine ) * 1e-5;
    }
    check( "flux", sum, PI, 1e-3 );
}

// Light at one bounce on a floor, walls and a box below what shines.
static Images lit( RfPunctual lamp, bool geometry, int spp )
{
    SceneBuilder b = { 0 };
    uint32_t white = add_material( &b, make_lambert( 0.7f, 0.6f, 0.5f ) ), coat = add_material( &b, make_plastic( 0.5f, 0.3f ) );
    add_box( &b, white, rf_vec3( -2, 0, -2 ), rf_vec3( 2, 4, 2 ), true );
    add_box( &b, coat, rf_vec3( -0.5f, 0.001f, -0.5f ), rf_vec3( 0.3f, 0.8f, 0.4f ), false );
    if ( geometry && lamp.kind == RF_PUNCTUAL_PLANE )
    {
        RfVec3 x = rf_scale( lamp.across, lamp.half[0] ), y = rf_scale( rf_plane_up( &lamp ), lamp.half[1] ), p = lamp.position;
        RfMaterial light = make_light( 1.0f, false );
        light.emission = rf_scale( lamp.intensity, (float)( 1.0 / rf_plane_area( &lamp ) ) );
        add_quad( &b, add_material( &b, light ), rf_sub( rf_sub( p, x ), y ), rf_add( rf_sub( p, x ), y ),
                  rf_add( rf_add( p, x ), y ), rf_sub( rf_add( p, x ), y ) );
    }
    if ( geometry && lamp.kind == RF_PUNCTUAL_POINT )
    {
        RfMaterial light = make_light( 1.0f, false );
        light.emission = rf_scale( lamp.intensity, 1.0f / ( RF_PI * lamp.radius * lamp.radius ) );
        add_sphere( &b, add_material( &b, light ), lamp.position, lamp.radius, 48 );
    }
    AUTO_SCENE scene = finish_scene( &b );
    if ( !geometry )
    {
        scene.punctuals = malloc( sizeof *scene.punctuals );
        assert_non_null( scene.punctuals );
        scene.punctuals[0] = lamp;
        scene.punctual_count = 1;
    }
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eye = rf_make_eye( rf_vec3( 0.3f, 1.4f, 1.9f ), rf_vec3( -0.1f, -0.6f, -1 ), rf_vec3( 0, 1, 0 ), 0.9, 24, 18 );
    RfRenderSettings settings = plain_settings();
    settings.group = 0;
    settings.spp = spp;
    settings.max_depth = 2;
    Images images = rendered_images( tracer, &eye, 1, 0, settings );
    return images;
}

static void check_lit( const char* what, RfPunctual lamp )
{
    Images lamps = lit( lamp, false, 16 ), geometry = lit( lamp, true, 16 );
    assert_unbiased( what, &lamps, &geometry, 4 );
    free_images( &lamps );
    free_images( &geometry );
}

TEST( test_pictures_are_those_of_geometry )
{
    RfPunctual plane = make_plane( false, 180.0 );
    plane.position = rf_vec3( 0.1f, 1.6f, 0 );
    plane.direction = rf_normalize( rf_vec3( -0.3f, -1, 0.1f ) );
    plane.across = rf_normalize( rf_cross( plane.direction, rf_vec3( 0, 0, 1 ) ) );
    check_lit( "plane", plane );
    RfPunctual ball = make_point_light( rf_vec3( 0.2f, 1.7f, 0.1f ), 3.0f );
    ball.radius = 0.3f;
    check_lit( "ball", ball );
}
