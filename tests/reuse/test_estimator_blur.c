// Frames of rooms in which things and the camera move while the shutter is open have the mean of path tracing of still rooms at
// moments of it.
#include "light/changing.h"
#include "path/lanes.h"
#include "scene/lens.h"
#include "scene/moments.h"
#include "support/moving_rooms.h"
#include "support/reference_tracer.h"
#include "support/scene_files.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"
#include "trace/trace.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 24
#define HEIGHT 16
#define BLOCK 4
#define FRAME 3
#define STEPS 12
#define MOMENTS 16
#define REFERENCE_SPP 4
#define REFERENCE_SEED 2000003
#define MAX_DEPTH 5

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

// With an open shutter; so many steps that straight ones are as good as turns.
static void open_shutters( MovingRoom* room, double length )
{
    RfLens lens = { .has_shutter = true, .shutter = { -0.5 * length, 0.5 * length }, .blur_steps = STEPS };
    RfCameraPath path;
    RfError error;
    RfPathOptions options = { .lens = &lens, .width = WIDTH, .height = HEIGHT };
    if ( rf_create_camera_path( &room->scene, &options, &path, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    assert_int_equal( path.count, room->eye_count );
    for ( int i = 0; i < path.count; ++i )
        assert_int_equal( path.eyes[i].blur_steps, STEPS );
    memcpy( room->eyes, path.eyes, (size_t)path.count * sizeof *path.eyes );
    rf_destroy_camera_path( &path );
}

// With lights that move and, as in the middle of the shutter, emission.
static RfGroupLights* light_moment( const RfTracer* still, const RfEye* eye, RfPosedScene* pose, RfTracer* posed )
{
    const RfLights* lights = rf_tracer_lights( still );
    RfGroupLights* group = NULL;
    RfError error;
    if ( lights->changing == NULL )
        return NULL;
    RfPosedScene middle = gltf_pose_at( rf_tracer_scene( still ), eye->time );
    RfVec3* emission = malloc( ( (size_t)lights->changing->dim_count + 1 ) * sizeof *emission );
    rf_note_emission( lights, &middle.scene, emission );
    RfLitFrame frame = { &pose->scene, emission };
    if ( rf_create_group_lights( lights, rf_tracer_scene( still ), 1, &frame, &group, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    rf_set_lights( posed, group->lights );
    rf_destroy_pose( &middle );
    free( emission );
    return group;
}

// One image: a still room at each of some moments, as the camera sees it then.
static float* mean_of_moments( const RfTracer* tracer, const RfEye* eye, int seed )
{
    size_t floats = 3 * (size_t)WIDTH * HEIGHT;
    float *sum = calloc( floats, sizeof *sum ), *one = calloc( floats, sizeof *one );
    int moments = MOMENTS * ( is_long() ? 4 : 1 );
    for ( int j = 0; j < moments; ++j )
    {
        RfRandomKey key = rf_pixel_key( rf_pass_key( REFERENCE_SEED, 0, 0, (uint32_t)seed ), (uint32_t)j );
        double moment = ( (double)j + (double)rf_random( key, 0 ) ) / moments;
        RfEye then = rf_sample_eye( eye, ( RfLensSample ){ 0.0f, 0.0f, (float)moment } );
        RfPosedScene pose = gltf_pose_at( rf_tracer_scene( tracer ), eye->opens + moment * ( eye->closes - eye->opens ) );
        RfTracer* posed;
        RfError error;
        if ( rf_create_posed_tracer( tracer, &pose.scene, &posed, &error ) != RF_OK )
            fail_msg( "%s", error.text );
        RfGroupLights* lights = light_moment( tracer, eye, &pose, posed );
        ReferenceSettings plain = { .spp = REFERENCE_SPP,
                                    .max_depth = MAX_DEPTH,
                                    .light_samples = 1,
                                    .seed = (uint64_t)( REFERENCE_SEED + seed * moments + j ) };
        reference_image( posed, &then, &plain, one );
        for ( size_t i = 0; i < floats; ++i )
            sum[i] += one[i] / (float)moments;
        rf_destroy_tracer( posed );
        rf_destroy_group_lights( lights );
        rf_destroy_pose( &pose );
    }
    free( one );
    return sum;
}

typedef struct Setting
{
    const char* tile;
    int group, spp;
    bool adaptive;
} Setting;

static const Setting s_settings[] = {
    { "3x3", 3, 7, false }, { "1", 3, 7, false }, { "3x3", 0, 6, false }, { "3x3", 3, 7, true }
};

static void check( const char* name, double shutter, int count )
{
    MovingRoom room = load_moving_room( name, WIDTH, HEIGHT );
    open_shutters( &room, shutter );
    RfTracer* tracer = make_tracer( &room.scene );
    Images reference = { .width = WIDTH, .height = HEIGHT, .count = SEEDS };
    for ( int k = 0; k < SEEDS; ++k )
        reference.rgb[k] = mean_of_moments( tracer, room.eyes + FRAME, k );
    for ( int k = 0; k < count; ++k )
    {
        const Setting* s = s_settings + k;
        RfRenderSettings settings = plain_settings();
        settings.max_depth = MAX_DEPTH;
        settings.memory = (size_t)512 << 20;
        settings.group = s->group;
        settings.spp = s->spp * ( is_long() ? 4 : 1 );
        settings.adaptive = s->adaptive ? RF_ADAPTIVE_ON : RF_ADAPTIVE_OFF;
        settings.light_paths = RF_LIGHT_PATHS_OFF;
        assert_true( rf_parse_tile( s->tile, &settings.tile ) );
        Images rendered = rendered_images( tracer, room.eyes, room.eye_count, FRAME, settings );
        char text[96];
        snprintf( text, sizeof text, "%s, group %d, tile %s%s:", name, s->group, s->tile, s->adaptive ? ", adaptive" : "" );
        assert_unbiased( text, &rendered, &reference, BLOCK );
        free_images( &rendered );
    }
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &room.scene );
}

TEST( test_what_passes_by ) { check( "sweep", 1.0, 4 ); }

TEST( test_a_fan ) { check( "fan", 0.5, 3 ); }

TEST( test_figures ) { check( "figure", 1.0, 3 ); }

TEST( test_mirrors_that_turn ) { check( "mirrors", 1.0, 2 ); }

TEST( test_panes_that_move ) { check( "panes", 1.0, 2 ); }

TEST( test_what_shines_and_moves ) { check( "torch", 1.0, 2 ); }

STATISTICAL_TESTS
