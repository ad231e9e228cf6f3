// Depth of field and motion blur of the camera under frames and tiles are unbiased: against a path tracer that draws a
// point of the lens and a moment of the shutter for each of its samples.
#include "support/rooms.h"
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"

#include <stdio.h>
#include <stdlib.h>

#define WIDTH 36
#define HEIGHT 30
#define BLOCK 6
#define EYES 5

typedef enum Blur
{
    LENS,
    SHUTTER,
    BOTH,
} Blur;

static const char* const s_blurs[] = { "lens", "shutter", "lens and shutter" };

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

// Focused on the sphere; the shutter is open from frame to frame, in a whip pan: the camera turns by 16 degrees.
static void blurred_eyes( RfEye* eyes, Blur blur )
{
    RfEye path[2 * EYES + 1];
    sweep_eyes( path, 2 * EYES + 1, WIDTH, HEIGHT );
    for ( int i = 0; i < EYES; ++i )
    {
        eyes[i] = path[2 * i + 1];
        if ( blur != SHUTTER )
            rf_set_lens( eyes + i, 0.4 + 0.02 * i, 1.5 + 0.1 * i, 0, 0.0 ); // the focus is pulled
        if ( blur != LENS )
            rf_set_shutter( eyes + i, path + 2 * i, path + 2 * i + 2 );
    }
}

// Pixels of a pass share points of the lens, so the p-values of blocks are not independent: their number only makes the bound
// for the smallest stricter than it claims to be, but they need not be uniform.
static void assert_means_agree( const char* what, const Images* rendered, const Images* reference )
{
    Verdict v = compare_images( what, rendered, reference, BLOCK );
    printf( "%-40s whole %.3g, smallest of the blocks %.3g\n", what, v.whole_p, v.smallest_p );
    assert_true( is_likely( v.whole_p ) );
    assert_true( is_likely( v.smallest_p ) );
}

static Images rendered_with( const RfTracer* tracer, const RfEye* eyes, int group, bool tiles, int spp )
{
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    settings.spp = spp;
    settings.memory = (size_t)512 << 20;
    if ( tiles )
        settings.tile = ( RfTile ){ RF_TILE_BLOCK, 3, 3 };
    return rendered_images( tracer, eyes, EYES, EYES / 2, settings );
}

// Else the tests would pass for a renderer that knows neither lens nor shutter.
static void assert_blur_is_seen( const RfTracer* tracer, const RfEye* eyes, Blur blur, const Images* reference )
{
    RfEye sharp[EYES];
    for ( int i = 0; i < EYES; ++i )
    {
        sharp[i] = eyes[i];
        sharp[i].lens_radius = 0.0f;
        sharp[i].moves = 0;
    }
    Images rendered = rendered_with( tracer, sharp, 0, false, 15 );
    double p = compare_images( NULL, &rendered, reference, BLOCK ).smallest_p;
    printf( "%s against a sharp picture: smallest of the blocks %.3g\n", s_blurs[blur], p );
    assert_true( p < 1e-6 );
    free_images( &rendered );
}

static void check( const char* scene_name, RfScene scene, Blur blur, bool all, bool blur_is_plain )
{
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    blurred_eyes( eyes, blur );
    RfRenderSettings plain = plain_settings();
    int times = is_long() ? 4 : 1;
    Images reference = reference_images( tracer, eyes, EYES / 2, 48 * times, &plain );
    if ( blur_is_plain )
        assert_blur_is_seen( tracer, eyes, blur, &reference );
    static const struct
    {
        int group;
        bool tiles;
        int spp;
    } s_ways[] = { { 0, false, 24 }, { 0, true, 16 }, { 2, false, 15 }, { 2, true, 15 } };
    // the short run takes all ways in the first room and all at once in the others
    for ( size_t k = all || is_long() ? 0 : 3; k < sizeof s_ways / sizeof *s_ways; ++k )
    {
        Images rendered = rendered_with( tracer, eyes, s_ways[k].group, s_ways[k].tiles, s_ways[k].spp * times );
        char what[96];
        snprintf( what, sizeof what, "%s, %s, group %d%s:", scene_name, s_blurs[blur], s_ways[k].group,
                  s_ways[k].tiles ? ", tiles" : "" );
        assert_means_agree( what, &rendered, &reference );
        free_images( &rendered );
    }
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

TEST( test_glossy_rooms_are_unbiased )
{
    check( "GGX", make_room( ROOM_GGX ), BOTH, true, false );
    check( "GGX", make_room( ROOM_GGX ), LENS, false, true );
    check( "GGX", make_room( ROOM_GGX ), SHUTTER, false, true );
}

TEST( test_mirrors_glass_and_panes_are_unbiased )
{
    check( "glass", make_glass_room(), BOTH, false, false );
    check( "mirror", make_mirror_room( FLAT_MIRROR ), SHUTTER, false, false );
    check( "panes", make_pane_room( PANES_AND_AREA_LIGHT ), LENS, false, false );
    if ( is_long() )
        check( "mirror", make_mirror_room( FLAT_MIRROR ), BOTH, false, false );
}

STATISTICAL_TESTS
