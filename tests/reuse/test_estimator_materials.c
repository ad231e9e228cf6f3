// Frame reuse is unbiased under environments and punctual lights, with glass and mirrors,
// and where colour, roughness, normals, alpha and emission are textured or blended:
// against independent references, over 16 seeds. Groups of 1 are the reference's picture, bit
// for bit (tests/render/test_same_bits.c).
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/rooms.h"
#include "support/test.h"
#include "support/unbiased.h"

#include <stdio.h>
#include <stdlib.h>

#define WIDTH 36
#define HEIGHT 30
#define BLOCK 6

static bool is_long( void ) { return getenv( "REFRAME_LONG" ) != NULL; }

static void check_group( const char* what, const RfTracer* tracer, const RfEye* eyes, int eye_count, int group, int spp,
                         const RfRenderSettings* like, const Images* reference )
{
    RfRenderSettings settings = *like;
    settings.group = group;
    settings.spp = spp;
    Images rendered = rendered_images( tracer, eyes, eye_count, eye_count / 2, settings );
    char name[64];
    snprintf( name, sizeof name, "%s group %d:", what, group );
    assert_unbiased( name, &rendered, reference, BLOCK );
    free_images( &rendered );
}

static void check_scene( const char* what, RfScene scene, int light_samples )
{
    enum
    {
        EYES = 7
    };
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = plain_settings();
    settings.light_samples = light_samples;
    settings.max_depth = 8;
    settings.memory = (size_t)512 << 20;
    int spp = is_long() ? 4 : 1;
    Images reference = reference_images( tracer, eyes, EYES / 2, is_long() ? 384 : 48, &settings );
    if ( is_long() )
        check_group( what, tracer, eyes, EYES, 1, 12 * spp, &settings, &reference );
    check_group( what, tracer, eyes, EYES, 3, 7 * spp, &settings, &reference );
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

TEST( test_skies_are_unbiased )
{
    check_scene( "constant sky", make_open_scene( LIT_BY_SKY ), 1 );
    check_scene( "map", make_open_scene( LIT_BY_MAP ), 1 );
}

TEST( test_lamps_are_unbiased )
{
    check_scene( "lamps", make_open_scene( LIT_BY_LAMPS ), 1 );
    check_scene( "all lights", make_open_scene( LIT_BY_ALL ), 3 );
}

TEST( test_glass_is_unbiased ) { check_scene( "glass, mirror", make_glass_room(), 1 ); }

TEST( test_textures_are_unbiased ) { check_scene( "textures", make_textured_room(), 1 ); }

TEST( test_varied_glass_and_coats_are_unbiased ) { check_scene( "textured glass and coats", make_varied_room(), 1 ); }

TEST( test_blending_is_unbiased ) { check_scene( "blended", make_blended_room(), 1 ); }

STATISTICAL_TESTS
