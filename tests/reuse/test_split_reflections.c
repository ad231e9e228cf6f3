// Split reflections (src/reuse/estimators.md, section 10): stacks of panes, slabs of glass and both in a mirror reflect what
// closed forms say, and with far less noise than if reflections were left to chance. So do what is seen through many dark panes
// and what one of them reflects, whatever frames share of it.
#include "support/rooms.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

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

TEST( test_panes_in_a_row )
{
    double f = fresnel( 1.0, 1.5 );
    check( "panes", PANES, DEEP, reflected( 3, f, false ), 0.1 );
    // panes that are passed do not count
    check( "panes", PANES, 2, reflected( 3, f, true ), 0.1 );
    check( "panes", PANES, 3, reflected( 3, f, true ), 0.1 );
}

TEST( test_a_slab )
{
    double f = fresnel( 1.0, 1.5 ), pass = ( 1.0 - f ) * ( 1.0 - f );
    check( "slab", SLAB, DEEP, reflected( 2, f, false ), 0.1 );
    check( "slab", SLAB, 2, f, 0.1 );
    check( "slab", SLAB, 3, f, 0.1 );
    check( "slab", SLAB, 4, f + pass * f, 0.1 );
}

TEST( test_panes_in_a_mirror )
{
    double mirror = MIRROR + ( 1.0 - MIRROR ) * pow( 1.0 - sqrt( 0.5 ), 5.0 ), both = mirror * mirror, f = fresnel( 1.0, 1.5 );
    check( "panes in a mirror", IN_MIRROR, DEEP, both * reflected( 3, f, false ), 0.1 );
    check( "panes in a mirror", IN_MIRROR, 4, both * reflected( 3, f, true ), 0.1 );
}

static void assert_near( const char* what, double found, double wanted, double tolerance )
{
    printf( "%s: %.5f, wanted %.5f\n", what, found, wanted );
    assert_true( fabs( found / wanted - 1.0 ) < tolerance );
}

// Of the middle one of three frames, with tiles and --max-depth 2.
static double mean_green( const RfTracer* tracer, const RfEye* eyes, int group, RfWeights weights )
{
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    settings.weights = weights;
    settings.spp = 64;
    settings.max_depth = 2;
    assert_true( rf_parse_tile( "2x2", &settings.tile ) );
    Rendered r = render_frames( tracer, eyes, 3, &( int ){ 1 }, 1, &settings );
    double sum = 0.0;
    for ( size_t i = 0; i < r.pixels; ++i )
        sum += (double)r.rgb[3 * i + 1] / (double)r.pixels;
    free_rendered( &r );
    return sum;
}

#define DARK 0.5f

// A wall that shines behind panes so dark that a chain over four of them would be a case for Russian roulette.
TEST( test_a_lamp_behind_many_dark_panes )
{
    double pass = (double)DARK * ( 1.0 - fresnel( 1.0, 1.5 ) );
    for ( int panes = 3; panes <= 6; ++panes )
    {
        SceneBuilder b = { 0 };
        add_sheet( &b, add_material( &b, make_light( 1.0f, false ) ), 9.0f, -3.0f );
        uint32_t dark = add_material( &b, make_thin_pane( rf_vec3( DARK, DARK, DARK ), 0.0f ) );
        for ( int k = 0; k < panes; ++k )
            add_sheet( &b, dark, 2.0f, 0.2f * (float)k );
        RfScene scene = finish_scene( &b );
        RfTracer* tracer = make_tracer( &scene );
        RfEye eyes[3];
        for ( int i = 0; i < 3; ++i )
            eyes[i] = rf_make_eye( rf_vec3( 0, 0, 4.0f - 0.01f * (float)i ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 0.05, WIDTH,
                                   WIDTH );
        for ( int group = 0; group < 2; ++group )
        {
            char what[64];
            snprintf( what, sizeof what, "%d dark panes, group %d", panes, group );
            assert_near( what, mean_green( tracer, eyes, group, RF_WEIGHTS_EXACT ), pow( pass, panes ), 0.1 );
        }
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &scene );
    }
}

// What is seen through a pane at --max-depth 2 has light samples, by all weights; those that compare do not follow camera rays.
TEST( test_a_floor_below_a_pane )
{
    SceneBuilder b = { 0 };
    uint32_t ground = add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) );
    uint32_t pane = add_material( &b, make_thin_pane( rf_vec3( 1, 1, 1 ), 0.0f ) );
    for ( int k = 0; k < 2; ++k )
        add_quad( &b, k == 0 ? ground : pane, rf_vec3( -9, (float)k, 9 ), rf_vec3( 9, (float)k, 9 ), rf_vec3( 9, (float)k, -9 ),
                  rf_vec3( -9, (float)k, -9 ) );
    RfScene scene = finish_scene( &b );
    scene.punctual_count = 1;
    scene.punctuals = calloc( 1, sizeof *scene.punctuals );
    scene.punctuals[0] = make_point_light( rf_vec3( 0, 3.0f, 0 ), 10.0f );
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[3];
    for ( int i = 0; i < 3; ++i )
        eyes[i] = rf_make_eye( rf_vec3( 0.02f * (float)i - 0.02f, 2.5f, 0 ), rf_vec3( 0, -1, 0 ), rf_vec3( 0, 0, -1 ), 0.05,
                               WIDTH, WIDTH );
    double pass = 1.0 - fresnel( 1.0, 1.5 ), want = 0.5 / 3.14159265358979 * 10.0 / 9.0 * pass * pass;
    static const RfWeights s_weights[] = { RF_WEIGHTS_EXACT, RF_WEIGHTS_EQ15, RF_WEIGHTS_UNWEIGHTED };
    for ( int w = 0; w < 3; ++w )
    {
        char what[64];
        snprintf( what, sizeof what, "floor below a pane, weights %d", w );
        assert_near( what, mean_green( tracer, eyes, 1, s_weights[w] ), want, 0.02 );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

// Rows of the picture of a wall that shines, in a dark pane: F by the angle of each row.
static double reflected_in_row( const RfEye* eye, int row )
{
    enum
    {
        PARTS = 16
    };
    double sum = 0.0;
    for ( int k = 0; k < PARTS * PARTS; ++k )
    {
        float fx = ( (float)( k % PARTS ) + 0.5f ) / PARTS * (float)eye->width - eye->axis_x;
        float fy = eye->axis_y - (float)row - ( (float)( k / PARTS ) + 0.5f ) / PARTS;
        RfVec3 d = rf_madd( rf_madd( eye->forward, eye->right, fx / eye->focal_x ), eye->up, fy / eye->focal );
        sum += fresnel( -(double)rf_normalize( d ).y, 1.5 ) / ( PARTS * PARTS );
    }
    return sum;
}

// Some of the eyes see what it shows at angles at which it reflects more often than not, others do not.
TEST( test_a_lamp_in_a_dark_pane )
{
    enum
    {
        HEIGHT = 18,
        EYES = 7
    };
    SceneBuilder b = { 0 };
    uint32_t pane = add_material( &b, make_thin_pane( rf_vec3( 0.05f, 0.05f, 0.05f ), 0.0f ) );
    uint32_t black = add_material( &b, make_lambert( 0, 0, 0 ) ), lamp = add_material( &b, make_light( 1.0f, true ) );
    for ( int k = 0; k < 2; ++k )
    {
        float y = k == 0 ? 0.0f : -0.1f;
        add_quad( &b, k == 0 ? pane : black, rf_vec3( -30, y, 9 ), rf_vec3( 30, y, 9 ), rf_vec3( 30, y, -9 ),
                  rf_vec3( -30, y, -9 ) );
    }
    add_quad( &b, lamp, rf_vec3( -60, 0, -9 ), rf_vec3( 60, 0, -9 ), rf_vec3( 60, 60, -9 ), rf_vec3( -60, 60, -9 ) );
    RfScene scene = finish_scene( &b );
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    for ( int i = 0; i < EYES; ++i )
        eyes[i] = rf_make_eye( rf_vec3( 0, 0.8f + 0.5f * (float)i, 2.6f ), rf_vec3( 0, -1, -1 ), rf_vec3( 0, 1, 0 ), 0.7, WIDTH,
                               HEIGHT );
    for ( int group = 0; group <= 3; group += 3 )
    {
        RfRenderSettings settings = plain_settings();
        settings.group = group;
        settings.spp = 128;
        settings.max_depth = 4;
        assert_true( rf_parse_tile( "2x2", &settings.tile ) );
        Rendered r = render_frames( tracer, eyes, EYES, &( int ){ EYES / 2 }, 1, &settings );
        for ( int row = 0; row < HEIGHT; ++row )
        {
            double sum = 0.0;
            for ( int x = 0; x < WIDTH; ++x )
                sum += (double)r.rgb[3 * ( row * WIDTH + x ) + 1] / WIDTH;
            char what[64];
            snprintf( what, sizeof what, "dark pane, group %d, row %d", group, row );
            assert_near( what, sum, reflected_in_row( eyes + EYES / 2, row ), 0.04 );
        }
        free_rendered( &r );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}
