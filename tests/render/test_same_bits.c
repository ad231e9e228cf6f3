// What must be the same to the bit: `--group 0` and a plain path tracer; any number of
// threads; a frame alone and in its sequence; two runs; any budget; with and without
// tiles.
#include "support/rooms.h"
#include "support/reference_tracer.h"
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/test.h"

#include <stdlib.h>
#include <string.h>

#define EYES 9
#ifdef REFRAME_SANITIZED // which take their time
#define WIDTH 25
#define HEIGHT 23
#else
#define WIDTH 39
#define HEIGHT 34
#endif

static RfRenderSettings quick( int group, int spp, const char* tile )
{
    RfRenderSettings settings = plain_settings();
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    settings.group = group;
    settings.spp = spp;
    settings.threads = 1;
    settings.memory = (size_t)256 << 20;
    return settings;
}

// Frames of two renders, of which the second may be of fewer.
static void expect_same_frames( const RfFrameResult* a, const RfFrameResult* b, int count )
{
    for ( int i = 0; i < count; ++i )
    {
        expect_same_bits( a + i, b + i );
        assert_memory_equal( &a[i].relmse_estimate, &b[i].relmse_estimate, sizeof a->relmse_estimate );
    }
}

static void check_plain( RfScene scene, int light_samples, int max_depth )
{
    AUTO_BY( close_stage ) Stage s;
    open_stage( &s, scene, EYES, 4.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = quick( 0, 5, "1" );
    settings.light_samples = light_samples;
    settings.max_depth = max_depth;
    settings.seed = 7;
    double sum = 0.0;
    for ( int frame = 2; frame <= 5; frame += 3 )
    {
        float reference[3 * WIDTH * HEIGHT];
        ReferenceSettings plain = reference_settings_of( &settings, frame );
        reference_image( stage_tracer( &s ), s.eyes + frame, &plain, reference );
        assert_memory_equal( render_one( &s, frame, &settings )->rgb, reference, sizeof reference );
        sum += brightness( reference, 3 * WIDTH * HEIGHT );
    }
    assert_true( sum > 0.0 || max_depth == 1 ); // the light itself is not in view
}

// All eyes within a body that absorbs, with something in it.
static RfScene make_flooded_room( void )
{
    SceneBuilder b = { 0 };
    uint32_t wall = add_material( &b, make_lambert( 0.6f, 0.55f, 0.5f ) ), light = add_material( &b, make_light( 4.0f, false ) );
    uint32_t plastic = add_material( &b, make_plastic( 0.6f, 0.25f ) );
    RfMaterial water = make_glass( 1.33f, 0.0f, false );
    water.absorption = rf_vec3( 0.9f, 0.3f, 0.1f );
    add_box( &b, wall, rf_vec3( -3, -2, -3 ), rf_vec3( 3, 4, 3 ), true );
    add_quad( &b, light, rf_vec3( -2, 3.9f, -2 ), rf_vec3( 2, 3.9f, -2 ), rf_vec3( 2, 3.9f, 2 ), rf_vec3( -2, 3.9f, 2 ) );
    add_box( &b, plastic, rf_vec3( -0.6f, 0.0f, -0.5f ), rf_vec3( 0.7f, 0.5f, 0.5f ), false );
    add_sphere( &b, add_material( &b, water ), rf_vec3( 0, 1, 0 ), 2.5f, 12 );
    return finish_scene( &b );
}

TEST( test_group_0_is_a_plain_path_tracer )
{
    for ( int kind = ROOM_DIFFUSE; kind <= ROOM_GGX; ++kind )
    {
        check_plain( make_room( (RoomKind)kind ), 1, 12 );
        check_plain( make_room( (RoomKind)kind ), 3, 4 );
    }
    check_plain( make_room( ROOM_DIFFUSE ), 1, 1 );
    check_plain( make_room( ROOM_GGX ), 1, 2 );
    for ( int light = LIT_BY_SKY; light <= LIT_BY_ALL; ++light )
        check_plain( make_open_scene( (OpenLight)light ), 2, 5 );
    check_plain( make_open_scene( LIT_BY_MAP ), 1, 1 );
    check_plain( make_glass_room(), 1, 12 );
    check_plain( make_glass_room(), 2, 3 );
    check_plain( make_flooded_room(), 1, 6 );
    for ( int kind = 0; kind < MIRROR_ROOM_COUNT; ++kind )
        check_plain( make_mirror_room( (MirrorRoom)kind ), 1, 2 + kind % 5 );
    for ( int depth = 1; depth <= 5; ++depth ) // mirrors count as vertices
        check_plain( make_mirror_room( FLAT_MIRROR ), 1, depth );
    check_plain( make_textured_room(), 1, 8 );
    check_plain( make_varied_room(), 1, 8 );
    check_plain( make_blended_room(), 1, 8 );
    for ( int light = PANES_AND_AREA_LIGHT; light <= PANES_AND_ALL; ++light )
        check_plain( make_pane_room( (PaneLight)light ), 1 + light % 2, 7 );
}

static const RfFrameResult* begin( Stage* s, const RfRenderSettings* settings )
{
    open_stage( s, make_room( ROOM_GGX ), EYES, 4.0f, WIDTH, HEIGHT );
    return render_stage( s, settings );
}

TEST( test_threads_and_runs )
{
    static const RfWeights weights[] = { RF_WEIGHTS_EXACT, RF_WEIGHTS_EQ15, RF_WEIGHTS_UNWEIGHTED };
    for ( int w = 0; w < 3; ++w )
    {
        for ( int group = 0; group <= 2; group += 2 )
        {
            RfRenderSettings settings = quick( group, 6, w == 0 ? "3x3" : w == 1 ? "1" : "rooks9" );
            settings.weights = weights[w];
            AUTO_BY( close_stage ) Stage s;
            const RfFrameResult* whole = begin( &s, &settings );
            static const int threads[] = { 1, 2, 3, 5, 16 }; // more than there are cores or batches, too
            for ( int k = 0; k < 5; ++k )
            {
                settings.threads = threads[k];
                expect_same_frames( whole, render_stage( &s, &settings ), EYES );
            }
        }
    }
}

TEST( test_alone_and_in_sequence )
{
    static const int groups[] = { 0, 1, 3, 20 };
    for ( int g = 0; g < 4; ++g )
    {
        RfRenderSettings settings = quick( groups[g], 7, g % 2 == 0 ? "rooks36" : "2x3" );
        AUTO_BY( close_stage ) Stage s;
        const RfFrameResult* whole = begin( &s, &settings );
        static const int frames[] = { 0, 4, 7 };
        for ( int k = 0; k < 3; ++k )
            expect_same_frames( whole + frames[k], render_one( &s, frames[k], &settings ), 1 );
    }
}

TEST( test_any_budget_same_bits )
{
    RfRenderSettings settings = quick( 2, 5, "3x3" );
    AUTO_BY( close_stage ) Stage s;
    const RfFrameResult* whole = begin( &s, &settings );
    size_t needed = s.stats.peak_bytes;
    settings.memory = needed - ( needed / 8 ); // fewer batches at once
    const RfFrameResult* small = render_stage( &s, &settings );
    assert_true( s.stats.peak_bytes <= settings.memory );
    assert_true( s.stats.peak_bytes < needed );
    expect_same_frames( whole, small, EYES );

    settings.memory = 100000;
    RfError error;
    RfShot shot = stage_shot( &s, &( int ){ 0 }, 1 );
    assert_int_equal( rf_render( &shot, &settings, NULL, NULL, &error ), RF_ERROR_MEMORY );
    assert_int_equal( error.remedy, RF_REMEDY_MEMORY );
    assert_true( error.least_memory > 100000 );
    settings.memory = error.least_memory; // which is enough
    assert_int_equal( rf_render( &shot, &settings, NULL, NULL, &error ), RF_OK );
}

// Groups with tiles: threads, some frames only, less memory.
TEST( test_mirrors_and_glass_same_bits )
{
    static const MirrorRoom rooms[] = { FLAT_MIRROR, FACING_MIRRORS, MIRROR_BEHIND_PANE, GLASS_BALL };
    for ( size_t k = 0; k < sizeof rooms / sizeof rooms[0]; ++k )
    {
        RfRenderSettings settings = quick( 3, 7, "3x3" );
        settings.max_depth = 6;
        AUTO_BY( close_stage ) Stage s;
        open_stage( &s, make_mirror_room( rooms[k] ), EYES, 4.0f, WIDTH, HEIGHT );
        const RfFrameResult* whole = render_stage( &s, &settings );
        size_t needed = s.stats.peak_bytes;
        static const int frames[] = { 2, 7 };
        RfShot two = stage_shot( &s, frames, 2 );
        const RfFrameResult* some = render_shot( &s, &two, &settings );
        for ( int f = 0; f < 2; ++f )
            expect_same_frames( whole + frames[f], some + f, 1 );
        settings.threads = 4;
        expect_same_frames( whole, render_stage( &s, &settings ), EYES );
        settings.threads = 1;
        settings.memory = needed / 8 * 7;
        expect_same_frames( whole, render_stage( &s, &settings ), EYES );
    }
}

TEST( test_seeds_differ )
{
    RfRenderSettings settings = quick( 1, 3, "1" );
    AUTO_BY( close_stage ) Stage s;
    const RfFrameResult* whole = begin( &s, &settings );
    settings.seed = 2;
    assert_memory_not_equal( whole->rgb, render_one( &s, 0, &settings )->rgb, 3 * WIDTH * HEIGHT * sizeof( float ) );
}
