// What must be the same to the bit: `--group 0` and a plain path tracer; any number of
// threads; a frame alone and in its sequence; two runs; any budget; with and without
// tiles.
#include "support/rooms.h"
#include "support/reference_tracer.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
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

static RfRenderSettings quick( int group, int spp )
{
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    settings.spp = spp;
    settings.threads = 1;
    settings.memory = (size_t)256 << 20;
    return settings;
}

static RfTile tile_of( const char* name )
{
    RfTile tile;
    assert_true( rf_parse_tile( name, &tile ) );
    return tile;
}

static void assert_same_frames( const Rendered* a, int first_a, const Rendered* b, int first_b, int count )
{
    assert_memory_equal( frame_rgb( a, first_a ), frame_rgb( b, first_b ), 3 * a->pixels * (size_t)count * sizeof( float ) );
    assert_memory_equal( frame_weight( a, first_a ), frame_weight( b, first_b ), a->pixels * (size_t)count * sizeof( float ) );
    assert_memory_equal( a->relmse_estimate + first_a, b->relmse_estimate + first_b, (size_t)count * sizeof( double ) );
}

static void check_plain( RfScene scene, int light_samples, int max_depth )
{
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 4.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = quick( 0, 5 );
    settings.light_samples = light_samples;
    settings.max_depth = max_depth;
    settings.seed = 7;
    int frames[] = { 2, 5 };
    Rendered rendered = render_frames( tracer, eyes, EYES, frames, 2, &settings );
    float* reference = malloc( 3 * rendered.pixels * sizeof( float ) );
    double sum = 0.0;
    for ( int k = 0; k < 2; ++k )
    {
        ReferenceSettings plain = reference_settings_of( &settings, frames[k] );
        reference_image( tracer, eyes + frames[k], &plain, reference );
        assert_memory_equal( frame_rgb( &rendered, k ), reference, 3 * rendered.pixels * sizeof( float ) );
        for ( size_t i = 0; i < 3 * rendered.pixels; ++i )
            sum += (double)reference[i];
    }
    assert_true( sum > 0.0 || max_depth == 1 ); // the light itself is not in view
    free( reference );
    free_rendered( &rendered );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
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

// One scene, one setting, and what is changed without effect.
typedef struct Twice
{
    RfScene scene;
    RfTracer* tracer;
    RfEye eyes[EYES];
    Rendered whole;
} Twice;

static void end_twice( Twice* t )
{
    free_rendered( &t->whole );
    rf_destroy_tracer( t->tracer );
    rf_destroy_scene( &t->scene );
}

static void begin_in( Twice* t, RfScene scene, const RfRenderSettings* settings )
{
    *t = ( Twice ){ .scene = scene };
    orbit_eyes( t->eyes, EYES, 4.0f, WIDTH, HEIGHT );
    t->tracer = make_tracer( &t->scene );
    t->whole = render_all( t->tracer, t->eyes, EYES, settings );
    assert_int_equal( t->whole.count, EYES );
}

static void begin( Twice* t, const RfRenderSettings* settings ) { begin_in( t, make_room( ROOM_GGX ), settings ); }

TEST( test_threads_and_runs )
{
    static const RfWeights weights[] = { RF_WEIGHTS_EXACT, RF_WEIGHTS_EQ15, RF_WEIGHTS_UNWEIGHTED };
    for ( int w = 0; w < 3; ++w )
    {
        for ( int group = 0; group <= 2; group += 2 )
        {
            RfRenderSettings settings = quick( group, 6 );
            settings.weights = weights[w];
            settings.tile = tile_of( w == 0 ? "3x3" : w == 1 ? "1" : "rooks9" );
            Twice t;
            begin( &t, &settings );
            static const int threads[] = { 1, 2, 3, 5, 16 }; // more than there are cores or batches, too
            for ( int k = 0; k < 5; ++k )
            {
                settings.threads = threads[k];
                Rendered again = render_all( t.tracer, t.eyes, EYES, &settings );
                assert_same_frames( &t.whole, 0, &again, 0, EYES );
                free_rendered( &again );
            }
            end_twice( &t );
        }
    }
}

TEST( test_alone_and_in_sequence )
{
    static const int groups[] = { 0, 1, 3, 20 };
    for ( int g = 0; g < 4; ++g )
    {
        RfRenderSettings settings = quick( groups[g], 7 );
        settings.tile = tile_of( g % 2 == 0 ? "rooks36" : "2x3" );
        Twice t;
        begin( &t, &settings );
        static const int frames[] = { 0, 4, 7 };
        for ( int k = 0; k < 3; ++k )
        {
            Rendered alone = render_frames( t.tracer, t.eyes, EYES, frames + k, 1, &settings );
            assert_int_equal( alone.count, 1 );
            assert_same_frames( &t.whole, frames[k], &alone, 0, 1 );
            free_rendered( &alone );
        }
        end_twice( &t );
    }
}

TEST( test_any_budget_same_bits )
{
    RfRenderSettings settings = quick( 2, 5 );
    settings.tile = tile_of( "3x3" );
    Twice t;
    begin( &t, &settings );
    size_t needed = t.whole.stats.peak_bytes;
    settings.memory = needed - ( needed / 8 ); // fewer batches at once
    Rendered small = render_all( t.tracer, t.eyes, EYES, &settings );
    assert_true( small.stats.peak_bytes <= settings.memory );
    assert_true( small.stats.peak_bytes < needed );
    assert_same_frames( &t.whole, 0, &small, 0, EYES );
    free_rendered( &small );

    settings.memory = 100000;
    RfError error;
    int frame = 0;
    assert_int_equal( rf_render( &( RfShot ){ t.tracer, t.eyes, EYES, &frame, 1 }, &settings, NULL, NULL, &error ),
                      RF_ERROR_MEMORY );
    assert_int_equal( error.remedy, RF_REMEDY_MEMORY );
    assert_true( error.least_memory > 100000 );
    settings.memory = error.least_memory; // which is enough
    assert_int_equal( rf_render( &( RfShot ){ t.tracer, t.eyes, EYES, &frame, 1 }, &settings, NULL, NULL, &error ), RF_OK );
    end_twice( &t );
}

static void check_all_again( const Twice* t, RfRenderSettings settings )
{
    Rendered again = render_all( t->tracer, t->eyes, EYES, &settings );
    assert_same_frames( &t->whole, 0, &again, 0, EYES );
    free_rendered( &again );
}

// Groups with tiles: threads, some frames only, less memory.
TEST( test_mirrors_and_glass_same_bits )
{
    static const MirrorRoom rooms[] = { FLAT_MIRROR, FACING_MIRRORS, MIRROR_BEHIND_PANE, GLASS_BALL };
    for ( size_t k = 0; k < sizeof rooms / sizeof rooms[0]; ++k )
    {
        RfRenderSettings settings = quick( 3, 7 );
        settings.tile = tile_of( "3x3" );
        settings.max_depth = 6;
        Twice t;
        begin_in( &t, make_mirror_room( rooms[k] ), &settings );
        static const int frames[] = { 2, 7 };
        Rendered some = render_frames( t.tracer, t.eyes, EYES, frames, 2, &settings );
        for ( int f = 0; f < 2; ++f )
            assert_same_frames( &t.whole, frames[f], &some, f, 1 );
        free_rendered( &some );
        settings.threads = 4;
        check_all_again( &t, settings );
        settings.threads = 1;
        settings.memory = t.whole.stats.peak_bytes / 8 * 7;
        check_all_again( &t, settings );
        end_twice( &t );
    }
}

TEST( test_seeds_differ )
{
    RfRenderSettings settings = quick( 1, 3 );
    Twice t;
    begin( &t, &settings );
    settings.seed = 2;
    Rendered other = render_all( t.tracer, t.eyes, EYES, &settings );
    assert_memory_not_equal( frame_rgb( &t.whole, 0 ), frame_rgb( &other, 0 ), 3 * other.pixels * sizeof( float ) );
    free_rendered( &other );
    end_twice( &t );
}
