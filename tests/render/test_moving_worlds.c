// A scene that moves, frame by frame: its motion against closed forms, memory that counts what moves, the same bits however frames
// are asked for, and failures in the midst of a render.
#include "reframe/plan.h"
#include "render/settings.h"
#include "render/memory/memory.h"
#include "render/worlds.h"
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/scene_files.h"
#include "support/test.h"

#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 48
#define HEIGHT 32
#define DISTANCE 3.0

// A plate from x = −1 to 1 and y = −0.6 to 0.6 at z = −3, before a wall, lit by the wall's light.
static const float s_plate[] = { -1, -0.6f, -3, 1, -0.6f, -3, 1, 0.6f, -3, -1, 0.6f, -3 };
static const float s_wall[] = { -50, -50, -9, 50, -50, -9, 50, 50, -9, -50, 50, -9 };
static const uint16_t s_faces[] = { 0, 1, 2, 0, 2, 3 };
static const float s_times[] = { 0, 4 };

// 0 plate, 1 faces, 2 wall, 3 times
static GltfBuilder make_plate_at( const float* times, int count )
{
    GltfBuilder b = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 4, s_plate );
    add_gltf_u16( &b, 6, s_faces );
    add_gltf_floats( &b, "VEC3", 3, 4, s_wall );
    add_gltf_floats( &b, "SCALAR", 1, count, times );
    return b;
}

static GltfBuilder make_plate( void ) { return make_plate_at( s_times, 2 ); }

#define MATERIALS "\"materials\":[{},{\"emissiveFactor\":[0.5,0.5,0.5]}],"
#define WALL "{\"primitives\":[{\"attributes\":{\"POSITION\":2},\"indices\":1,\"material\":1}]}"
#define PLATE( members ) "{\"primitives\":[{\"attributes\":{\"POSITION\":0" members "}]}"
#define MESHES( members ) MATERIALS "\"meshes\":[" PLATE( members ) "," WALL "],"
#define MOVED( node, path, kind )                                                                                                \
    "\"animations\":[{\"samplers\":[{\"input\":3,\"output\":4,\"interpolation\":\"" kind "\"}],\"channels\":[{\"sampler\":0,"    \
    "\"target\":{\"node\":" node ",\"path\":\"" path "\"}}]}]"

// Moves by `to` within 4 s.
static RfScene load_sliding( const float to[3] )
{
    GltfBuilder b = make_plate();
    const float places[] = { 0, 0, 0, to[0], to[1], to[2] };
    add_gltf_floats( &b, "VEC3", 3, 2, places );
    return gltf_load_built( &b, "\"nodes\":[{\"mesh\":1},{\"mesh\":0}]," MESHES( "},\"indices\":1,\"material\":0" )
                                    MOVED( "1", "translation", "LINEAR" ) );
}

// A second apart, from `first` on.
static void still_eyes( RfEye* eyes, int count, double first )
{
    for ( int i = 0; i < count; ++i )
    {
        eyes[i] = rf_make_eye( rf_vec3( 0, 0, 0 ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 0.6, WIDTH, HEIGHT );
        eyes[i].time = first + i;
    }
}

// Half a length before and after its time.
static void open_eye( RfEye* eye, double half, int steps )
{
    eye->opens = steps > 0 ? eye->time - half : 0.0;
    eye->closes = steps > 0 ? eye->time + half : 0.0;
    eye->blur_steps = steps;
}

// ---- Motion ---------------------------------------------------------------------

static RfRenderSettings moving_settings( int group, int spp )
{
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    settings.spp = spp;
    settings.max_depth = 3;
    settings.memory = (size_t)256 << 20;
    settings.aovs = RF_AOV_BIT( RF_AOV_MOTION );
    return settings;
}

// Takes the scene over, with these eyes a second apart.
static void open_plates( Stage* s, RfScene scene, int count, double first )
{
    RfEye eyes[STAGE_EYES];
    still_eyes( eyes, count, first );
    open_stage_before( s, scene, eyes, count );
}

static double pixels_per_m( const RfEye* eye ) { return (double)eye->focal / DISTANCE; }

// Film position of a pixel's middle, m at the plate's distance.
static void place_of( const RfEye* eye, int x, int y, double at[2] )
{
    at[0] = ( x + 0.5 - 0.5 * WIDTH ) / pixels_per_m( eye );
    at[1] = ( 0.5 * HEIGHT - y - 0.5 ) / pixels_per_m( eye );
}

static void assert_motion( const RfFrameResult* frame, int x, int y, int channel, double wanted, double tolerance )
{
    double got = (double)frame->aovs[RF_AOV_MOTION][4 * ( y * WIDTH + x ) + channel];
    if ( !( fabs( got - wanted ) <= tolerance ) )
        fail_msg( "frame %d, pixel %d,%d: motion %d is %.6f instead of %.6f", frame->frame, x, y, channel, got, wanted );
}

TEST( test_motion_of_what_slides )
{
    AUTO_BY( close_stage ) Stage s;
    open_plates( &s, load_sliding( ( const float[3] ){ 0.8f, -0.4f, 0 } ), 5, 0.0 );
    double step = pixels_per_m( s.eyes );
    for ( int i = 0; i < 6; ++i )
    {
        int group = i % 3;                      // 1: windows that are cut
        for ( int k = 0; k < 5 && i >= 3; ++k ) // motion is that in the middle of the shutter
            open_eye( s.eyes + k, 0.25, k );
        RfRenderSettings settings = moving_settings( group, 5 );
        const RfFrameResult* kept = render_stage( &s, &settings );
        for ( int k = 0; k < 5; ++k )
        {
            int x = WIDTH / 2, y = HEIGHT / 2;
            assert_motion( kept + k, x, y, 0, k > 0 ? -0.2 * step : 0.0, 1e-3 );
            assert_motion( kept + k, x, y, 1, k > 0 ? 0.1 * step : 0.0, 1e-3 );
            assert_motion( kept + k, x, y, 2, k < 4 ? 0.2 * step : 0.0, 1e-3 );
            assert_motion( kept + k, x, y, 3, k < 4 ? -0.1 * step : 0.0, 1e-3 );
            for ( int c = 0; c < 4; ++c )
                assert_motion( kept + k, 0, 0, c, 0.0, 0.0 ); // the wall, which stands still before an eye that does
        }
    }
}

// Eye and plate move alike: to the film it rests, while the wall moves.
TEST( test_an_eye_that_goes_along )
{
    AUTO_BY( close_stage ) Stage s;
    open_plates( &s, load_sliding( ( const float[3] ){ 0.8f, 0, 0 } ), 3, 0.0 );
    for ( int i = 0; i < 3; ++i )
        s.eyes[i].origin.x = 0.2f * (float)i;
    RfRenderSettings settings = moving_settings( 1, 5 );
    const RfFrameResult* kept = render_stage( &s, &settings );
    assert_motion( kept + 1, WIDTH / 2, HEIGHT / 2, 0, 0.0, 1e-4 );
    assert_motion( kept + 1, WIDTH / 2, HEIGHT / 2, 2, 0.0, 1e-4 );
    assert_motion( kept + 1, 0, 0, 2, -0.2 * (double)s.eyes[0].focal / 9.0, 1e-3 );
}

// It is gone in the second frame: there is nowhere to follow it to.
TEST( test_motion_of_what_vanishes )
{
    GltfBuilder b = make_plate();
    static const float s_scales[] = { 1, 1, 1, 0, 0, 0 };
    add_gltf_floats( &b, "VEC3", 3, 2, s_scales );
    AUTO_BY( close_stage ) Stage s;
    open_plates( &s,
                 gltf_load_built( &b, "\"nodes\":[{\"mesh\":1},{\"mesh\":0}]," MESHES( "},\"indices\":1,\"material\":0" )
                                          MOVED( "1", "scale", "STEP" ) ),
                 3, 2.5 );
    RfRenderSettings settings = moving_settings( 1, 3 );
    const RfFrameResult* kept = render_stage( &s, &settings );
    for ( int c = 0; c < 4; ++c )
        assert_motion( kept + 1, WIDTH / 2, HEIGHT / 2, c, 0.0, 0.0 );
}

// x grows by y, by a morph target: 0.1 y each second.
TEST( test_motion_of_what_changes_its_shape )
{
    GltfBuilder b = make_plate();
    static const float s_weights[] = { 0, 0.4f }, s_lean[] = { -0.6f, 0, 0, -0.6f, 0, 0, 0.6f, 0, 0, 0.6f, 0, 0 };
    add_gltf_floats( &b, "SCALAR", 1, 2, s_weights );
    add_gltf_floats( &b, "VEC3", 3, 4, s_lean );
    RfScene scene = gltf_load_built(
        &b, "\"nodes\":[{\"mesh\":1},{\"mesh\":0}]," MESHES( "},\"indices\":1,\"material\":0,\"targets\":[{\"POSITION\":5}]" )
                MOVED( "1", "weights", "LINEAR" ) );
    AUTO_BY( close_stage ) Stage s;
    open_plates( &s, scene, 3, 0.0 );
    RfRenderSettings settings = moving_settings( 1, 5 );
    const RfFrameResult* kept = render_stage( &s, &settings );
    for ( int y = HEIGHT / 2 - 8; y < HEIGHT / 2 + 8; ++y )
    {
        double at[2];
        place_of( s.eyes, WIDTH / 2, y, at );
        assert_motion( kept + 1, WIDTH / 2, y, 0, -0.1 * at[1] * pixels_per_m( s.eyes ), 0.05 ); // of a pixel, anywhere in it
        assert_motion( kept + 1, WIDTH / 2, y, 2, 0.1 * at[1] * pixels_per_m( s.eyes ), 0.05 );
        assert_motion( kept + 1, WIDTH / 2, y, 3, 0.0, 1e-3 );
    }
}

// A joint mirrors the plate from one frame to the next, which turns its triangles over.
TEST( test_motion_of_a_skin_that_is_turned_over )
{
    GltfBuilder b = make_plate();
    static const float s_scales[] = { 1, 1, 1, -1, 1, 1 }, s_weights[] = { 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0 };
    static const uint8_t s_joints[16] = { 0 };
    add_gltf_floats( &b, "VEC3", 3, 2, s_scales );
    add_gltf_accessor( &b, 5121, "VEC4", 4, s_joints, sizeof s_joints, "" );
    add_gltf_floats( &b, "VEC4", 4, 4, s_weights );
    RfScene scene = gltf_load_built(
        &b, "\"nodes\":[{\"mesh\":1},{\"mesh\":0,\"skin\":0},{}],\"skins\":[{\"joints\":[2]}]," MESHES(
                ",\"JOINTS_0\":5,\"WEIGHTS_0\":6},\"indices\":1,\"material\":0" ) MOVED( "2", "scale", "STEP" ) );
    AUTO_BY( close_stage ) Stage s;
    open_plates( &s, scene, 2, 3.0 );
    RfRenderSettings settings = moving_settings( 1, 5 );
    const RfFrameResult* kept = render_stage( &s, &settings );
    for ( int x = WIDTH / 2 - 10; x < WIDTH / 2 + 10; ++x )
    {
        for ( int frame = 0; frame < 2; ++frame )
        {
            double at[2];
            place_of( s.eyes, x, HEIGHT / 2 + 5, at );
            assert_motion( kept + frame, x, HEIGHT / 2 + 5, 2 - 2 * frame, -2.0 * at[0] * pixels_per_m( s.eyes ), 1.01 );
            assert_motion( kept + frame, x, HEIGHT / 2 + 5, 3 - 2 * frame, 0.0, 1e-3 );
        }
    }
}

// ---- Which frames are asked for -------------------------------------------------

static void check_parts( Stage* s, const RfRenderSettings* settings, int steps )
{
    for ( int i = 0; i < 7; ++i ) // the eye moves in every other frame
    {
        s->eyes[i] =
            rf_make_eye( rf_vec3( 0.05f * (float)( i / 2 ), 0, 0 ), rf_vec3( 0, 0, -1 ), rf_vec3( 0, 1, 0 ), 0.6, WIDTH, HEIGHT );
        s->eyes[i].time = 0.7 * i;
        open_eye( s->eyes + i, 0.2, steps );
    }
    const RfFrameResult* all = render_stage( s, settings );
    for ( int first = 0; first < 7; first += 2 )
    {
        int count = first + 2 < 7 ? 2 : 7 - first;
        const RfFrameResult* part = render_some( s, first, count, settings );
        for ( int i = 0; i < count; ++i )
        {
            assert_int_equal( part[i].frame, first + i );
            expect_same_bits( part + i, all + first + i );
        }
    }
}

TEST( test_a_frame_alone_is_that_of_its_sequence )
{
    AUTO_BY( close_stage ) Stage s;
    open_plates( &s, load_sliding( ( const float[3] ){ 0.8f, -0.4f, 0.5f } ), 7, 0.0 );
    for ( int kind = 0; kind < 9; ++kind )
    {
        RfRenderSettings settings = moving_settings( kind % 3, 7 );
        assert_true( rf_parse_tile( kind < 3 ? "1" : "3x3", &settings.tile ) );
        settings.adaptive = kind >= 1 ? RF_ADAPTIVE_ON : RF_ADAPTIVE_OFF;
        settings.threads = 1 + kind % 2;
        check_parts( &s, &settings, kind < 6 ? 0 : 2 );
    }
}

// A mirror that grows: light paths are aimed at where it is in their own frame.
TEST( test_light_paths_by_a_mirror_that_grows )
{
    GltfBuilder b = make_plate();
    static const float s_scales[] = { 0.2f, 0.2f, 1, 1.5f, 1.5f, 1 };
    add_gltf_floats( &b, "VEC3", 3, 2, s_scales );
    RfScene scene = gltf_load_built(
        &b, "\"nodes\":[{\"mesh\":1,\"rotation\":[0,1,0,0]},{\"mesh\":0},{\"mesh\":2,\"scale\":[1,1,0.1],\"rotation\":[-0."
            "70710678,0,0,0.70710678]}],\"materials\":[{\"pbrMetallicRoughness\":{"
            "\"roughnessFactor\":0}},{\"emissiveFactor\":[0.5,0.5,0.5]},{}],\"meshes\":[" PLATE(
                "},\"indices\":1,\"material\":0" ) "," WALL ",{\"primitives\":[{\"attributes\":{\"POSITION\":2},\"indices\":1,"
                                                   "\"material\":2}]}]," MOVED( "1", "scale", "LINEAR" ) );
    RfRenderSettings settings = moving_settings( 0, 2 );
    settings.light_paths = RF_LIGHT_PATHS_ON;
    AUTO_BY( close_stage ) Stage s;
    open_plates( &s, scene, 7, 0.0 );
    check_parts( &s, &settings, 0 );
    settings.group = 1;
    s.eye_count = 2;
    still_eyes( s.eyes, 2, 0.0 );
    expect_refused( &s, &settings, "light paths" );
    s.eye_count = 1; // a frame alone
    expect_refused( &s, &settings, NULL );
    open_eye( s.eyes, 0.2, 2 );
    expect_refused( &s, &settings, "light paths are of one moment" );
    s.eyes->blur_steps = RF_MAX_BLUR_STEPS + 1;
    settings.light_paths = RF_LIGHT_PATHS_OFF;
    expect_refused( &s, &settings, "" );
}

// The wall brightens while the plate slides: it is as bright as in the middle of the shutter, in which moment that lies or not.
TEST( test_light_of_the_middle_of_a_shutter )
{
    GltfBuilder b = make_plate();
    add_gltf_floats( &b, "VEC3", 3, 2, ( const float[] ){ 0, 0, 0, 0.5f, 0, 0 } );
    add_gltf_floats( &b, "VEC3", 3, 2, ( const float[] ){ 0, 0, 0, 1, 1, 1 } );
    RfScene scene = gltf_load_built(
        &b, "\"nodes\":[{\"mesh\":1},{\"mesh\":0}]," MESHES(
                "},\"indices\":1,\"material\":0" ) "\"animations\":[{"
                                                   "\"samplers\":[{\"input\":3,\"output\":4},{\"input\":3,\"output\":5}],"
                                                   "\"channels\":["
                                                   "{\"sampler\":0,\"target\":{\"node\":1,\"path\":\"translation\"}},"
                                                   "{\"sampler\":1,\"target\":{\"path\":\"pointer\",\"extensions\":{\"KHR_"
                                                   "animation_pointer\":{"
                                                   "\"pointer\":\"/materials/1/emissiveFactor\"}}}}]}]" );
    AUTO_BY( close_stage ) Stage s;
    open_plates( &s, scene, 1, 2.0 );
    RfRenderSettings settings = moving_settings( 0, 1 );
    settings.max_depth = 1;
    for ( int steps = 0; steps <= 5; ++steps )
    {
        open_eye( s.eyes, 1.0, steps );
        assert_float_equal( render_one( &s, 0, &settings )->rgb[0], 0.5, 1e-5 );
    }
}

// ---- Plan and pilot -------------------------------------------------------------

// Takes the scene over.
static RfPlan plan_of( RfScene scene )
{
    Stage s;
    RfPlan plan;
    RfError error;
    open_plates( &s, scene, 9, 0.0 );
    for ( int i = 0; i < 9; ++i )
        s.eyes[i].time = 0.4 * i;
    RfRenderSettings settings = moving_settings( RF_GROUP_AUTO, 9 );
    settings.aovs = 0;
    RfShot shot = stage_shot( &s, &( int ){ 0 }, 1 );
    if ( rf_plan_render( &shot, &settings, &plan, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    close_stage( &s );
    return plan;
}

static RfPlan plan_of_sheet( const char* size )
{
    GltfBuilder b = make_plate();
    add_gltf_floats( &b, "VEC3", 3, 2, ( const float[] ){ 0, 0, -2, 1, 0, -2 } );
    char rest[2048];
    snprintf( rest, sizeof rest, "\"nodes\":[{\"mesh\":1},{\"children\":[2]},{\"mesh\":0,\"scale\":[%s,1]}],%s", size,
              MESHES( "},\"indices\":1,\"material\":0" ) MOVED( "1", "translation", "LINEAR" ) );
    return plan_of( gltf_load_built( &b, rest ) );
}

// A sheet of 40 by 40 m at z = −5 that slides before all else, and hardly anything that does.
TEST( test_groups_that_do_not_pay )
{
    RfPlan plan = plan_of_sheet( "40,40" );
    assert_int_equal( plan.rows[plan.chosen].group, 0 );
    for ( int r = 0; r < plan.count; ++r )
        assert_true( fabs( plan.rows[r].reach - 1.0 ) < 1e-6 );
    plan = plan_of_sheet( "0.1,0.1" );
    assert_true( plan.rows[plan.chosen].group > 0 && plan.rows[plan.count - 1].reach > 3.0 );
}

// A curtain between a lamp on the left and the right half of the wall, which the eye sees edge on. Where it has been lifted, the
// light is that of one frame alone.
TEST( test_pilots_see_light_that_no_other_frame_has )
{
    GltfBuilder b = make_plate();
    static const float s_lifts[] = { 0, 0, 0, 0, 60, 0 };
    add_gltf_floats( &b, "VEC3", 3, 2, s_lifts );
    RfScene scene = gltf_load_built(
        &b,
        "\"nodes\":[{\"mesh\":1},{\"children\":[2]},{\"mesh\":0,\"translation\":[-3,0,-6],\"scale\":[3,20,1],\"rotation\":[0,-0."
        "70710678,0,0."
        "70710678]},{\"mesh\":2,\"translation\":[-11,0,-6],\"rotation\":[0,0.70710678,0,0.70710678]}],\"materials\":[{},{"
        "\"emissiveFactor\":"
        "[1,1,1]}],\"meshes\":[" PLATE(
            "},\"indices\":1,\"material\":0" ) ",{\"primitives\":[{\"attributes\":{\"POSITION\":2},"
                                               "\"indices\":1,\"material\":0}]},{\"primitives\":[{\"attributes\":{\"POSITION\":0}"
                                               ",\"indices\":1,\"material\":1}]}]," MOVED( "1", "translation", "LINEAR" ) );
    AUTO_BY( close_stage ) Stage s;
    open_plates( &s, scene, 7, 0.0 );
    for ( int i = 0; i < 7; ++i )
        s.eyes[i].time = 0.6 * i;
    RfRenderSettings settings = moving_settings( 3, 7 );
    settings.adaptive = RF_ADAPTIVE_ON;
    settings.aovs = RF_AOV_BIT( RF_AOV_SAMPLES );
    const float* kept = render_one( &s, 5, &settings )->aovs[RF_AOV_SAMPLES];
    double samples[2] = { 0 };
    for ( int i = 0; i < WIDTH * HEIGHT; ++i )
        samples[i % WIDTH >= WIDTH / 2] += (double)kept[i];
    assert_true( samples[1] > 1.02 * samples[0] );
}

// ---- Memory ---------------------------------------------------------------------

TEST( test_the_budget_counts_what_moves )
{
    AUTO_BY( close_stage ) Stage s;
    open_plates( &s, load_sliding( ( const float[3] ){ 0.8f, 0, 0 } ), 9, 0.0 );
    RfRenderSettings settings = moving_settings( 1, 3 );
    size_t five = rf_worlds_bytes( &s.scene, 5, 0 ), three = rf_worlds_bytes( &s.scene, 3, 0 );
    assert_true( three > 0 && five > three );
    assert_int_equal( rf_worlds_held( &s.scene, 9, 3, true, false ), 5 );
    assert_int_equal( rf_worlds_held( &s.scene, 9, 7, true, true ), 9 );
    settings.adaptive = RF_ADAPTIVE_OFF;
    settings.aovs = RF_AOV_BIT( RF_AOV_DEPTH ) | RF_AOV_BIT( RF_AOV_MOTION );
    RfShot shot = stage_shot( &s, &( int ){ 4 }, 1 );
    RfRenderSettings resolved;
    RfMemoryFit fit;
    RfError error;
    assert_int_equal( rf_resolve_settings( &shot, &settings, &resolved, &error ), RF_OK );
    assert_int_equal( rf_fit_memory( &shot, &resolved, &fit, &error ), RF_OK );
    settings.memory = fit.least;
    render_one( &s, 4, &settings );
    assert_true( s.stats.peak_bytes <= fit.least );
    size_t moving = 0;
    for ( int i = 0; i < s.stats.entry_count; ++i )
        moving += strcmp( s.stats.entries[i].name, "moving" ) == 0 ? s.stats.entries[i].peak : 0;
    assert_true( moving == rf_arena_size( five ) );
    settings.memory = fit.least - 1024;
    assert_int_equal( rf_render( &shot, &settings, NULL, NULL, &error ), RF_ERROR_MEMORY );
    assert_true( error.least_memory == fit.least );
}

// A strip of squares that a morph target moves, and `count` of it.
static RfScene load_strips( int squares, int count )
{
    GltfBuilder b = { 0 };
    float at[3 * 2 * 100], by[3 * 2 * 100];
    uint16_t faces[6 * 100];
    for ( int i = 0; i < 2 * squares; ++i )
    {
        for ( int c = 0; c < 3; ++c )
        {
            at[3 * i + c] = c == 0 ? 0.1f * (float)( i / 2 ) : c == 1 ? (float)( i % 2 ) : -4.0f;
            by[3 * i + c] = 0.1f * (float)( i % 3 );
        }
    }
    for ( int i = 0; i + 1 < squares; ++i )
    {
        for ( int k = 0; k < 6; ++k )
            faces[6 * i + k] = (uint16_t)( 2 * i + ( ( const int[6] ){ 0, 2, 3, 0, 3, 1 } )[k] );
    }
    add_gltf_floats( &b, "VEC3", 3, 2 * squares, at );
    add_gltf_u16( &b, 6 * ( squares - 1 ), faces );
    add_gltf_floats( &b, "VEC3", 3, 2 * squares, by );
    add_gltf_floats( &b, "SCALAR", 1, 2, s_times );
    add_gltf_floats( &b, "SCALAR", 1, 2, ( const float[2] ){ 0, 1 } );
    char rest[8192];
    size_t used = (size_t)snprintf( rest, sizeof rest, "\"nodes\":[" );
    for ( int i = 0; i < count; ++i )
        used += (size_t)snprintf( rest + used, sizeof rest - used, "%s{\"mesh\":0}", i > 0 ? "," : "" );
    used += (size_t)snprintf( rest + used, sizeof rest - used,
                              "],\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"indices\":1,\"targets\":[{"
                              "\"POSITION\":2}]}]}],\"animations\":[{\"samplers\":[{\"input\":3,\"output\":4}],\"channels\":[" );
    for ( int i = 0; i < count; ++i )
        used += (size_t)snprintf( rest + used, sizeof rest - used,
                                  "%s{\"sampler\":0,\"target\":{\"node\":%d,\"path\":\"weights\"}}", i > 0 ? "," : "", i );
    snprintf( rest + used, sizeof rest - used, "]}]" );
    return gltf_load_built( &b, rest );
}

// What Embree says that it holds.
TEST( test_embree_holds_no_more_than_counted )
{
    static const int s_steps[] = { 0, 1, 4, 32 };
    for ( int i = 0; i < 12; ++i )
    {
        int kind = i % 3, steps = s_steps[i / 3];
        RfScene scene = kind == 0   ? load_strips( 100, 1 )
                        : kind == 1 ? load_strips( 2, 60 )
                                    : load_sliding( ( const float[3] ){ 1, 0, 0 } );
        AUTO_BY( close_stage ) Stage s;
        RfError error;
        AUTO_BY( rf_destroy_worlds ) RfWorlds worlds;
        open_plates( &s, scene, 12, 0.0 );
        for ( int k = 0; k < 12; ++k )
            open_eye( s.eyes + k, 0.25, steps );
        const RfTracer* tracer = stage_tracer( &s );
        size_t before = rf_tracer_bytes( tracer );
        assert_int_equal( rf_create_worlds( &( RfShot ){ tracer, s.eyes, 12, NULL, 0 }, 5, false, &worlds, &error ), RF_OK );
        for ( int first = 0; first + 5 <= 12; ++first )
        {
            assert_non_null( rf_open_worlds( &worlds, first, 5 ) );
            size_t poses = 5 * (size_t)( steps + 1 ) * rf_pose_bytes( &s.scene ), held = rf_tracer_bytes( tracer ) - before;
            size_t counted = rf_worlds_bytes( &s.scene, 5, steps ) - poses;
            if ( first == 0 || held > counted )
                printf( "kind %d, %d steps: %zu of %zu bytes\n", kind, steps, held, counted );
            assert_true( held <= counted );
        }
    }
}

// ---- Failures -------------------------------------------------------------------

// Something is further out than floats compute with, for a moment that the reader does not look at.
TEST( test_a_pose_that_fails )
{
    static const float s_keys[] = { 0, 2.05f, 2.2f, 4 }, s_places[] = { 0, 0, 0, 3e15f, 0, 0, 0, 0, 0, 0, 0, 0 };
    GltfBuilder b = make_plate_at( s_keys, 4 );
    add_gltf_floats( &b, "VEC3", 3, 4, s_places );
    RfScene scene = gltf_load_built( &b, "\"nodes\":[{\"mesh\":1},{\"mesh\":0,\"name\":\"plate\"}]," MESHES(
                                             "},\"indices\":1,\"material\":0" ) MOVED( "1", "translation", "STEP" ) );
    AUTO_BY( close_stage ) Stage s;
    open_plates( &s, scene, 5, 0.125 );
    for ( int group = 0; group <= 1; ++group )
    {
        RfRenderSettings settings = moving_settings( group, 3 );
        settings.aovs = 0;
        expect_failure( &s, &settings, RF_ERROR_SCENE, "object 'plate' at 2.125 s" );
        assert_int_equal( s.handed_over, group == 0 ? 2 : 0 ); // those before; none that shares a group with it
    }
}

SHARED_BY_TESTS( gltf_enter, gltf_leave )
