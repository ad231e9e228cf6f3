// Light that holds in its own frame alone (src/reuse/estimators.md, section 18): with any ghosts, however large, pictures of a
// room in which all stands still have the same mean. Boxes that paths from walls, cameras and lamps cross, one around everything,
// and a ball that counts as moving; with groups and tiles, on diffuse and glossy surfaces, with a mirror, panes, glass, a lamp in
// glass and a sky. Ghosts that no path meets change no bit.
#include "render/traits.h"
#include "support/rooms.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/unbiased.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include <cmocka.h>

#define WIDTH 32
#define HEIGHT 24
#define BLOCK 4
#define EYES 7
#define REFERENCE_SPP 48

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

typedef struct Setting
{
    const char* tile;
    int group, spp;
} Setting;

static const Setting s_frames = { "1", 3, 7 }, s_tiles = { "3x3", 3, 7 }, s_rooks = { "rooks4", 1, 6 };

typedef enum Ghosts
{
    SOME,       // between walls, eyes, the lamp and the back wall
    EVERYWHERE, // around all
    BALL,       // the ball, which moves
    FAR_AWAY,   // that nothing meets
} Ghosts;

static const char* const s_names[] = { "some", "everywhere", "ball" };

static const RfVec3 s_some[][2] = {
    { { -0.4f, 2.5f, -0.6f }, { 0.3f, 2.6f, 0.4f } },
    { { 0.9f, 0.4f, -0.9f }, { 1.3f, 1.6f, 0.6f } },
    { { -1.9f, 0.2f, 0.2f }, { -1.2f, 0.9f, 0.9f } },
    { { -1.5f, 0.6f, -2.1f }, { -0.2f, 1.4f, -1.7f } },
};
static const RfVec3 s_everywhere[][2] = { { { -1e3f, -1e3f, -1e3f }, { 1e3f, 1e3f, 1e3f } } };
static const RfVec3 s_far_away[][2] = { { { 900.0f, -1e3f, 900.0f }, { 1e3f, 0.0f, 1e3f } } };

// The longest run of triangles of one material: the ball, and the box around it.
static void find_ball( const RfScene* scene, RfFeignedGhosts* ghosts, RfVec3 box[2] )
{
    const RfTriangles* t = &scene->triangles;
    uint32_t first = 0;
    for ( uint32_t i = 0; i < t->count; ++i )
    {
        first = t->material[i] != t->material[first] ? i : first;
        if ( i + 1 - first <= ghosts->end - ghosts->first )
            continue;
        ghosts->first = first;
        ghosts->end = i + 1;
    }
    box[0] = rf_vec3( INFINITY, INFINITY, INFINITY );
    box[1] = rf_scale( box[0], -1.0f );
    for ( uint32_t k = 3 * ghosts->first; k < 3 * ghosts->end; ++k )
    {
        const float* p = t->positions + 3 * (size_t)t->indices[k];
        box[0] = rf_vec3( fminf( box[0].x, p[0] ), fminf( box[0].y, p[1] ), fminf( box[0].z, p[2] ) );
        box[1] = rf_vec3( fmaxf( box[1].x, p[0] ), fmaxf( box[1].y, p[1] ), fmaxf( box[1].z, p[2] ) );
    }
}

// `box`: has room for one.
static RfFeignedGhosts make_ghosts( const RfScene* scene, Ghosts kind, RfVec3 box[2] )
{
    RfFeignedGhosts ghosts = { .count = 1, .box = (const RfVec3( * )[2])box };
    ghosts.box = kind == SOME ? s_some : kind == EVERYWHERE ? s_everywhere : kind == FAR_AWAY ? s_far_away : ghosts.box;
    ghosts.count = kind == SOME ? (int)( sizeof s_some / sizeof *s_some ) : 1;
    if ( kind == BALL )
        find_ball( scene, &ghosts, box );
    return ghosts;
}

static RfRenderSettings settings_of( Setting setting, int max_depth )
{
    RfRenderSettings settings = plain_settings();
    settings.max_depth = max_depth;
    settings.memory = (size_t)512 << 20;
    settings.group = setting.group;
    settings.spp = setting.spp * ( is_long() ? 4 : 1 );
    assert_true( rf_parse_tile( setting.tile, &settings.tile ) );
    return settings;
}

// A room, and all that is tried in it.
typedef struct Case
{
    const char* what;
    int max_depth;
    unsigned ghosts; // a bit for each kind
    int count;
    Setting settings[3];
} Case;

static void check( const Case* tested, RfScene scene )
{
    RfEye eyes[EYES];
    RfRenderSettings plain = settings_of( s_frames, tested->max_depth );
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    RfTracer* tracer = make_tracer( &scene );
    Images reference = reference_images( tracer, eyes, EYES / 2, REFERENCE_SPP * ( is_long() ? 4 : 1 ), &plain );
    for ( int kind = SOME; kind <= BALL; ++kind )
    {
        RfVec3 box[2];
        RfFeignedGhosts ghosts = make_ghosts( &scene, (Ghosts)kind, box );
        for ( int k = 0; k < tested->count && ( tested->ghosts >> kind & 1u ) != 0; ++k )
        {
            char name[96];
            const Setting* setting = tested->settings + k;
            snprintf( name, sizeof name, "%s, %s, group %d, tile %s:", tested->what, s_names[kind], setting->group,
                      setting->tile );
            scene.feigned = &ghosts;
            Images rendered = rendered_images( tracer, eyes, EYES, EYES / 2, settings_of( *setting, tested->max_depth ) );
            scene.feigned = NULL;
            assert_unbiased( name, &rendered, &reference, BLOCK );
            free_images( &rendered );
        }
    }
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

#define ALL ( 1u << SOME | 1u << EVERYWHERE | 1u << BALL )

static void test_rooms_are_unbiased( void** state )
{
    (void)state;
    check( &( Case ){ "diffuse", 6, 1u << SOME, 2, { s_frames, s_rooks } }, make_room( ROOM_DIFFUSE ) );
    check( &( Case ){ "GGX", 6, ALL, 2, { s_frames, s_tiles } }, make_room( ROOM_GGX ) );
    check( &( Case ){ "blended", 6, 1u << SOME, 1, { s_tiles } }, make_blended_room() );
}

static void test_skies_and_lamps_are_unbiased( void** state )
{
    (void)state;
    check( &( Case ){ "map", 5, 1u << SOME, 2, { s_frames, s_tiles } }, make_open_scene( LIT_BY_MAP ) );
    check( &( Case ){ "all lights", 5, 1u << BALL, 1, { s_tiles } }, make_open_scene( LIT_BY_ALL ) );
}

static void test_mirrors_and_glass_are_unbiased( void** state )
{
    (void)state;
    check( &( Case ){ "mirror", 5, 1u << SOME | 1u << BALL, 1, { s_tiles } }, make_mirror_room( FLAT_MIRROR ) );
    check( &( Case ){ "glass ball", 6, 1u << SOME, 2, { s_frames, s_tiles } }, make_mirror_room( GLASS_BALL ) );
    check( &( Case ){ "lamp in glass", 6, 1u << SOME, 1, { s_tiles } }, make_mirror_room( LAMP_IN_GLASS ) );
    check( &( Case ){ "smooth plastic", 5, 1u << SOME | 1u << BALL, 1, { s_tiles } }, make_mirror_room( SMOOTH_PLASTIC ) );
}

static void test_panes_are_unbiased( void** state )
{
    (void)state;
    check( &( Case ){ "panes", 6, 1u << SOME | 1u << BALL, 1, { s_tiles } }, make_pane_room( PANES_AND_AREA_LIGHT ) );
}

// A glint is spread by the pixel filter as its hit is, and extra samples have light of their own.
static void test_filters_and_extra_samples_are_unbiased( void** state )
{
    (void)state;
    RfScene scene = make_room( ROOM_DIFFUSE );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings settings = settings_of( ( Setting ){ "1", 0, 48 }, 5 );
    settings.filter = RF_FILTER_GAUSSIAN;
    Images reference = rendered_images( tracer, eyes, EYES, EYES / 2, settings );
    for ( int adaptive = 0; adaptive < 2; ++adaptive )
    {
        RfFeignedGhosts ghosts = make_ghosts( &scene, adaptive ? SOME : EVERYWHERE, NULL );
        settings = settings_of( s_tiles, 5 );
        settings.filter = RF_FILTER_GAUSSIAN;
        settings.adaptive = adaptive ? RF_ADAPTIVE_ON : RF_ADAPTIVE_OFF;
        scene.feigned = &ghosts;
        Images rendered = rendered_images( tracer, eyes, EYES, EYES / 2, settings );
        scene.feigned = NULL;
        assert_unbiased( adaptive ? "filtered, adaptive:" : "filtered:", &rendered, &reference, BLOCK );
        free_images( &rendered );
    }
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

static void test_settings_that_cannot_tell_are_refused( void** state )
{
    (void)state;
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

// B counts first hits, whatever becomes of their light.
static void test_mean_weight_is_1( void** state )
{
    (void)state;
    RfScene scene = make_room( ROOM_GGX );
    RfEye eyes[EYES];
    RfVec3 box[2];
    RfFeignedGhosts ghosts = make_ghosts( &scene, BALL, box );
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    RfTracer* tracer = make_tracer( &scene );
    scene.feigned = &ghosts;
    double mean[SEEDS] = { 0 };
    int frame = EYES / 2;
    for ( int k = 0; k < SEEDS; ++k )
    {
        RfRenderSettings settings = settings_of( s_tiles, 3 );
        settings.seed = (uint64_t)( k + 1 );
        Rendered rendered = render_frames( tracer, eyes, EYES, &frame, 1, &settings );
        for ( size_t i = 0; i < rendered.pixels; ++i )
            mean[k] += (double)rendered.weight[i] / (double)rendered.pixels;
        free_rendered( &rendered );
    }
    Sample all = sample_of( mean, SEEDS );
    printf( "mean weight %.6f, its variance %.3g\n", all.mean, all.variance );
    assert_true( fabs( all.mean - 1.0 ) < 5.0 * sqrt( all.variance ) );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

static void test_ghosts_out_of_the_way_change_no_bit( void** state )
{
    (void)state;
    RfScene scene = make_room( ROOM_GGX );
    RfEye eyes[EYES];
    RfFeignedGhosts ghosts = make_ghosts( &scene, FAR_AWAY, NULL );
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    RfTracer* tracer = make_tracer( &scene );
    const Setting tried[] = { s_frames, s_tiles };
    for ( int k = 0; k < 2; ++k )
    {
        RfRenderSettings settings = settings_of( tried[k], 6 );
        int frame = EYES / 2;
        scene.feigned = NULL;
        Rendered still = render_frames( tracer, eyes, EYES, &frame, 1, &settings );
        scene.feigned = &ghosts;
        Rendered haunted = render_frames( tracer, eyes, EYES, &frame, 1, &settings );
        assert_memory_equal( still.rgb, haunted.rgb, 3 * still.pixels * sizeof( float ) );
        free_rendered( &still );
        free_rendered( &haunted );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_settings_that_cannot_tell_are_refused ),
        cmocka_unit_test( test_filters_and_extra_samples_are_unbiased ),
        cmocka_unit_test( test_ghosts_out_of_the_way_change_no_bit ),
        cmocka_unit_test( test_mean_weight_is_1 ),
        cmocka_unit_test( test_rooms_are_unbiased ),
        cmocka_unit_test( test_skies_and_lamps_are_unbiased ),
        cmocka_unit_test( test_mirrors_and_glass_are_unbiased ),
        cmocka_unit_test( test_panes_are_unbiased ),
    };
    return run_statistical_tests( tests, sizeof tests / sizeof *tests );
}
