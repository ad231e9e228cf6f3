// The thin lens and the shutter against closed forms.
#include "scene/lens.h"
#include "scene/pinhole.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/test.h"

#define SAMPLES 4096

static RfEye test_eye( void )
{
    return rf_make_eye( rf_vec3( 0.3f, 1.2f, 2.0f ), rf_vec3( 0.2f, -0.1f, -1.0f ), rf_vec3( 0, 1, 0 ), 0.7, 640, 480 );
}

// A point before the eye: pixels from the middle of the film, and metres along the view.
static RfVec3 point_before( const RfEye* eye, float x, float y, float depth )
{
    RfVec3 d = rf_madd( rf_madd( eye->forward, eye->right, x / eye->focal_x ), eye->up, y / eye->focal );
    return rf_madd( eye->origin, d, depth );
}

// Two well spread numbers.
static RfLensSample sample( int i )
{
    double u = ( i + 0.5 ) / SAMPLES, v = i * 0.6180339887498949;
    return ( RfLensSample ){ (float)u, (float)( v - (int)v ), 0.5f };
}

static void film_position( const RfEye* eye, RfVec3 p, float at[2] )
{
    assert_true( rf_pinhole_position( eye, rf_sub( p, rf_pinhole_origin( eye ) ), at ) > 0.0f );
}

TEST( test_points_in_focus_stay_in_place )
{
    RfEye eye = test_eye();
    rf_shift_eye( &eye, 1.3, 0.1, -0.05 );
    rf_set_lens( &eye, 0.05, 3.0, 7, 0.3 );
    RfVec3 p = point_before( &eye, 100.0f, -50.0f, 3.0f );
    float middle[2];
    film_position( &eye, p, middle );
    for ( int i = 0; i < SAMPLES; i += 7 )
    {
        RfEye pinhole = rf_sample_eye( &eye, sample( i ) );
        float at[2];
        film_position( &pinhole, p, at );
        assert_float_equal( at[0], middle[0], 2e-3 );
        assert_float_equal( at[1], middle[1], 2e-3 );
    }
}

// A point at depth z of a lens of radius R focused at F: a disc of radius f R |1/F − 1/z|, in pixels with f. The mean
// squared distance of its points is half the square of that.
static void check_circle( float depth, double focus )
{
    const double radius = 0.05;
    RfEye eye = test_eye();
    rf_set_lens( &eye, radius, focus, 0, 0.0 );
    RfVec3 p = point_before( &eye, 30.0f, 20.0f, depth );
    double expected = (double)eye.focal * radius * fabs( 1.0 / focus - 1.0 / (double)depth ), square = 0.0, most = 0.0;
    for ( int i = 0; i < SAMPLES; ++i )
    {
        RfEye pinhole = rf_sample_eye( &eye, sample( i ) );
        float at[2];
        film_position( &pinhole, p, at );
        double dx = (double)at[0] - 30.0, dy = (double)at[1] - 20.0, r2 = dx * dx + dy * dy;
        square += r2 / SAMPLES;
        most = fmax( most, sqrt( r2 ) );
    }
    assert_float_equal( sqrt( 2.0 * square ), expected, 2e-3 * expected + 1e-3 );
    assert_true( most <= expected * 1.0001 + 2e-3 );
    assert_true( most >= expected * 0.98 - 2e-3 );
}

TEST( test_circles_of_confusion_are_those_of_the_thin_lens )
{
    check_circle( 2.0f, 3.0 );
    check_circle( 6.0f, 3.0 );
    check_circle( 1000.0f, 3.0 );
    check_circle( 2.0f, 1e9 ); // as good as infinity
    check_circle( 2.0f, HUGE_VAL );
}

// A uniform point of a regular n-gon in the unit circle: the mean squared distance from the middle is
// ( 1 + 2 cos²(π/n) ) / 6, and every point is inside.
TEST( test_blades_make_a_polygon )
{
    for ( int blades = 3; blades <= 9; ++blades )
    {
        RfEye eye = test_eye();
        rf_set_lens( &eye, 1.0, 2.0, blades, 0.4 );
        double square = 0.0, x = 0.0, y = 0.0, inner = cos( 3.14159265358979 / blades );
        for ( int i = 0; i < SAMPLES; ++i )
        {
            float p[2];
            RfLensSample s = sample( i );
            rf_lens_point( &eye, s.u, s.v, p );
            square += (double)( p[0] * p[0] + p[1] * p[1] ) / SAMPLES;
            x += (double)p[0] / SAMPLES;
            y += (double)p[1] / SAMPLES;
            for ( int k = 0; k < blades; ++k )
            {
                double normal = 0.4 + ( 2 * k + 1 ) * 3.14159265358979 / blades;
                assert_true( (double)p[0] * cos( normal ) + (double)p[1] * sin( normal ) <= inner + 1e-5 );
            }
        }
        assert_float_equal( square, ( 1.0 + 2.0 * inner * inner ) / 6.0, 2e-3 );
        assert_float_equal( x, 0.0, 2e-3 );
        assert_float_equal( y, 0.0, 2e-3 );
    }
}

TEST( test_the_shutter_goes_through_its_poses )
{
    RfEye eye = test_eye(), open = eye, close = eye;
    open.origin = rf_add( eye.origin, rf_vec3( -0.1f, 0.02f, 0.0f ) );
    close = rf_make_eye( rf_add( eye.origin, rf_vec3( 0.2f, 0, 0 ) ), rf_vec3( 0.3f, -0.1f, -1.0f ), rf_vec3( 0, 1, 0 ), 0.6, 640,
                         480 );
    rf_set_shutter( &eye, &open, &close );
    assert_true( eye.moves );
    const RfEye* wanted[] = { &open, &eye, &close };
    for ( int k = 0; k < 3; ++k )
    {
        RfEye at = rf_sample_eye( &eye, ( RfLensSample ){ 0.0f, 0.0f, 0.5f * (float)k } );
        assert_float_equal( rf_length( rf_sub( at.origin, wanted[k]->origin ) ), 0.0, 1e-6 );
        assert_float_equal( rf_length( rf_sub( at.forward, wanted[k]->forward ) ), 0.0, 1e-6 );
        assert_float_equal( rf_length( rf_sub( at.right, wanted[k]->right ) ), 0.0, 1e-6 );
        assert_float_equal( at.focal, wanted[k]->focal, 1e-3 );
        assert_false( at.moves );
    }
    rf_set_shutter( &eye, &eye, &eye );
    assert_false( eye.moves );
}

// A wall that shines to the left of an edge. The camera passes by so that the edge moves over the film at constant speed,
// twenty pixels while the shutter is open: a linear ramp.
TEST( test_a_moving_edge_is_a_ramp )
{
    enum
    {
        W = 48,
        H = 4
    };
    SceneBuilder builder = { 0 };
    uint32_t light = add_material( &builder, make_light( 1.0f, true ) ), dark = add_material( &builder, make_lambert( 0, 0, 0 ) );
    add_quad( &builder, light, rf_vec3( -9, -9, -2 ), rf_vec3( 0, -9, -2 ), rf_vec3( 0, 9, -2 ), rf_vec3( -9, 9, -2 ) );
    add_quad( &builder, dark, rf_vec3( 0, -9, -2 ), rf_vec3( 9, -9, -2 ), rf_vec3( 9, 9, -2 ), rf_vec3( 0, 9, -2 ) );
    AUTO_SCENE scene = finish_scene( &builder );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eyes[3], shut[3];
    for ( int i = 0; i < 3; ++i )
    {
        RfEye at[3];
        for ( int k = 0; k < 3; ++k )
        {
            at[k] = rf_make_eye( rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 0.3, W, H );
            at[k].origin.x = ( (float)( i - 1 ) + (float)( k - 1 ) ) * 20.0f / at[k].focal; // 10 px a step at 2 m
        }
        eyes[i] = shut[i] = at[1];
        rf_set_shutter( eyes + i, at, at + 2 );
    }
    (void)shut;
    RfRenderSettings settings = plain_settings();
    settings.group = 1;
    settings.spp = 3 * 2048;
    settings.max_depth = 1;
    int frame = 1;
    AUTO_BY( free_rendered ) Rendered r = render_frames( tracer, eyes, 3, &frame, 1, &settings );
    for ( int x = 0; x < W; ++x )
    {
        double sum = 0.0;
        for ( int y = 0; y < H; ++y )
            sum += (double)frame_rgb( &r, 0 )[3 * ( y * W + x )] / H;
        // the edge is at 24 − 20 t, t in [−½, ½] uniform; the mean over the pixel
        double wanted = 0.0;
        for ( int k = 0; k < 100; ++k )
            wanted += fmin( fmax( ( W / 2 + 10.0 - ( x + ( k + 0.5 ) / 100.0 ) ) / 20.0, 0.0 ), 1.0 ) / 100.0;
        assert_float_equal( sum, wanted, 0.03 );
    }
}

TEST( test_threads_change_nothing )
{
    AUTO_SCENE scene = make_room( ROOM_GGX );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfEye eyes[7], path[8];
    orbit_eyes( path, 8, 1.0f, 60, 44 );
    for ( int i = 0; i < 7; ++i )
    {
        eyes[i] = path[i];
        rf_set_lens( eyes + i, 0.05, 1.5, 6, 0.0 );
        rf_set_shutter( eyes + i, path + ( i > 0 ? i - 1 : 0 ), path + i + 1 );
    }
    eyes[0].lens_radius = 0.0f; // a path of which some frames are sharp
    eyes[0].moves = 0;
    RfRenderSettings settings = plain_settings();
    settings.group = 2;
    settings.spp = 5;
    settings.tile = ( RfTile ){ RF_TILE_BLOCK, 3, 3 };
    settings.threads = 1;
    AUTO_BY( free_rendered ) Rendered one = render_all( tracer, eyes, 7, &settings );
    settings.threads = 3;
    AUTO_BY( free_rendered ) Rendered three = render_all( tracer, eyes, 7, &settings );
    size_t bytes = 7 * 3 * one.pixels * sizeof( float );
    assert_memory_equal( one.rgb, three.rgb, bytes );
}
