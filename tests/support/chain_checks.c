#include "support/chain_checks.h"

#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/unbiased.h"
#include "trace/trace.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#define BLOCK 4
#define PIXELS ( CHAIN_WIDTH * CHAIN_HEIGHT )
#define SIGNIFICANCE 1e-4
#define REFERENCE_SPP 32
#define SHARP_ALPHA 0.01f // GGX lobes that count as nearly specular

const ChainSetting g_all_reuse[4] = {
    { .group = 0, .tile = "3x3", .spp = 12 },
    { .group = 1, .tile = "1", .spp = 6 },
    { .group = 3, .tile = "1", .spp = 7 },
    { .group = 3, .tile = "3x3", .spp = 7 },
};
const ChainSetting g_tiles_and_both[2] = { { .group = 0, .tile = "3x3", .spp = 12 }, { .group = 3, .tile = "3x3", .spp = 7 } };
const ChainSetting g_adaptive_and_roulette[2] = {
    { .group = 3, .tile = "3x3", .spp = 7, .adaptive = true },
    { .group = 3, .tile = "3x3", .spp = 7, .roulette = true },
};

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

static int samples( int spp ) { return is_long() ? 4 * spp : spp; }

ChainCase chain_case( const char* what, int max_depth )
{
    ChainCase c = {
        .what = what, .frame = CHAIN_EYES / 2, .max_depth = max_depth, .settings = g_tiles_and_both, .setting_count = 2
    };
    orbit_eyes( c.eyes, CHAIN_EYES, 3.0f, CHAIN_WIDTH, CHAIN_HEIGHT );
    return c;
}

static bool is_sharp( const RfMaterial* m )
{
    if ( m->kind == RF_BSDF_COATED )
        return m->clearcoat_alpha < SHARP_ALPHA;
    return m->kind == RF_BSDF_GLASS || ( m->kind == RF_BSDF_GGX && m->alpha < SHARP_ALPHA );
}

// Marks the pixels whose centres see a mirror, glass or a sharp lobe. Returns how many.
static int mark_sharp( const RfTracer* tracer, const RfEye* eye, bool* marked )
{
    int count = 0;
    for ( int i = 0; i < PIXELS; ++i )
    {
        float fx = ( (float)( i % CHAIN_WIDTH ) + 0.5f - 0.5f * CHAIN_WIDTH ) / eye->focal;
        float fy = ( 0.5f * CHAIN_HEIGHT - (float)( i / CHAIN_WIDTH ) - 0.5f ) / eye->focal;
        RfVec3 d = rf_normalize( rf_madd( rf_madd( eye->forward, eye->right, fx ), eye->up, fy ) );
        const float* o_in[3] = { &eye->origin.x, &eye->origin.y, &eye->origin.z };
        const float* d_in[3] = { &d.x, &d.y, &d.z };
        uint32_t triangle;
        float u, v;
        rf_trace_nearest( tracer, 1, o_in, d_in, true, &triangle, &u, &v );
        marked[i] = triangle != RF_MISS &&
                    is_sharp( rf_tracer_scene( tracer )->materials + rf_tracer_triangles( tracer )[triangle].material );
        count += marked[i];
    }
    return count;
}

static void marked_means( const Images* images, const bool* marked, int count, double means[SEEDS] )
{
    for ( int k = 0; k < SEEDS; ++k )
    {
        means[k] = 0.0;
        for ( int i = 0; i < PIXELS; ++i )
        {
            const float* p = images->rgb[k] + 3 * (size_t)i;
            double value = 0.2126 * (double)p[0] + 0.7152 * (double)p[1] + 0.0722 * (double)p[2];
            means[k] += marked[i] ? value / count : 0.0;
        }
    }
}

// Welch's test of the mean over the marked pixels. Prints the relative error of their difference, of which
// a bias of some five is found.
static void assert_marked_unbiased( const Images* rendered, const Images* reference, const bool* marked, int count )
{
    if ( count == 0 )
        return;
    double a[SEEDS], b[SEEDS], error_a, error_b;
    marked_means( rendered, marked, count, a );
    marked_means( reference, marked, count, b );
    double mean = mean_of( a, SEEDS, &error_a ), expected = mean_of( b, SEEDS, &error_b ), p = welch_p( a, SEEDS, b, SEEDS );
    printf( "    %2d %% of the pixels: off by %.2f %% ± %.2f %%, p %.3g\n", 100 * count / PIXELS,
            100.0 * ( mean / expected - 1.0 ), 100.0 * sqrt( error_a * error_a + error_b * error_b ) / expected, p );
    assert_true( p > SIGNIFICANCE );
}

// What is compared with: the reference, and the pixels that are looked at together.
typedef struct Expected
{
    Images reference;
    bool marked[PIXELS];
    int marked_count;
} Expected;

static void check_setting( const ChainCase* c, const RfTracer* tracer, RfRenderSettings settings, const ChainSetting* s,
                           const Expected* expected )
{
    settings.group = s->group;
    settings.spp = samples( s->spp );
    settings.adaptive = s->adaptive;
    settings.tile_roulette = s->roulette;
    assert_true( rf_parse_tile( s->tile, &settings.tile ) );
    Images rendered = rendered_images( tracer, c->eyes, CHAIN_EYES, c->frame, settings );
    char name[96];
    snprintf( name, sizeof name, "%s, group %d tile %s%s%s:", c->what, s->group, s->tile, s->adaptive ? ", adaptive" : "",
              s->roulette ? ", roulette" : "" );
    assert_unbiased( name, &rendered, &expected->reference, BLOCK );
    assert_marked_unbiased( &rendered, &expected->reference, expected->marked, expected->marked_count );
    free_images( &rendered );
}

void check_case( const ChainCase* c, const RfScene* scene )
{
    static Expected expected;
    RfTracer* tracer = make_tracer( scene );
    RfRenderSettings settings = plain_settings();
    settings.max_depth = c->max_depth;
    settings.memory = (size_t)256 << 20;
    expected.marked_count = mark_sharp( tracer, c->eyes + c->frame, expected.marked );
    expected.reference = reference_images( tracer, c->eyes, c->frame, samples( REFERENCE_SPP ), &settings );
    for ( int k = 0; k < c->setting_count; ++k )
        check_setting( c, tracer, settings, c->settings + k, &expected );
    for ( int k = 0; is_long() && k < 4; ++k )
        check_setting( c, tracer, settings, g_all_reuse + k, &expected );
    free_images( &expected.reference );
    rf_destroy_tracer( tracer );
}

void check_chains( const ChainCase* tested, RfScene scene )
{
    check_case( tested, &scene );
    rf_destroy_scene( &scene );
}
