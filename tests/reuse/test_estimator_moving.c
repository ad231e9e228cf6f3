// Frames of rooms in which something moves (src/reuse/estimators.md, section 18), rendered with groups and tiles, have the mean of
// path tracing of a still room each, which a script made without any movement (tests/support/moving_rooms.py).
#include "support/moving_rooms.h"
#include "support/statistics.h"
#include "support/unbiased.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define WIDTH 24
#define HEIGHT 16
#define BLOCK 4
#define REFERENCE_SPP 48
#define MOST_FRAMES 3

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

typedef struct Setting
{
    const char* tile;
    int group, spp;
    bool adaptive;
    bool connected;    // light paths
    int light_samples; // 0: 1
} Setting;

#define FRAMES                                                                                                                   \
    {                                                                                                                            \
        .tile = "1", .group = 3, .spp = 7                                                                                        \
    }
#define TILES                                                                                                                    \
    {                                                                                                                            \
        .tile = "3x3", .group = 3, .spp = 7                                                                                      \
    }
#define ROOKS                                                                                                                    \
    {                                                                                                                            \
        .tile = "rooks4", .group = 1, .spp = 6                                                                                   \
    }
#define ADAPTIVE                                                                                                                 \
    {                                                                                                                            \
        .tile = "3x3", .group = 3, .spp = 7, .adaptive = true                                                                    \
    }
#define TWO_LIGHTS                                                                                                               \
    {                                                                                                                            \
        .tile = "3x3", .group = 2, .spp = 5, .light_samples = 2                                                                  \
    }
#define CONNECTED                                                                                                                \
    {                                                                                                                            \
        .tile = "3x3", .group = 0, .spp = 3, .connected = true                                                                   \
    }

static RfRenderSettings settings_of( const Setting* setting, int max_depth )
{
    RfRenderSettings settings = plain_settings();
    settings.max_depth = max_depth;
    settings.memory = (size_t)512 << 20;
    settings.group = setting->group;
    settings.spp = setting->spp * ( is_long() ? 4 : 1 );
    settings.adaptive = setting->adaptive ? RF_ADAPTIVE_ON : RF_ADAPTIVE_OFF;
    settings.light_samples = setting->light_samples > 0 ? setting->light_samples : 1;
    settings.light_paths = setting->connected ? RF_LIGHT_PATHS_ON : RF_LIGHT_PATHS_OFF;
    assert_true( rf_parse_tile( setting->tile, &settings.tile ) );
    return settings;
}

// A room, and all that is tried in it.
typedef struct Case
{
    const char* room;
    int max_depth;
    int frames[MOST_FRAMES], frame_count;
    Setting settings[4];
    int count;
} Case;

typedef struct FrameImages
{
    Images of[MOST_FRAMES];
} FrameImages;

static void free_frames( FrameImages* images, int count )
{
    for ( int f = 0; f < count; ++f )
        free_images( images->of + f );
}

static void keep( const Rendered* r, int frame, int seed, Images* images )
{
    size_t bytes = 3 * r->pixels * sizeof( float );
    float* rgb = images->rgb[seed] = malloc( bytes );
    assert_non_null( rgb );
    memcpy( rgb, frame_rgb( r, frame ), bytes );
}

static FrameImages render_case( const Case* c, RfRenderSettings settings )
{
    FrameImages images;
    MovingRoom room = load_moving_room( c->room, WIDTH, HEIGHT );
    RfTracer* tracer = make_tracer( &room.scene );
    for ( int f = 0; f < c->frame_count; ++f )
        images.of[f] = ( Images ){ .width = WIDTH, .height = HEIGHT, .count = SEEDS };
    for ( int k = 0; k < SEEDS; ++k )
    {
        settings.seed = (uint64_t)( k + 1 );
        Rendered r = render_frames( tracer, room.eyes, room.eye_count, c->frames, c->frame_count, &settings );
        for ( int f = 0; f < c->frame_count; ++f )
            keep( &r, f, k, images.of + f );
        free_rendered( &r );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &room.scene );
    return images;
}

static FrameImages refer_case( const Case* c, const RfRenderSettings* settings )
{
    FrameImages images;
    for ( int f = 0; f < c->frame_count; ++f )
    {
        MovingRoom room = load_still_room( c->room, c->frames[f], WIDTH, HEIGHT );
        RfTracer* tracer = make_tracer( &room.scene );
        images.of[f] = reference_images( tracer, room.eyes, c->frames[f], REFERENCE_SPP * ( is_long() ? 4 : 1 ), settings );
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &room.scene );
    }
    return images;
}

static void check( const Case* c )
{
    RfRenderSettings plain = settings_of( c->settings, c->max_depth );
    FrameImages reference = refer_case( c, &plain );
    for ( int k = 0; k < c->count; ++k )
    {
        const Setting* s = c->settings + k;
        FrameImages rendered = render_case( c, settings_of( s, c->max_depth ) );
        for ( int f = 0; f < c->frame_count; ++f )
        {
            char name[96];
            snprintf( name, sizeof name, "%s, frame %d, group %d, tile %s%s:", c->room, c->frames[f], s->group, s->tile,
                      s->adaptive    ? ", adaptive"
                      : s->connected ? ", connected"
                                     : "" );
            assert_unbiased( name, rendered.of + f, reference.of + f, BLOCK );
        }
        free_frames( &rendered, c->frame_count );
    }
    free_frames( &reference, c->frame_count );
}

static void test_what_passes_by( void** state )
{
    (void)state;
    check( &( Case ){ "sweep", 5, { 1, 3, 5 }, 3, { FRAMES, TILES, ROOKS, ADAPTIVE }, 4 } );
}

static void test_a_door( void** state )
{
    (void)state;
    check( &( Case ){ "door", 5, { 1, 3, 5 }, 3, { FRAMES, TILES }, 2 } );
}

static void test_mirrors_that_turn( void** state )
{
    (void)state;
    check( &( Case ){ "mirrors", 5, { 1, 3, 5 }, 3, { TILES, FRAMES, CONNECTED }, 3 } );
}

static void test_figures( void** state )
{
    (void)state;
    check( &( Case ){ "figure", 5, { 1, 3, 5 }, 3, { TILES, TWO_LIGHTS }, 2 } );
}

static void test_what_is_shown_at_times( void** state )
{
    (void)state;
    check( &( Case ){ "shown", 5, { 1, 3, 5 }, 3, { TILES, ADAPTIVE }, 2 } );
}

static void test_panes_that_move( void** state )
{
    (void)state;
    check( &( Case ){ "panes", 5, { 1, 3, 5 }, 3, { TILES, FRAMES }, 2 } );
}

static void test_a_sky_through_openings( void** state )
{
    (void)state;
    check( &( Case ){ "sky", 5, { 1, 3, 5 }, 3, { TILES, FRAMES }, 2 } );
}

static void test_lamps_and_a_hidden_sky( void** state )
{
    (void)state;
    check( &( Case ){ "lamps", 5, { 2, 4 }, 2, { TILES, TWO_LIGHTS }, 2 } );
}

// B counts first hits, whatever becomes of their light.
static void test_mean_weight_is_1( void** state )
{
    (void)state;
    double mean[SEEDS] = { 0 };
    MovingRoom room = load_moving_room( "sweep", WIDTH, HEIGHT );
    RfTracer* tracer = make_tracer( &room.scene );
    for ( int k = 0; k < SEEDS; ++k )
    {
        RfRenderSettings settings = settings_of( &(Setting)TILES, 3 );
        settings.seed = (uint64_t)( k + 1 );
        int frame = MOVING_EYES / 2;
        Rendered r = render_frames( tracer, room.eyes, room.eye_count, &frame, 1, &settings );
        for ( size_t i = 0; i < r.pixels; ++i )
            mean[k] += (double)r.weight[i] / (double)r.pixels;
        free_rendered( &r );
    }
    Sample all = sample_of( mean, SEEDS );
    printf( "mean weight %.5f ± %.2g\n", all.mean, sqrt( all.variance ) );
    assert_false( is_far_off( ( all.mean - 1.0 ) / sqrt( all.variance ), SEEDS - 1 ) );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &room.scene );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_mean_weight_is_1 ),       cmocka_unit_test( test_lamps_and_a_hidden_sky ),
        cmocka_unit_test( test_what_passes_by ),         cmocka_unit_test( test_a_door ),
        cmocka_unit_test( test_mirrors_that_turn ),      cmocka_unit_test( test_figures ),
        cmocka_unit_test( test_what_is_shown_at_times ), cmocka_unit_test( test_panes_that_move ),
        cmocka_unit_test( test_a_sky_through_openings ),
    };
    return run_statistical_tests( tests, sizeof tests / sizeof *tests );
}
