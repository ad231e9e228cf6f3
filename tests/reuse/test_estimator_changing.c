// Frames of rooms in which lamps, materials and lenses change (src/reuse/estimators.md, section 18), rendered with groups and tiles,
// have the mean of path tracing of a still room each, which a script made without any change (tests/support/changing_rooms.py).
#include "support/moving_cases.h"
#include "support/statistics.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>

#define DEPTH 5
#define MIDDLE 3

// A room with tiles and groups, and by another setting; NULL: none.
static void check_room( const char* room, const MovingSetting* other )
{
    MovingCase c = { room, DEPTH, { 1, 3, 5 }, 3, { &g_moving_tiles, other } };
    check_moving( &c );
}

// Rooms of which others have all that changes in them.
static void check_room_if_long( const char* room, const MovingSetting* other )
{
    if ( is_moving_long() )
        check_room( room, other );
}

TEST( test_a_dimmer )
{
    MovingCase c = {
        "dimmer", DEPTH, { 1, 3, 5 }, 3, { &g_moving_tiles, &g_moving_frames, &g_moving_rooks, &g_moving_adaptive }
    };
    check_moving( &c );
}

TEST( test_panels_that_dim ) { check_room( "glow", &g_moving_adaptive ); }

TEST( test_switches ) { check_room( "switches", &g_moving_frames ); }

TEST( test_colours ) { check_room( "colors", &g_moving_two_lights ); }

TEST( test_more_lamps_than_parts ) { check_room( "six", &g_moving_frames ); }

TEST( test_what_is_seen_of_lights ) { check_room( "seen", &g_moving_frames ); }

TEST( test_lamps_that_pass )
{
    MovingCase c = { "passing", DEPTH, { 1, 3, 5 }, 3, { &g_moving_tiles, &g_moving_frames, &g_moving_two_lights } };
    check_moving( &c );
    check_room_if_long( "matt", &g_moving_frames );
}

TEST( test_cones_and_ranges ) { check_room( "cones", NULL ); }

TEST( test_torches )
{
    MovingCase c = { "torch", DEPTH, { 1, 3, 5 }, 3, { &g_moving_tiles, &g_moving_frames, &g_moving_connected } };
    check_moving( &c );
}

TEST( test_a_sun_that_travels ) { check_room( "sun", &g_moving_rooks ); }

TEST( test_surfaces_that_change ) { check_room( "surfaces", &g_moving_frames ); }

TEST( test_films )
{
    check_room( "poster", NULL );
    check_room_if_long( "cinema", NULL );
}

TEST( test_a_sky_that_turns_and_dims )
{
    MovingCase c = { "heavens", DEPTH, { 1, 2, 5 }, 3, { &g_moving_tiles, &g_moving_frames } }; // dark in between
    check_moving( &c );
    check_room_if_long( "dawn", &g_moving_frames );
}

TEST( test_a_lens_that_zooms ) { check_room( "zoom", NULL ); }

TEST( test_everything ) { check_room( "everything", &g_moving_adaptive ); }

// What the frames are shared with is bright; the one in the middle has no light at all.
TEST( test_a_dark_frame )
{
    const MovingSetting* settings[] = { &g_moving_tiles, &g_moving_frames, &g_moving_adaptive };
    MovingRoom room = load_moving_room( "blackout", MOVING_WIDTH, MOVING_HEIGHT );
    RfTracer* tracer = make_tracer( &room.scene );
    for ( size_t k = 0; k < sizeof settings / sizeof *settings; ++k )
    {
        RfRenderSettings plain = moving_settings( settings[k], DEPTH );
        Rendered r = render_all( tracer, room.eyes, room.eye_count, &plain );
        for ( int f = 0; f < r.count; ++f )
        {
            double sum = 0.0, most = 0.0;
            for ( size_t i = 0; i < 3 * r.pixels; ++i )
            {
                sum += frame_rgb( &r, f )[i];
                most = fmax( most, fabs( frame_rgb( &r, f )[i] ) );
            }
            assert_true( f == MIDDLE ? most == 0.0 : sum > 0.0 );
        }
        free_rendered( &r );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &room.scene );
}

// The frames beside it have all of theirs.
TEST( test_lamps_that_go_out )
{
    MovingCase c = { "blackout", DEPTH, { 1, 4, 5 }, 3, { &g_moving_tiles, &g_moving_frames } };
    check_moving( &c );
}

// B counts first hits, whatever becomes of their light.
TEST( test_mean_weight_is_1 ) { assert_mean_weight_is_1( "everything" ); }

STATISTICAL_TESTS
