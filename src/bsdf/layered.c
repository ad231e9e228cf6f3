// The models made of layers over GGX: a clear coat (KHR_materials_clearcoat), sheen, or any of coat, sheen, anisotropy and film
// together, of which those that a surface lacks have the strength 0.
#include "bsdf/sheen.h"

#include "base/fault.h"
#include "bsdf/lane.h"

// A clear coat (GGX, Fresnel of an index of 1.5) over the metallic-roughness model,
// which is attenuated both ways by the transmission of the coat. Reciprocal and
// energy-conserving.
//
//   f = f_ggx (1 − c F(μo)) (1 − c F(μi)) + c D G2 F(wo·h) / (4 μo μi) · μi / (n·wi)
//
// The coat has its own shading normal, nc, which defines its μ: it may be smooth
// over bumps, or bumpy over smooth (then it is not quite reciprocal). The last
// factor, 1 where the two normals agree, cancels the cosine of the surface that
// callers multiply f by.

#define COAT_F0 0.04f

RF_KERNEL float coat_fresnel( float cos_theta ) { return COAT_F0 + ( 1.0f - COAT_F0 ) * rf_schlick_weight( cos_theta ); }

// The probability of sampling the coat, from the camera's cosine alone.
RF_KERNEL float coat_probability( float clearcoat, float cos_o, RfVec3 diffuse, RfVec3 specular )
{
    float coat = clearcoat * coat_fresnel( cos_o );
    float below = ( 1.0f - coat ) * rf_maxf( rf_mean( diffuse ) + rf_mean( specular ), 0.05f );
    return coat / ( coat + below );
}

// The coat: its f, its transmission to what is below, its density.
typedef struct CoatLobe
{
    float f, below;
    float pdf_solid_angle;
} CoatLobe;

// n: of the coat; surface_i: n·wi of the surface below.
RF_KERNEL CoatLobe coat_lobe( RfVec3 n, RfEyeLane eye, RfVec3 wi, float surface_i, float clearcoat, float alpha )
{
    float cos_o = eye.cos_o, dot_i = rf_dot( n, wi );
    float cos_i = RF_FAULT( coat_horizon ) ? dot_i : rf_maxf( dot_i, 0.0f );
    // some directions are sampled below the coat's horizon, which need not be below
    // the surface's: they have a density, though f is 0
    float drawn = surface_i > 0.0f ? 1.0f : 0.0f;
    float lit = dot_i > 0.0f || RF_FAULT( coat_horizon ) ? drawn : 0.0f;
    drawn = cos_o + dot_i > 0.0f ? drawn : 0.0f;
    float turned = cos_i / rf_maxf( surface_i, 1e-12f );
    // along and across n separately, for sharp lobes (see ggx.c)
    float along = rf_maxf( cos_o + dot_i, 1e-12f );
    RfVec3 cross = rf_cross( n, rf_add( eye.wo, wi ) );
    float across2 = rf_dot( cross, cross ), length2 = along * along + across2;
    float alpha2 = alpha * alpha;
    float q = length2 / ( alpha2 * along * along + across2 );
    float d = alpha2 * RF_INV_PI * q * q;
    float so = sqrtf( alpha2 + ( 1.0f - alpha2 ) * cos_o * cos_o );
    float si = sqrtf( alpha2 + ( 1.0f - alpha2 ) * cos_i * cos_i );
    float fresnel = coat_fresnel( 0.5f * sqrtf( length2 ) );
    CoatLobe out = { 0 };
    out.f = lit * clearcoat * fresnel * 0.5f * d / ( cos_o * si + cos_i * so ) * turned;
    out.pdf_solid_angle = drawn * 0.5f * d / ( cos_o + so );
    out.below = ( 1.0f - clearcoat * coat_fresnel( cos_o ) ) * ( 1.0f - clearcoat * coat_fresnel( cos_i ) );
    return out;
}

RF_KERNEL void coat_block( int count, const RfBsdfLanes* lanes, const RfEyeBlock* eyes, const float* const wi[3],
                           float* const f[3], float* pdf_solid_angle )
{
    const RfLanes3 n = rf_lanes3( lanes->n ), coat_n = rf_lanes3( lanes->param + RF_PARAM_CLEARCOAT_N ), w = rf_lanes3( wi );
    const RfLanes3 diffuse = rf_lanes3( lanes->param + RF_PARAM_DIFFUSE ),
                   specular = rf_lanes3( lanes->param + RF_PARAM_SPECULAR );
    const float *coat = lanes->param[RF_PARAM_CLEARCOAT], *alpha = lanes->param[RF_PARAM_CLEARCOAT_ALPHA];
    const RfLanesOut3 out = rf_lanes_out3( f );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfEyeLane eye = rf_eye_at( eyes, i );
        RfVec3 in = rf_at( w, i );
        CoatLobe c = coat_lobe( rf_at( coat_n, i ), eye, in, rf_dot( rf_at( n, i ), in ), coat[i], alpha[i] );
        if ( f != NULL )
            rf_put( out, i, rf_vec3( out.x[i] * c.below + c.f, out.y[i] * c.below + c.f, out.z[i] * c.below + c.f ) );
        if ( pdf_solid_angle != NULL )
        {
            float probability = coat_probability( coat[i], eye.cos_o, rf_at( diffuse, i ), rf_at( specular, i ) );
            pdf_solid_angle[i] = ( 1.0f - probability ) * pdf_solid_angle[i] + probability * c.pdf_solid_angle;
        }
    }
}

// Makes f and density of what is below those of both; see rf_bsdf_evaluate.
// The direction to the camera is lifted to the horizon of the coat.
static void lay_coat( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3], float* const f[3],
                      float* pdf_solid_angle )
{
    RfEyeBlock eyes;
    rf_lift_block( count, lanes->param + RF_PARAM_CLEARCOAT_N, wo, &eyes );
    RF_FOR_OUTPUTS( coat_block, count, lanes, &eyes, wi );
}

// Chooses by u between the coat and what is below: u_below is u rescaled for the lobes there, or −1 where it is the coat.
static void choose_coat( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* u, float* u_below )
{
    RfEyeBlock eyes;
    rf_lift_block( count, lanes->param + RF_PARAM_CLEARCOAT_N, wo, &eyes );
    const RfLanes3 diffuse = rf_lanes3( lanes->param + RF_PARAM_DIFFUSE ),
                   specular = rf_lanes3( lanes->param + RF_PARAM_SPECULAR );
    const float* coat = lanes->param[RF_PARAM_CLEARCOAT];
    for ( int i = 0; i < count; ++i )
    {
        float probability = coat_probability( coat[i], eyes.cos_o[i], rf_at( diffuse, i ), rf_at( specular, i ) );
        u_below[i] = rf_below_layer( u[i], probability );
    }
}

// Directions of the coat, where it was chosen; elsewhere wi stays as it is.
// Samples all lanes, and keeps those of the coat.
static void sample_coat( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                         const float* u_below, float* const wi[3] )
{
    float black[RF_BLOCK] = { 0 }, one[RF_BLOCK], x[RF_BLOCK], y[RF_BLOCK], z[RF_BLOCK];
    for ( int i = 0; i < count; ++i )
        one[i] = 1.0f;
    RfBsdfLanes coat = *lanes;
    coat.param[RF_PARAM_SHAPE] = lanes->param[RF_PARAM_CLEARCOAT_ALPHA];
    for ( int c = 0; c < 3; ++c ) // a white metal: the specular lobe alone
    {
        coat.n[c] = lanes->param[RF_PARAM_CLEARCOAT_N + c];
        coat.param[RF_PARAM_DIFFUSE + c] = black;
        coat.param[RF_PARAM_SPECULAR + c] = one;
    }
    const float* random[3] = { u[0], u[1], black };
    float* const coat_out[3] = { x, y, z };
    rf_ggx_sample( count, &coat, wo, random, coat_out );
    for ( int c = 0; c < 3; ++c )
    {
        for ( int i = 0; i < count; ++i )
            wi[c][i] = u_below[i] < 0.0f ? coat_out[c][i] : wi[c][i];
    }
}

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

// Makes f and density of what is below those of both; see rf_bsdf_evaluate.
static void lay_sheen( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3], float* const f[3],
                       float* pdf_solid_angle )
{
    RfEyeBlock eyes;
    SideBlock sides;
    rf_lift_block( count, lanes->n, wo, &eyes );
    side_block( count, lanes, &eyes, wi, &sides );
    RF_FOR_OUTPUTS( sheen_block, count, lanes, &eyes, &sides, wi );
}

// Chooses by u between the sheen and what is below: u_below is u rescaled for the lobes there, or −1 where it is the sheen. Where
// a layer above has been chosen u is −1, and any number does.
static void choose_sheen( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* u, float* u_below )
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
        u_below[i] = rf_below_layer( rf_maxf( u[i], 0.0f ), probability );
    }
}

// Directions of the sheen, where it was chosen; elsewhere wi stays as it is.
static void sample_sheen( int count, const RfBsdfLanes* lanes, const float* const u[3], const float* u_below, float* const wi[3] )
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
        rf_put( out, i, rf_choose( u_below[i] < 0.0f, w, rf_vec3( out.x[i], out.y[i], out.z[i] ) ) );
    }
}

// The models.

// What is below, and the layers over it, from below.
typedef struct Layers
{
    RfBsdfEvaluate* evaluate;
    RfBsdfSample* sample;
    bool sheen, coat;
} Layers;

static const Layers s_coated = { rf_ggx_evaluate, rf_ggx_sample, false, true };
static const Layers s_sheen = { rf_ggx_evaluate, rf_ggx_sample, true, false };
static const Layers s_layered = { rf_facets_evaluate, rf_facets_sample, true, true };

RF_KERNEL void evaluate( Layers of, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                         float* const f[3], float* pdf_solid_angle )
{
    of.evaluate( count, lanes, wo, wi, f, pdf_solid_angle );
    if ( of.sheen )
        lay_sheen( count, lanes, wo, wi, f, pdf_solid_angle );
    if ( of.coat )
        lay_coat( count, lanes, wo, wi, f, pdf_solid_angle );
}

// All lobes are sampled, from the base on; those that were chosen are kept.
RF_KERNEL void sample( Layers of, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                       float* const wi[3] )
{
    float below_coat[RF_BLOCK], below_sheen[RF_BLOCK], left[RF_BLOCK];
    if ( of.coat )
        choose_coat( count, lanes, wo, u[2], below_coat );
    if ( of.sheen )
        choose_sheen( count, lanes, wo, of.coat ? below_coat : u[2], below_sheen );
    const float* below = of.sheen ? below_sheen : below_coat;
    for ( int i = 0; i < count; ++i )
        left[i] = rf_maxf( below[i], 0.0f ); // where a layer was chosen, any number does
    const float* random[3] = { u[0], u[1], left };
    of.sample( count, lanes, wo, random, wi );
    if ( of.sheen )
        sample_sheen( count, lanes, random, below_sheen, wi );
    if ( of.coat )
        sample_coat( count, lanes, wo, random, below_coat, wi );
}

RF_MODEL_FUNCTIONS( coated, s_coated )
RF_MODEL_FUNCTIONS( sheen, s_sheen )
RF_MODEL_FUNCTIONS( layered, s_layered )
