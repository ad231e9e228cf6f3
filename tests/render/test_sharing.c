// How the light of what changes is shared: pictures under some of the lights sum to that under all of them, and no light is in two.
#include "support/render_one.h"
#include "support/render_support.h"
#include "support/rooms.h"
#include "support/test.h"

#include "trace/trace.h"

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

TEST( test_relit_pictures_sum_to_the_whole )
{
    Stage stage;
    const float* rgb[8];
    open_stage( &stage, make_pane_room( PANES_AND_ALL ), 1, 4.0f, WIDTH, HEIGHT );
    RfRenderSettings settings = small_settings( 0, 2 );
    const RfFrameResult* whole = render_one( &stage, 0, &settings );
    Lit lit = { .lights = rf_tracer_lights( stage.tracer ) };
    int parts = 1 + (int)( lit.lights->count - lit.lights->triangle_count ), bright = 0;
    assert_int_equal( parts, 4 );
    for ( ; lit.part < parts; ++lit.part )
    {
        RfRelitTracer* relit;
        assert_int_equal( rf_create_relit_tracer( stage.tracer, is_lit, &lit, &relit, NULL ), RF_OK );
        RfShot shot = { rf_relit_tracer( relit ), stage.eyes, 1, &( int ){ 0 }, 1 };
        rgb[lit.part] = render_shot( &stage, &shot, &settings )->rgb;
        rf_destroy_relit_tracer( relit );
        bright += mean_value( rgb[lit.part], VALUES ) > 0.01;
    }
    assert_int_equal( bright, 4 );
    expect_sum( "relit", "the sum", rgb, parts, whole->rgb, VALUES, 1e-4, 1.0 );
    close_stage( &stage );
}
