// Split reflections (src/reuse/estimators.md, section 10): stacks of panes, slabs of glass and both in a mirror reflect what
// closed forms say, and with far less noise than if reflections were left to chance.
#include "support/pane_room.h"
#include "support/render_support.h"
#include "support/scene_builder.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#define WIDTH 12
#define SPP 32
#define DEEP 60
#define MIRROR 0.9

typedef enum Shown
{
    PANES,    // three in a row
    SLAB,     // of solid glass
    IN_MIRROR // the panes, which only the mirror shows
} Shown;

// A sheet across the z axis that faces +z.
static void add_sheet( SceneBuilder* b, uint32_t material, float half, float z )
{
    add_quad( b, material, rf_vec3( -half, -half, z ), rf_vec3( half, -half, z ), rf_vec3( half, half, z ),
              rf_vec3( -half, half, z ) );
}

// The eye at (0, 0, 4) looks down the z axis, at glass before a black wall; a wall behind it shines. With a mirror it is at
// (3, 0, 4) and looks along −x, at the mirror, which shows the glass what is behind the eye.
static RfScene make_stack( Shown shown )
{
    SceneBuilder b = { 0 };
    uint32_t black = add_material( &b, make_lambert( 0, 0, 0 ) ), lamp = add_material( &b, make_light( 1.0f, false ) );
    RfMaterial glass = make_glass( 1.5f, 0.0f, shown != SLAB );
    uint32_t clear = add_material( &b, glass );
    add_sheet( &b, black, 9.0f, -3.0f );
    add_quad( &b, lamp, rf_vec3( -9, -9, 9 ), rf_vec3( -9, 9, 9 ), rf_vec3( 9, 9, 9 ), rf_vec3( 9, -9, 9 ) ); // faces −z
    for ( int k = 0; k < 3 && shown != SLAB; ++k )
        add_sheet( &b, clear, 2.0f, 0.2f * (float)k );
    if ( shown == SLAB )
        add_box( &b, clear, rf_vec3( -2, -2, 0 ), rf_vec3( 2, 2, 0.3f ), false );
    if ( shown == IN_MIRROR )
    {
        uint32_t mirror = add_material( &b, make_mirror( (float)MIRROR ) );
        add_quad( &b, mirror, rf_vec3( -0.4f, -0.4f, 3.6f ), rf_vec3( -0.4f, 0.4f, 3.6f ), rf_vec3( 0.4f, 0.4f, 4.4f ),
                  rf_vec3( 0.4f, -0.4f, 4.4f ) );
        add_quad( &b, lamp, rf_vec3( 9, -9, 9 ), rf_vec3( 9, 9, 9 ), rf_vec3( 9, 9, -9 ), rf_vec3( 9, -9, -9 ) ); // faces −x
    }
    return finish_scene( &b );
}

// Of lossless surfaces that reflect f each, one behind the other; with `once`, by one reflection alone.
static double reflected( int surfaces, double f, bool once )
{
    double pass = 1.0, sum = 0.0;
    for ( int k = 0; k < surfaces; ++k, pass *= ( 1.0 - f ) * ( 1.0 - f ) )
        sum += f * pass;
    return once ? sum : surfaces * f / ( 1.0 + ( surfaces - 1 ) * f );
}

// Renders the middle one of three frames. Returns the mean of its pixels' green; *rms their difference from it.
static double render( Shown shown, int max_depth, int group, float* rms )
{
    RfScene scene = make_stack( shown );
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[3];
    RfVec3 o = rf_vec3( shown == IN_MIRROR ? 3.0f : 0.0f, 0, 4.0f ),
           way = rf_vec3( shown == IN_MIRROR ? -1.0f : 0.0f, 0, shown == IN_MIRROR ? 0.0f : -1.0f );
    for ( int i = 0; i < 3; ++i )
        eyes[i] = rf_make_eye( rf_madd( o, way, 0.01f * (float)i ), way, rf_vec3( 0, 1, 0 ), 0.05, WIDTH, WIDTH );
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    settings.spp = SPP;
    settings.max_depth = max_depth;
    settings.adaptive = RF_ADAPTIVE_OFF;
    assert_true( rf_parse_tile( "2x2", &settings.tile ) );
    int frame = 1;
    Rendered r = render_frames( tracer, eyes, 3, &frame, 1, &settings );
    double sum = 0.0, squares = 0.0;
    for ( size_t i = 0; i < r.pixels; ++i )
        sum += (double)r.rgb[3 * i + 1];
    sum /= (double)r.pixels;
    for ( size_t i = 0; i < r.pixels; ++i )
        squares += ( (double)r.rgb[3 * i + 1] - sum ) * ( (double)r.rgb[3 * i + 1] - sum );
    *rms = (float)sqrt( squares / (double)( r.pixels - 1 ) );
    free_rendered( &r );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
    return sum;
}

// `noise`: at most that of a pixel, relative; left to chance, reflections beyond the first one would have five times as much.
static void check( const char* what, Shown shown, int max_depth, double want, double noise )
{
    for ( int group = 0; group < 2; ++group )
    {
        float rms;
        double mean = render( shown, max_depth, group, &rms ), error = (double)rms / WIDTH;
        printf( "%s, depth %d, group %d: %.5f ± %.5f, wanted %.5f; a pixel's noise %.3f\n", what, max_depth, group, mean, error,
                want, (double)rms / want );
        assert_true( fabs( mean - want ) < 4.0 * error + 1e-3 * want );
        assert_true( (double)rms < noise * want );
    }
}

static void test_panes_in_a_row( void** state )
{
    (void)state;
    double f = fresnel( 1.0, 1.5 );
    check( "panes", PANES, DEEP, reflected( 3, f, false ), 0.1 );
    // panes that are passed do not count
    check( "panes", PANES, 2, reflected( 3, f, true ), 0.1 );
    check( "panes", PANES, 3, reflected( 3, f, true ), 0.1 );
}

static void test_a_slab( void** state )
{
    (void)state;
    double f = fresnel( 1.0, 1.5 ), pass = ( 1.0 - f ) * ( 1.0 - f );
    check( "slab", SLAB, DEEP, reflected( 2, f, false ), 0.1 );
    check( "slab", SLAB, 2, f, 0.1 );
    check( "slab", SLAB, 3, f, 0.1 );
    check( "slab", SLAB, 4, f + pass * f, 0.1 );
}

static void test_panes_in_a_mirror( void** state )
{
    (void)state;
    double mirror = MIRROR + ( 1.0 - MIRROR ) * pow( 1.0 - sqrt( 0.5 ), 5.0 ), both = mirror * mirror, f = fresnel( 1.0, 1.5 );
    check( "panes in a mirror", IN_MIRROR, DEEP, both * reflected( 3, f, false ), 0.1 );
    check( "panes in a mirror", IN_MIRROR, 4, both * reflected( 3, f, true ), 0.1 );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_panes_in_a_row ),
        cmocka_unit_test( test_a_slab ),
        cmocka_unit_test( test_panes_in_a_mirror ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
