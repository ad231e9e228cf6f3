// A dielectric whose base scatters light to the side that it came from and to the other, Lambert both (KHR_materials_diffuse_transmission):
//
//   f = D G2 F / (4 μo μi) + ρ/π (1 − Fc(μo)) (1 − Fc(μi))      on the side of the light,
//   f = τ/π (1 − Fc(|μo|)) (1 − Fc(|μi|))                        on the other,
//
// D, G2, F and Fc as in GGX. A hit has drawn the side on which light arrives (RF_PARAM_CHOICE), the other one with the
// probability p, and n is on that side: it scatters the light of one hemisphere, over the probability of its side. So it is
// GGX with other reflectances, and where light arrives on the other side, seen as from the mirror image of wo.
#include "bsdf/lane.h"

// The lanes of GGX.
typedef struct Turned
{
    float diffuse[3][RF_BLOCK], specular[3][RF_BLOCK], f90[RF_BLOCK], wo[3][RF_BLOCK];
    const float* seen_from[3]; // wo
    RfBsdfLanes lanes;
} Turned;

static void turn( int count, const RfBsdfLanes* lanes, const float* const wo[3], Turned* restrict out )
{
    const RfLanes3 normal = rf_lanes3( lanes->n ), eye = rf_lanes3( wo ),
                   through_base = rf_lanes3( lanes->param + RF_PARAM_THROUGH );
    const RfLanes3 diffuse = rf_lanes3( lanes->param + RF_PARAM_DIFFUSE ),
                   specular = rf_lanes3( lanes->param + RF_PARAM_SPECULAR );
    const float *f90 = lanes->param[RF_PARAM_F90], *choice = lanes->param[RF_PARAM_CHOICE];
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 n = rf_at( normal, i ), o = rf_at( eye, i );
        RfVec3 d = rf_at( diffuse, i ), t = rf_at( through_base, i ), s = rf_at( specular, i );
        float through = choice[i] < 0.0f ? 1.0f : 0.0f, here = 1.0f - through;
        float p = rf_through_probability( t, d, s, f90[i] ), drawn = through > 0.0f ? p : 1.0f - p;
        float scale = drawn > 0.0f ? 1.0f / ( drawn > 0.0f ? drawn : 1.0f ) : 0.0f;
        RfVec3 base = rf_scale( rf_madd( rf_scale( d, here ), t, through ), scale );
        RfVec3 seen = rf_madd( o, n, RF_FAULT( mirrored_eye ) ? 0.0f : -2.0f * through * rf_dot( n, o ) );
        RF_PUT3( out->diffuse, i, base );
        out->specular[0][i] = s.x * here * scale;
        out->specular[1][i] = s.y * here * scale;
        out->specular[2][i] = s.z * here * scale;
        out->f90[i] = f90[i] * here * scale;
        RF_PUT3( out->wo, i, seen );
    }
    out->lanes = *lanes;
    for ( int c = 0; c < 3; ++c )
    {
        out->lanes.param[RF_PARAM_DIFFUSE + c] = out->diffuse[c];
        out->lanes.param[RF_PARAM_SPECULAR + c] = out->specular[c];
        out->seen_from[c] = out->wo[c];
    }
    out->lanes.param[RF_PARAM_F90] = out->f90;
}

void rf_translucent_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                              float* const f[3], float* pdf_solid_angle )
{
    Turned turned;
    turn( count, lanes, wo, &turned );
    rf_ggx_evaluate( count, &turned.lanes, turned.seen_from, wi, f, pdf_solid_angle );
}

void rf_translucent_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                            float* const wi[3] )
{
    Turned turned;
    turn( count, lanes, wo, &turned );
    rf_ggx_sample( count, &turned.lanes, turned.seen_from, u, wi );
}
