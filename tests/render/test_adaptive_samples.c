// Extra samples for pixels that few other frames help: which pixels get them, and that
// nothing else changes the result.
#include "support/cli_run.h"
#include "render/adaptive.h"
#include "support/render_support.h"
#include "support/scene_builder.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <string.h>

#include <cmocka.h>

#define EYES 5

static Rendered render( const RfTracer* tracer, RfRenderSettings settings, int frame )
{
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 15.0f, 40, 30 );
    settings.memory = settings.memory > 0 ? settings.memory : (size_t)256 << 20;
    settings.max_depth = 4;
    if ( frame < 0 )
        return render_all( tracer, eyes, EYES, &settings );
    return render_frames( tracer, eyes, EYES, &frame, 1, &settings );
}

static RfRenderSettings adaptive_settings( void )
{
    RfRenderSettings settings = rf_default_render_settings();
    settings.group = 1;
    settings.spp = 6;
    settings.adaptive = true;
    return settings;
}

// A frame is the same whichever others are asked for, and for any threads and memory.
static void test_nothing_else_decides( void** state )
{
    (void)state;
    RfScene scene = make_glass_room();
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings settings = adaptive_settings();
    settings.threads = 1;
    Rendered all = render( tracer, settings, -1 );
    settings.threads = 3;
    Rendered one = render( tracer, settings, 3 );
    settings.hold_all = true;
    Rendered held = render( tracer, settings, -1 );
    settings.hold_all = false;
    settings.memory = all.stats.fit.least;
    Rendered tight = render( tracer, settings, -1 );
    assert_true( all.native_spp[3] > settings.spp );
    assert_memory_equal( frame_rgb( &all, 3 ), frame_rgb( &one, 0 ), 3 * all.pixels * sizeof( float ) );
    assert_memory_equal( frame_rgb( &all, 0 ), frame_rgb( &tight, 0 ), 3 * all.pixels * EYES * sizeof( float ) );
    assert_memory_equal( frame_rgb( &all, 0 ), frame_rgb( &held, 0 ), 3 * all.pixels * EYES * sizeof( float ) );
    assert_true( tight.stats.peak_bytes <= tight.stats.budget_bytes );
    free_rendered( &all );
    free_rendered( &one );
    free_rendered( &held );
    free_rendered( &tight );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

// Without other frames there is nothing to make up for.
static void test_single_frames_are_as_without( void** state )
{
    (void)state;
    RfScene scene = make_glass_room();
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings settings = adaptive_settings();
    settings.group = 0;
    Rendered with = render( tracer, settings, -1 );
    settings.adaptive = false;
    Rendered without = render( tracer, settings, -1 );
    assert_memory_equal( with.rgb, without.rgb, 3 * with.pixels * EYES * sizeof( float ) );
    assert_true( with.native_spp[2] == 6.0 );
    free_rendered( &with );
    free_rendered( &without );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

static void test_threshold_follows_the_weights( void** state )
{
    (void)state;
    enum
    {
        BINS = 64
    };
    double counts[BINS] = { 0 };
    counts[BINS - 1] = 1000.0; // a frame alone: equal samples are best
    assert_true( rf_extra_threshold( counts, BINS, 1000.0, 1 ) == 1.0 );
    counts[BINS - 1] = 0.0;
    counts[BINS / 7] = 1000.0; // all of them are helped alike: none gets more
    assert_true( rf_extra_threshold( counts, BINS, 1000.0, 7 ) <= (double)BINS / ( BINS / 7 + 1 ) );
    // some are alone: brought to between what they have, 1, and the others, 6.4; where the
    // derivative of error times cost is 0, theta^2 is cost / (cost of an extra sample x error)
    for ( int few = 50; few <= 400; few *= 2 )
    {
        counts[BINS - 1] = few;
        counts[BINS / 7] = 1000.0 - few;
        double theta = rf_extra_threshold( counts, BINS, 1000.0, 7 );
        double error = few / theta + ( 1000.0 - few ) / 6.4, cost = 1300.0 + few * 1.2 * ( theta - 1.0 );
        assert_true( fabs( theta * theta - cost / ( 1.2 * error ) ) < 0.1 * theta * theta );
    }
    counts[BINS - 1] = 2.0; // too few to matter
    counts[BINS / 7] = 998.0;
    assert_true( rf_extra_threshold( counts, BINS, 1000.0, 7 ) == 1.0 );
    counts[BINS / 7] = counts[BINS - 1] = 0.0; // nothing but sky
    assert_true( rf_extra_threshold( counts, BINS, 1000.0, 7 ) == 1.0 );
}

static void test_command_line_takes_it( void** state )
{
    (void)state;
    cli_enter();
    cli_expect( cli_run( "$R render $VASE -o a.exr --frames 3 --size 24x16 --spp 3 --group 1 --quiet --adaptive --json a.json && "
                         "grep -q '\"adaptive\": *true' a.json" ),
                0, NULL );
    cli_expect( cli_run( "$R render $VASE -o a.exr --resume --frames 3 --size 24x16 --spp 3 --group 1 --quiet" ), 1,
                "--resume: " );
    cli_expect( cli_run( "$R render $VASE -o b.exr --adaptive --weights eq15" ), 2, "--adaptive: wants --weights exact" );
    cli_expect( cli_run( "$R render $VASE -o c.exr --frames 3 --size 24x16 --noise 0.1 --group 2 --quiet --adaptive" ), 0, NULL );
    cli_leave();
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_nothing_else_decides ),
        cmocka_unit_test( test_single_frames_are_as_without ),
        cmocka_unit_test( test_threshold_follows_the_weights ),
        cmocka_unit_test( test_command_line_takes_it ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
