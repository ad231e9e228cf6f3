// Sheen over the metallic-roughness model (KHR_materials_sheen): the Charlie distribution of microfibres with the fit to its
// shadowing that the extension gives (Estevez and Kulla, Production Friendly Microfacet Sheen BRDF, 2017), over a base scaled by
// what the sheen leaves:
//
//   f = c N D / (4 μo μi (1 + Λ(μo) + Λ(μi))) + f_ggx min(1 − m E(μo), 1 − m E(μi))
//
// c is the colour, m its largest channel, E the directional albedo of white sheen. Below a roughness of 0.28 the fit to Λ is too
// small at grazing angles, and the lobe of the extension would reflect more than falls in, up to 3 times at a roughness of 0.07.
// N = min(1, N(μo), N(μi)) takes that back: N(μ) is at most 1 over that albedo, and 1 in all the rest of the lobe. Reciprocal.
// Energy-conserving to the error of E.
#include "bsdf/sheen.h"

#include "bsdf/lane.h"

#define INV_LOG2_LEAST_ROUGHNESS -0.2606542f // of RF_MIN_SHEEN_ALPHA

// What one direction decides, by its cosine.
typedef struct Side
{
    float lambda, limit, albedo; // Λ, N and E of white sheen
} Side;

// What the roughness decides for all directions: the fit of Λ, and polynomials of E.
typedef struct Shape
{
    float a, b, c, d, e, middle; // `middle`: 2 l(0.5)
    float roughness, inverse;
    float e0, e1, e2, e3, e4, e5, e6;
} Shape;

RF_KERNEL float mix( float of_one, float of_zero, float t ) { return of_one + ( of_zero - of_one ) * t; }

// log2 of Λ, or of its mirror image
RF_KERNEL float fit( const Shape* s, float x )
{
    float power = rf_exp2( s->c * rf_log2( x ) );
    return 1.44269504f * ( s->a / ( 1.0f + s->b * power ) + s->d * x + s->e );
}

RF_KERNEL float quintic( float x, float c0, float c1, float c2, float c3, float c4, float c5 )
{
    float x2 = x * x;
    return rf_fused( rf_fused( rf_fused( c5, x, c4 ), x2, rf_fused( c3, x, c2 ) ), x2, rf_fused( c1, x, c0 ) );
}

RF_KERNEL Shape shape_of( float alpha )
{
    float t = ( 1.0f - alpha ) * ( 1.0f - alpha );
    Shape s = { .a = mix( 21.5473f, 25.3245f, t ),
                .b = mix( 3.82987f, 3.32435f, t ),
                .c = mix( 0.19823f, 0.16801f, t ),
                .d = mix( -1.97760f, -1.27393f, t ),
                .e = mix( -4.32054f, -4.85967f, t ) };
    s.middle = 2.0f * fit( &s, 0.5f );
    s.roughness = sqrtf( alpha );
    s.inverse = 1.0f / s.roughness;
    float w = INV_LOG2_LEAST_ROUGHNESS * rf_log2( alpha ) - 1.0f; // −1 at a roughness of 1, 1 at the least
    s.e0 = quintic( w, 3.624239f, 3.252979f, 2.830061f, 0.004309f, 0.447096f, 0.658504f );
    s.e1 = quintic( w, -2.114729f, -3.306916f, -1.922190f, -4.203817f, -1.668788f, 1.175055f );
    s.e2 = quintic( w, 0.651470f, -0.033723f, 3.294183f, 5.945216f, -3.798936f, -5.624998f );
    s.e3 = quintic( w, 0.555654f, -6.188808f, -1.826193f, 29.899506f, 6.795920f, -17.035408f );
    s.e4 = quintic( w, -0.534783f, 1.739982f, -12.137941f, -1.777953f, 16.186873f, 7.854762f );
    s.e5 = quintic( w, -1.418558f, 22.689069f, -2.583344f, -68.188133f, -5.850931f, 41.452600f );
    s.e6 = quintic( w, -0.413197f, 15.999869f, 5.615095f, -44.448524f, -13.407899f, 22.587138f );
    return s;
}

// E is fitted to the albedo by quadrature, with an error of 0.005 at most (tests/bsdf/test_sheen.c), as N / (4 μ (3 + Λ)) times
// a decay at low roughness times a polynomial of cosine and roughness.
RF_KERNEL Side side_of( const Shape* s, float cos_theta )
{
    float mu = rf_minf( rf_maxf( cos_theta, 0.0f ), 1.0f );
    float near = rf_minf( mu, 1.0f - mu ), l = fit( s, near );
    Side side;
    side.lambda = rf_exp2( mu < 0.5f ? l : s->middle - l );
    float r = rf_minf( s->roughness, 0.5f ), x = mu * s->inverse;
    side.limit = rf_minf( 1.0f, ( 5.07f - 5.08f * r ) * r + mu * ( 4.145f + 10.47f * x ) );
    mu = rf_maxf( mu, RF_MIN_COS ); // as that of eyes; E is flat there
    float u = 2.0f * mu / ( mu + 0.5f * s->roughness ) - 1.0f;
    float polynomial = rf_fused( quintic( u, s->e1, s->e2, s->e3, s->e4, s->e5, s->e6 ), u, s->e0 );
    float decay = 1.0f + x * x * ( 1.0f / 9.0f ), decay2 = decay * decay;
    float albedo = side.limit * polynomial / ( 4.0f * mu * ( 3.0f + side.lambda ) * decay2 * decay2 );
    side.albedo = rf_minf( rf_maxf( albedo, 0.0f ), 1.0f );
    return side;
}

float rf_sheen_albedo( float cos_theta, float alpha )
{
    Shape shape = shape_of( alpha );
    return side_of( &shape, cos_theta ).albedo;
}

// Directions are drawn by 1 − μ = u^w: evenly at a roughness of 1, ever closer to the horizon below.
RF_KERNEL float spread( float roughness ) { return roughness * ( 2.0f - roughness ); }

// The probability of sampling the sheen, from the camera's cosine alone.
RF_KERNEL float sheen_probability( RfVec3 colour, float albedo, RfVec3 diffuse, RfVec3 specular )
{
    float sheen = rf_mean( colour ) * albedo;
    float below = ( 1.0f - rf_max_component( colour ) * albedo ) * rf_maxf( rf_mean( diffuse ) + rf_mean( specular ), 0.05f );
    return rf_minf( sheen / ( sheen + below ), 0.99f );
}

// Both directions of each lane, in a loop of its own (lane.h).
typedef struct SideBlock
{
    float fibres[RF_BLOCK];      // N / (4 μo μi (1 + Λ + Λ))
    float albedo[RF_BLOCK];      // the larger E
    float probability[RF_BLOCK]; // of sampling the sheen
    float cos_i[RF_BLOCK];
} SideBlock;

static void side_block( int count, const RfBsdfLanes* lanes, const RfEyeBlock* eyes, const float* const wi[3],
                        SideBlock* restrict block )
{
    const RfLanes3 n = rf_lanes3( lanes->n ), w = rf_lanes3( wi ), colour = rf_lanes3( lanes->param + RF_PARAM_SHEEN );
    const RfLanes3 diffuse = rf_lanes3( lanes->param + RF_PARAM_DIFFUSE ),
                   specular = rf_lanes3( lanes->param + RF_PARAM_SPECULAR );
    const float* alpha = lanes->param[RF_PARAM_SHEEN_ALPHA];
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        float cos_o = eyes->cos_o[i], mi = rf_dot( rf_at( n, i ), rf_at( w, i ) );
        Shape shape = shape_of( alpha[i] );
        Side o = side_of( &shape, cos_o ), in = side_of( &shape, mi );
        // 1e-12: what divides is never 0
        block->fibres[i] =
            rf_minf( o.limit, in.limit ) / ( 4.0f * cos_o * rf_maxf( mi, 1e-12f ) * ( 1.0f + o.lambda + in.lambda ) );
        block->albedo[i] = rf_maxf( o.albedo, in.albedo );
        block->probability[i] = sheen_probability( rf_at( colour, i ), o.albedo, rf_at( diffuse, i ), rf_at( specular, i ) );
        block->cos_i[i] = mi;
    }
}

RF_KERNEL void sheen_block( int count, const RfBsdfLanes* lanes, const RfEyeBlock* eyes, const SideBlock* sides,
                            const float* const wi[3], float* const f[3], float* pdf_solid_angle )
{
    const RfLanes3 n = rf_lanes3( lanes->n ), w = rf_lanes3( wi ), colour = rf_lanes3( lanes->param + RF_PARAM_SHEEN );
    const float* alpha = lanes->param[RF_PARAM_SHEEN_ALPHA];
    const RfLanesOut3 out = rf_lanes_out3( f );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        float cos_i = sides->cos_i[i], lit = cos_i > 0.0f ? 1.0f : 0.0f, mi = rf_minf( rf_maxf( cos_i, 0.0f ), 1.0f );
        if ( f != NULL )
        {
            // across n and along it: sin θ is no difference (see ggx.c)
            RfEyeLane eye = rf_eye_at( eyes, i );
            RfVec3 cross = rf_cross( rf_at( n, i ), rf_add( eye.wo, rf_at( w, i ) ) ), c = rf_at( colour, i );
            float along = eye.cos_o + mi, across2 = rf_dot( cross, cross ), inverse = 1.0f / alpha[i];
            // D = (2 + 1/α) sin^(1/α) θ / 2π
            float d = ( 2.0f + inverse ) * ( 0.5f * RF_INV_PI ) * rf_pow( across2 / ( along * along + across2 ), 0.5f * inverse );
            float lobe = lit * d * sides->fibres[i], below = 1.0f - rf_max_component( c ) * sides->albedo[i];
            rf_put( out, i,
                    rf_vec3( out.x[i] * below + c.x * lobe, out.y[i] * below + c.y * lobe, out.z[i] * below + c.z * lobe ) );
        }
        if ( pdf_solid_angle != NULL )
        {
            float inverse = 1.0f / spread( sqrtf( alpha[i] ) ), probability = sides->probability[i];
            float drawn = lit * ( 0.5f * RF_INV_PI ) * inverse * rf_pow_one_minus( mi, rf_maxf( inverse - 1.0f, 0.0f ) );
            pdf_solid_angle[i] = ( 1.0f - probability ) * pdf_solid_angle[i] + probability * drawn;
        }
    }
}

void rf_lay_sheen( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3], float* const f[3],
                   float* pdf_solid_angle )
{
    RfEyeBlock eyes;
    SideBlock sides;
    rf_lift_block( count, lanes->n, wo, &eyes );
    side_block( count, lanes, &eyes, wi, &sides );
    RF_FOR_OUTPUTS( sheen_block, count, lanes, &eyes, &sides, wi );
}

void rf_choose_sheen( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* u, float* u_below )
{
    RfEyeBlock eyes;
    rf_lift_block( count, lanes->n, wo, &eyes );
    const RfLanes3 diffuse = rf_lanes3( lanes->param + RF_PARAM_DIFFUSE ),
                   specular = rf_lanes3( lanes->param + RF_PARAM_SPECULAR );
    const RfLanes3 colour = rf_lanes3( lanes->param + RF_PARAM_SHEEN );
    const float* alpha = lanes->param[RF_PARAM_SHEEN_ALPHA];
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        Shape shape = shape_of( alpha[i] );
        Side o = side_of( &shape, eyes.cos_o[i] );
        float probability = sheen_probability( rf_at( colour, i ), o.albedo, rf_at( diffuse, i ), rf_at( specular, i ) );
        u_below[i] = rf_below_layer( u[i], probability );
    }
}

void rf_sample_sheen( int count, const RfBsdfLanes* lanes, const float* const u[3], const float* u_below, float* const wi[3] )
{
    const RfLanes3 normal = rf_lanes3( lanes->n );
    const RfLanesOut3 out = rf_lanes_out3( wi );
    const float *alpha = lanes->param[RF_PARAM_SHEEN_ALPHA], *u0 = u[0], *u1 = u[1];
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 n = rf_at( normal, i );
        float y = spread( sqrtf( alpha[i] ) ) * rf_log2( u0[i] );
        float sunk = rf_exp2( y ), mu = rf_one_minus_exp2( y );
        RfVec3 w = rf_madd( rf_scale( rf_azimuth_direction( n, u1[i] ), sqrtf( sunk * ( 1.0f + mu ) ) ), n, mu );
        bool chosen = u_below[i] < 0.0f;
        rf_put( out, i, rf_vec3( chosen ? w.x : out.x[i], chosen ? w.y : out.y[i], chosen ? w.z : out.z[i] ) );
    }
}
