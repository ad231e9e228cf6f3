// Guided paths in frames, tiles, extra samples and chains are unbiased: against a path tracer that knows of no guide.
#include "support/rooms.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"

#include <stdio.h>
#include <stdlib.h>

#define WIDTH 32
#define HEIGHT 24
#define BLOCK 4
#define EYES 7

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

static RfRenderSettings settings_of( ChainSetting s )
{
    RfRenderSettings settings = plain_settings();
    settings.group = s.group;
    settings.spp = s.spp * ( is_long() ? 4 : 1 );
    settings.max_depth = 7;
    settings.memory = (size_t)512 << 20;
    settings.adaptive = s.adaptive ? RF_ADAPTIVE_ON : RF_ADAPTIVE_OFF;
    settings.light_paths = s.connected ? RF_LIGHT_PATHS_ON : RF_LIGHT_PATHS_OFF;
    settings.guide = RF_GUIDE_ON;
    assert_true( rf_parse_tile( s.tile, &settings.tile ) );
    return settings;
}

// Something is learned.
static void check_guided( const RfTracer* tracer, const RfEye* eyes, int eye_count )
{
    RfRenderSettings settings = settings_of( ( ChainSetting ){ .group = 0, .tile = "1", .spp = 1 } );
    RfRenderStats stats;
    RfError error;
    int frame = 0;
    RfShot shot = { tracer, eyes, eye_count, &frame, 1 };
    assert_int_equal( rf_render( &shot, &settings, NULL, &stats, &error ), RF_OK );
    print_message( "%d tables\n", stats.guide_tables );
    assert_true( stats.guide_tables > 0 );
    settings.guide = RF_GUIDE_OFF;
    assert_int_equal( rf_render( &shot, &settings, NULL, &stats, &error ), RF_OK );
    assert_int_equal( stats.guide_tables, 0 );
}

static void check_scene( const char* what, RfScene scene, const RfEye* eyes, const ChainSetting* settings, int count )
{
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings plain = plain_settings();
    plain.max_depth = 7;
    Images reference = reference_images( tracer, eyes, EYES / 2, 64 * ( is_long() ? 4 : 1 ), &plain );
    check_guided( tracer, eyes, EYES );
    for ( int i = 0; i < count; ++i )
    {
        ChainSetting s = settings[i];
        char name[96];
        snprintf( name, sizeof name, "%s, group %d tile %s%s%s:", what, s.group, s.tile, s.adaptive ? ", adaptive" : "",
                  s.connected ? ", connected" : "" );
        Images rendered = rendered_images( tracer, eyes, EYES, EYES / 2, settings_of( s ) );
        assert_unbiased( name, &rendered, &reference, BLOCK );
        free_images( &rendered );
    }
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

// A room with a sphere, whose lamp shines on a baffle below it: light comes by the gaps around that.
static RfScene make_baffled_room( RoomKind kind )
{
    SceneBuilder b = { .vertex_room = 0 };
    uint32_t white = add_material( &b, make_lambert( 0.8f, 0.75f, 0.7f ) ), lamp = add_material( &b, make_light( 20.0f, false ) );
    RfMaterial ball = kind == ROOM_DIFFUSE ? make_lambert( 0.3f, 0.6f, 0.3f )
                      : kind == ROOM_PHONG ? make_phong( 0.3f, 0.5f, 30.0f )
                                           : make_plastic( 0.5f, 0.2f );
    RfMaterial sheet = make_lambert( 0.5f, 0.5f, 0.5f );
    sheet.double_sided = true;
    uint32_t object = add_material( &b, ball ), baffle = add_material( &b, sheet );
    add_box( &b, white, rf_vec3( -2, 0, -2 ), rf_vec3( 2, 3, 2 ), true );
    add_quad( &b, lamp, rf_vec3( -0.5f, 2.98f, -0.5f ), rf_vec3( 0.5f, 2.98f, -0.5f ), rf_vec3( 0.5f, 2.98f, 0.5f ),
              rf_vec3( -0.5f, 2.98f, 0.5f ) );
    add_quad( &b, baffle, rf_vec3( -1.4f, 2.6f, -1.7f ), rf_vec3( 1.8f, 2.6f, -1.7f ), rf_vec3( 1.8f, 2.6f, 1.7f ),
              rf_vec3( -1.4f, 2.6f, 1.7f ) );
    add_sphere( &b, object, rf_vec3( 0.3f, 0.6f, 0.0f ), 0.6f, 12 );
    return finish_scene( &b );
}

TEST( test_frames_and_tiles_are_unbiased )
{
    static const ChainSetting diffuse[] = {
        { .group = 0, .tile = "1", .spp = 24 },     { .group = 0, .tile = "3x3", .spp = 16 },
        { .group = 3, .tile = "1", .spp = 9 },      { .group = 3, .tile = "3x3", .spp = 7 },
        { .group = 1, .tile = "rooks4", .spp = 9 },
    };
    static const ChainSetting glossy[] = { { .group = 0, .tile = "3x3", .spp = 16 },
                                           { .group = 3, .tile = "1", .spp = 9 },
                                           { .group = 3, .tile = "3x3", .spp = 7, .adaptive = true } };
    RfEye eyes[EYES], away[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    orbit_eyes( away, EYES, 12.0f, WIDTH, HEIGHT );
    check_scene( "diffuse", make_baffled_room( ROOM_DIFFUSE ), eyes, diffuse, 5 );
    eyes[EYES / 2] = away[EYES - 1]; // sees what the others do not: there extra samples pay
    check_scene( "plastic", make_baffled_room( ROOM_GGX ), eyes, glossy, 3 );
    check_scene( "phong", make_baffled_room( ROOM_PHONG ), eyes, glossy, 2 );
}

// Translucent sheets and glass have no tables; what lies behind them has.
TEST( test_chains_and_light_paths_are_unbiased )
{
    static const ChainSetting settings[] = { { .group = 3, .tile = "3x3", .spp = 7 },
                                             { .group = 0, .tile = "1", .spp = 8, .connected = true },
                                             { .group = 1, .tile = "3x3", .spp = 6, .connected = true } };
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    check_scene( "curtain, glass", make_curtain_room( CURTAIN_AND_GLASS ), eyes, settings, 3 );
    check_scene( "coat, mirror", make_mirror_room( CLEAR_COAT ), eyes, settings, 1 );
    check_scene( "tank", make_mirror_room( GLASS_TANK ), eyes, settings, 1 );
    check_scene( "lamp in glass", make_mirror_room( LAMP_IN_GLASS ), eyes, settings, 1 );
}

STATISTICAL_TESTS
