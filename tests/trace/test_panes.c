// Rays and segments through thin panes against closed forms: probability and colour of several in a row, from both
// sides, with holes of their alpha, and how often rays pass; queries that do not pass them.
#include "support/rooms.h"
#include "support/render_support.h"
#include "support/test.h"

#include "trace/trace.h"

static const RfVec3 s_tint[2] = { { 0.9f, 0.5f, 0.2f }, { 1, 1, 1 } };

// Two panes at z = 0 and −1, the first half there if it is blended, before a wall at z = −2.
static RfScene make_panes( bool blended )
{
    SceneBuilder b = { 0 };
    for ( int k = 0; k < 3; ++k )
    {
        uint32_t m = add_material( &b, k < 2 ? make_thin_pane( s_tint[k], 0.0f ) : make_lambert( 1, 1, 1 ) );
        float z = -(float)k;
        add_quad( &b, m, rf_vec3( -4, -4, z ), rf_vec3( 4, -4, z ), rf_vec3( 4, 4, z ), rf_vec3( -4, 4, z ) );
    }
    RfScene scene = finish_scene( &b );
    if ( blended )
    {
        RfFactors factors = { .base = { 0.9, 0.5, 0.2, 0.5 }, .specular = 1, .specular_color = { 1, 1, 1 }, .ior = 1.5 };
        RfTextured* t = scene.materials[0].textured = make_textured( &factors );
        t->model = RF_TEXTURED_GLASS;
        t->transmission = 1.0;
        t->blended = true;
    }
    return scene;
}

// q and T of pane k for this angle, with a hole.
static void expected( int k, double cos_theta, double hole, double* q, double colour[3] )
{
    double tint[3] = { (double)s_tint[k].x, (double)s_tint[k].y, (double)s_tint[k].z };
    double f = fresnel( cos_theta, 1.5 ), sent = ( 1.0 - f ) * ( tint[0] + tint[1] + tint[2] ) / 3.0;
    *q = hole + ( 1.0 - hole ) * sent / ( f + sent );
    for ( int c = 0; c < 3; ++c )
        colour[c] = hole + ( 1.0 - hole ) * tint[c] * ( 1.0 - f );
}

typedef struct Passed
{
    float visible, probability, weight[3];
} Passed;

static Passed pass( const RfTracer* tracer, RfVec3 from, RfVec3 to )
{
    Passed p;
    RfVec3 way = rf_sub( to, from );
    const float* o[3] = { &from.x, &from.y, &from.z };
    const float* d[3] = { &way.x, &way.y, &way.z };
    RfPaneLanes panes = { .probability = &p.probability, .weight = { p.weight, p.weight + 1, p.weight + 2 } };
    rf_trace_segments_past_panes( tracer, 1, o, d, &p.visible, &panes );
    return p;
}

static void assert_close( double a, double b, double tolerance )
{
    assert_true( fabs( a - b ) <= tolerance * ( 1.0 + fabs( b ) ) );
}

static void check_segment( const RfTracer* tracer, RfVec3 from, RfVec3 to, int first, int end, double hole )
{
    double q = 1.0, colour[3] = { 1, 1, 1 };
    RfVec3 way = rf_normalize( rf_sub( to, from ) );
    for ( int k = first; k < end; ++k )
    {
        double one, t[3];
        expected( k, (double)fabsf( way.z ), k == 0 ? hole : 0.0, &one, t );
        q *= one;
        for ( int c = 0; c < 3; ++c )
            colour[c] *= t[c];
    }
    for ( int back = 0; back < 2; ++back )
    {
        Passed p = back == 0 ? pass( tracer, from, to ) : pass( tracer, to, from );
        assert_true( p.visible == 1.0f );
        assert_close( (double)p.probability, q, 1e-6 );
        for ( int c = 0; c < 3; ++c )
            assert_close( (double)p.weight[c] * (double)p.probability, colour[c], 1e-6 );
    }
}

TEST( test_segments_have_the_closed_forms )
{
    for ( int blended = 0; blended < 2; ++blended )
    {
        AUTO_SCENE scene = make_panes( blended == 1 );
        AUTO_TRACER tracer = make_tracer( &scene );
        double hole = blended == 1 ? 0.5 : 0.0;
        assert_true( rf_tracer_has_panes( tracer ) );
        RfVec3 before = rf_vec3( 0.2f, 0.1f, 1 );
        check_segment( tracer, before, rf_vec3( 0.3f, 0.4f, 0.1f ), 0, 0, hole );
        check_segment( tracer, before, rf_vec3( 0.2f, 0.1f, -0.5f ), 0, 1, hole );
        check_segment( tracer, before, rf_vec3( 1.5f, -1.4f, -1.5f ), 0, 2, hole );
        check_segment( tracer, rf_vec3( -3, 0, -0.9f ), rf_vec3( 3, 0.5f, -1.1f ), 1, 2, hole );
        assert_true( pass( tracer, before, rf_vec3( 0.2f, 0.1f, -2.5f ) ).visible == 0.0f ); // the wall
    }
}

// Rays pass with the probability q, each pane on its own, and carry the weight of those they passed.
TEST( test_rays_pass_with_their_probability )
{
    enum
    {
        RAYS = 40000
    };
    static float o[3][RAYS], d[3][RAYS], u[RAYS], v[RAYS], probability[RAYS], weight[3][RAYS];
    static uint32_t triangle[RAYS];
    for ( int blended = 0; blended < 2; ++blended )
    {
        AUTO_SCENE scene = make_panes( blended == 1 );
        AUTO_TRACER tracer = make_tracer( &scene );
        RfVec3 way = rf_normalize( rf_vec3( 0.9f, 0.3f, -0.5f ) );
        for ( int i = 0; i < RAYS; ++i ) // none through the diagonal of a pane, where it meets both triangles
        {
            float from[3] = { -1.5f + 1e-5f * (float)i, (float)( i % 7 ) * 0.1f + 0.0137037f, 0.5f },
                  along[3] = { way.x, way.y, way.z };
            for ( int c = 0; c < 3; ++c )
            {
                o[c][i] = from[c];
                d[c][i] = along[c];
            }
        }
        const float* ro[3] = { o[0], o[1], o[2] };
        const float* rd[3] = { d[0], d[1], d[2] };
        RfPaneLanes panes = { .probability = probability, .weight = { weight[0], weight[1], weight[2] } };
        rf_trace_nearest_past_panes( tracer, RAYS, ro, rd, triangle, u, v, &panes );
        int found[3] = { 0 };
        double q[2], t[2][3];
        for ( int k = 0; k < 2; ++k )
            expected( k, (double)-way.z, k == 0 && blended == 1 ? 0.5 : 0.0, q + k, t[k] );
        for ( int i = 0; i < RAYS; ++i )
        {
            assert_int_not_equal( triangle[i], RF_MISS );
            int at = (int)triangle[i] / 2;
            found[at] += 1;
            double passed = 1.0;
            for ( int k = 0; k < at; ++k )
                passed *= q[k];
            assert_close( (double)probability[i], passed, 1e-6 );
            for ( int c = 0; c < 3; ++c )
                assert_close( (double)weight[c][i], ( at > 0 ? t[0][c] / q[0] : 1.0 ) * ( at > 1 ? t[1][c] / q[1] : 1.0 ), 1e-5 );
        }
        double share[3] = { 1.0 - q[0], q[0] * ( 1.0 - q[1] ), q[0] * q[1] };
        for ( int k = 0; k < 3; ++k )
        {
            double sigma = sqrt( RAYS * share[k] * ( 1.0 - share[k] ) );
            assert_true( fabs( found[k] - RAYS * share[k] ) < 4.0 * sigma );
        }
    }
}

// To the other queries panes are surfaces like any others, and from an origin they can be passed as well.
TEST( test_panes_stop_the_plain_queries )
{
    AUTO_SCENE scene = make_panes( false );
    AUTO_TRACER tracer = make_tracer( &scene );
    RfVec3 from = rf_vec3( 0, 0, 1 ), way = rf_vec3( 0, 0, -1 );
    const float* o[3] = { &from.x, &from.y, &from.z };
    const float* d[3] = { &way.x, &way.y, &way.z };
    uint32_t triangle;
    float u, v, visible;
    rf_trace_nearest( tracer, 1, o, d, true, &triangle, &u, &v );
    assert_true( triangle < 2 );
    way.z = -1.5f;
    rf_trace_segments( tracer, 1, o, d, &visible );
    assert_true( visible == 0.0f );
    float x[3] = { 0.1f, 0.2f, 0.3f }, y[3] = { 0, 0, 0 }, z[3] = { -0.5f, 0.5f, -1.5f }, weight[3] = { 4, 4, 4 };
    const float* points[3] = { x, y, z };
    assert_int_equal( rf_trace_from_origin( tracer, from, 3, points, weight ), 3 );
    assert_true( weight[0] == 0.0f && weight[1] == 4.0f && weight[2] == 0.0f );
    float past[3] = { 4, 4, 0 }, probability[3], colour[3][3];
    RfPaneLanes panes = { .probability = probability, .weight = { colour[0], colour[1], colour[2] } };
    assert_int_equal( rf_trace_from_origin_past_panes( tracer, from, 3, points, past, &panes ), 2 );
    assert_true( past[0] == 4.0f && past[1] == 4.0f && past[2] == 0.0f );
    Passed same = pass( tracer, from, rf_vec3( x[0], y[0], z[0] ) );
    assert_close( (double)probability[0], (double)same.probability, 1e-6 );
    assert_close( (double)colour[1][0], (double)same.weight[1], 1e-6 );
    assert_true( probability[1] == 1.0f && colour[2][1] == 1.0f );
}
