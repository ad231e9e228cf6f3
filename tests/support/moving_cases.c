#include "support/moving_cases.h"

#include "support/statistics.h"
#include "support/test.h"

#define BLOCK 4
#define REFERENCE_SPP 48

const MovingSetting g_moving_frames = { .tile = "1", .group = 3, .spp = 7 };
const MovingSetting g_moving_tiles = { .tile = "3x3", .group = 3, .spp = 7 };
const MovingSetting g_moving_rooks = { .tile = "rooks4", .group = 1, .spp = 6 };
const MovingSetting g_moving_adaptive = { .tile = "3x3", .group = 3, .spp = 7, .adaptive = true };
const MovingSetting g_moving_two_lights = { .tile = "3x3", .group = 2, .spp = 5, .light_samples = 2 };
const MovingSetting g_moving_connected = { .tile = "3x3", .group = 0, .spp = 3, .connected = true };

bool is_moving_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

RfRenderSettings moving_settings( const MovingSetting* setting, int max_depth )
{
    RfRenderSettings settings = plain_settings();
    settings.max_depth = max_depth;
    settings.memory = (size_t)512 << 20;
    settings.group = setting->group;
    settings.spp = setting->spp * ( is_moving_long() ? 4 : 1 );
    settings.adaptive = setting->adaptive ? RF_ADAPTIVE_ON : RF_ADAPTIVE_OFF;
    settings.light_samples = setting->light_samples > 0 ? setting->light_samples : 1;
    settings.light_paths = setting->connected ? RF_LIGHT_PATHS_ON : RF_LIGHT_PATHS_OFF;
    assert_true( rf_parse_tile( setting->tile, &settings.tile ) );
    return settings;
}

typedef struct FrameImages
{
    Images of[MOVING_MOST_FRAMES];
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

static FrameImages render_case( const MovingCase* c, RfRenderSettings settings )
{
    FrameImages images = { 0 };
    MovingRoom room = load_moving_room( c->room, MOVING_WIDTH, MOVING_HEIGHT );
    RfTracer* tracer = make_tracer( &room.scene );
    for ( int f = 0; f < c->frame_count; ++f )
        images.of[f] = ( Images ){ .width = MOVING_WIDTH, .height = MOVING_HEIGHT, .count = SEEDS };
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

static FrameImages refer_case( const MovingCase* c, const RfRenderSettings* settings )
{
    FrameImages images = { 0 };
    for ( int f = 0; f < c->frame_count; ++f )
    {
        MovingRoom room = load_still_room( c->room, c->frames[f], MOVING_WIDTH, MOVING_HEIGHT );
        RfTracer* tracer = make_tracer( &room.scene );
        images.of[f] =
            reference_images( tracer, room.eyes, c->frames[f], REFERENCE_SPP * ( is_moving_long() ? 4 : 1 ), settings );
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &room.scene );
    }
    return images;
}

void check_moving( const MovingCase* c )
{
    RfRenderSettings plain = moving_settings( c->settings[0], c->max_depth );
    FrameImages reference = refer_case( c, &plain );
    for ( int k = 0; c->settings[k] != NULL; ++k )
    {
        const MovingSetting* s = c->settings[k];
        FrameImages rendered = render_case( c, moving_settings( s, c->max_depth ) );
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

void assert_mean_weight_is_1( const char* name )
{
    double mean[SEEDS] = { 0 };
    MovingRoom room = load_moving_room( name, MOVING_WIDTH, MOVING_HEIGHT );
    RfTracer* tracer = make_tracer( &room.scene );
    for ( int k = 0; k < SEEDS; ++k )
    {
        RfRenderSettings settings = moving_settings( &g_moving_tiles, 3 );
        settings.seed = (uint64_t)( k + 1 );
        int frame = MOVING_EYES / 2;
        Rendered r = render_frames( tracer, room.eyes, room.eye_count, &frame, 1, &settings );
        for ( size_t i = 0; i < r.pixels; ++i )
            mean[k] += (double)r.weight[i] / (double)r.pixels;
        free_rendered( &r );
    }
    Sample all = sample_of( mean, SEEDS );
    printf( "%s: mean weight %.5f ± %.2g\n", name, all.mean, sqrt( all.variance ) );
    assert_false( is_far_off( ( all.mean - 1.0 ) / sqrt( all.variance ), SEEDS - 1 ) );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &room.scene );
}
