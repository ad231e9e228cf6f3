// Surfaces that scatter light to both sides: each hit draws the side on which light arrives, and frames, tiles, extra samples, light
// paths and gradients share what is found there. Against a path tracer that scatters to both sides at every point.
#include "support/rooms.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"

#include <stdio.h>
#include <stdlib.h>

#define WIDTH 36
#define HEIGHT 28
#define BLOCK 6
#define EYES 7

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

typedef struct Setting
{
    int group;
    const char* tile;
    int spp;
    bool adaptive, connected, gradient;
} Setting;

static void check( const char* what, const RfTracer* tracer, const RfEye* eyes, Setting s, const Images* reference )
{
    RfRenderSettings settings = plain_settings();
    settings.group = s.group;
    settings.spp = s.spp * ( is_long() ? 4 : 1 );
    settings.max_depth = 7;
    settings.memory = (size_t)512 << 20;
    settings.adaptive = s.adaptive ? RF_ADAPTIVE_ON : RF_ADAPTIVE_OFF;
    settings.light_paths = s.connected ? RF_LIGHT_PATHS_ON : RF_LIGHT_PATHS_OFF;
    if ( s.gradient )
        settings.estimator = rf_find_estimator( "gradient" );
    assert_true( rf_parse_tile( s.tile, &settings.tile ) );
    Images rendered = rendered_images( tracer, eyes, s.gradient ? 1 : EYES, s.gradient ? 0 : EYES / 2, settings );
    char name[96];
    snprintf( name, sizeof name, "%s, group %d tile %s%s%s%s:", what, s.group, s.tile, s.adaptive ? ", adaptive" : "",
              s.connected ? ", connected" : "", s.gradient ? ", gradient" : "" );
    assert_unbiased( name, &rendered, reference, BLOCK );
    free_images( &rendered );
}

static void check_room( const char* what, CurtainRoom kind, const RfEye* eyes, const Setting* settings, int count )
{
    RfScene scene = make_curtain_room( kind );
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings plain = plain_settings();
    plain.max_depth = 7;
    Images reference = reference_images( tracer, eyes, EYES / 2, 64 * ( is_long() ? 4 : 1 ), &plain );
    for ( int i = 0; i < count; ++i )
        check( what, tracer, settings[i].gradient ? eyes + EYES / 2 : eyes, settings[i], &reference );
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

TEST( test_frames_and_tiles_are_unbiased )
{
    static const Setting settings[] = {
        { .group = 0, .tile = "1", .spp = 24 },
        { .group = 0, .tile = "3x3", .spp = 16 },
        { .group = 3, .tile = "1", .spp = 9 },
        { .group = 3, .tile = "3x3", .spp = 7 },
        { .group = 3, .tile = "3x3", .spp = 7, .adaptive = true },
        { .group = 1, .tile = "rooks4", .spp = 9 },
        { .group = 0, .tile = "4x4", .spp = 8, .gradient = true },
        { .group = 0, .tile = "1", .spp = 8, .gradient = true },
    };
    RfEye eyes[EYES], away[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    orbit_eyes( away, EYES, 12.0f, WIDTH, HEIGHT );
    eyes[EYES / 2] = away[EYES - 1]; // sees what the others do not: there extra samples pay
    check_room( "curtain", CURTAIN, eyes, settings, sizeof settings / sizeof *settings );
}

// Frames on one side of a sheet do not share what those on the other see.
TEST( test_eyes_on_both_sides_are_unbiased )
{
    static const Setting settings[] = { { .group = 3, .tile = "1", .spp = 9 }, { .group = 3, .tile = "3x3", .spp = 7 } };
    RfEye eyes[EYES];
    crossing_eyes( eyes, EYES, WIDTH, HEIGHT );
    for ( int i = 0; i < EYES; ++i ) // none in the plane
        eyes[i].origin.z += 0.05f;
    check_room( "crossed", CURTAIN_CROSSED, eyes, settings, sizeof settings / sizeof *settings );
}

TEST( test_chains_and_light_paths_are_unbiased )
{
    static const Setting settings[] = { { .group = 3, .tile = "3x3", .spp = 7 },
                                        { .group = 0, .tile = "1", .spp = 4, .connected = true },
                                        { .group = 1, .tile = "3x3", .spp = 4, .connected = true } };
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    check_room( "curtain, glass", CURTAIN_AND_GLASS, eyes, settings, sizeof settings / sizeof *settings );
}

STATISTICAL_TESTS
