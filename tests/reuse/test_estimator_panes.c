// Thin panes let straight rays through: lamps and suns light what is behind them, by closed forms; a furnace with
// panes in it holds the radiance of one without; frames and tiles with connections through panes (several in a row,
// coloured, with a base, textured, bumpy, blended) are unbiased, against a path tracer that scatters at panes as at
// other glass and against one that passes them.
#include "support/embree_kind.h"
#include "support/rooms.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define WIDTH 36
#define HEIGHT 30
#define BLOCK 6
#define EYES 7

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

typedef struct Setting
{
    int group;
    const char* tile;
    int spp;
} Setting;

static RfRenderSettings settings_of( Setting setting, int max_depth, int light_samples )
{
    RfRenderSettings settings = plain_settings();
    settings.group = setting.group;
    settings.spp = setting.spp * ( is_long() ? 4 : 1 );
    settings.max_depth = max_depth;
    settings.light_samples = light_samples;
    settings.memory = (size_t)512 << 20;
    assert_true( rf_parse_tile( setting.tile, &settings.tile ) );
    return settings;
}

enum
{
    PLAIN = 0,
    BOTH = 3,
};

static const Setting s_settings[] = {
    [PLAIN] = { 0, "1", 32 }, { 0, "3x3", 16 }, { 3, "1", 7 }, [BOTH] = { 3, "3x3", 7 }, { 1, "rooks4", 9 },
};
#define SETTINGS (int)( sizeof s_settings / sizeof *s_settings )

// ── closed forms ──

#define FLOOR_ALBEDO 0.5
static const RfVec3 s_tint = { 0.9f, 0.6f, 0.3f };

// A floor under two panes, one of them coloured, and a lamp or a sun above them.
static RfScene make_floor( bool sun )
{
    SceneBuilder b = { 0 };
    uint32_t ground = add_material( &b, make_lambert( (float)FLOOR_ALBEDO, (float)FLOOR_ALBEDO, (float)FLOOR_ALBEDO ) );
    uint32_t pane[2] = { add_material( &b, make_thin_pane( s_tint, 0.0f ) ),
                         add_material( &b, make_thin_pane( rf_vec3( 1, 1, 1 ), 0.0f ) ) };
    float far = 9.0f;
    add_quad( &b, ground, rf_vec3( -far, 0, far ), rf_vec3( far, 0, far ), rf_vec3( far, 0, -far ), rf_vec3( -far, 0, -far ) );
    for ( int k = 0; k < 2; ++k )
    {
        float y = 2.0f + 0.1f * (float)k;
        add_quad( &b, pane[k], rf_vec3( -far, y, far ), rf_vec3( far, y, far ), rf_vec3( far, y, -far ),
                  rf_vec3( -far, y, -far ) );
    }
    RfScene scene = finish_scene( &b );
    scene.punctual_count = 1;
    scene.punctuals = calloc( 1, sizeof *scene.punctuals );
    scene.punctuals[0] = make_point_light( rf_vec3( 0.4f, 3.0f, -0.2f ), 10.0f );
    if ( sun )
    {
        scene.punctuals[0].kind = RF_PUNCTUAL_DIRECTIONAL;
        scene.punctuals[0].direction = rf_normalize( rf_vec3( 0.5f, -1.0f, 0.3f ) );
    }
    return scene;
}

// Radiance of the floor at a point, direct light alone, channel c.
static double floor_radiance( const RfPunctual* lamp, RfVec3 p, int c )
{
    double intensity[3] = { (double)lamp->intensity.x, (double)lamp->intensity.y, (double)lamp->intensity.z };
    double tint[3] = { (double)s_tint.x, (double)s_tint.y, (double)s_tint.z };
    RfVec3 way = rf_sub( lamp->position, p );
    double d2 = (double)rf_dot( way, way ), cos_x = (double)way.y / sqrt( d2 );
    if ( lamp->kind == RF_PUNCTUAL_DIRECTIONAL )
    {
        d2 = 1.0;
        cos_x = -(double)lamp->direction.y;
    }
    double sent = 1.0 - fresnel( cos_x, 1.5 );
    return FLOOR_ALBEDO / 3.14159265358979 * intensity[c] * cos_x / d2 * sent * sent * tint[c];
}

// The eyes look down from under the panes: all is known, to the size of a pixel.
TEST( test_lamp_and_sun_shine_through )
{
    for ( int sun = 0; sun < 2; ++sun )
    {
        RfScene scene = make_floor( sun == 1 );
        RfTracer* tracer = make_tracer( &scene );
        RfEye eyes[3];
        for ( int i = 0; i < 3; ++i )
            eyes[i] = rf_make_eye( rf_vec3( 0.02f * (float)i, 1.5f, 0 ), rf_vec3( 0, -1, 0 ), rf_vec3( 0, 0, -1 ), 0.3, 8, 8 );
        static const Setting tried[] = { { 0, "1", 16 }, { 1, "1", 16 }, { 1, "2x2", 16 } };
        for ( int k = 0; k < 3; ++k )
        {
            RfRenderSettings settings = settings_of( tried[k], 2, 1 );
            Rendered r = render_all( tracer, eyes, 3, &settings );
            for ( size_t i = 0; i < r.pixels; ++i )
            {
                // the pixel's middle on the floor
                float scale = 2.0f * 1.5f * tanf( 0.15f ) / 8.0f;
                RfVec3 p = rf_vec3( 0.02f + ( (float)( i % 8 ) - 3.5f ) * scale, 0, ( (float)( i / 8 ) - 3.5f ) * scale );
                for ( int c = 0; c < 3; ++c )
                {
                    double want = floor_radiance( scene.punctuals, p, c );
                    assert_true( fabs( (double)frame_rgb( &r, 1 )[3 * i + (size_t)c] / want - 1.0 ) <
                                 ( sun == 1 ? 1e-4 : 0.02 ) );
                }
            }
            free_rendered( &r );
        }
        rf_destroy_tracer( tracer );
        rf_destroy_scene( &scene );
    }
}

// A box that emits and reflects half, cut by panes that lose nothing: the same radiance everywhere.
TEST( test_furnace_with_panes )
{
    enum
    {
        SEEDS_HERE = 24
    };
    SceneBuilder b = { 0 };
    RfMaterial wall = make_lambert( 0.5f, 0.5f, 0.5f );
    wall.emission = rf_vec3( 1, 1, 1 );
    add_box( &b, add_material( &b, wall ), rf_vec3( -1, -1, -1 ), rf_vec3( 1, 1, 1 ), true );
    uint32_t pane = add_material( &b, make_thin_pane( rf_vec3( 1, 1, 1 ), 0.0f ) );
    for ( int k = 0; k < 3; ++k )
    {
        float x = -0.6f + 0.5f * (float)k;
        add_quad( &b, pane, rf_vec3( x, -1, -1 ), rf_vec3( x + 0.2f, -1, 1 ), rf_vec3( x + 0.2f, 1, 1 ), rf_vec3( x, 1, -1 ) );
    }
    add_box( &b, pane, rf_vec3( 0.0f, -0.7f, -0.6f ), rf_vec3( 0.3f, 0.2f, -0.2f ), false );
    RfScene scene = finish_scene( &b );
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    for ( int i = 0; i < EYES; ++i )
        eyes[i] = rf_make_eye( rf_vec3( 0.15f + 0.01f * (float)i, 0, 0.9f ), rf_vec3( 0.02f * (float)i, -0.1f, -1 ),
                               rf_vec3( 0, 1, 0 ), 1.4, 24, 18 );
    for ( int k = 0; k < SETTINGS; ++k )
    {
        double mean[SEEDS_HERE];
        for ( int seed = 0; seed < SEEDS_HERE; ++seed )
        {
            RfRenderSettings settings = settings_of( s_settings[k], 100, 1 );
            settings.seed = (uint64_t)( seed + 1 );
            int frame = EYES / 2;
            Rendered r = render_frames( tracer, eyes, EYES, &frame, 1, &settings );
            double sum = 0.0;
            for ( size_t i = 0; i < 3 * r.pixels; ++i )
                sum += (double)r.rgb[i];
            mean[seed] = sum / ( 3.0 * (double)r.pixels );
            free_rendered( &r );
        }
        double error, middle = mean_of( mean, SEEDS_HERE, &error );
        printf( "furnace group %d tile %s: %.5f +- %.5f\n", s_settings[k].group, s_settings[k].tile, middle, error );
        assert_true( error < 0.01 );
        assert_false( is_far_off( ( middle - 2.0 ) / error, SEEDS_HERE - 1 ) );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

// ── against path tracers ──

// `vertices`: the reference takes panes for vertices.
static void check_room( const char* what, PaneLight light, int light_samples, int max_depth, bool vertices )
{
    RfScene scene = make_pane_room( light );
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = settings_of( s_settings[0], max_depth, light_samples );
    int spp = is_long() ? 384 : 48;
    Images reference = vertices ? pane_vertex_images( tracer, eyes, EYES / 2, spp, &settings )
                                : reference_images( tracer, eyes, EYES / 2, spp, &settings );
    for ( int k = 0; k < SETTINGS; ++k )
    {
        // path tracing that passes panes is the reference's, bit for bit (tests/render/test_same_bits.c)
        if ( k == PLAIN ? !vertices : k != BOTH && !is_long() )
            continue;
        Images rendered = rendered_images( tracer, eyes, EYES, EYES / 2, settings_of( s_settings[k], max_depth, light_samples ) );
        char name[64];
        snprintf( name, sizeof name, "%s group %d tile %s:", what, s_settings[k].group, s_settings[k].tile );
        assert_unbiased( name, &rendered, &reference, BLOCK );
        free_images( &rendered );
    }
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

// Deep, so that it does not matter whether panes count as vertices.
TEST( test_panes_passed_or_scattered_at_are_the_same )
{
    check_room( "area light, panes as vertices", PANES_AND_AREA_LIGHT, 1, 40, true );
    check_room( "sky, panes as vertices", PANES_AND_SKY, 2, 40, true );
}

TEST( test_lamps_through_panes_are_unbiased )
{
    check_room( "lamp", PANES_AND_LAMP, 1, 6, false );
    check_room( "sun", PANES_AND_SUN, 1, 6, false );
    check_room( "all lights", PANES_AND_ALL, 2, 4, false );
}

// Blocks over many seeds: a bias of one or two per cent in a few of them is within the noise of sixteen. Path tracing by the
// renderer is the reference; it is that of the tests, bit for bit (tests/render/test_same_bits.c).
TEST( test_blocks_over_many_seeds )
{
    enum
    {
        ACROSS = WIDTH / BLOCK,
        BLOCKS = ACROSS * ( HEIGHT / BLOCK ),
        MOST = 200
    };
    static const struct
    {
        Setting setting;
        const char* instruction_set;
    } s_ways[] = { { { 0, "1", 64 }, NULL }, { { 3, "3x3", 7 }, "avx2" }, { { 3, "1", 7 }, NULL }, { { 0, "3x3", 16 }, "avx2" } };
    static double mean[sizeof s_ways / sizeof *s_ways][BLOCKS][MOST];
    memset( mean, 0, sizeof mean ); // of the first round
    int seeds = is_long() ? MOST : 32, ways = is_long() ? sizeof s_ways / sizeof *s_ways : 2;
    RfScene scene = make_pane_room( PANES_AND_LAMP );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    for ( int way = 0; way < ways; ++way )
    {
        use_embree_for( s_ways[way].instruction_set );
        RfTracer* tracer = make_tracer( &scene );
        RfRenderSettings settings = settings_of( s_ways[way].setting, 6, 1 );
        double smallest = 1.0;
        for ( int k = 0; k < seeds; ++k )
        {
            settings.seed = (uint64_t)( 2000 * ( way + 1 ) + k );
            Rendered r = render_frames( tracer, eyes, EYES, &( int ){ EYES / 2 }, 1, &settings );
            for ( int i = 0; i < WIDTH * HEIGHT; ++i )
                mean[way][i / WIDTH / BLOCK * ACROSS + i % WIDTH / BLOCK][k] +=
                    (double)( r.rgb[3 * i] + r.rgb[3 * i + 1] + r.rgb[3 * i + 2] ) / ( 3.0 * BLOCK * BLOCK );
            free_rendered( &r );
        }
        rf_destroy_tracer( tracer );
        for ( int b = 0; b < BLOCKS && way > 0; ++b )
        {
            double p = welch_p( mean[way][b], seeds, mean[0][b], seeds ), error[2];
            double found = mean_of( mean[way][b], seeds, error ), wanted = mean_of( mean[0][b], seeds, error + 1 );
            smallest = fmin( smallest, p );
            if ( p < 0.01 )
                printf( "block %d,%d: %+.2f %% ± %.2f %%, p %.2g\n", b % ACROSS * BLOCK, b / ACROSS * BLOCK,
                        100.0 * ( found / wanted - 1.0 ), 100.0 * hypot( error[0], error[1] ) / wanted, p );
        }
        if ( way == 0 )
            continue;
        smallest = 1.0 - pow( 1.0 - smallest, BLOCKS );
        printf( "%d seeds, group %d tile %s: smallest p of the blocks %.3g\n", seeds, s_ways[way].setting.group,
                s_ways[way].setting.tile, smallest );
        assert_true( is_likely( smallest ) );
    }
    use_embree_for( NULL );
    rf_destroy_scene( &scene );
}

STATISTICAL_TESTS
