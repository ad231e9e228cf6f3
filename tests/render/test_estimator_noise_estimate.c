// The error that a render reports, relMSE from the halves of its films, is true: over
// seeds (32 with REFRAME_LONG) and scenes, without reuse, over frames, in tiles and in
// both, the mean estimate lies within 15 % of the mean relMSE against a converged
// reference with another seed.
#include "measure/error.h"
#include "support/render_support.h"
#include "scene/camera.h"
#include "scene/json/scene_file.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#define WIDTH 80
#define HEIGHT 45
#define EYES 15 // more than two groups of 7: they slide over the frame in the middle
#define SPP 14
#define REFERENCE_SEED 1000003
#define FIRST_SEED 100 // the estimate was chosen by lower ones

typedef struct Shot
{
    RfScene scene;
    RfTracer* tracer;
    RfEye eyes[EYES];
    float* reference; // of the middle frame
} Shot;

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

static Rendered render_middle( const Shot* shot, int group, const char* tile, int spp, uint64_t seed )
{
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    settings.spp = spp;
    settings.seed = seed;
    settings.memory = (size_t)512 << 20;
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    int frame = EYES / 2;
    return render_frames( shot->tracer, shot->eyes, EYES, &frame, 1, &settings );
}

static Shot load_shot( const char* file )
{
    Shot shot = { 0 };
    RfError error = { 0 };
    RfLog log = { 0 };
    int camera;
    if ( rf_load_scene( file, &shot.scene, &log, &error ) != RF_OK ||
         rf_find_camera( &shot.scene, NULL, &camera, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    for ( int i = 0; i < EYES; ++i )
    {
        if ( rf_camera_eye( &shot.scene, shot.scene.cameras + camera, 16.0 + i, 24, 1, WIDTH, HEIGHT, shot.eyes + i, &error ) !=
             RF_OK )
            fail_msg( "%s", error.text );
    }
    shot.tracer = make_tracer( &shot.scene );
    Rendered reference = render_middle( &shot, 0, "3x3", is_long() ? 8192 : 2048, REFERENCE_SEED );
    shot.reference = reference.rgb;
    reference.rgb = NULL;
    free_rendered( &reference );
    return shot;
}

static void destroy_shot( Shot* shot )
{
    rf_destroy_tracer( shot->tracer );
    rf_destroy_scene( &shot->scene );
    free( shot->reference );
}

static void check_honest( const char* what, Shot* shot, int group, const char* tile, int seeds )
{
    double estimate = 0.0, truth = 0.0;
    for ( int seed = 1; seed <= seeds; ++seed )
    {
        Rendered rendered = render_middle( shot, group, tile, SPP, (uint64_t)( FIRST_SEED + seed ) );
        RfImage image = { .width = WIDTH, .height = HEIGHT, .rgb = rendered.rgb };
        RfImage reference = { .width = WIDTH, .height = HEIGHT, .rgb = shot->reference };
        RfErrorMetrics metrics;
        RfError error;
        assert_int_equal( rf_measure_error( &image, &reference, &metrics, &error ), RF_OK );
        estimate += rendered.relmse_estimate[0] / seeds;
        truth += metrics.relmse / seeds;
        free_rendered( &rendered );
    }
    printf( "%-14s group %d tile %-4s relMSE %.4f, estimated %.4f: %.3f\n", what, group, tile, truth, estimate,
            estimate / truth );
    // few seeds have few of the fireflies that carry the error
    assert_true( fabs( estimate / truth - 1.0 ) < ( is_long() ? 0.15 : 0.25 ) );
}

static void check_scene( const char* what, const char* file, bool always )
{
    if ( !always && !is_long() )
        skip();
    Shot shot = load_shot( file );
    int seeds = is_long() ? 32 : 6;
    check_honest( what, &shot, 0, "1", seeds );
    check_honest( what, &shot, 3, "1", seeds );
    check_honest( what, &shot, 0, "3x3", seeds );
    check_honest( what, &shot, 3, "3x3", seeds );
    destroy_shot( &shot );
}

static void test_vase_room( void** state )
{
    (void)state;
    check_scene( "vase room", REFRAME_VASE_ROOM, true );
}

static void test_bounced_room( void** state )
{
    (void)state;
    check_scene( "bounced room", REFRAME_SCENE_FOLDER "/bounced-room.glb", false );
}

static void test_textured_room( void** state )
{
    (void)state;
    check_scene( "textured room", REFRAME_SCENE_FOLDER "/textured-room.glb", true );
}

static void test_still_life( void** state )
{
    (void)state;
    check_scene( "still life", REFRAME_SCENE_FOLDER "/still-life.glb", true );
}

static void test_ggx_room( void** state )
{
    (void)state;
    check_scene( "GGX room", REFRAME_SCENE_FOLDER "/vase-room-ggx.glb", false );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_vase_room ),  cmocka_unit_test( test_bounced_room ), cmocka_unit_test( test_textured_room ),
        cmocka_unit_test( test_still_life ), cmocka_unit_test( test_ggx_room ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
