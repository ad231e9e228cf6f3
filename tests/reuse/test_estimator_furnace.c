// A closed box of albedo a that emits e holds the radiance e / (1 − a)
// everywhere: for all groups, tiles and normalisations (the bias of the ratio is nil
// where all light is the same).
#include "support/render_support.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define EYES 9
#define WIDTH 24
#define HEIGHT 18
#define SEED_COUNT 16
#define EMISSION 1.5f

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

static const char* const names[] = { "crossfit", "ratio", "none" };

typedef struct Furnace
{
    RfScene scene;
    RfTracer* tracer;
    RfEye eyes[EYES];
    double radiance; // expected
} Furnace;

static void begin( Furnace* f, float albedo )
{
    *f = ( Furnace ){ .scene = make_furnace( albedo, EMISSION ), .radiance = (double)EMISSION / ( 1.0 - (double)albedo ) };
    f->tracer = make_tracer( &f->scene );
    for ( int i = 0; i < EYES; ++i )
    {
        float a = 0.06f * (float)i;
        RfVec3 o = rf_vec3( 0.3f * sinf( a ), 0.05f * (float)i - 0.2f, 0.6f * cosf( a ) );
        f->eyes[i] = rf_make_eye( o, rf_vec3( -sinf( a ), -0.1f, -cosf( a ) ), rf_vec3( 0, 1, 0 ), 1.4, WIDTH, HEIGHT );
    }
}

static void end( Furnace* f )
{
    rf_destroy_tracer( f->tracer );
    rf_destroy_scene( &f->scene );
}

static RfRenderSettings settings_of( int group, const char* tile, RfNormalize normalize, int seed )
{
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    settings.spp = 14 * ( is_long() ? 8 : 1 );
    settings.normalize = normalize;
    settings.threads = 1;                                 // the seeds are shared out
    settings.seed = (uint64_t)( 100 * group + seed + 1 ); // a group's own: some of its frames draw the same paths
    settings.memory = (size_t)512 << 20;
    return settings;
}

static double image_mean( const Rendered* r, int frame )
{
    double sum = 0.0;
    for ( size_t i = 0; i < 3 * r->pixels; ++i )
        sum += (double)frame_rgb( r, frame )[i];
    return sum / ( 3.0 * (double)r->pixels );
}

// No pixel far from the mean: relative to it. The plain sum has the noise of
// the number of hits as well, and can have none.
static void check_pixels( const Rendered* r, int frame, double radiance, RfNormalize normalize, bool exact )
{
    double low = normalize == RF_NORMALIZE_NONE ? 0.0 : 0.3, high = normalize == RF_NORMALIZE_NONE ? 5.0 : 2.5;
    if ( exact && normalize != RF_NORMALIZE_NONE )
        low = 1.0 - 1e-4, high = 1.0 + 1e-4;
    for ( size_t i = 0; i < 3 * r->pixels; ++i )
    {
        double value = (double)frame_rgb( r, frame )[i] / radiance;
        assert_true( value >= low && value <= high );
    }
}

static void check( const Furnace* f, float albedo, int group, const char* tile, RfNormalize normalize )
{
    static const int frames[] = { 0, EYES / 2 };
    double means[2][SEED_COUNT];
    Rendered r[SEED_COUNT];
#pragma omp parallel for schedule( dynamic, 1 )
    for ( int k = 0; k < SEED_COUNT; ++k )
    {
        RfRenderSettings settings = settings_of( group, tile, normalize, k );
        r[k] = render_frames( f->tracer, f->eyes, EYES, frames, 2, &settings );
    }
    for ( int k = 0; k < SEED_COUNT; ++k )
    {
        for ( int i = 0; i < 2; ++i )
        {
            means[i][k] = image_mean( r + k, i );
            check_pixels( r + k, i, f->radiance, normalize, albedo == 0.0f );
        }
        free_rendered( r + k );
    }
    for ( int i = 0; i < 2; ++i )
    {
        double error, mean = mean_of( means[i], SEED_COUNT, &error );
        error = fmax( error, 1e-6 * f->radiance ); // of rounding, where nothing is random
        double away = ( mean - f->radiance ) / error;
        printf( "albedo %.1f group %d tile %-6s %-8s frame %d: %.5f of %.5f, %5.2f SE (SE %.1e)\n", (double)albedo, group, tile,
                names[normalize], frames[i], mean, f->radiance, away, error );
        assert_false( is_far_off( away, SEED_COUNT - 1 ) );
    }
}

static void check_albedo( float albedo )
{
    static const int groups[] = { 0, 1, 3 };
    Furnace f;
    begin( &f, albedo );
    for ( int g = 0; g < 3; ++g )
    {
        for ( int n = RF_NORMALIZE_CROSSFIT; n <= RF_NORMALIZE_NONE; ++n )
            check( &f, albedo, groups[g], "1", (RfNormalize)n );
    }
    check( &f, albedo, 0, "3x3", RF_NORMALIZE_CROSSFIT );
    check( &f, albedo, 0, "rooks9", RF_NORMALIZE_CROSSFIT );
    check( &f, albedo, 3, "3x3", RF_NORMALIZE_CROSSFIT );
    check( &f, albedo, 1, "rooks16", RF_NORMALIZE_NONE );
    end( &f );
}

TEST( test_emission_only ) { check_albedo( 0.0f ); }

TEST( test_albedo_half ) { check_albedo( 0.5f ); }

TEST( test_albedo_high ) { check_albedo( 0.8f ); }

// A quarter of the light is from beyond the 64th vertex.
TEST( test_long_paths )
{
    Furnace f;
    begin( &f, 0.98f );
    double means[SEED_COUNT], error;
#pragma omp parallel for schedule( dynamic, 1 )
    for ( int k = 0; k < SEED_COUNT; ++k )
    {
        static const int only = 0;
        RfRenderSettings settings = settings_of( 0, "1", RF_NORMALIZE_CROSSFIT, k );
        settings.spp = 2;
        Rendered r = render_frames( f.tracer, f.eyes, EYES, &only, 1, &settings );
        means[k] = image_mean( &r, 0 );
        free_rendered( &r );
    }
    double mean = mean_of( means, SEED_COUNT, &error ), away = ( mean - f.radiance ) / error;
    printf( "albedo 0.98: %.3f of %.3f, %.2f SE (SE %.1e)\n", mean, f.radiance, away, error );
    assert_true( error < 0.02 * f.radiance );
    assert_false( is_far_off( away, SEED_COUNT - 1 ) );
    end( &f );
}

// Where nothing absorbs, roulette alone ends paths.
TEST( test_albedo_1_ends )
{
    Furnace f;
    begin( &f, 1.0f );
    RfRenderSettings settings = settings_of( 0, "1", RF_NORMALIZE_CROSSFIT, 0 );
    settings.spp = 1;
    static const int frames[] = { 0 };
    Rendered one = render_frames( f.tracer, f.eyes, EYES, frames, 1, &settings );
    settings.threads = 3;
    Rendered three = render_frames( f.tracer, f.eyes, EYES, frames, 1, &settings );
    assert_memory_equal( frame_rgb( &one, 0 ), frame_rgb( &three, 0 ), 3 * one.pixels * sizeof( float ) );
    assert_true( image_mean( &one, 0 ) > 64.0 * (double)EMISSION && isfinite( image_mean( &one, 0 ) ) );
    free_rendered( &one );
    free_rendered( &three );
    end( &f );
}

// Beyond vertex D lies the share a^D of the light.
TEST( test_light_beyond_depth )
{
    Furnace f;
    begin( &f, 0.8f );
    static const int only = 0;
    RfShot shot = { f.tracer, f.eyes, EYES, &only, 1 };
    for ( int depth = 1; depth <= 16; depth *= 2 )
    {
        RfRenderSettings settings = settings_of( 3, "3x3", RF_NORMALIZE_CROSSFIT, depth );
        double share, again;
        settings.max_depth = depth;
        assert_int_equal( rf_find_light_beyond_depth( &shot, &settings, &share, NULL ), RF_OK );
        printf( "depth %d: %.4f of %.4f beyond\n", depth, share, pow( 0.8, depth ) );
        assert_true( fabs( share - pow( 0.8, depth ) ) < 0.01 );
        settings.seed += 1;
        assert_int_equal( rf_find_light_beyond_depth( &shot, &settings, &again, NULL ), RF_OK );
        assert_true( share == again );
    }
    RfRenderSettings unlimited = rf_default_render_settings();
    double none = 1.0;
    assert_int_equal( rf_find_light_beyond_depth( &shot, &unlimited, &none, NULL ), RF_OK );
    assert_true( none == 0.0 );
    end( &f );
}

STATISTICAL_TESTS
