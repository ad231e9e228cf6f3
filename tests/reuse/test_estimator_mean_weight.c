// E[B] = 1 (src/reuse/estimators.md, section 2): the summed weights of the hits that land in a pixel
// have mean one, at every pixel, for every group and camera path, with and without tiles.
// A ray that misses everything weighs one in its own frame, so this holds where rays miss
// as well; tested with a closed and an open scene, with mirrors in both, and with panes that cross.
#include "support/rooms.h"
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"
#include "trace/trace.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define EYES 17
#define WIDTH 32
#define HEIGHT 24
#define PIXELS ( WIDTH * HEIGHT )
#define BLOCK 4
#define BLOCKS ( ( WIDTH / BLOCK ) * ( HEIGHT / BLOCK ) )
#define SEED_COUNT 16

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

typedef void MakeEyes( RfEye* eyes );

static void make_orbit( RfEye* eyes ) { orbit_eyes( eyes, EYES, 2.0f, WIDTH, HEIGHT ); }

// Up to the sphere: every frame sees less of it, and larger.
static void make_dolly( RfEye* eyes )
{
    for ( int i = 0; i < EYES; ++i )
    {
        RfVec3 o = rf_vec3( 0.02f * (float)i, 1.5f, 1.85f - 0.065f * (float)i );
        eyes[i] = rf_make_eye( o, rf_sub( rf_vec3( 0, 0.9f, 0 ), o ), rf_vec3( 0, 1, 0 ), 1.0, WIDTH, HEIGHT );
    }
}

// 11 degrees a frame: the films of a group hardly overlap at its ends.
static void make_pan( RfEye* eyes )
{
    for ( int i = 0; i < EYES; ++i )
    {
        float a = 11.0f * RF_PI / 180.0f * (float)( i - EYES / 2 );
        RfVec3 o = rf_vec3( 0.01f * (float)i, 1.2f, 1.6f );
        eyes[i] = rf_make_eye( o, rf_vec3( sinf( a ), -0.1f, -cosf( a ) ), rf_vec3( 0, 1, 0 ), 0.9, WIDTH, HEIGHT );
    }
}

typedef struct CameraPath
{
    const char* name;
    MakeEyes* make;
} CameraPath;

// Close to where a tinted pane, which reflects, crosses a blended one: some eyes see through its holes what others see past it.
static void make_close_orbit( RfEye* eyes )
{
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    for ( int i = 0; i < EYES; ++i )
    {
        RfVec3 o = eyes[i].origin;
        eyes[i] = rf_make_eye( o, rf_sub( rf_vec3( -1.1f, 0.9f, -0.4f ), o ), rf_vec3( 0, 1, 0 ), 0.3, WIDTH, HEIGHT );
    }
}

static const CameraPath paths[] = { { "orbit", make_orbit }, { "dolly", make_dolly }, { "pan", make_pan } };

// Floor, block and sphere under an open sky.
static RfScene make_plain_scene( void )
{
    SceneBuilder b = { 0 };
    uint32_t grey = add_material( &b, make_lambert( 0.5f, 0.5f, 0.5f ) );
    uint32_t shiny = add_material( &b, make_plastic( 0.5f, 0.3f ) );
    uint32_t light = add_material( &b, make_light( 10.0f, false ) );
    add_quad( &b, grey, rf_vec3( -2, 0, 2 ), rf_vec3( 2, 0, 2 ), rf_vec3( 2, 0, -2 ), rf_vec3( -2, 0, -2 ) );
    add_box( &b, grey, rf_vec3( -0.6f, 0, -0.5f ), rf_vec3( 0.7f, 0.5f, 0.5f ), false );
    add_sphere( &b, shiny, rf_vec3( 0, 1.0f, 0 ), 0.5f, 12 );
    add_quad( &b, light, rf_vec3( -0.5f, 3, -0.5f ), rf_vec3( 0.5f, 3, -0.5f ), rf_vec3( 0.5f, 3, 0.5f ),
              rf_vec3( -0.5f, 3, 0.5f ) );
    return finish_scene( &b );
}

// Marks the pixels of which no ray misses: none of a fine grid that reaches a
// pixel's width beyond it. Returns how many.
static int mark_solid( const RfTracer* tracer, const RfEye* eye, bool* solid )
{
    enum
    {
        GRID = 24
    };
    int count = 0;
    for ( int i = 0; i < PIXELS; ++i )
    {
        solid[i] = true;
        for ( int k = 0; k < GRID * GRID && solid[i]; ++k )
        {
            float fx = (float)( i % WIDTH ) - 1.0f + 3.0f * (float)( k % GRID ) / ( GRID - 1 ) - 0.5f * WIDTH;
            float fy = 0.5f * HEIGHT - ( (float)( i / WIDTH ) - 1.0f + 3.0f * (float)( k / GRID ) / ( GRID - 1 ) );
            RfVec3 d = rf_madd( rf_madd( eye->forward, eye->right, fx / eye->focal ), eye->up, fy / eye->focal );
            const float* o_in[3] = { &eye->origin.x, &eye->origin.y, &eye->origin.z };
            const float* d_in[3] = { &d.x, &d.y, &d.z };
            uint32_t triangle;
            float u, v;
            rf_trace_nearest( tracer, 1, o_in, d_in, true, &triangle, &u, &v );
            solid[i] = triangle != RF_MISS;
        }
        count += solid[i];
    }
    return count;
}

// One-sample t-test of the mean being 1. Constant samples: 1 where they are it.
static double one_p( const double* values )
{
    double error, mean = mean_of( values, SEED_COUNT, &error );
    if ( error < 1e-7 )
        return fabs( mean - 1.0 ) < 1e-5 ? 1.0 : 0.0;
    return student_p( ( mean - 1.0 ) / error, SEED_COUNT - 1 );
}

// B of one frame, one image per seed.
typedef struct Weights
{
    float image[SEED_COUNT][PIXELS];
} Weights;

// In standard errors: how far the mean of B over the marked pixels is off 1.
static double distance( const Weights* weights, const bool* marked, double* error )
{
    double means[SEED_COUNT];
    for ( int k = 0; k < SEED_COUNT; ++k )
    {
        double sum = 0.0, count = 0.0;
        for ( int i = 0; i < PIXELS; ++i )
        {
            sum += marked[i] ? (double)weights->image[k][i] : 0.0;
            count += marked[i];
        }
        means[k] = sum / count;
    }
    double mean = mean_of( means, SEED_COUNT, error );
    return *error > 1e-7 ? ( mean - 1.0 ) / *error : ( mean - 1.0 ) / 1e-7;
}

static double smallest_block_p( const Weights* weights, double* uniform )
{
    double p[BLOCKS];
    for ( int b = 0; b < BLOCKS; ++b )
    {
        double means[SEED_COUNT] = { 0 };
        for ( int i = 0; i < BLOCK * BLOCK; ++i )
        {
            int x = b % ( WIDTH / BLOCK ) * BLOCK + i % BLOCK, y = b / ( WIDTH / BLOCK ) * BLOCK + i / BLOCK;
            for ( int k = 0; k < SEED_COUNT; ++k )
                means[k] += (double)weights->image[k][y * WIDTH + x] / ( BLOCK * BLOCK );
        }
        p[b] = one_p( means );
    }
    *uniform = uniform_p( p, BLOCKS ); // sorts
    return 1.0 - pow( 1.0 - p[0], BLOCKS );
}

static bool is_one_everywhere( const Weights* weights )
{
    for ( int k = 0; k < SEED_COUNT; ++k )
    {
        for ( int i = 0; i < PIXELS; ++i )
        {
            if ( weights->image[k][i] != 1.0f )
                return false;
        }
    }
    return true;
}

#define FRAMES 3
static const int s_frames[FRAMES] = { 0, EYES / 2, EYES - 1 };

// A camera path in a scene, and which pixels of the tested frames are solid: that takes as long as a render.
typedef struct View
{
    const char *scene, *path;
    const RfTracer* tracer;
    RfEye eyes[EYES];
    bool solid[FRAMES][PIXELS];
    int solid_count[FRAMES];
} View;

static const View* view_of( const char* scene, const RfTracer* tracer, const CameraPath* path )
{
    static View v;
    v = ( View ){ .scene = scene, .path = path->name, .tracer = tracer };
    path->make( v.eyes );
    for ( int f = 0; f < FRAMES; ++f )
        v.solid_count[f] = mark_solid( tracer, v.eyes + s_frames[f], v.solid[f] );
    return &v;
}

static void check_weights( const View* view, int group, const char* tile, int f, const Weights* weights )
{
    if ( group == 0 )
    {
        assert_true( is_one_everywhere( weights ) );
        return;
    }
    static bool all[PIXELS];
    for ( int i = 0; i < PIXELS; ++i )
        all[i] = true;
    int count = view->solid_count[f];
    double error, error_solid = 0.0, away = distance( weights, all, &error ), away_solid = 0.0, uniform;
    if ( count > 0 )
        away_solid = distance( weights, view->solid[f], &error_solid );
    double smallest = smallest_block_p( weights, &uniform );
    printf( "%s %s group %d tile %-6s frame %2d: %5.2f SE off 1 (SE %.1e); %3d solid pixels: %5.2f SE; blocks: smallest p %.3g, "
            "uniform p %.3g\n",
            view->scene, view->path, group, tile, s_frames[f], away, error, count, away_solid, smallest, uniform );
    assert_false( is_far_off( away, SEED_COUNT - 1 ) );
    assert_false( is_far_off( away_solid, SEED_COUNT - 1 ) );
    assert_true( is_likely( smallest ) );
}

// The weights do not depend on the light: camera rays alone are enough, and what they see in mirrors.
static RfRenderSettings settings_of( int group, const char* tile, int max_depth, int seed )
{
    static const int spp[] = { 3, 6, 0, 14, 0, 0, 0, 0, 4 };
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    settings.spp = spp[group] * ( is_long() ? 8 : 1 );
    settings.threads = 1; // the seeds are shared out
    settings.max_depth = max_depth;
    settings.seed = (uint64_t)seed + 1;
    settings.memory = (size_t)512 << 20;
    return settings;
}

static void check_path( const View* view, int group, const char* tile, int max_depth )
{
    static Weights weights[FRAMES];
#pragma omp parallel for schedule( dynamic, 1 )
    for ( int k = 0; k < SEED_COUNT; ++k )
    {
        RfRenderSettings settings = settings_of( group, tile, max_depth, k );
        Rendered r = render_frames( view->tracer, view->eyes, EYES, s_frames, FRAMES, &settings );
        for ( int f = 0; f < FRAMES; ++f )
        {
            for ( int i = 0; i < PIXELS; ++i )
                weights[f].image[k][i] = frame_weight( &r, f )[i];
        }
        free_rendered( &r );
    }
    for ( int f = 0; f < FRAMES; ++f )
        check_weights( view, group, tile, f, weights + f );
}

static void check_scene( const char* name, RfScene scene )
{
    static const int groups[] = { 0, 1, 3, 8 };
    RfTracer* tracer = make_tracer( &scene );
    for ( int p = 0; p < 3; ++p )
    {
        const View* view = view_of( name, tracer, paths + p );
        for ( int g = 0; g < 4; ++g )
            check_path( view, groups[g], "1", 1 );
        check_path( view, 3, "3x3", 1 );
        check_path( view, 1, "rooks16", 1 );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

// As far as a chain by way of a mirror and glass needs. Fewer settings: whole paths are traced here.
static void check_mirrors( const char* name, RfScene scene )
{
    RfTracer* tracer = make_tracer( &scene );
    for ( int p = 0; p < 3; p += 2 )
    {
        const View* view = view_of( name, tracer, paths + p );
        check_path( view, 1, "1", 3 );
        check_path( view, 3, "3x3", 3 );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

TEST( test_mirrors )
{
    check_mirrors( "mirrors", make_mirror_room( FACING_MIRRORS ) );
    check_mirrors( "open mirror", make_mirror_in_the_open( LIT_BY_SKY ) );
    RfScene scene = make_pane_room( PANES_AND_LAMP );
    RfTracer* tracer = make_tracer( &scene );
    check_path( view_of( "panes", tracer, &( CameraPath ){ "close", make_close_orbit } ), 3, "1", 3 );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

TEST( test_closed_room ) { check_scene( "room", make_room( ROOM_GGX ) ); }

TEST( test_open_scene ) { check_scene( "open", make_plain_scene() ); }

STATISTICAL_TESTS
