// Pixels that stand out from the noise are told apart: glints of a lamp on beads smaller than a pixel, and light of a small
// lamp that a metal plate throws on the walls, which paths find by chance.
#include "cli/render/render_json.h"
#include "support/render_support.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 64
#define HEIGHT 36
#define FRAMES 3

enum
{
    WALL,
    LAMP,
    SHINY,
    MATERIALS
};

typedef struct Kept
{
    int count;
    RfSpecks specks[FRAMES];
    float rgb[FRAMES][3 * WIDTH * HEIGHT];
} Kept;

static RfResult keep( void* user, const RfFrameResult* frame, RfError* error )
{
    (void)error;
    Kept* kept = user;
    kept->specks[kept->count] = frame->specks;
    memcpy( kept->rgb[kept->count++], frame->rgb, sizeof kept->rgb[0] );
    return RF_OK;
}

static void render( const RfScene* scene, const RfRenderSettings* settings, int first, int count, Kept* kept )
{
    RfTracer* tracer = make_tracer( scene );
    RfEye eyes[FRAMES];
    int frames[FRAMES] = { first, first + 1, first + 2 };
    RfError error;
    for ( int k = 0; k < FRAMES; ++k )
        eyes[k] = rf_make_eye( rf_vec3( 0.02f * (float)k, 1.0f, 1.9f ), rf_vec3( 0, -0.1f, -1 ), rf_vec3( 0, 1, 0 ), 1.0, WIDTH,
                               HEIGHT );
    RfRenderCallbacks callbacks = { .user = kept, .frame = keep };
    *kept = ( Kept ){ 0 };
    if ( rf_render( &( RfShot ){ tracer, eyes, FRAMES, frames, count }, settings, &callbacks, NULL, &error ) != RF_OK )
        fail_msg( "%s", error.text );
    rf_destroy_tracer( tracer );
}

// A closed room with a large lamp under the ceiling.
static SceneBuilder begin_room( RfMaterial shiny )
{
    SceneBuilder b = { 0 };
    add_material( &b, make_lambert( 0.6f, 0.6f, 0.6f ) );
    add_material( &b, make_light( 1.0f, true ) );
    add_material( &b, shiny );
    add_box( &b, WALL, rf_vec3( -2, 0, -2 ), rf_vec3( 2, 3, 2 ), true );
    add_quad( &b, LAMP, rf_vec3( -1.8f, 2.99f, -1.8f ), rf_vec3( 1.8f, 2.99f, -1.8f ), rf_vec3( 1.8f, 2.99f, 1.8f ),
              rf_vec3( -1.8f, 2.99f, 1.8f ) );
    return b;
}

// Beads of a pixel's size that mirror a point of light behind the camera.
static RfScene make_beads( void )
{
    SceneBuilder b = begin_room( make_metal( 0.9f, 0.2f ) );
    for ( int k = 0; k < 48; ++k )
        add_sphere( &b, SHINY, rf_vec3( -1.15f + 0.2f * (float)( k % 12 ), 0.9f + 0.2f * (float)( k / 12 ), -1.0f ), 0.05f, 12 );
    RfScene scene = finish_scene( &b );
    scene.punctuals = malloc( sizeof *scene.punctuals );
    assert_non_null( scene.punctuals );
    scene.punctuals[0] = make_point_light( rf_vec3( 0.3f, 2.5f, 1.5f ), 20.0f );
    scene.punctual_count = 1;
    return scene;
}

// A plate below the camera that throws the light of a lamp on the walls.
static RfScene make_plate( RfMaterial material )
{
    SceneBuilder b = begin_room( material );
    uint32_t bright = add_material( &b, make_light( 4000.0f, false ) );
    add_quad( &b, SHINY, rf_vec3( -0.5f, 0.01f, 1.0f ), rf_vec3( 0.5f, 0.01f, 1.0f ), rf_vec3( 0.5f, 0.01f, 0.0f ),
              rf_vec3( -0.5f, 0.01f, 0.0f ) );
    // shines down on the plate alone
    add_quad( &b, bright, rf_vec3( -0.03f, 0.5f, 0.47f ), rf_vec3( 0.03f, 0.5f, 0.47f ), rf_vec3( 0.03f, 0.5f, 0.53f ),
              rf_vec3( -0.03f, 0.5f, 0.53f ) );
    return finish_scene( &b );
}

// A closed box that shines.
static RfScene make_even( void )
{
    SceneBuilder b = { 0 };
    add_box( &b, add_material( &b, make_light( 1.0f, true ) ), rf_vec3( -3, -3, -3 ), rf_vec3( 3, 3, 3 ), true );
    return finish_scene( &b );
}

static double share_of( const RfSpecks* s, RfSpeckKind kind, int material )
{
    double share = 0.0;
    for ( int p = 0; p < s->part_count; ++p )
    {
        bool counts = s->parts[p].kind == kind && ( material < 0 || s->parts[p].material == material );
        share += counts ? s->parts[p].share : 0.0;
    }
    return share;
}

// `depth`: of the paths.
static void check_kind( const char* what, const RfScene* scene, int depth, RfSpeckKind kind, int material )
{
    static const struct
    {
        int group, spp;
        const char* tile;
    } cases[] = { { 0, 14, "1" }, { 0, 14, "3x3" }, { 1, 14, "3x3" }, { 0, 64, "1" } };
    for ( size_t k = 0; k < sizeof cases / sizeof cases[0]; ++k )
    {
        RfRenderSettings settings = plain_settings();
        settings.group = cases[k].group;
        settings.spp = cases[k].spp;
        settings.max_depth = depth;
        assert_true( rf_parse_tile( cases[k].tile, &settings.tile ) );
        double of_kind = 0.0, all = 0.0;
        int pixels = 0;
        for ( uint64_t seed = 1; seed <= 3; ++seed )
        {
            static Kept kept;
            settings.seed = seed;
            render( scene, &settings, 1, 1, &kept );
            of_kind += share_of( kept.specks, kind, material );
            all += kept.specks[0].share;
            pixels += kept.specks[0].pixels;
        }
        printf( "%-12s group %d tile %-3s spp %2d: %3d specks hold %.3f, %.3f of them as they should\n", what, cases[k].group,
                cases[k].tile, cases[k].spp, pixels, all / 3.0, of_kind / all );
        assert_true( pixels > 0 && of_kind >= 0.8 * all );
    }
}

// Without indirect light all that stands out is a glint.
TEST( test_glints )
{
    RfScene scene = make_beads();
    check_kind( "beads", &scene, 2, RF_SPECK_GLINT, SHINY );
    rf_destroy_scene( &scene );
}

TEST( test_chance )
{
    RfScene mirror = make_plate( make_mirror( 0.9f ) ), metal = make_plate( make_metal( 0.9f, 0.1f ) );
    check_kind( "mirror plate", &mirror, 8, RF_SPECK_CHANCE, -1 );
    check_kind( "metal plate", &metal, 8, RF_SPECK_CHANCE, -1 );
    rf_destroy_scene( &mirror );
    rf_destroy_scene( &metal );
}

// Looking at specks changes no picture, whatever follows, and any number of threads finds the same.
TEST( test_nothing_else_changes )
{
    static Kept all, alone, threaded;
    RfScene scenes[] = { make_beads(), make_plate( make_metal( 0.9f, 0.1f ) ) };
    for ( size_t k = 0; k < sizeof scenes / sizeof scenes[0]; ++k )
    {
        RfRenderSettings settings = rf_default_render_settings();
        settings.group = 1;
        settings.spp = 14;
        settings.threads = 1;
        render( scenes + k, &settings, 0, FRAMES, &all );
        render( scenes + k, &settings, FRAMES - 1, 1, &alone );
        assert_memory_equal( all.rgb[FRAMES - 1], alone.rgb[0], sizeof alone.rgb[0] );
        settings.threads = 3;
        render( scenes + k, &settings, 0, FRAMES, &threaded );
        assert_memory_equal( &all, &threaded, sizeof all );
        assert_true( all.specks[0].part_count > 0 && all.specks[1].part_count > 0 );
        rf_destroy_scene( scenes + k );
    }
}

// Sums agree, and where nothing stands out or nothing is known there are none.
TEST( test_what_cannot_be_told )
{
    static Kept kept;
    RfRenderSettings settings = plain_settings();
    RfScene dark = make_furnace( 0.5f, 0.0f ), even = make_even(), sky = make_open_scene( LIT_BY_SKY );
    const RfScene* const scenes[] = { &dark, &even, &sky };
    settings.group = 0;
    for ( int k = 0; k < 3; ++k )
    {
        settings.spp = 4;
        for ( settings.seed = 1; settings.seed < 6; ++settings.seed )
        {
            render( scenes[k], &settings, 0, 1, &kept );
            assert_true( kept.specks[0].share < RF_SPECKS_STAND_OUT && isfinite( kept.specks[0].rest ) );
            assert_true( k == 2 ||
                         ( kept.specks[0].pixels == 0 && kept.specks[0].part_count == 0 ) ); // no error, but for the sky
        }
        settings.spp = 1;
        render( scenes[k], &settings, 0, 1, &kept );
        assert_true( kept.specks[0].pixels == 0 && isnan( kept.specks[0].rest ) );
    }
    rf_destroy_scene( &dark );
    rf_destroy_scene( &even );
    rf_destroy_scene( &sky );
}
