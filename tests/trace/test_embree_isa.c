// Rays and segments on processors of all kinds: Embree with packets of 16 (AVX-512) and without. Lanes that are not to be traced
// are left alone, and what is found does not depend on the kind.
#include "support/embree_kind.h"
#include "support/rooms.h"
#include "support/render_support.h"
#include "support/test.h"
#include "trace/trace.h"

static const char* const s_kinds[] = { NULL, "avx2", "sse4.2" };
#define KINDS (int)( sizeof s_kinds / sizeof *s_kinds )

static RfTracer* make_tracer_of_kind( const RfScene* scene, int kind )
{
    use_embree_for( s_kinds[kind] );
    return make_tracer( scene );
}

#define COUNT 250 // no multiple of 16

// Ends of segments everywhere in the room; the same ones every time.
static void draw_points( float point[3][COUNT] )
{
    uint32_t state = 1;
    for ( int i = 0; i < 3 * COUNT; ++i )
    {
        state = state * 1664525u + 1013904223u;
        float u = (float)( state >> 8 ) * 0x1p-24f;
        point[i % 3][i / 3] = i % 3 == 1 ? 0.01f + 2.98f * u : -1.99f + 3.98f * u;
    }
}

TEST( test_lanes_without_weight_are_left_alone )
{
    AUTO_SCENE scene = make_pane_room( PANES_AND_LAMP );
    static float point[3][COUNT], weight[COUNT], probability[COUNT], colour[3][COUNT];
    draw_points( point );
    const float* points[3] = { point[0], point[1], point[2] };
    for ( int kind = 0; kind < KINDS; ++kind )
    {
        AUTO_TRACER tracer = make_tracer_of_kind( &scene, kind );
        for ( int i = 0; i < COUNT; ++i )
            weight[i] = i % 3 == 0 ? 1.0f : 0.0f;
        RfPaneLanes panes = { .probability = probability, .weight = { colour[0], colour[1], colour[2] } };
        int traced = rf_trace_from_origin_past_panes( tracer, rf_vec3( 0, 1.4f, 1.7f ), COUNT, points, weight, &panes );
        int passed = 0;
        for ( int i = 0; i < COUNT; ++i )
        {
            if ( i % 3 == 0 )
                passed += probability[i] < 1.0f;
            else
                assert_true( weight[i] == 0.0f && probability[i] == 1.0f && colour[0][i] == 1.0f && colour[1][i] == 1.0f );
        }
        assert_int_equal( traced, ( COUNT + 2 ) / 3 );
        assert_true( passed > COUNT / 12 ); // else there were no panes to find
    }
}

TEST( test_kinds_of_processors_agree )
{
    AUTO_SCENE scene = make_pane_room( PANES_AND_LAMP );
    static float point[3][COUNT], way[3][COUNT], visible[KINDS][COUNT], probability[KINDS][COUNT], colour[KINDS][3][COUNT];
    draw_points( point );
    for ( int c = 0; c < 3; ++c )
    {
        for ( int i = 0; i < COUNT; ++i )
            way[c][i] = point[c][( i + 1 ) % COUNT] - point[c][i];
    }
    const float *from[3] = { point[0], point[1], point[2] }, *ways[3] = { way[0], way[1], way[2] };
    for ( int kind = 0; kind < KINDS; ++kind )
    {
        AUTO_TRACER tracer = make_tracer_of_kind( &scene, kind );
        RfPaneLanes panes = { .probability = probability[kind], .weight = { colour[kind][0], colour[kind][1], colour[kind][2] } };
        rf_trace_segments_past_panes( tracer, COUNT, from, ways, visible[kind], &panes );
        for ( int i = 0; i < COUNT; ++i )
        {
            assert_true( visible[kind][i] == visible[0][i] );
            if ( visible[0][i] == 0.0f )
                continue; // what was passed before the end is not known
            assert_true( fabsf( probability[kind][i] / probability[0][i] - 1.0f ) < 1e-3f );
            for ( int c = 0; c < 3; ++c )
                assert_true( fabsf( colour[kind][c][i] / colour[0][c][i] - 1.0f ) < 1e-3f );
        }
    }
}
