// Lambert: f = ρ/π, sampled by the cosine, independent of wo.
#include "bsdf/lane.h"

RF_KERNEL void evaluate_lanes( int count, const RfBsdfLanes* lanes, const float* const wi[3], float* const f[3],
                               float* pdf_solid_angle, bool want_f, bool want_pdf )
{
    const float* restrict nx = lanes->n[0], * restrict ny = lanes->n[1], * restrict nz = lanes->n[2];
    const float* restrict dx = lanes->param[RF_PARAM_DIFFUSE], * restrict dy = lanes->param[RF_PARAM_DIFFUSE + 1], * restrict dz = lanes->param[RF_PARAM_DIFFUSE + 2];
    const float* restrict ix = wi[0], * restrict iy = wi[1], * restrict iz = wi[2];
    float* restrict fx = want_f ? f[0] : NULL;
    float* restrict fy = want_f ? f[1] : NULL;
    float* restrict fz = want_f ? f[2] : NULL;
    float* restrict pdf = pdf_solid_angle;

#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        float cos_i = rf_dot( rf_vec3( nx[i], ny[i], nz[i] ), rf_vec3( ix[i], iy[i], iz[i] ) );
        if ( want_f )
        {
            float lit = cos_i > 0.0f ? RF_INV_PI : 0.0f;
            fx[i] = dx[i] * lit;
            fy[i] = dy[i] * lit;
            fz[i] = dz[i] * lit;
        }
        if ( want_pdf )
            pdf[i] = rf_maxf( cos_i, 0.0f ) * RF_INV_PI;
    }
}

void rf_lambert_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                          float* const f[3], float* pdf_solid_angle )
{
    (void)wo;
    if ( f != NULL && pdf_solid_angle != NULL )
        evaluate_lanes( count, lanes, wi, f, pdf_solid_angle, true, true );
    else if ( f != NULL )
        evaluate_lanes( count, lanes, wi, f, NULL, true, false );
    else if ( pdf_solid_angle != NULL )
        evaluate_lanes( count, lanes, wi, NULL, pdf_solid_angle, false, true );
}

void rf_lambert_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                        float* const wi[3] )
{
    (void)wo;
    const float* restrict nx = lanes->n[0], * restrict ny = lanes->n[1], * restrict nz = lanes->n[2];
    const float* restrict u0 = u[0], * restrict u1 = u[1];
    float* restrict ix = wi[0], * restrict iy = wi[1], * restrict iz = wi[2];

#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 n = rf_vec3( nx[i], ny[i], nz[i] );
        // 1 − u is at least 2⁻²⁴: the direction is never tangential.
        RfVec3 w = rf_scale( rf_azimuth_direction( n, u1[i] ), sqrtf( u0[i] ) );
        w = rf_madd( w, n, sqrtf( 1.0f - u0[i] ) );
        ix[i] = w.x;
        iy[i] = w.y;
        iz[i] = w.z;
    }
}
