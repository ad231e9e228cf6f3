// Rooms in which something moves (tests/support/moving_rooms.py) against the still room of each frame: path tracing and tiles give
// the same pictures and AOVs at the same seed, but for a few pixels whose paths part where a rounding decides. What moves out of
// the way changes no bit. Ten thousand nodes that move take little time and memory.
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/test.h"

#include "film/aov.h"
#include "render/traits.h"
#include "render/worlds.h"
#include "scene/pose.h"

#include <string.h>

#define WIDTH 24
#define HEIGHT 16
#define PIXELS ( WIDTH * HEIGHT )

static const char* const s_rooms[] = { "sweep",      "door",  "mirrors",  "figure",  "shown",   "panes",   "sky",
                                       "around-eye", "flat",  "singular", "late",    "no-area", "far-out", "short-path",
                                       "plate",      "lamps", "poster",   "heavens", "dawn" };

#define PANES 5 // rays through what is half transparent are hashed: all values may differ

static RfRenderSettings settings_of( int group, const char* tile, int spp )
{
    RfRenderSettings settings = tiled_settings( group, spp, tile );
    settings.adaptive = RF_ADAPTIVE_OFF;
    settings.light_paths = RF_LIGHT_PATHS_OFF;
    return settings;
}

// A moving room, and the still one of a frame in the same ball, by which lights are chosen.
static void open_both( Stage stages[2], const char* name, int frame )
{
    open_moving_stage( stages, name, WIDTH, HEIGHT );
    open_still_stage( stages + 1, name, frame, WIDTH, HEIGHT );
    if ( strcmp( name, "plate" ) == 0 ) // whose own bounds have to reach it
        return;
    stages[1].scene.bounds_min = stages[0].scene.bounds_min;
    stages[1].scene.bounds_max = stages[0].scene.bounds_max;
}

static void close_both( Stage stages[2] )
{
    close_stage( stages );
    close_stage( stages + 1 );
}

static void check_frame( const char* name, int frame, const RfRenderSettings* settings, double most_others )
{
    Stage stages[2];
    open_both( stages, name, frame );
    const RfFrameResult *moving = render_one( stages, frame, settings ), *still = render_one( stages + 1, frame, settings );
    double others = share_of_others( moving->rgb, still->rgb, 3 * PIXELS );
    if ( !( others <= most_others ) )
        fail_msg( "%s, frame %d: %.2f %% of the values differ", name, frame, 100.0 * others );
    expect_like_aovs( name, moving, still, 0.005 );
    close_both( stages );
}

TEST( test_frames_are_those_of_still_rooms )
{
    for ( size_t i = 0; i < sizeof s_rooms / sizeof s_rooms[0]; ++i )
    {
        RfRenderSettings settings = settings_of( 0, i % 2 == 0 ? "1" : "3x3", 2 );
        settings.aovs = RF_AOV_BIT( RF_AOV_ALBEDO ) | RF_AOV_BIT( RF_AOV_NORMAL ) | RF_AOV_BIT( RF_AOV_DEPTH );
        int frames = strcmp( s_rooms[i], "short-path" ) == 0 ? 3 : MOVING_EYES;
        for ( int frame = 0; frame < frames; ++frame )
            check_frame( s_rooms[i], frame, &settings, i == PANES ? 0.4 : 0.01 );
    }
}

TEST( test_groups_are_finite )
{
    for ( size_t i = 0; i < sizeof s_rooms / sizeof s_rooms[0]; ++i )
    {
        Stage room;
        open_moving_stage( &room, s_rooms[i], WIDTH, HEIGHT );
        RfRenderSettings settings = settings_of( 3, i % 2 == 0 ? "3x3" : "1", 7 );
        check_sane_settings( s_rooms[i], stage_tracer( &room ), room.eyes, room.eye_count, &settings );
        close_stage( &room );
    }
}

TEST( test_what_is_out_of_the_way_changes_no_bit )
{
    Stage stages[2];
    open_both( stages, "apart", 3 );
    for ( int k = 0; k < 2; ++k )
    {
        RfRenderSettings settings = settings_of( 3, k == 0 ? "1" : "3x3", 7 );
        const RfFrameResult *moving = render_one( stages, 3, &settings ), *still = render_one( stages + 1, 3, &settings );
        assert_memory_equal( moving->rgb, still->rgb, 3 * PIXELS * sizeof( float ) );
    }
    close_both( stages );
}

TEST( test_ten_thousand_nodes )
{
    Stage room;
    open_moving_stage( &room, "many", WIDTH, HEIGHT );
    RfPosedScene pose = { 0 };
    RfError error;
    assert_int_equal( rf_pose_scene( &room.scene, 0.1, &pose, &error ), RF_OK );
    rf_destroy_pose( &pose );
    RfRenderSettings settings = settings_of( 3, "3x3", 7 );
    render_one( &room, 3, &settings );
    double bytes = (double)rf_worlds_bytes( &room.scene, MOVING_EYES, 0 );
    assert_true( bytes < 1e8 );
    close_stage( &room );
}

TEST( test_settings_that_cannot_tell_are_refused )
{
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
