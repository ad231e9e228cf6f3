// Frames of rooms in which something moves (src/reuse/estimators.md, section 18), rendered with groups and tiles, have the mean of
// path tracing of a still room each, which a script made without any movement (tests/support/moving_rooms.py).
#include "support/moving_cases.h"
#include "support/statistics.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>

#include <cmocka.h>

static void test_what_passes_by( void** state )
{
    (void)state;
    check_moving( &( MovingCase ){
        "sweep", 5, { 1, 3, 5 }, 3, { &g_moving_frames, &g_moving_tiles, &g_moving_rooks, &g_moving_adaptive } } );
}

static void test_a_door( void** state )
{
    (void)state;
    check_moving( &( MovingCase ){ "door", 5, { 1, 3, 5 }, 3, { &g_moving_frames, &g_moving_tiles } } );
}

static void test_mirrors_that_turn( void** state )
{
    (void)state;
    check_moving( &( MovingCase ){ "mirrors", 5, { 1, 3, 5 }, 3, { &g_moving_tiles, &g_moving_frames, &g_moving_connected } } );
}

static void test_figures( void** state )
{
    (void)state;
    check_moving( &( MovingCase ){ "figure", 5, { 1, 3, 5 }, 3, { &g_moving_tiles, &g_moving_two_lights } } );
}

static void test_what_is_shown_at_times( void** state )
{
    (void)state;
    check_moving( &( MovingCase ){ "shown", 5, { 1, 3, 5 }, 3, { &g_moving_tiles, &g_moving_adaptive } } );
}

static void test_panes_that_move( void** state )
{
    (void)state;
    check_moving( &( MovingCase ){ "panes", 5, { 1, 3, 5 }, 3, { &g_moving_tiles, &g_moving_frames } } );
}

static void test_a_sky_through_openings( void** state )
{
    (void)state;
    check_moving( &( MovingCase ){ "sky", 5, { 1, 3, 5 }, 3, { &g_moving_tiles, &g_moving_frames } } );
}

static void test_lamps_and_a_hidden_sky( void** state )
{
    (void)state;
    check_moving( &( MovingCase ){ "lamps", 5, { 2, 4 }, 2, { &g_moving_tiles, &g_moving_two_lights } } );
}

// B counts first hits, whatever becomes of their light.
static void test_mean_weight_is_1( void** state )
{
    (void)state;
    assert_mean_weight_is_1( "sweep" );
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
