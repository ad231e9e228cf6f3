// Rooms in which something moves (tests/support/moving_rooms.py) against the still room of each frame: path tracing and tiles give
// the same pictures and AOVs at the same seed, but for a few pixels whose paths part where a rounding decides. What moves out of
// the way changes no bit. Ten thousand nodes that move take little time and memory.
#include "support/moving_rooms.h"
#include "support/render_support.h"

#include "film/aov.h"
#include "render/traits.h"
#include "render/worlds.h"
#include "scene/pose.h"

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
#define PIXELS ( WIDTH * HEIGHT )

static const char* const s_rooms[] = { "sweep",      "door",  "mirrors",  "figure",  "shown",   "panes",   "sky",
                                       "around-eye", "flat",  "singular", "late",    "no-area", "far-out", "short-path",
                                       "plate",      "lamps", "poster",   "heavens", "dawn" };

#define PANES 5 // rays through what is half transparent are hashed: all values may differ

static void render( const MovingRoom* room, const RfEye* eyes, int frame, const RfRenderSettings* settings, KeptPicture* p )
{
    RfTracer* tracer = make_tracer( &room->scene );
    render_picture( &( RfShot ){ tracer, eyes, room->eye_count, &frame, 1 }, settings, p );
    rf_destroy_tracer( tracer );
}

static RfRenderSettings settings_of( int group, const char* tile, int spp )
{
    RfRenderSettings settings = small_settings( group, spp );
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    settings.adaptive = RF_ADAPTIVE_OFF;
    settings.light_paths = RF_LIGHT_PATHS_OFF;
    return settings;
}

// The same ball around both, by which lights are chosen.
static void share_bounds( RfScene* scene, const RfScene* from )
{
    scene->bounds_min = from->bounds_min;
    scene->bounds_max = from->bounds_max;
}

static void check_frame( const char* name, int frame, const RfRenderSettings* settings, double most_others )
{
    static KeptPicture pictures[2];
    MovingRoom moving = load_moving_room( name, WIDTH, HEIGHT ), still = load_still_room( name, frame, WIDTH, HEIGHT );
    if ( strcmp( name, "plate" ) != 0 ) // whose own bounds have to reach it
        share_bounds( &still.scene, &moving.scene );
    render( &moving, moving.eyes, frame, settings, pictures );
    render( &still, still.eyes, frame, settings, pictures + 1 );
    double others = share_of_others( pictures[0].rgb, pictures[1].rgb, 3 * PIXELS );
    if ( !( others <= most_others ) )
        fail_msg( "%s, frame %d: %.2f %% of the values differ", name, frame, 100.0 * others );
    for ( int k = 0; k < RF_AOV_COUNT; ++k )
    {
        if ( pictures[0].channels[k] == 0 )
            continue;
        double share = share_of_others( pictures[0].aov[k], pictures[1].aov[k], pictures[0].channels[k] * PIXELS );
        if ( share > 0.005 )
            fail_msg( "%s, frame %d: AOV %s differs in %.2f %% of its values", name, frame, rf_aov_name( (RfAov)k ),
                      100.0 * share );
    }
    rf_destroy_scene( &moving.scene );
    rf_destroy_scene( &still.scene );
}

static void test_frames_are_those_of_still_rooms( void** state )
{
    (void)state;
    for ( size_t i = 0; i < sizeof s_rooms / sizeof s_rooms[0]; ++i )
    {
        RfRenderSettings settings = settings_of( 0, i % 2 == 0 ? "1" : "3x3", 2 );
        settings.aovs = RF_AOV_BIT( RF_AOV_ALBEDO ) | RF_AOV_BIT( RF_AOV_NORMAL ) | RF_AOV_BIT( RF_AOV_DEPTH );
        int frames = strcmp( s_rooms[i], "short-path" ) == 0 ? 3 : MOVING_EYES;
        for ( int frame = 0; frame < frames; ++frame )
            check_frame( s_rooms[i], frame, &settings, i == PANES ? 0.4 : 0.01 );
    }
}

static void test_groups_are_finite( void** state )
{
    (void)state;
    for ( size_t i = 0; i < sizeof s_rooms / sizeof s_rooms[0]; ++i )
    {
        MovingRoom room = load_moving_room( s_rooms[i], WIDTH, HEIGHT );
        RfTracer* tracer = make_tracer( &room.scene );
        RfRenderSettings settings = settings_of( 3, i % 2 == 0 ? "3x3" : "1", 7 );
        check_sane_settings( s_rooms[i], tracer, room.eyes, room.eye_count, &settings );
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &room.scene );
    }
}

static void test_what_is_out_of_the_way_changes_no_bit( void** state )
{
    (void)state;
    static KeptPicture pictures[2];
    MovingRoom moving = load_moving_room( "apart", WIDTH, HEIGHT ), still = load_still_room( "apart", 3, WIDTH, HEIGHT );
    share_bounds( &still.scene, &moving.scene );
    for ( int k = 0; k < 2; ++k )
    {
        RfRenderSettings settings = settings_of( 3, k == 0 ? "1" : "3x3", 7 );
        render( &moving, moving.eyes, 3, &settings, pictures );
        render( &still, still.eyes, 3, &settings, pictures + 1 );
        assert_memory_equal( pictures[0].rgb, pictures[1].rgb, 3 * PIXELS * sizeof( float ) );
    }
    rf_destroy_scene( &moving.scene );
    rf_destroy_scene( &still.scene );
}

static void test_ten_thousand_nodes( void** state )
{
    (void)state;
    MovingRoom room = load_moving_room( "many", WIDTH, HEIGHT );
    RfPosedScene pose = { 0 };
    RfError error;
    assert_int_equal( rf_pose_scene( &room.scene, 0.1, &pose, &error ), RF_OK );
    rf_destroy_pose( &pose );
    static KeptPicture picture;
    RfRenderSettings settings = settings_of( 3, "3x3", 7 );
    render( &room, room.eyes, 3, &settings, &picture );
    double bytes = (double)rf_worlds_bytes( &room.scene, MOVING_EYES, 0 );
    assert_true( bytes < 1e8 );
    rf_destroy_scene( &room.scene );
}

static void test_settings_that_cannot_tell_are_refused( void** state )
{
    (void)state;
    RfSceneTraits traits = { .moves = true };
    RfRenderSettings settings = plain_settings();
    RfError error;
    settings.group = 3;
    assert_int_equal( RF_OK, rf_check_moving( &traits, &settings, &error ) );
    settings.weights = RF_WEIGHTS_EQ15;
    assert_int_equal( RF_ERROR_USAGE, rf_check_moving( &traits, &settings, &error ) );
    settings.group = 0;
    assert_int_equal( RF_OK, rf_check_moving( &traits, &settings, &error ) );
    settings = plain_settings();
    settings.group = 3;
    settings.light_paths = RF_LIGHT_PATHS_ON;
    assert_int_equal( RF_ERROR_USAGE, rf_check_moving( &traits, &settings, &error ) );
    traits.moves = false;
    assert_int_equal( RF_OK, rf_check_moving( &traits, &settings, &error ) );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_settings_that_cannot_tell_are_refused ),
        cmocka_unit_test( test_frames_are_those_of_still_rooms ),
        cmocka_unit_test( test_groups_are_finite ),
        cmocka_unit_test( test_what_is_out_of_the_way_changes_no_bit ),
        cmocka_unit_test( test_ten_thousand_nodes ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
