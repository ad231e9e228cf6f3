// A clear coat (GGX, Fresnel of an index of 1.5) over the metallic-roughness model,
// which is attenuated both ways by the transmission of the coat. Reciprocal and
// energy-conserving.
//
//   f = f_ggx (1 − c F(μo)) (1 − c F(μi)) + c D G2 F(wo·h) / (4 μo μi) · μi / (n·wi)
//
// The coat has its own shading normal, nc, which defines its μ: it may be smooth
// over bumps, or the other way round (then it is not quite reciprocal). The last
// factor, 1 where the two normals agree, cancels the cosine of the surface that
// callers multiply f by.
#include "base/fault.h"
#include "bsdf/coat.h"
#include "bsdf/lane.h"

#define COAT_F0 0.04f

RF_KERNEL float coat_fresnel( float cos_theta )
{
    float m = rf_maxf( 1.0f - cos_theta, 0.0f ), m2 = m * m;
    return COAT_F0 + ( 1.0f - COAT_F0 ) * ( m2 * m2 * m );
}

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

RF_KERNEL void coat_block( int first, int count, const RfBsdfLanes* lanes, const RfEyeBlock* eyes, const float* const wi[3],
                           float* const f[3], float* pdf_solid_angle )
{
    const float* restrict nx = lanes->n[0] + first, * restrict ny = lanes->n[1] + first, * restrict nz = lanes->n[2] + first;
    const float* restrict cx = lanes->param[RF_PARAM_CLEARCOAT_N] + first, * restrict cy =
                                                                               lanes->param[RF_PARAM_CLEARCOAT_N + 1] + first;
    const float* restrict cz = lanes->param[RF_PARAM_CLEARCOAT_N + 2] + first;
    const float* restrict dx = lanes->param[RF_PARAM_DIFFUSE] + first, * restrict dy = lanes->param[RF_PARAM_DIFFUSE + 1] + first;
    const float* restrict dz = lanes->param[RF_PARAM_DIFFUSE + 2] + first, * restrict sx =
                                                                               lanes->param[RF_PARAM_SPECULAR] + first;
    const float* restrict sy = lanes->param[RF_PARAM_SPECULAR + 1] + first, * restrict sz =
                                                                                lanes->param[RF_PARAM_SPECULAR + 2] + first;
    const float* restrict coat = lanes->param[RF_PARAM_CLEARCOAT] + first, * restrict alpha =
                                                                               lanes->param[RF_PARAM_CLEARCOAT_ALPHA] + first;
    const float* restrict ix = wi[0] + first, * restrict iy = wi[1] + first, * restrict iz = wi[2] + first;
    float* restrict fx = f != NULL ? f[0] + first : NULL;
    float* restrict fy = f != NULL ? f[1] + first : NULL;
    float* restrict fz = f != NULL ? f[2] + first : NULL;
    float* restrict pdf = pdf_solid_angle != NULL ? pdf_solid_angle + first : NULL;
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfEyeLane eye = { rf_vec3( eyes->x[i], eyes->y[i], eyes->z[i] ), eyes->cos_o[i] };
        RfVec3 in = rf_vec3( ix[i], iy[i], iz[i] );
        float surface_i = rf_dot( rf_vec3( nx[i], ny[i], nz[i] ), in );
        CoatLobe c = coat_lobe( rf_vec3( cx[i], cy[i], cz[i] ), eye, in, surface_i, coat[i], alpha[i] );
        if ( f != NULL )
        {
            fx[i] = fx[i] * c.below + c.f;
            fy[i] = fy[i] * c.below + c.f;
            fz[i] = fz[i] * c.below + c.f;
        }
        if ( pdf != NULL )
        {
            float probability =
                coat_probability( coat[i], eye.cos_o, rf_vec3( dx[i], dy[i], dz[i] ), rf_vec3( sx[i], sy[i], sz[i] ) );
            pdf[i] = ( 1.0f - probability ) * pdf[i] + probability * c.pdf_solid_angle;
        }
    }
}

// The direction to the camera, lifted to the horizon of the coat.
static void lift_to_coat( int first, int count, const RfBsdfLanes* lanes, const float* const wo[3], RfEyeBlock* eyes )
{
    RfBsdfLanes coat = { .n = { lanes->param[RF_PARAM_CLEARCOAT_N], lanes->param[RF_PARAM_CLEARCOAT_N + 1],
                                lanes->param[RF_PARAM_CLEARCOAT_N + 2] } };
    rf_lift_block( first, count, &coat, wo, eyes );
}

void rf_lay_coat( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3], float* const f[3],
                  float* pdf_solid_angle )
{
    for ( int first = 0; first < count; first += RF_BLOCK )
    {
        RfEyeBlock eyes;
        int size = rf_block_size( first, count );
        lift_to_coat( first, size, lanes, wo, &eyes );
        if ( f != NULL && pdf_solid_angle != NULL )
            coat_block( first, size, lanes, &eyes, wi, f, pdf_solid_angle );
        else if ( f != NULL )
            coat_block( first, size, lanes, &eyes, wi, f, NULL );
        else if ( pdf_solid_angle != NULL )
            coat_block( first, size, lanes, &eyes, wi, NULL, pdf_solid_angle );
    }
}

void rf_coated_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                         float* const f[3], float* pdf_solid_angle )
{
    rf_ggx_evaluate( count, lanes, wo, wi, f, pdf_solid_angle );
    rf_lay_coat( count, lanes, wo, wi, f, pdf_solid_angle );
}

static void choose_block( int first, int count, const RfBsdfLanes* lanes, const RfEyeBlock* eyes, const float* u, float* u_below )
{
    for ( int i = 0; i < count; ++i )
    {
        int k = first + i;
        RfVec3 diffuse = rf_vec3( lanes->param[RF_PARAM_DIFFUSE][k], lanes->param[RF_PARAM_DIFFUSE + 1][k],
                                  lanes->param[RF_PARAM_DIFFUSE + 2][k] );
        RfVec3 specular = rf_vec3( lanes->param[RF_PARAM_SPECULAR][k], lanes->param[RF_PARAM_SPECULAR + 1][k],
                                   lanes->param[RF_PARAM_SPECULAR + 2][k] );
        float probability = coat_probability( lanes->param[RF_PARAM_CLEARCOAT][k], eyes->cos_o[i], diffuse, specular );
        float below = rf_minf( ( u[k] - probability ) / ( 1.0f - probability ), 0x1.fffffep-1f );
        u_below[k] = u[k] < probability ? -1.0f : below;
    }
}

void rf_choose_coat( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* u, float* u_below )
{
    for ( int first = 0; first < count; first += RF_BLOCK )
    {
        RfEyeBlock eyes;
        int size = rf_block_size( first, count );
        lift_to_coat( first, size, lanes, wo, &eyes );
        choose_block( first, size, lanes, &eyes, u, u_below );
    }
}

// Samples all lanes, and keeps those of the coat.
static void sample_block( int first, int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                          const float* u_below, float* const wi[3] )
{
    float black[RF_BLOCK] = { 0 }, one[RF_BLOCK], x[RF_BLOCK], y[RF_BLOCK], z[RF_BLOCK];
    for ( int i = 0; i < RF_BLOCK; ++i )
        one[i] = 1.0f;
    RfBsdfLanes coat = rf_bsdf_lanes( RF_BSDF_GGX, lanes->n, lanes->param, first );
    coat.param[RF_PARAM_SHAPE] = lanes->param[RF_PARAM_CLEARCOAT_ALPHA] + first;
    for ( int c = 0; c < 3; ++c ) // a white metal: the specular lobe alone
    {
        coat.n[c] = lanes->param[RF_PARAM_CLEARCOAT_N + c] + first;
        coat.param[RF_PARAM_DIFFUSE + c] = black;
        coat.param[RF_PARAM_SPECULAR + c] = one;
    }
    const float* o[3] = { wo[0] + first, wo[1] + first, wo[2] + first };
    const float* random[3] = { u[0] + first, u[1] + first, black };
    float* const coat_out[3] = { x, y, z };
    rf_ggx_sample( count, &coat, o, random, coat_out );
    for ( int c = 0; c < 3; ++c )
    {
        for ( int i = 0; i < count; ++i )
            wi[c][first + i] = u_below[first + i] < 0.0f ? coat_out[c][i] : wi[c][first + i];
    }
}

void rf_sample_coat( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3], const float* u_below,
                     float* const wi[3] )
{
    for ( int first = 0; first < count; first += RF_BLOCK )
        sample_block( first, rf_block_size( first, count ), lanes, wo, u, u_below, wi );
}

void rf_coated_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                       float* const wi[3] )
{
    for ( int first = 0; first < count; first += RF_BLOCK )
    {
        float u_below[RF_BLOCK], u_base[RF_BLOCK];
        int size = rf_block_size( first, count );
        RfBsdfLanes block = rf_bsdf_lanes( RF_BSDF_COATED, lanes->n, lanes->param, first );
        const float* o[3] = { wo[0] + first, wo[1] + first, wo[2] + first };
        float* out[3] = { wi[0] + first, wi[1] + first, wi[2] + first };
        rf_choose_coat( size, &block, o, u[2] + first, u_below );
        for ( int i = 0; i < size; ++i )
            u_base[i] = rf_maxf( u_below[i], 0.0f );
        const float* random[3] = { u[0] + first, u[1] + first, u_base };
        rf_ggx_sample( size, &block, o, random, out );
        rf_sample_coat( size, &block, o, random, u_below, out );
    }
}
