// A bias of 0.3 % in what reuse yields does not pass: the standard error of the whole picture is 0.02 to 0.03 %, for groups, for
// tiles and for both. `scripts/test --seeds N --bias` builds such a bias in, and all three must find it.
#include "support/scene_builder.h"
#include "support/statistics.h"
#include "support/test.h"
#include "support/unbiased.h"

#include <stdio.h>

#define WIDTH 48
#define HEIGHT 36
#define BLOCK 6
#define EYES 7
#define FRAME ( EYES / 2 )
#define LARGEST_ERROR 0.0004 // relative; a first round finds four of these

static RfScene s_scene;
static RfTracer* s_tracer;
static RfEye s_eyes[EYES];

static void check( const char* what, int group, const char* tile, int spp )
{
    static Images reference;
    static int samples; // of the reference: a repetition has its own
    RfRenderSettings settings = plain_settings();
    settings.max_depth = 4;
    settings.light_samples = 2;
    if ( samples != suite_samples() )
    {
        free_images( &reference );
        reference = reference_images( s_tracer, s_eyes, FRAME, 160, &settings );
        samples = suite_samples();
    }
    settings.group = group;
    settings.spp = spp;
    assert_true( rf_parse_tile( tile, &settings.tile ) );
    Images rendered = rendered_images( s_tracer, s_eyes, EYES, FRAME, settings );
    double error = compare_images( NULL, &rendered, &reference, BLOCK ).whole_error;
    assert_true( error < LARGEST_ERROR );
    assert_unbiased( what, &rendered, &reference, BLOCK );
    free_images( &rendered );
}

TEST( test_groups ) { check( "groups", 3, "1", 16 ); }

TEST( test_tiles ) { check( "tiles", 0, "3x3", 128 ); }

TEST( test_groups_with_tiles ) { check( "groups with tiles", 3, "3x3", 24 ); }

STATISTICAL_TESTS

int main( void )
{
    s_scene = make_room( ROOM_DIFFUSE );
    s_tracer = make_tracer( &s_scene );
    orbit_eyes( s_eyes, EYES, 3.0f, WIDTH, HEIGHT );
    int failed = run_listed_tests();
    rf_destroy_tracer( s_tracer );
    rf_destroy_scene( &s_scene );
    return failed;
}
