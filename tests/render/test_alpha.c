// Alpha: over the sky the picture is the one without alpha, to the last digits; its mean is an independent count of
// rays that hit something; panes and mirrors cover, holes do not.
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/statistics.h"
#include "support/test.h"

#include "base/random.h"
#include "reuse/tile/tile.h"
#include "scene/pinhole.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define EYES 5
#define WIDTH 32
#define HEIGHT 24
#define PIXELS ( WIDTH * HEIGHT )

// The middle frame of the path; alpha is in `aovs`.
static const RfFrameResult* render( Stage* stage, RfRenderSettings settings, bool alpha )
{
    settings.aovs = alpha ? RF_AOV_BIT( RF_AOV_ALPHA ) : 0u;
    return render_one( stage, EYES / 2, &settings );
}

static RfRenderSettings tiled( int group, int spp, const char* tile )
{
    RfRenderSettings settings = tiled_settings( group, spp, tile );
    settings.adaptive = RF_ADAPTIVE_OFF;
    return settings;
}

static RfRenderSettings by_gradients( int spp, const char* tile, RfReconstruction reconstruction )
{
    RfRenderSettings settings = tiled( 0, spp, tile );
    settings.estimator = rf_find_estimator( "gradient" );
    settings.reconstruction = reconstruction;
    return settings;
}

// The floor, the ball and the block of an open scene, before its sky.
static void open_eyes( RfEye* eyes, float step )
{
    for ( int i = 0; i < EYES; ++i )
        eyes[i] = rf_make_eye( rf_vec3( step * (float)( i - EYES / 2 ), 1.2f, 4.5f ), rf_vec3( 0, -0.05f, -1 ),
                               rf_vec3( 0, 1, 0 ), 0.7, WIDTH, HEIGHT );
}

static void check_over_sky( const char* what, Stage* stage, RfRenderSettings settings )
{
    const RfFrameResult *with = render( stage, settings, true ), *without = render( stage, settings, false );
    const float* alpha = with->aovs[RF_AOV_ALPHA];
    RfVec3 sky = stage->scene.environment.radiance;
    const float background[3] = { sky.x, sky.y, sky.z };
    double most = 0.0;
    int part = 0;
    for ( int i = 0; i < PIXELS; ++i )
    {
        part += alpha[i] != 0.0f && alpha[i] != 1.0f;
        for ( int c = 0; c < 3; ++c )
        {
            float over = with->rgb[3 * i + c] + ( 1.0f - alpha[i] ) * background[c];
            most = fmax( most, fabs( (double)( over - without->rgb[3 * i + c] ) ) );
        }
    }
    printf( "%s: over the sky %.2g off at most, %d pixels covered in part\n", what, most, part );
    assert_true( most < 2e-6 );
    assert_true( part > 20 );
}

TEST( test_over_the_sky_it_is_the_picture_without )
{
    Stage stage;
    open_stage( &stage, make_open_scene( LIT_BY_SKY ), EYES, 0.0f, WIDTH, HEIGHT );
    open_eyes( stage.eyes, 0.2f );
    check_over_sky( "path tracing", &stage, tiled( 0, 8, "1" ) );
    check_over_sky( "tiles", &stage, tiled( 0, 8, "3x3" ) );
    check_over_sky( "group", &stage, tiled( 2, 10, "1" ) );
    check_over_sky( "group and tiles", &stage, tiled( 2, 20, "3x3" ) );
    RfRenderSettings filtered = tiled( 2, 10, "3x3" ), ratio = filtered;
    filtered.filter = RF_FILTER_BLACKMAN_HARRIS;
    ratio.normalize = RF_NORMALIZE_RATIO;
    check_over_sky( "pixel filter", &stage, filtered );
    check_over_sky( "ratio", &stage, ratio );
    check_over_sky( "pixels of gradients", &stage, by_gradients( 4, "6x6", RF_RECONSTRUCTION_NONE ) );
    const RfFrameResult* one = render( &stage, filtered, true );
    filtered.threads = 3;
    expect_same_bits( one, render( &stage, filtered, true ) );
    close_stage( &stage );
}

#define SEEDS 12
#define BLOCK 4
#define BLOCKS ( PIXELS / ( BLOCK * BLOCK ) )

static void add_to_blocks( const float* alpha, int k, double blocks[BLOCKS + 1][SEEDS] )
{
    for ( int i = 0; i < PIXELS; ++i )
    {
        int block = i / WIDTH / BLOCK * ( WIDTH / BLOCK ) + i % WIDTH / BLOCK;
        blocks[block][k] += (double)alpha[i] / ( BLOCK * BLOCK );
        blocks[BLOCKS][k] += (double)alpha[i] / PIXELS;
    }
}

// The share of some rays of each pixel that hit something.
static void count_rays( const RfTracer* tracer, const RfEye* eye, int k, float* alpha )
{
    const float inverse[2] = { 1.0f / eye->focal_x, 1.0f / eye->focal };
    for ( int i = 0; i < PIXELS; ++i )
    {
        RfRandomKey key = rf_pixel_key( rf_pass_key( 99, (uint32_t)k, 0, 0 ), (uint32_t)i );
        int hits = 0;
        for ( uint32_t s = 0; s < 16; ++s )
        {
            RfVec3 o = rf_pinhole_origin( eye ),
                   d = rf_pinhole_ray( eye, inverse, i % WIDTH, i / WIDTH, rf_random( key, 2 * s ), rf_random( key, 2 * s + 1 ) );
            const float *from[3] = { &o.x, &o.y, &o.z }, *way[3] = { &d.x, &d.y, &d.z };
            uint32_t triangle;
            float u, v;
            rf_trace_nearest( tracer, 1, from, way, false, &triangle, &u, &v );
            hits += triangle != RF_MISS;
        }
        alpha[i] = (float)hits / 16.0f;
    }
}

static void check_mean( const char* what, Stage* stage, RfRenderSettings settings )
{
    static double rendered[BLOCKS + 1][SEEDS], counted[BLOCKS + 1][SEEDS];
    memset( rendered, 0, sizeof rendered );
    memset( counted, 0, sizeof counted );
    for ( int k = 0; k < SEEDS; ++k )
    {
        float alpha[PIXELS];
        settings.seed = (uint64_t)k + 1;
        add_to_blocks( render( stage, settings, true )->aovs[RF_AOV_ALPHA], k, rendered );
        count_rays( stage->tracer, stage->eyes + EYES / 2, k, alpha );
        add_to_blocks( alpha, k, counted );
    }
    double least = 1.0, whole = welch_p( rendered[BLOCKS], SEEDS, counted[BLOCKS], SEEDS ), error;
    int part = 0;
    for ( int b = 0; b < BLOCKS; ++b )
    {
        double mean = mean_of( counted[b], SEEDS, &error );
        part += mean > 0.0 && mean < 1.0;
        least = fmin( least, welch_p( rendered[b], SEEDS, counted[b], SEEDS ) );
    }
    printf( "%s: mean %.5f, counted %.5f, p %.3f; least p of %d blocks at rims %.2g\n", what,
            mean_of( rendered[BLOCKS], SEEDS, &error ), mean_of( counted[BLOCKS], SEEDS, &error ), whole, part, least );
    assert_true( whole > 1e-4 && least * part > 1e-4 );
    assert_true( part > 10 );
}

TEST( test_its_mean_is_what_rays_hit )
{
    Stage stage; // no sky at all: alpha is the same
    open_stage( &stage, make_open_scene( LIT_BY_LAMPS ), EYES, 0.0f, WIDTH, HEIGHT );
    open_eyes( stage.eyes, 0.2f );
    check_mean( "path tracing", &stage, tiled( 0, 4, "1" ) );
    check_mean( "group and tiles", &stage, tiled( 2, 10, "3x3" ) );
    check_mean( "gradients", &stage, by_gradients( 2, "6x6", RF_RECONSTRUCTION_L2 ) );
    check_mean( "gradients, single pixels", &stage, by_gradients( 2, "1", RF_RECONSTRUCTION_L2 ) );
    RfRenderSettings adaptive = tiled( 2, 10, "3x3" );
    adaptive.adaptive = RF_ADAPTIVE_ON;
    open_eyes( stage.eyes, 1.5f ); // much that no other frame sees
    check_mean( "adaptive", &stage, adaptive );
    close_stage( &stage );
}

// A sheet at z = −3, from x = 0 on, whose rim halves the pixels of column 15.
static RfScene make_sheet( RfMaterial material )
{
    SceneBuilder b = { 0 };
    uint32_t m = add_material( &b, material );
    add_quad( &b, m, rf_vec3( 0, -50, -3 ), rf_vec3( 50, -50, -3 ), rf_vec3( 50, 50, -3 ), rf_vec3( 0, 50, -3 ) );
    RfScene scene = finish_scene( &b );
    scene.environment.radiance = rf_vec3( 2, 1, 0.5f );
    return scene;
}

static void check_sheet( const char* what, RfMaterial material, double radiance, double tolerance )
{
    Stage stage;
    RfEye eyes[EYES];
    for ( int i = 0; i < EYES; ++i )
    {
        eyes[i] = rf_make_eye( rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 0.8, WIDTH, HEIGHT );
        // half a pixel to the right at the sheet
        eyes[i].origin.x = 1.5f / eyes[i].focal;
    }
    double half = 0.0, colour = 0.0;
    open_stage_before( &stage, make_sheet( material ), eyes, EYES );
    const RfFrameResult* p = render( &stage, tiled( 2, 160, "3x3" ), true ); // 768 samples of its own in the column
    for ( int y = 0; y < HEIGHT; ++y )
    {
        for ( int x = 0; x < WIDTH; ++x )
        {
            const float* rgb = p->rgb + 3 * ( y * WIDTH + x );
            float alpha = p->aovs[RF_AOV_ALPHA][y * WIDTH + x];
            if ( x == 15 )
                half += (double)alpha / HEIGHT;
            else if ( x < 15 )
                assert_true( alpha == 0.0f && rgb[0] == 0.0f && rgb[1] == 0.0f && rgb[2] == 0.0f );
            else
            {
                assert_true( alpha == 1.0f );
                colour += (double)rgb[0] / ( HEIGHT * ( WIDTH - 16 ) );
            }
        }
    }
    printf( "%s: column at the rim %.3f, red behind it %.4f\n", what, half, colour );
    assert_true( fabs( half - 0.5 ) < 0.08 );
    assert_true( fabs( colour - radiance ) < tolerance );
    close_stage( &stage );
}

// As compositors have it unless they are reported otherwise: glass covers, and shows the sky in its colour.
TEST( test_panes_and_mirrors_cover )
{
    check_sheet( "Lambert", make_lambert( 0.5f, 0.5f, 0.5f ), 1.0, 0.02 );
    check_sheet( "mirror", make_mirror( 0.9f ), 1.8, 0.01 );
    check_sheet( "pane", make_thin_pane( rf_vec3( 1, 1, 1 ), 0.0f ), 2.0, 0.02 );
}
