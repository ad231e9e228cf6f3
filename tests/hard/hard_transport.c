// Input cases of light transport: rays by the million, sharp lobes, the selection of lights.
#include "hard/hard_inputs.h"
#include "bsdf/bsdf.h"
#include "trace/trace.h"
#include "support/select_light.h"

#include <math.h>

static bool reaches( const RfTracer* tracer, RfVec3 from, RfVec3 to )
{
    RfVec3 way = rf_sub( to, from );
    const float *o[3] = { &from.x, &from.y, &from.z }, *d[3] = { &way.x, &way.y, &way.z };
    float visible;
    rf_trace_segments( tracer, 1, o, d, &visible );
    return visible > 0.0f;
}

// Rays onto the faces of a turned box, from inside: what leaves a hit must see the middle (acne if not), and
// nothing outside (a leak if it does). At scales of 1e-12 to 1e12, and far from the origin.
static HardInput acne_and_leaks( void )
{
    HardInput out = { 0 };
    long acne = 0, leaks = 0, hits = 0;
    for ( int s = -12; s <= 12; s += 4 )
    {
        for ( int moved = 0; moved < 2; ++moved )
        {
            HardScene h = { 0 };
            SceneBuilder b = { 0 };
            uint32_t grey = add_material( &b, hard_grey() );
            add_box( &b, grey, rf_vec3( -1, -1, -1 ), rf_vec3( 1, 1, 1 ), true );
            for ( uint32_t i = 0; i < b.scene.triangles.vertex_count; ++i ) // turned about two axes
            {
                float *p = b.scene.triangles.positions + 3 * (size_t)i, x = p[0], y = p[1];
                p[0] = 0.8f * x - 0.6f * y;
                p[1] = 0.6f * x + 0.8f * y;
                y = p[1];
                p[1] = 0.28f * y - 0.96f * p[2];
                p[2] = 0.96f * y + 0.28f * p[2];
            }
            h.scene = finish_scene( &b );
            float scale = powf( 10.0f, (float)s );
            RfVec3 shift = rf_scale( rf_vec3( 300, -100, 200 ), moved ? scale : 0.0f );
            hard_move( &h, scale, shift );
            AUTO_TRACER tracer = make_tracer( &h.scene );
            for ( uint32_t i = 0; i < HARD_MANY / 40; ++i )
            {
                RfVec3 d =
                    rf_normalize( rf_vec3( hard_even( i, 0 ) - 0.5f, hard_even( i, 1 ) - 0.5f, hard_even( i, 2 ) - 0.5f ) );
                RfVec3 from =
                    rf_add( shift, rf_scale( rf_vec3( 0.3f * hard_even( i, 3 ), 0.3f * hard_even( i, 4 ), 0 ), scale ) );
                const float *o[3] = { &from.x, &from.y, &from.z }, *way[3] = { &d.x, &d.y, &d.z };
                uint32_t triangle;
                float u, v;
                rf_trace_nearest( tracer, 1, o, way, false, &triangle, &u, &v );
                if ( triangle == RF_MISS )
                {
                    leaks += 1;
                    continue;
                }
                RfTriangleRecord place;
                const RfTriangleRecord* t = rf_triangle_record( tracer, triangle, &place );
                RfHitPoint hit = rf_hit_point( t, u, v, from, d );
                RfVec3 start = rf_madd( hit.p, t->ng, hit.offset );
                hits += 1;
                acne += !reaches( tracer, start, shift ) || !reaches( tracer, shift, start );
                leaks += reaches( tracer, start, rf_madd( shift, d, 4.0f * scale ) );
            }
            rf_destroy_scene( &h.scene );
        }
    }
    out.holds = acne == 0 && leaks == 0 && hits > HARD_MANY / 8;
    HARD_TELL( "%ld hits at scales of 1e-12 to 1e12: %ld with acne, %ld leaks", hits, acne, leaks );
}

// f of the sharpest lobes near their middle, as the formula in doubles has it for the same floats.
static HardInput sharp_lobes( void )
{
    HardInput out = { .holds = true };
    double worst[2] = { 0.0, 0.0 };
    int close = 0, drawn = 0;
    for ( uint32_t i = 0; i < HARD_MANY; ++i )
    {
        bool phong = i % 2 == 0;
        RfVec3 n = rf_normalize( rf_vec3( hard_even( i, 0 ) - 0.5f, hard_even( i, 1 ) + 0.2f, hard_even( i, 2 ) - 0.5f ) ), t, b;
        rf_basis( n, &t, &b );
        RfVec3 wo = rf_normalize( rf_madd( rf_madd( n, t, 2.0f * hard_even( i, 3 ) ), b, hard_even( i, 4 ) ) );
        float exponent = 1e7f, alpha = RF_MIN_ALPHA, spread = phong ? 5e-4f : 2e-3f, zero = 0.0f, one = 1.0f;
        RfVec3 mirror = rf_sub( rf_scale( n, 2.0f * rf_dot( n, wo ) ), wo ),
               jitter = rf_madd( rf_scale( t, hard_even( i, 5 ) - 0.5f ), b, hard_even( i, 6 ) - 0.5f );
        RfVec3 wi = rf_normalize( rf_madd( mirror, jitter, spread ) );
        RfBsdfLanes lanes = { .n = { &n.x, &n.y, &n.z } };
        for ( int p = 0; p < 3; ++p )
        {
            lanes.param[RF_PARAM_DIFFUSE + p] = &zero;
            lanes.param[RF_PARAM_SPECULAR + p] = &one;
        }
        lanes.param[RF_PARAM_SHAPE] = phong ? &exponent : &alpha;
        lanes.param[RF_PARAM_F90] = lanes.param[RF_PARAM_COAT_F90] = lanes.param[RF_PARAM_COAT_F0] = &one;
        const float *o[3] = { &wo.x, &wo.y, &wo.z }, *d[3] = { &wi.x, &wi.y, &wi.z };
        float f[3], pdf, *to[3] = { f, f + 1, f + 2 };
        rf_bsdf_evaluate( phong ? RF_BSDF_PHONG : RF_BSDF_GGX, 1, &lanes, o, d, to, &pdf );
        // |n x h|2 and what is along n, for h = wo + wi
        double N[3] = { (double)n.x, (double)n.y, (double)n.z }, O[3] = { (double)wo.x, (double)wo.y, (double)wo.z };
        double I[3] = { (double)wi.x, (double)wi.y, (double)wi.z }, C[3], across = 0.0, length2 = 0.0, cos_o = 0.0, cos_i = 0.0;
        for ( int k = 0; k < 3; ++k )
        {
            int k1 = ( k + 1 ) % 3, k2 = ( k + 2 ) % 3;
            C[k] = N[k1] * ( O[k2] + I[k2] ) - N[k2] * ( O[k1] + I[k1] );
            across += C[k] * C[k];
            length2 += ( O[k] + I[k] ) * ( O[k] + I[k] );
            cos_o += N[k] * O[k];
            cos_i += N[k] * I[k];
        }
        double exact, a2 = (double)alpha * (double)alpha;
        if ( phong )
            exact = 1e7 / ( 2.0 * 3.14159265358979324 ) *
                    exp( 1e7 * log1p( -0.5 * ( across + ( cos_i - cos_o ) * ( cos_i - cos_o ) ) ) );
        else
        {
            double q = length2 / ( a2 * ( cos_o + cos_i ) * ( cos_o + cos_i ) + across );
            double so = sqrt( a2 + ( 1.0 - a2 ) * cos_o * cos_o ), si = sqrt( a2 + ( 1.0 - a2 ) * cos_i * cos_i );
            exact = a2 * q * q / 3.14159265358979324 * 0.5 / ( cos_o * si + cos_i * so );
        }
        worst[phong] = fmax( worst[phong], fabs( (double)f[0] / exact - 1.0 ) );
        if ( !phong )
            continue;
        // 1 - cos of what is drawn around the normal: below 0.1 / n with probability 1 - exp(-0.1)
        float u0 = hard_even( i, 7 ), u1 = hard_even( i, 8 ), u2 = 0.5f;
        const float *u[3] = { &u0, &u1, &u2 }, *above[3] = { &n.x, &n.y, &n.z };
        RfVec3 in;
        float* to_wi[3] = { &in.x, &in.y, &in.z };
        rf_bsdf_sample( RF_BSDF_PHONG, 1, &lanes, above, u, to_wi );
        double c0 = N[1] * (double)in.z - N[2] * (double)in.y, c1 = N[2] * (double)in.x - N[0] * (double)in.z,
               c2 = N[0] * (double)in.y - N[1] * (double)in.x;
        close += 0.5 * ( c0 * c0 + c1 * c1 + c2 * c2 ) < 0.1 / 1e7;
        drawn += 1;
    }
    double share = (double)close / drawn, due = 1.0 - exp( -0.1 );
    bool drawn_well = fabs( share - due ) < 5.0 * sqrt( due * ( 1.0 - due ) / drawn );
    out.holds = worst[0] < 1e-3 && worst[1] < 1e-3 && drawn_well;
    HARD_TELL(
        "%.1f million directions: GGX of alpha 1e-3 within %.2g, Phong of exponent 1e7 within %.2g, drawn near its middle %.4f "
        "(%.4f)",
        HARD_MANY / 1e6, worst[0], worst[1], share, due );
}

// The interval of random numbers that leads to each light must be as long as its probability says.
static HardInput light_intervals( void )
{
    HardInput out = { .holds = true };
    HardScene h = { .eye_count = 7 };
    hard_stage( &h, hard_grey() );
    SceneBuilder b = hard_reopen( &h.scene );
    for ( int i = 0; i < 40; ++i )
    {
        uint32_t light = add_material( &b, make_light( powf( 10.0f, -6.0f + 12.0f * (float)i / 39.0f ), true ) );
        RfVec3 p = rf_vec3( -1.5f + 0.08f * (float)( i * 7 % 40 ), 2.0f, 0.03f * (float)i );
        add_quad( &b, light, p, rf_add( p, rf_vec3( 0.03f, 0, 0 ) ), rf_add( p, rf_vec3( 0.03f, 0.03f, 0 ) ),
                  rf_add( p, rf_vec3( 0, 0.03f, 0 ) ) );
    }
    h.scene = finish_scene( &b );
    AUTO_TRACER tracer = make_tracer( &h.scene );
    const RfLights* lights = rf_tracer_lights( tracer );
    RfVec3 x = rf_vec3( 0.3f, 0.01f, 0.2f ), n = rf_vec3( 0, 1, 0 );
    double worst = 0.0;
    uint64_t u = 0, end = (uint64_t)1 << 53;
    int found = 0, due = 0;
    for ( ; u < end && found < 1000; ++found )
    {
        uint64_t low = u, high = end;
        uint32_t here =
            select_light( lights, RF_LIGHTS_BY_TREE, x, n, ( uint32_t[2] ){ (uint32_t)( u >> 21 ), (uint32_t)( u << 11 ) } )
                .light;
        while ( high - low > 1 ) // the last number that leads here, plus 1
        {
            uint64_t middle = low + ( high - low ) / 2;
            uint32_t there = select_light( lights, RF_LIGHTS_BY_TREE, x, n,
                                           ( uint32_t[2] ){ (uint32_t)( middle >> 21 ), (uint32_t)( middle << 11 ) } )
                                 .light;
            low = there == here ? middle : low;
            high = there == here ? high : middle;
        }
        double length = (double)( high - u ) * 0x1p-53,
               told = (double)rf_light_probability( lights, RF_LIGHTS_BY_TREE, here, x, n );
        worst = fmax( worst, fabs( length - told ) / fmax( told, 1e-9 ) );
        u = high;
    }
    for ( uint32_t k = 0; k < lights->count; ++k )
        due += rf_light_probability( lights, RF_LIGHTS_BY_TREE, k, x, n ) > 1e-13f;
    rf_destroy_scene( &h.scene );
    out.holds = worst < 1e-5 && found >= due && found < 1000;
    HARD_TELL( "%d lights of powers 1e12 apart: intervals as long as probabilities, within %.2g", found, worst );
}

const HardCase g_hard_transport[] = {
    { "acne-and-leaks", "rays that leave hits, at any scale", "offsets too small or too large", HARD_INPUT, 0, NULL,
      acne_and_leaks },
    { "sharp-lobes", "f of the sharpest lobes next to their middle", "sines of 1e-4 as differences of cosines", HARD_INPUT, 0,
      NULL, sharp_lobes },
    { "light-intervals", "a light tree whose powers differ by 1e12", "sums of importances in floats", HARD_INPUT, 0, NULL,
      light_intervals },
    { 0 },
};
