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

// The direction to the camera is lifted to the horizon of the coat.
void rf_lay_coat( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3], float* const f[3],
                  float* pdf_solid_angle )
{
    RfEyeBlock eyes;
    rf_lift_block( count, lanes->param + RF_PARAM_CLEARCOAT_N, wo, &eyes );
    RF_FOR_OUTPUTS( coat_block, count, lanes, &eyes, wi );
}

void rf_choose_coat( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* u, float* u_below )
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

// Samples all lanes, and keeps those of the coat.
void rf_sample_coat( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3], const float* u_below,
                     float* const wi[3] )
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
