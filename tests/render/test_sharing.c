// How the light of what changes is shared: pictures under some of the lights sum to that under all of them, and no light is in two.
#include "support/render_support.h"
#include "support/rooms.h"

#include "trace/relit.h"

#include <math.h>
#include <setjmp.h>
#include <stdarg.h>
#include <stddef.h>
#include <stdio.h>

#include <cmocka.h>

#define WIDTH 24
#define HEIGHT 16
#define VALUES ( 3 * WIDTH * HEIGHT )

typedef struct Lit
{
    const RfLights* lights;
    int part; // 0: the triangles, then punctual lights one by one, the sky
} Lit;

static bool is_lit( void* user, uint32_t light )
{
    const Lit* lit = user;
    uint32_t triangles = lit->lights->triangle_count;
    return ( light < triangles ? 0 : 1 + (int)( light - triangles ) ) == lit->part;
}

static void test_relit_pictures_sum_to_the_whole( void** state )
{
    (void)state;
    static KeptPicture whole, part;
    const int frame = 0;
    double sum[VALUES] = { 0 };
    RfEye eyes[1];
    RfScene scene = make_pane_room( PANES_AND_ALL );
    orbit_eyes( eyes, 1, 4.0f, WIDTH, HEIGHT );
    RfTracer* tracer = make_tracer( &scene );
    RfRenderSettings settings = small_settings( 0, 2 );
    render_picture( &( RfShot ){ tracer, eyes, 1, &frame, 1 }, &settings, &whole );
    Lit lit = { .lights = rf_tracer_lights( tracer ) };
    int parts = 1 + (int)( lit.lights->count - lit.lights->triangle_count ), bright = 0;
    for ( ; lit.part < parts; ++lit.part )
    {
        RfRelitTracer* relit;
        double mean = 0.0;
        assert_int_equal( rf_create_relit_tracer( tracer, is_lit, &lit, &relit, NULL ), RF_OK );
        render_picture( &( RfShot ){ rf_relit_tracer( relit ), eyes, 1, &frame, 1 }, &settings, &part );
        rf_destroy_relit_tracer( relit );
        for ( int i = 0; i < VALUES; ++i )
        {
            sum[i] += (double)part.rgb[i];
            mean += (double)part.rgb[i] / VALUES;
        }
        bright += mean > 0.01;
    }
    assert_int_equal( parts, 4 );
    assert_int_equal( bright, 4 );
    for ( int i = 0; i < VALUES; ++i )
    {
        if ( !( fabs( sum[i] - (double)whole.rgb[i] ) <= 1e-4 * ( 1.0 + sum[i] ) ) )
            fail_msg( "value %d is %g by the sum, %g in the whole", i, sum[i], (double)whole.rgb[i] );
    }
    rf_destroy_tracer( tracer );
    rf_destroy_scene( &scene );
}

int main( void )
{
    const struct CMUnitTest tests[] = {
        cmocka_unit_test( test_relit_pictures_sum_to_the_whole ),
    };
    return cmocka_run_group_tests( tests, NULL, NULL );
}
