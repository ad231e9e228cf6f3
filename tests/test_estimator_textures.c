// Frame reuse is unbiased where colours, roughness, normals, alpha and light
// come from textures: against independent references, over 16 seeds.
#include "textured_room.h"
#include "unbiased.h"

#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>

#include <cmocka.h>

#define WIDTH 48
#define HEIGHT 36
#define BLOCK 6
#define SIGNIFICANCE 1e-4

static void check_group( const RfTracer* tracer, const RfEye* eyes, int eye_count, int group, int spp, const Images* reference )
{
    RfRenderSettings settings = rf_default_render_settings();
    settings.group = group;
    settings.spp = spp;
    settings.max_depth = 6;
    settings.memory = (size_t)512 << 20;
    Images rendered = rendered_images( tracer, eyes, eye_count, eye_count / 2, settings );
    Verdict block = compare_images( &rendered, reference, BLOCK ), pixel = compare_images( &rendered, reference, 1 );
    printf( "textured room group %d: whole p %.3g, per block smallest p %.3g, uniform p %.3g; per pixel smallest p %.3g\n", group,
            block.whole_p, block.smallest_p, block.uniform_p, pixel.smallest_p );
    assert_true( block.whole_p > SIGNIFICANCE );
    assert_true( block.smallest_p > SIGNIFICANCE );
    assert_true( block.uniform_p > SIGNIFICANCE );
    assert_true( pixel.smallest_p > SIGNIFICANCE );
    free_images( &rendered );
}

static void test_textured_room( void** state )
{
    (void)state;
    enum { EYES = 7 };
    RfScene scene = make_textured_room();
    RfTracer* tracer = make_tracer( &scene );
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 3.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = rf_default_render_settings();
    settings.max_depth = 6;
    int spp = getenv( "REFRAME_LONG" ) != NULL ? 4 : 1;
    Images reference = reference_images( tracer, eyes, EYES / 2, 64 * spp, &settings );
    check_group( tracer, eyes, EYES, 0, 32 * spp, &reference );
    check_group( tracer, eyes, EYES, 3, 7 * spp, &reference );
    free_images( &reference );
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

int main( void )
{
    const struct CMUnitTest tests[] = { cmocka_unit_test( test_textured_room ) };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
