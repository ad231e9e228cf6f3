// Pixel filters are unbiased, under frames, tiles and extra samples: against the filter's formula applied to pictures
// of many times the pixels by a plain path tracer, and at an edge against the integral of the filter.
#include "support/filter_reference.h"
#include "support/rooms.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define WIDTH 24
#define HEIGHT 18
#define BLOCK 3
#define EYES 5
#define TIMES 6 // pixels of the reference for each one, each way

static const char* const s_names[] = { "box", "tent", "gaussian", "blackman-harris" };

typedef struct Way
{
    RfFilter filter;
    double width;
    int group;
    bool tiles, adaptive;
    int spp;
} Way;

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

static RfRenderSettings settings_of( const Way* way )
{
    RfRenderSettings settings = plain_settings();
    settings.filter = way->filter;
    settings.filter_width = way->width;
    settings.group = way->group;
    settings.spp = way->spp * ( is_long() ? 4 : 1 ); // as skewed as a few samples through glass are, t is not Student's
    settings.adaptive = way->adaptive ? RF_ADAPTIVE_ON : RF_ADAPTIVE_OFF;
    settings.max_depth = 4;
    settings.memory = (size_t)512 << 20;
    if ( way->tiles )
        settings.tile = ( RfTile ){ RF_TILE_BLOCK, 3, 3 };
    return settings;
}

static void check_way( const char* scene, const RfTracer* tracer, const RfEye* eyes, const Images* fine, const Way* way )
{
    Images reference = { .width = WIDTH, .height = HEIGHT, .count = SEEDS };
    for ( int k = 0; k < SEEDS; ++k )
    {
        reference.rgb[k] = malloc( 3 * WIDTH * HEIGHT * sizeof( float ) );
        if ( reference.rgb[k] == NULL )
            abort();
        filter_picture( way->filter, way->width, fine->rgb[k], TIMES, WIDTH, HEIGHT, reference.rgb[k] );
    }
    RfRenderSettings settings = settings_of( way );
    Images rendered = rendered_images( tracer, eyes, EYES, EYES / 2, settings );
    char what[96];
    snprintf( what, sizeof what, "%s, %s %g, group %d%s%s:", scene, s_names[way->filter], way->width, way->group,
              way->tiles ? ", tiles" : "", way->adaptive ? ", extra" : "" );
    // neighbouring blocks share samples, so their p-values need not be uniform
    Verdict blocks = compare_images( what, &rendered, &reference, BLOCK ),
            pixels = compare_images( what, &rendered, &reference, 1 );
    printf( "%-60s whole %.3g, smallest of the blocks %.3g, of the pixels %.3g\n", what, blocks.whole_p, blocks.smallest_p,
            pixels.smallest_p );
    assert_true( is_likely( blocks.whole_p ) && is_likely( blocks.smallest_p ) && is_likely( pixels.smallest_p ) );
    if ( way->adaptive )
    {
        Rendered one = render_frames( tracer, eyes, EYES, &( int ){ EYES / 2 }, 1, &settings );
        printf( "%.2f extra samples\n", one.native_spp[0] - one.stats.spp );
        assert_true( one.native_spp[0] > one.stats.spp + 0.1 ); // else nothing was tested
        free_rendered( &one );
    }
    free_images( &rendered );
    free_images( &reference );
}

typedef enum View
{
    SWEEP, // the camera turns by 8 degrees a frame: some of what it sees comes in over the border of the film
    ASIDE, // that of the middle frame sees what no other does
} View;

static void make_eyes( View view, int width, int height, RfEye* eyes )
{
    RfEye away[EYES];
    if ( view == SWEEP )
    {
        sweep_eyes( eyes, EYES, width, height );
        return;
    }
    orbit_eyes( eyes, EYES, 2.0f, width, height );
    orbit_eyes( away, EYES, 15.0f, width, height );
    eyes[EYES / 2] = away[EYES - 1];
}

static void check_scene( const char* name, RfScene scene, View view, const Way* ways, size_t count )
{
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES], fine_eyes[EYES];
    make_eyes( view, WIDTH, HEIGHT, eyes );
    make_eyes( view, TIMES * WIDTH, TIMES * HEIGHT, fine_eyes );
    RfRenderSettings plain = plain_settings();
    plain.max_depth = 4;
    Images fine = reference_images( tracer, fine_eyes, EYES / 2, is_long() ? 8 : 1, &plain );
    for ( size_t k = 0; k < count; ++k )
        check_way( name, tracer, eyes, &fine, ways + k );
    free_images( &fine );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

TEST( test_filters_are_unbiased )
{
    static const Way s_ways[] = {
        { RF_FILTER_BLACKMAN_HARRIS, 1.5, 0, false, false, 16 },
        { RF_FILTER_BLACKMAN_HARRIS, 1.5, 2, true, false, 10 },
        { RF_FILTER_TENT, 1.0, 2, true, false, 10 },
        { RF_FILTER_GAUSSIAN, 1.5, 2, true, false, 10 },
        { RF_FILTER_BOX, 2.0, 2, false, false, 10 },
    };
    check_scene( "GGX", make_room( ROOM_GGX ), SWEEP, s_ways, sizeof s_ways / sizeof *s_ways );
}

// Views through mirrors, chains without a hit, own-frame light, the sky.
TEST( test_mirrors_and_the_sky_are_unbiased )
{
    static const Way s_ways[] = { { RF_FILTER_BLACKMAN_HARRIS, 1.5, 2, true, false, 10 } };
    check_scene( "open", make_mirror_in_the_open( LIT_BY_SKY ), SWEEP, s_ways, 1 );
    if ( is_long() )
        check_scene( "mirror", make_mirror_room( FLAT_MIRROR ), SWEEP, s_ways, 1 );
}

// They are drawn by the filter of their pixel; in rooms with glass several of them in a batch.
TEST( test_extra_samples_are_unbiased )
{
    static const Way s_ways[] = { { RF_FILTER_TENT, 0.75, 2, true, true, 5 }, { RF_FILTER_GAUSSIAN, 1.0, 2, true, true, 5 } };
    check_scene( "Phong, aside", make_room( ROOM_PHONG ), ASIDE, s_ways, 1 );
    check_scene( "glass, aside", make_glass_room(), ASIDE, s_ways + 1, 1 );
}

#define EDGE 0.37 // of the bright half, pixels from the left border of pixel WIDTH/2

// A wall 4 m before the eyes that emits 1 on its left; the eyes slide along it, by 1.3 pixels a frame.
static RfScene make_edge( RfEye* eyes )
{
    SceneBuilder b = { 0 };
    uint32_t bright = add_material( &b, make_light( 1.0f, true ) ), dark = add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) );
    add_quad( &b, bright, rf_vec3( -9, -9, -4 ), rf_vec3( 0, -9, -4 ), rf_vec3( 0, 9, -4 ), rf_vec3( -9, 9, -4 ) );
    add_quad( &b, dark, rf_vec3( 0, -9, -4 ), rf_vec3( 9, -9, -4 ), rf_vec3( 9, 9, -4 ), rf_vec3( 0, 9, -4 ) );
    for ( int i = 0; i < EYES; ++i )
    {
        eyes[i] = rf_make_eye( rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 0.7, WIDTH, HEIGHT );
        double metres = 4.0 / (double)eyes[i].focal_x; // of a pixel
        eyes[i].origin.x = (float)( metres * ( -EDGE + 1.3 * ( i - EYES / 2 ) ) );
    }
    return finish_scene( &b );
}

// Mean of a column of pixels over the picture's rows, and of its normalisation.
static void column_means( const Rendered* r, int x, double* value, double* weight )
{
    *value = *weight = 0.0;
    for ( int y = 0; y < HEIGHT; ++y )
    {
        *value += (double)frame_rgb( r, 0 )[3 * ( y * WIDTH + x )] / HEIGHT;
        *weight += (double)frame_weight( r, 0 )[y * WIDTH + x] / HEIGHT;
    }
}

TEST( test_an_edge_is_the_integral_of_the_filter )
{
    static const Way s_ways[] = {
        { RF_FILTER_BOX, 1.7, 2, false, false, 20 },
        { RF_FILTER_TENT, 1.0, 2, false, false, 20 },
        { RF_FILTER_GAUSSIAN, 1.5, 2, false, false, 20 },
        { RF_FILTER_BLACKMAN_HARRIS, 1.5, 0, false, false, 20 },
        { RF_FILTER_BLACKMAN_HARRIS, 4.0, 2, false, false, 20 },
    };
    RfEye eyes[EYES];
    RfScene scene = make_edge( eyes );
    RfTracer* tracer = make_tracer( &scene );
    for ( size_t k = 0; k < sizeof s_ways / sizeof *s_ways; ++k )
    {
        const Way* way = s_ways + k;
        RfRenderSettings settings = settings_of( way );
        settings.max_depth = 1;
        double value[WIDTH][SEEDS], weight[WIDTH][SEEDS];
        for ( int seed = 0; seed < SEEDS; ++seed )
        {
            settings.seed = (uint64_t)( seed + 1 );
            Rendered r = render_frames( tracer, eyes, EYES, &( int ){ EYES / 2 }, 1, &settings );
            for ( int x = 0; x < WIDTH; ++x )
                column_means( &r, x, &value[x][seed], &weight[x][seed] );
            free_rendered( &r );
        }
        for ( int x = 0; x < WIDTH; ++x )
        {
            double left = -x - 0.5, edge = WIDTH / 2 + EDGE - x - 0.5, right = WIDTH - x - 0.5, error;
            double wanted =
                filter_integral( way->filter, way->width, left, edge ) / filter_integral( way->filter, way->width, left, right );
            double mean = mean_of( value[x], SEEDS, &error );
            if ( fabs( mean - wanted ) > 1e-4 && is_far_off( ( mean - wanted ) / error, SEEDS - 1 ) )
                fail_msg( "%s %g, column %d: %g ± %g, wanted %g", s_names[way->filter], way->width, x, mean, error, wanted );
            mean = mean_of( weight[x], SEEDS, &error );
            if ( fabs( mean - 1.0 ) > 1e-4 && is_far_off( ( mean - 1.0 ) / error, SEEDS - 1 ) )
                fail_msg( "%s %g, column %d: the mean of B is %g ± %g", s_names[way->filter], way->width, x, mean, error );
        }
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

STATISTICAL_TESTS
