// Effects that change noise alone: without them the picture has the same mean, by an independent reference of the whole scene.
// (Without the light tree it has the bits of selection by power: tests/render/test_effects.c.)
#include "support/rooms.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"

#include <stdlib.h>

#define EYES 3
#define WIDTH 32
#define HEIGHT 24
#define SPP 9
#define REFERENCE_SPP 64

typedef Images Reference( const RfTracer* tracer, const RfEye* eyes, int frame, int spp, const RfRenderSettings* settings );

static void check( const char* what, RfScene whole, RfScene left, RfEffectId effect, Reference* reference )
{
    RfEye eyes[EYES];
    orbit_eyes( eyes, EYES, 4.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = plain_settings();
    settings.group = 1;
    settings.spp = SPP;
    settings.adaptive = RF_ADAPTIVE_OFF;
    assert_true( rf_parse_tile( "2x2", &settings.tile ) );
    assert_int_equal( rf_choose_effects( &left, 0, RF_EFFECT_BIT( effect ), NULL ), RF_OK );
    RfTracer *whole_tracer = make_tracer( &whole ), *left_tracer = make_tracer( &left );
    Images wanted = reference( whole_tracer, eyes, 1, REFERENCE_SPP, &settings );
    Images rendered = rendered_images( left_tracer, eyes, EYES, 1, settings );
    assert_unbiased( what, &rendered, &wanted, 4 );
    free_images( &wanted );
    free_images( &rendered );
    rf_destroy_tracer( whole_tracer );
    rf_destroy_tracer( left_tracer );
    rf_destroy_scene( &whole );
    rf_destroy_scene( &left );
}

TEST( test_chains_change_noise_alone )
{
    check( "no chains", make_mirror_room( FLAT_MIRROR ), make_mirror_room( FLAT_MIRROR ), RF_EFFECT_CHAINS, reference_images );
}

TEST( test_flat_mirrors_change_noise_alone )
{
    check( "no flat mirrors", make_mirror_room( FLAT_MIRROR ), make_mirror_room( FLAT_MIRROR ), RF_EFFECT_FLAT_MIRRORS,
           reference_images );
}

// Without punctual lights.
TEST( test_panes_change_noise_alone )
{
    check( "no panes", make_pane_room( PANES_AND_AREA_LIGHT ), make_pane_room( PANES_AND_AREA_LIGHT ), RF_EFFECT_PANES,
           pane_vertex_images );
}

STATISTICAL_TESTS
