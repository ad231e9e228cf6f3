// Frame reuse is unbiased: against independent references, over 16 seeds, per block and
// per pixel, for diffuse, Phong and GGX, groups of 3, 7, 13 and 17 frames. The test can
// see bias: the biased weightings fail it. Groups of 1 are the reference's picture, bit for
// bit (tests/render/test_same_bits.c).
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"

#include <stdio.h>
#include <stdlib.h>

#define WIDTH 36
#define HEIGHT 30
#define BLOCK 6

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

static RfRenderSettings settings_of( int group, int spp )
{
    RfRenderSettings settings = plain_settings();
    settings.group = group;
    settings.spp = spp;
    settings.memory = (size_t)512 << 20;
    return settings;
}

static void assert_frame_unbiased( const char* what, int group, int frame, const Images* rendered, const Images* reference )
{
    char name[64];
    snprintf( name, sizeof name, "%s group %d frame %d:", what, group, frame );
    assert_unbiased( name, rendered, reference, BLOCK );
}

static void check_group( const char* what, const RfTracer* tracer, const RfEye* eyes, int eye_count, int frame, int group,
                         int spp, RfNormalize normalize, const Images* reference )
{
    RfRenderSettings settings = settings_of( group, spp );
    settings.normalize = normalize;
    Images rendered = rendered_images( tracer, eyes, eye_count, frame, settings );
    assert_frame_unbiased( what, group, frame, &rendered, reference );
    free_images( &rendered );
}

// Groups of half-width `larger`; 0: of every size, also plain sums and the end of the path. With REFRAME_LONG all are.
static void check_scene( const char* what, RfScene scene, int larger )
{
    enum
    {
        EYES = 17
    };
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    RfRenderSettings plain = settings_of( 0, 1 );
    int spp = is_long() ? 4 : 1;
    int frames[] = { 8, 0 };
    bool thorough = larger == 0 || is_long();
    for ( int k = 0; k < ( thorough ? 2 : 1 ); ++k )
    {
        int f = frames[k];
        Images reference = reference_images( tracer, eyes, f, is_long() ? 384 : 48, &plain );
        if ( k == 0 ? thorough : is_long() )
            check_group( what, tracer, eyes, EYES, f, 3, 7 * spp, RF_NORMALIZE_CROSSFIT, &reference );
        if ( thorough || larger == 6 ) // cut windows
            check_group( what, tracer, eyes, EYES, f, 6, 5 * spp, RF_NORMALIZE_CROSSFIT, &reference );
        if ( thorough || larger == 8 )
            check_group( what, tracer, eyes, EYES, f, 8, 4 * spp, RF_NORMALIZE_CROSSFIT, &reference );
        if ( ( k == 0 && thorough ) || is_long() )
        {
            check_group( what, tracer, eyes, EYES, f, 1, 12 * spp, RF_NORMALIZE_CROSSFIT, &reference );
            check_group( what, tracer, eyes, EYES, f, 3, 7 * spp, RF_NORMALIZE_NONE, &reference );
        }
        free_images( &reference );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

TEST( test_diffuse_is_unbiased ) { check_scene( "diffuse", make_room( ROOM_DIFFUSE ), 8 ); }

TEST( test_phong_is_unbiased ) { check_scene( "Phong", make_room( ROOM_PHONG ), 6 ); }

TEST( test_ggx_is_unbiased ) { check_scene( "GGX", make_room( ROOM_GGX ), 0 ); }

// A zoom whose lens shifts as well, over pixels wider than high: every frame has a film of its own.
static void zoom_eyes( RfEye* eyes, int count )
{
    orbit_eyes( eyes, count, 3.0f, WIDTH, HEIGHT );
    for ( int i = 0; i < count; ++i )
    {
        const RfEye* e = eyes + i;
        eyes[i] = rf_make_eye( e->origin, e->forward, e->up, 0.7 + 0.12 * i, WIDTH, HEIGHT );
        rf_shift_eye( eyes + i, 1.4, 0.1 - 0.06 * i, 0.05 * i );
    }
}

TEST( test_animated_lenses_are_unbiased )
{
    RfScene scene = make_room( ROOM_GGX );
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[5];
    zoom_eyes( eyes, 5 );
    RfRenderSettings settings = settings_of( 2, 15 );
    int frames[] = { 2, 4 }; // from both sides, and the widest lens from narrower ones
    for ( int k = 0; k < 2; ++k )
    {
        Images reference = reference_images( tracer, eyes, frames[k], 64, &settings );
        settings.tile = ( RfTile ){ RF_TILE_NONE, 1, 1 };
        Images groups = rendered_images( tracer, eyes, 5, frames[k], settings );
        assert_frame_unbiased( "animated lens", 2, frames[k], &groups, &reference );
        settings.tile = ( RfTile ){ RF_TILE_BLOCK, 3, 3 };
        Images tiles = rendered_images( tracer, eyes, 5, frames[k], settings );
        assert_frame_unbiased( "animated lens, tiles", 2, frames[k], &tiles, &reference );
        free_images( &tiles );
        free_images( &groups );
        free_images( &reference );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

TEST( test_light_samples_and_depth_are_unbiased )
{
    RfScene scene = make_room( ROOM_GGX );
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[5];
    orbit_eyes( eyes, 5, 3.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = settings_of( 2, 10 );
    settings.light_samples = 4;
    settings.max_depth = 3;
    Images reference = reference_images( tracer, eyes, 2, 64, &settings );
    Images rendered = rendered_images( tracer, eyes, 5, 2, settings );
    assert_frame_unbiased( "4 light samples", 2, 2, &rendered, &reference );
    free_images( &rendered );
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

// A glossy vase seen from widely spaced eyes: the exact weights pass where
// both of the biased weightings of the literature fail.
TEST( test_biased_weightings_are_seen )
{
    enum
    {
        EYES = 7
    };
    RfScene scene = make_room( ROOM_PHONG );
    scene.materials[ROOM_OBJECT_MATERIAL].diffuse = rf_vec3( 0, 0, 0 ); // each eye draws from its own lobe only
    scene.materials[ROOM_OBJECT_MATERIAL].specular = rf_vec3( 0.9f, 0.9f, 0.9f );
    scene.materials[ROOM_OBJECT_MATERIAL].exponent = 100.0f;
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 25.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = settings_of( 3, 28 );
    Images reference = reference_images( tracer, eyes, 3, 96, &settings );
    static const RfWeights weights[] = { RF_WEIGHTS_EXACT, RF_WEIGHTS_EQ15, RF_WEIGHTS_UNWEIGHTED };
    static const char* names[] = { "wide, exact", "wide, eq15", "wide, unweighted" };
    for ( int w = 0; w < 3; ++w )
    {
        settings.weights = weights[w];
        Images rendered = rendered_images( tracer, eyes, EYES, 3, settings );
        if ( weights[w] == RF_WEIGHTS_EXACT )
            assert_frame_unbiased( names[w], 3, 3, &rendered, &reference );
        else
        {
            Verdict v = compare_images( NULL, &rendered, &reference, BLOCK );
            printf( "%s: smallest p %.3g\n", names[w], v.smallest_p );
            assert_true( v.smallest_p < 1e-6 );
        }
        free_images( &rendered );
    }
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

STATISTICAL_TESTS
