// What a group gains: identical cameras are worth as many samples as there are, and the
// ends of a path are as good as its middle.
#include "measure/image_error.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 40
#define HEIGHT 30
#define BLOCK 5
#define ACROSS ( WIDTH / BLOCK )
#define BLOCKS ( ACROSS * ( HEIGHT / BLOCK ) )

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

static RfRenderSettings settings_of( int group, int spp, int seed )
{
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    settings.spp = spp;
    settings.max_depth = 4; // enough, and quick
    settings.seed = (uint64_t)seed + 1;
    settings.memory = (size_t)512 << 20;
    return settings;
}

#define VARIANCE_SEEDS 32

static void block_means( const float* rgb, double* means )
{
    memset( means, 0, BLOCKS * sizeof *means );
    for ( int i = 0; i < WIDTH * HEIGHT; ++i )
    {
        int b = i / WIDTH / BLOCK * ACROSS + i % WIDTH / BLOCK;
        means[b] += (double)( rgb[3 * i] + rgb[3 * i + 1] + rgb[3 * i + 2] ) / ( 3.0 * BLOCK * BLOCK );
    }
}

// Frame 2 of five equal eyes, block means by seed.
static void render_blocks( const RfTracer* tracer, const RfEye* eyes, int group, int spp, int first_seed,
                           double means[BLOCKS][VARIANCE_SEEDS] )
{
    int frame = 2;
    for ( int k = 0; k < VARIANCE_SEEDS; ++k )
    {
        RfRenderSettings settings = settings_of( group, spp, first_seed + k );
        Rendered r = render_frames( tracer, eyes, 5, &frame, 1, &settings );
        double blocks[BLOCKS];
        block_means( r.rgb, blocks );
        for ( int b = 0; b < BLOCKS; ++b )
            means[b][k] = blocks[b];
        free_rendered( &r );
    }
}

static void check_equal_eyes( const char* name, RfScene scene )
{
    static double group[BLOCKS][VARIANCE_SEEDS], plain[BLOCKS][VARIANCE_SEEDS];
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[5];
    orbit_eyes( eyes, 1, 0.0f, WIDTH, HEIGHT );
    for ( int i = 1; i < 5; ++i )
        eyes[i] = eyes[0];
    int passes = is_long() ? 16 : 4;
    render_blocks( tracer, eyes, 2, passes, 0, group );
    render_blocks( tracer, eyes, 0, 5 * passes, 1000, plain );
    double p[BLOCKS], ratio = 0.0;
    for ( int b = 0; b < BLOCKS; ++b )
    {
        double eg, ep;
        p[b] = welch_p( group[b], VARIANCE_SEEDS, plain[b], VARIANCE_SEEDS );
        mean_of( group[b], VARIANCE_SEEDS, &eg );
        mean_of( plain[b], VARIANCE_SEEDS, &ep );
        ratio += log( eg * eg / ( ep * ep ) ) / BLOCKS; // no block weighs more for being noisier
    }
    ratio = exp( ratio );
    double uniform = uniform_p( p, BLOCKS ), smallest = 1.0 - pow( 1.0 - p[0], BLOCKS );
    printf( "%s, five equal eyes: variance %.3f of plain path tracing's; blocks: smallest p %.3g, uniform p %.3g\n", name, ratio,
            smallest, uniform );
    assert_true( is_likely( smallest ) && is_likely( uniform ) );
    assert_true( ratio > 0.75 && ratio < 1.25 );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

TEST( test_equal_eyes_add_up_their_samples )
{
    check_equal_eyes( "diffuse", make_room( ROOM_DIFFUSE ) );
    check_equal_eyes( "GGX", make_room( ROOM_GGX ) );
}

#define MOST_FRAMES 21
#define END_SEEDS 8

static RfImage image_of( float* rgb ) { return ( RfImage ){ .width = WIDTH, .height = HEIGHT, .rgb = rgb }; }

static void check_ends( const char* name, RfScene scene, int path, int group, int spp )
{
    int frames[3] = { 0, path / 2, path - 1 };
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[MOST_FRAMES];
    orbit_eyes( eyes, path, 0.5f, WIDTH, HEIGHT );
    RfRenderSettings many = settings_of( 0, is_long() ? 16384 : 2048, 5000 );
    Rendered truth = render_frames( tracer, eyes, path, frames, 3, &many );
    double relmse[3] = { 0 };
    int seeds = is_long() ? 4 * END_SEEDS : END_SEEDS;
    for ( int k = 0; k < seeds; ++k )
    {
        RfRenderSettings settings = settings_of( group, spp, k );
        Rendered r = render_frames( tracer, eyes, path, frames, 3, &settings );
        for ( int f = 0; f < 3; ++f )
        {
            RfImage image = image_of( r.rgb + 3 * r.pixels * (size_t)f ),
                    reference = image_of( truth.rgb + 3 * r.pixels * (size_t)f );
            RfErrorMetrics metrics;
            RfError error;
            assert_int_equal( rf_measure_error( &image, &reference, &metrics, &error ), RF_OK );
            relmse[f] += metrics.relmse / seeds;
        }
        free_rendered( &r );
    }
    printf(
        "%s, %d frames, group %d, %d samples: relMSE of first, middle, last frame %.5f %.5f %.5f; ends over middle %.3f %.3f\n",
        name, path, group, spp, relmse[0], relmse[1], relmse[2], relmse[0] / relmse[1], relmse[2] / relmse[1] );
    assert_true( relmse[0] <= 1.3 * relmse[1] );
    assert_true( relmse[2] <= 1.3 * relmse[1] );
    free_rendered( &truth );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

TEST( test_the_ends_are_as_good )
{
    check_ends( "diffuse", make_room( ROOM_DIFFUSE ), 21, 3, 7 );
    check_ends( "diffuse", make_room( ROOM_DIFFUSE ), 21, 8, 17 ); // cut windows
    check_ends( "diffuse", make_room( ROOM_DIFFUSE ), 9, 3, 14 );
    if ( is_long() )
    {
        check_ends( "GGX", make_room( ROOM_GGX ), 21, 3, 28 );
        check_ends( "GGX", make_room( ROOM_GGX ), 21, 8, 34 );
    }
}

STATISTICAL_TESTS
