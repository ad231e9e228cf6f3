// Extra own-frame samples where few other frames help leave the estimator unbiased and
// E[B] = 1: in rooms with mirrors and glass, with cameras far apart, without and with
// tiles.
#include "support/rooms.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define WIDTH 36
#define HEIGHT 27
#define BLOCK 6
#define EYES 7

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

static RfRenderSettings settings_of( int group, int spp, const char* tile )
{
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    settings.spp = spp;
    settings.max_depth = 5;
    settings.adaptive = RF_ADAPTIVE_ON;
    settings.memory = (size_t)512 << 20;
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    return settings;
}

// Of settings to test: the first so many, all with REFRAME_LONG.
static const char* const s_tiles[] = { "1", "3x3", "rooks4" };

static int tile_count( int tiles ) { return is_long() ? (int)( sizeof s_tiles / sizeof *s_tiles ) : tiles; }

// Mirrors and glass in the middle of the room: pixels of one class of noise beside those of the others. With the first of the
// tiles, where extra samples pay.
static void check_noisy( const char* what, MirrorRoom kind, int tiles )
{
    RfScene scene = make_mirror_room( kind );
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 4.0f, WIDTH, HEIGHT );
    int more = is_long() ? 4 : 1, frame = 3;
    RfRenderSettings plain = settings_of( 0, 1, "1" );
    Images reference = reference_images( tracer, eyes, frame, is_long() ? 384 : 48, &plain );
    for ( int t = 0; t < tile_count( tiles ); ++t )
    {
        char name[64];
        snprintf( name, sizeof name, "%s group 3 tile %s:", what, s_tiles[t] );
        RfRenderSettings settings = settings_of( 3, 12 * more, s_tiles[t] );
        Images rendered = rendered_images( tracer, eyes, EYES, frame, settings );
        assert_unbiased( name, &rendered, &reference, BLOCK );
        free_images( &rendered );
        Rendered one = render_frames( tracer, eyes, EYES, &frame, 1, &settings );
        printf( "%.2f extra samples\n", one.native_spp[0] - one.stats.spp );
        assert_true( one.native_spp[0] > one.stats.spp + 0.1 ); // else nothing was tested
        free_rendered( &one );
    }
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

// Eyes `degrees` apart, but the middle one, whose picture it is, 3 `aside` degrees off the middle.
static void check( const char* what, RfScene scene, float degrees, float aside, RfAdaptive adaptive, int tiles )
{
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    RfEye away[EYES];
    orbit_eyes( eyes, EYES, degrees, WIDTH, HEIGHT );
    orbit_eyes( away, EYES, aside, WIDTH, HEIGHT );
    eyes[EYES / 2] = away[EYES - 1];
    int more = is_long() ? 4 : 1, frame = 3;
    RfRenderSettings plain = settings_of( 0, 1, "1" );
    Images reference = reference_images( tracer, eyes, frame, is_long() ? 384 : 48, &plain );
    for ( int t = 0; t < tile_count( tiles ); ++t )
    {
        char name[64];
        snprintf( name, sizeof name, "%s group 3 tile %s:", what, s_tiles[t] );
        RfRenderSettings settings = settings_of( 3, 12 * more, s_tiles[t] );
        settings.adaptive = adaptive;
        Images rendered = rendered_images( tracer, eyes, EYES, frame, settings );
        assert_unbiased( name, &rendered, &reference, BLOCK );
        free_images( &rendered );
        Rendered one = render_frames( tracer, eyes, EYES, &frame, 1, &settings );
        printf( "%.2f extra samples\n", one.native_spp[0] - one.stats.spp );
        assert_true( one.native_spp[0] > one.stats.spp + 0.1 ); // else nothing was tested
        free_rendered( &one );
    }
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

TEST( test_glass_room ) { check( "glass", make_glass_room(), 12.0f, 2.0f, RF_ADAPTIVE_ON, 1 ); }

// Glass takes several samples of a pixel into one batch.
TEST( test_noisy_glass )
{
    check_noisy( "absorbing ball", ABSORBING_BALL, 1 );
    check_noisy( "mirror behind a pane", MIRROR_BEHIND_PANE, 1 );
    check_noisy( "mirror ball", MIRROR_BALL, 2 );
    check_noisy( "smooth plastic", SMOOTH_PLASTIC, 1 );
}

// Walls that no other frame sees.
TEST( test_another_view ) { check( "aside, Phong", make_room( ROOM_PHONG ), 2.0f, 15.0f, RF_ADAPTIVE_AUTO, 2 ); }

// Highlights smaller than a pixel: extra samples by them alone, since all frames see the same.
TEST( test_glints )
{
    check( "glints, GGX", make_glint_room( RF_BSDF_GGX ), 2.0f, 0.0f, RF_ADAPTIVE_AUTO, 1 );
    check( "glints, Phong", make_glint_room( RF_BSDF_PHONG ), 2.0f, 0.0f, RF_ADAPTIVE_AUTO, 1 );
    if ( is_long() )
        check( "glints, coat", make_glint_room( RF_BSDF_COATED ), 2.0f, 0.0f, RF_ADAPTIVE_AUTO, 1 );
}

// Over seeds.
TEST( test_mean_weight )
{
    RfScene scene = make_glass_room();
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 5.0f, WIDTH, HEIGHT );
    enum
    {
        RUNS = 64
    };
    for ( int t = 0; t < 2; ++t )
    {
        double means[RUNS], extra = 0.0, error;
        for ( int k = 0; k < RUNS; ++k )
        {
            RfRenderSettings settings = settings_of( 3, 7, t == 0 ? "1" : "3x3" );
            settings.seed = (uint64_t)k + 1;
            Rendered r = render_frames( tracer, eyes, EYES, &( int ){ 3 }, 1, &settings );
            means[k] = 0.0;
            for ( size_t i = 0; i < r.pixels; ++i )
                means[k] += frame_weight( &r, 0 )[i] / (double)r.pixels;
            extra += ( r.native_spp[0] - 7.0 ) / RUNS;
            free_rendered( &r );
        }
        double mean = mean_of( means, RUNS, &error );
        printf( "mean of B %.6f ± %.6f, %.3f extra samples\n", mean, error, extra );
        assert_true( fabs( mean - 1.0 ) < 4.0 * error + 1e-6 );
        assert_true( extra > 0.02 );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

STATISTICAL_TESTS
