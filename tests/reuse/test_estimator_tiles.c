// Tile reuse is unbiased, alone and with frame reuse, against independent references over
// 16 seeds: on diffuse, Phong, GGX, textured and blended surfaces, under environments,
// under lamps with size and profiles, with glass and mirrors in the tiles, in corners,
// where a tile sees a lit room through the bars of a fence, with several light samples,
// with a single shared bounce, with Russian roulette.
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/rooms.h"
#include "support/test.h"
#include "support/unbiased.h"

#include <stdio.h>
#include <stdlib.h>

#define WIDTH 36
#define HEIGHT 30
#define BLOCK 6
#define EYES 7

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

typedef struct Setting
{
    int group;
    const char* tile;
    int spp;
} Setting;

static RfRenderSettings settings_of( int light_samples, int max_depth )
{
    RfRenderSettings settings = plain_settings();
    settings.light_samples = light_samples;
    settings.max_depth = max_depth;
    settings.memory = (size_t)512 << 20;
    return settings;
}

static void check_setting( const char* what, const RfTracer* tracer, const RfEye* eyes, Setting setting,
                           const RfRenderSettings* like, const Images* reference )
{
    RfRenderSettings settings = *like;
    settings.group = setting.group;
    settings.spp = setting.spp * ( is_long() ? 4 : 1 );
    assert_true( rf_parse_tile( setting.tile, &settings.tile ) );
    Images rendered = rendered_images( tracer, eyes, EYES, EYES / 2, settings );
    char name[64];
    snprintf( name, sizeof name, "%s group %d tile %s:", what, setting.group, setting.tile );
    assert_unbiased( name, &rendered, reference, BLOCK );
    free_images( &rendered );
}

static void check_eyes( const char* what, RfScene scene, const RfEye* eyes, RfRenderSettings settings, const Setting* tried,
                        int count )
{
    RfTracer* tracer = make_tracer( &scene );
    Images reference = reference_images( tracer, eyes, EYES / 2, is_long() ? 384 : 48, &settings );
    for ( int k = 0; k < count; ++k )
        check_setting( what, tracer, eyes, tried[k], &settings, &reference );
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

static const Setting s_all[] = { { 0, "3x3", 16 }, { 0, "rooks16", 16 }, { 0, "5x2", 8 }, { 3, "3x3", 7 }, { 1, "rooks9", 6 } };
static const Setting s_few[] = { { 0, "4x4", 16 }, { 3, "3x3", 7 } };

static void check_scene( const char* what, RfScene scene, RfRenderSettings settings, const Setting* tried, int count )
{
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    check_eyes( what, scene, eyes, settings, tried, count );
}

TEST( test_rooms_are_unbiased )
{
    const Setting* tried = is_long() ? s_all : s_few;
    check_scene( "diffuse", make_room( ROOM_DIFFUSE ), settings_of( 1, 12 ), tried, is_long() ? 5 : 2 );
    check_scene( "Phong", make_room( ROOM_PHONG ), settings_of( 1, 12 ), tried, is_long() ? 5 : 2 );
    check_scene( "GGX", make_room( ROOM_GGX ), settings_of( 1, 12 ), s_all, 5 );
}

// Thin bars in front of a lit room: the pixels of a tile see bars and room, and
// each other's second vertices through the gaps only.
static RfScene make_fence( void )
{
    SceneBuilder b = { 0 };
    uint32_t wall = add_material( &b, make_lambert( 0.7f, 0.65f, 0.6f ) );
    uint32_t bar = add_material( &b, make_lambert( 0.3f, 0.4f, 0.2f ) );
    uint32_t metal = add_material( &b, make_metal( 0.8f, 0.3f ) );
    uint32_t light = add_material( &b, make_light( 12.0f, false ) );
    add_box( &b, wall, rf_vec3( -2, 0, -2 ), rf_vec3( 2, 3, 2 ), true );
    add_sphere( &b, metal, rf_vec3( 0.5f, 0.7f, -1.0f ), 0.6f, 12 );
    for ( int i = 0; i < 24; ++i )
    {
        float x = -1.95f + 3.9f * (float)i / 23.0f;
        add_box( &b, bar, rf_vec3( x - 0.025f, 0, 0.18f ), rf_vec3( x + 0.025f, 2.6f, 0.22f ), false );
    }
    add_quad( &b, light, rf_vec3( -0.8f, 2.98f, -1.4f ), rf_vec3( 0.8f, 2.98f, -1.4f ), rf_vec3( 0.8f, 2.98f, -0.6f ),
              rf_vec3( -0.8f, 2.98f, -0.6f ) );
    return finish_scene( &b );
}

TEST( test_large_tiles_are_unbiased )
{
    static const Setting large[] = { { 0, "rooks36", 8 }, { 1, "8x8", 6 } };
    check_scene( "GGX", make_room( ROOM_GGX ), settings_of( 1, 5 ), large, 2 );
}

TEST( test_light_samples_and_depth_are_unbiased )
{
    check_scene( "GGX, 4 light samples", make_room( ROOM_GGX ), settings_of( 4, 4 ), s_few, 2 );
    check_scene( "GGX, depth 2", make_room( ROOM_GGX ), settings_of( 1, 2 ), s_few, 2 );
    if ( is_long() )
        check_scene( "Phong, depth 3", make_room( ROOM_PHONG ), settings_of( 2, 3 ), s_few, 2 );
}

TEST( test_textures_and_blending_are_unbiased )
{
    check_scene( "textures", make_textured_room(), settings_of( 1, 8 ), s_few, 2 );
    check_scene( "blended", make_blended_room(), settings_of( 1, 8 ), s_few, 2 );
}

TEST( test_skies_lamps_glass_are_unbiased )
{
    check_scene( "map", make_open_scene( LIT_BY_MAP ), settings_of( 1, 8 ), s_few, 2 );
    check_scene( "all lights", make_open_scene( LIT_BY_ALL ), settings_of( 2, 8 ), s_few, 2 );
    check_scene( "glass", make_glass_room(), settings_of( 1, 8 ), s_few, 2 );
}

TEST( test_fence_is_unbiased ) { check_scene( "fence", make_fence(), settings_of( 1, 8 ), s_all, 4 ); }

// A room that a lamp lights alone; where its light comes in from outside, without the walls behind the eyes and on their left.
static RfScene make_lit_room( RfPunctual lamp )
{
    SceneBuilder b = { 0 };
    uint32_t wall = add_material( &b, make_lambert( 0.7f, 0.65f, 0.6f ) ), metal = add_material( &b, make_metal( 0.8f, 0.3f ) ),
             coat = add_material( &b, make_plastic( 0.5f, 0.3f ) );
    if ( lamp.kind == RF_PUNCTUAL_DIRECTIONAL )
    {
        add_quad( &b, wall, rf_vec3( -2, 0, 2 ), rf_vec3( 2, 0, 2 ), rf_vec3( 2, 0, -2 ), rf_vec3( -2, 0, -2 ) );
        add_quad( &b, wall, rf_vec3( -2, 0, -2 ), rf_vec3( 2, 0, -2 ), rf_vec3( 2, 3, -2 ), rf_vec3( -2, 3, -2 ) );
        add_quad( &b, wall, rf_vec3( 2, 0, -2 ), rf_vec3( 2, 0, 2 ), rf_vec3( 2, 3, 2 ), rf_vec3( 2, 3, -2 ) );
    }
    else
        add_box( &b, wall, rf_vec3( -2, 0, -2 ), rf_vec3( 2, 3, 2 ), true );
    add_box( &b, coat, rf_vec3( -1.1f, 0.001f, -0.9f ), rf_vec3( -0.3f, 0.9f, -0.2f ), false );
    add_sphere( &b, metal, rf_vec3( 0.6f, 0.6f, -0.6f ), 0.6f, 12 );
    RfScene scene = finish_scene( &b );
    scene.punctuals = malloc( sizeof *scene.punctuals );
    assert_non_null( scene.punctuals );
    scene.punctuals[0] = lamp;
    scene.punctual_count = 1;
    return scene;
}

TEST( test_lamps_with_size_and_profiles_are_unbiased )
{
    static const Setting s_both = { 3, "3x3", 4 };
    RfPunctual ball = make_point_light( rf_vec3( 0.3f, 2.0f, 0.1f ), 6.0f ), sun = ball;
    ball.radius = 0.5f;
    sun.kind = RF_PUNCTUAL_DIRECTIONAL;
    sun.direction = rf_normalize( rf_vec3( 0.4f, -1.0f, -0.6f ) );
    sun.versine = 0.05f;
    check_scene( "ball", make_lit_room( ball ), settings_of( 1, 3 ), &s_both, 1 );
    check_scene( "sun with an angle", make_lit_room( sun ), settings_of( 1, 3 ), &s_both, 1 );
    RfPunctual beam = make_beam( rf_vec3( 0.3f, 2.7f, 0.1f ), rf_vec3( -0.2f, -1, -0.3f ), 9.0f );
    beam.radius = 0.1f;
    check_scene( "profile", make_lit_room( beam ), settings_of( 1, 3 ), &s_both, 1 );
}

// Into a corner of the room from near by: second vertices as close as can be.
TEST( test_corner_is_unbiased )
{
    static const RoomKind kinds[] = { ROOM_GGX, ROOM_DIFFUSE };
    RfEye eyes[EYES];
    for ( int i = 0; i < EYES; ++i )
    {
        RfVec3 o = rf_vec3( -1.7f + 0.01f * (float)i, 0.35f, -1.65f );
        eyes[i] = rf_make_eye( o, rf_vec3( -1, -1, -1 ), rf_vec3( 0, 1, 0 ), 1.2, WIDTH, HEIGHT );
    }
    for ( int k = 0; k < ( is_long() ? 2 : 1 ); ++k )
        check_eyes( "corner", make_room( kinds[k] ), eyes, settings_of( 1, 8 ), s_few, 2 );
}

STATISTICAL_TESTS
