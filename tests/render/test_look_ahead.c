// The look along the path that predicts the time to the end of --noise and --flicker changes no picture.
#include "support/scene_builder.h"
#include "support/render_support.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define EYES 15
#define WIDTH 40
#define HEIGHT 30
#define PIXELS ( WIDTH * HEIGHT )

typedef struct Kept
{
    float* rgb; // of all frames
    int told;   // progress with seconds left
} Kept;

static RfResult keep_frame( void* user, const RfFrameResult* result, RfError* error )
{
    (void)error;
    Kept* kept = user;
    memcpy( kept->rgb + (size_t)result->frame * PIXELS * 3, result->rgb, PIXELS * 3 * sizeof( float ) );
    return RF_OK;
}

static bool note_progress( void* user, const RfProgress* progress )
{
    Kept* kept = user;
    kept->told += isfinite( progress->left );
    return true;
}

static Kept render( const RfTracer* tracer, const RfEye* eyes, const RfRenderSettings* settings, bool progress,
                    RfRenderStats* stats )
{
    int frames[EYES];
    for ( int k = 0; k < EYES; ++k )
        frames[k] = k;
    Kept kept = { .rgb = calloc( (size_t)EYES * PIXELS * 3, sizeof( float ) ) };
    assert_non_null( kept.rgb );
    RfRenderCallbacks callbacks = { &kept, keep_frame, progress ? note_progress : NULL };
    RfError error;
    assert_int_equal( rf_render( tracer, eyes, EYES, frames, EYES, settings, &callbacks, stats, &error ), RF_OK );
    return kept;
}

static void check( RfRenderSettings settings )
{
    RfScene scene = make_room( ROOM_GGX );
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    settings.group = 1;
    settings.threads = 1;
    RfRenderStats with, without;
    Kept a = render( tracer, eyes, &settings, true, &with ), b = render( tracer, eyes, &settings, false, &without );
    assert_memory_equal( a.rgb, b.rgb, (size_t)EYES * PIXELS * 3 * sizeof( float ) );
    assert_int_equal( with.rays.primary, without.rays.primary ); // the look is counted apart
    assert_true( without.ahead_samples == 0.0 );
    bool looks = settings.noise > 0.0 || settings.flicker > 0.0;
    assert_true( looks == ( with.ahead_samples > 0.0 ) );
    assert_true( a.told > 0 );
    free( a.rgb );
    free( b.rgb );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

static RfRenderSettings settings_of( double noise, double flicker )
{
    RfRenderSettings settings = plain_settings();
    settings.spp = noise > 0.0 || flicker > 0.0 ? 1 << 10 : 6;
    settings.noise = noise;
    settings.flicker = flicker;
    return settings;
}

static void test_no_picture_changes( void** state )
{
    (void)state;
    check( settings_of( 0.2, 0.0 ) );
    check( settings_of( 0.0, 0.1 ) );
    check( settings_of( 0.0, 0.0 ) );
}

int main( void )
{
    const struct CMUnitTest tests[] = { cmocka_unit_test( test_no_picture_changes ) };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
