// Light groups that are re-balanced after the render (src/reuse/estimators.md, E20) have the mean of path tracing with lamps that are
// re-balanced before it: in still rooms with mirrors, glass and panes, in the open, and in rooms in which lamps or things move.
#include "scene/light_groups.h"
#include "support/moving_cases.h"
#include "support/render_one.h"
#include "support/rooms.h"
#include "support/statistics.h"
#include "support/test.h"

#include <stdio.h>
#include <stdlib.h>

#define EYES 7
#define WIDTH 24
#define HEIGHT 16
#define FRAME 3
#define DEPTH 5
#define BLOCK 4
#define REFERENCE_SPP 48
#define MOST_GROUPS 3 // two tags and the rest

// What each group is multiplied by: one alone, and all of them.
#define BALANCES 2
static const float g_balance[BALANCES][MOST_GROUPS] = { { 1.0f, 0.0f, 0.0f }, { 0.3f, 2.0f, 1.0f } };
// Multiplies the lights of a scene by the balance of the groups that those of a tagged one are in.
static void balance( const RfScene* tagged, const float* by, RfScene* scene )
{
    RfLightGroups groups;
    assert_int_equal( rf_find_light_groups( tagged, "all", &groups, NULL ), RF_OK );
    assert_int_equal( tagged->punctual_count, scene->punctual_count );
    assert_int_equal( tagged->material_count, scene->material_count );
    for ( int i = 0; i < scene->punctual_count; ++i )
        scene->punctuals[i].intensity = rf_scale( scene->punctuals[i].intensity, by[groups.punctual[i]] );
    for ( uint32_t i = 0; i < scene->material_count; ++i )
        scene->materials[i].emission = rf_scale( scene->materials[i].emission, by[groups.material[i]] );
    scene->environment.radiance = rf_scale( scene->environment.radiance, by[groups.sky] );
    rf_destroy_light_groups( &groups );
}

static void render_groups( Stage* stage, RfRenderSettings settings, Images* of )
{
    const size_t values = 3 * WIDTH * HEIGHT;
    settings.light_groups = "all";
    settings.spp *= suite_samples();
    for ( int b = 0; b < BALANCES; ++b )
        of[b] = ( Images ){ .width = WIDTH, .height = HEIGHT, .count = SEEDS };
    for ( int k = 0; k < SEEDS; ++k )
    {
        settings.seed = (uint64_t)( k + 1 ) + suite_seed();
        const RfFrameResult* frame = render_one( stage, FRAME, &settings );
        assert_true( frame->layer_count > 1 && frame->layer_count <= MOST_GROUPS );
        for ( int b = 0; b < BALANCES; ++b )
        {
            float* rgb = of[b].rgb[k] = calloc( values, sizeof *rgb );
            assert_non_null( rgb );
            for ( size_t i = 0; i < values * (size_t)frame->layer_count; ++i )
                rgb[i % values] += (float)suite_bias() * g_balance[b][i / values] * frame->layers[i / values].values[i % values];
        }
    }
}

// Compares the balances of a render with references, which are freed.
static void compare( const char* what, Stage* stage, const MovingSetting* setting, Images* reference, bool last )
{
    Images rendered[BALANCES];
    render_groups( stage, moving_settings( setting, DEPTH ), rendered );
    for ( int b = 0; b < BALANCES; ++b )
    {
        char name[96];
        snprintf( name, sizeof name, "%s, balance %d, group %d, tile %s:", what, b, setting->group, setting->tile );
        assert_unbiased( name, rendered + b, reference + b, BLOCK );
        free_images( rendered + b );
        if ( last )
            free_images( reference + b );
    }
}

// Frame FRAME of a scene whose lights are balanced, as those of the stage are by their groups; it is destroyed.
static Images refer( const Stage* stage, int balance_number, RfScene scene, const RfEye* eyes )
{
    RfRenderSettings settings = moving_settings( &g_moving_tiles, DEPTH );
    balance( &stage->scene, g_balance[balance_number], &scene );
    RfTracer* tracer = make_tracer( &scene );
    Images images = reference_images( tracer, eyes, FRAME, REFERENCE_SPP * ( is_moving_long() ? 4 : 1 ), &settings );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
    return images;
}

static const MovingSetting g_one = { .tile = "3x3", .group = 0, .spp = 4 };
static const MovingSetting g_one_more = { .tile = "3x3", .group = 0, .spp = 16 };

typedef RfScene MakeRoom( int kind );

static void check_still( const char* what, MakeRoom* make, int kind, const MovingSetting* one )
{
    Images reference[BALANCES];
    Stage stage;
    open_stage( &stage, make( kind ), EYES, 3.0f, WIDTH, HEIGHT );
    tag_lights( &stage.scene, MOST_GROUPS - 1 );
    for ( int b = 0; b < BALANCES; ++b )
        reference[b] = refer( &stage, b, make( kind ), stage.eyes );
    compare( what, &stage, one, reference, false );
    compare( what, &stage, &g_moving_tiles, reference, true );
    close_stage( &stage );
}

// A mirror room with a lamp without size and a sheet that shines besides its ceiling light.
static RfScene lit_mirror_room( int kind )
{
    RfScene room = make_mirror_room( (MirrorRoom)kind );
    add_punctual( &room, make_point_light( rf_vec3( 1.0f, 2.0f, 1.0f ), 2.0f ) );
    return room;
}

static RfScene pane_room( int kind ) { return make_pane_room( (PaneLight)kind ); }

// With all kinds of light. Groups share light samples: next to the sky and the sun as they are, those of hits near the horizon choose
// a lamp of the first group once or twice in a hundred, so at few samples all images of the group may be black there, and a t-test
// fails of no bias. Sky and sun are dimmed, so that every hit has light samples of each group.
static RfScene open_room( int kind )
{
    RfScene room = make_open_scene( (OpenLight)kind );
    room.environment.radiance = rf_scale( room.environment.radiance, 0.1f );
    for ( int i = 0; i < room.punctual_count; ++i )
    {
        if ( room.punctuals[i].kind == RF_PUNCTUAL_DIRECTIONAL )
            room.punctuals[i].intensity = rf_scale( room.punctuals[i].intensity, 0.1f );
    }
    return room;
}

TEST( test_mirrors_and_glass )
{
    check_still( "glass ball", lit_mirror_room, GLASS_BALL, &g_one );
    check_still( "sharp plastic", lit_mirror_room, SHARP_PLASTIC, &g_one );
    check_still( "mirrors", lit_mirror_room, FACING_MIRRORS, &g_one );
}

TEST( test_open ) { check_still( "open", open_room, LIT_BY_ALL, &g_one_more ); }

TEST( test_panes ) { check_still( "panes", pane_room, PANES_AND_ALL, &g_one ); }

// Frame FRAME of a room in which something moves against the still room of that frame.
static void check_room( const char* name, const MovingSetting* setting )
{
    Images reference[BALANCES];
    Stage stage;
    open_moving_stage( &stage, name, WIDTH, HEIGHT );
    tag_lights( &stage.scene, MOST_GROUPS - 1 );
    for ( int b = 0; b < BALANCES; ++b )
    {
        MovingRoom still = load_still_room( name, FRAME, WIDTH, HEIGHT );
        reference[b] = refer( &stage, b, still.scene, still.eyes );
    }
    compare( name, &stage, setting, reference, true );
    close_stage( &stage );
}

TEST( test_dimmed_lamps )
{
    check_room( "dimmer", &g_moving_tiles );
    check_room( "glow", &g_moving_tiles );
    check_room( "six", &g_moving_frames );
    check_room( "seen", &g_moving_tiles );
}

TEST( test_what_moves )
{
    check_room( "torch", &g_moving_tiles );
    check_room( "passing", &g_moving_frames );
    check_room( "cones", &g_moving_tiles );
    check_room( "jumps", &g_moving_tiles );
    check_room( "lamps", &g_moving_tiles );
}

STATISTICAL_TESTS
