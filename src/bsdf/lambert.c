// Lambert: f = ρ/π, sampled by the cosine, independent of wo.
#include "bsdf/lane.h"

RF_KERNEL void evaluate_lanes( int count, const RfBsdfLanes* lanes, const float* const wi[3], float* const f[3],
                               float* pdf_solid_angle )
{
    const RfLanes3 n = rf_lanes3( lanes->n ), diffuse = rf_lanes3( lanes->param + RF_PARAM_DIFFUSE ), in = rf_lanes3( wi );
    const RfLanesOut3 out = rf_lanes_out3( f );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        float cos_i = rf_dot( rf_at( n, i ), rf_at( in, i ) );
        if ( f != NULL )
            rf_put( out, i, rf_scale( rf_at( diffuse, i ), cos_i > 0.0f ? RF_INV_PI : 0.0f ) );
        if ( pdf_solid_angle != NULL )
            pdf_solid_angle[i] = rf_maxf( cos_i, 0.0f ) * RF_INV_PI;
    }
}

void rf_lambert_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                          float* const f[3], float* pdf_solid_angle )
{
    (void)wo;
    RF_FOR_OUTPUTS( evaluate_lanes, count, lanes, wi );
}

void rf_lambert_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                        float* const wi[3] )
{
    (void)wo;
    const RfLanes3 normal = rf_lanes3( lanes->n );
    const RfLanesOut3 out = rf_lanes_out3( wi );
    const float *u0 = u[0], *u1 = u[1];
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 n = rf_at( normal, i );
        // 1 − u is at least 2⁻²⁴: the direction is never tangential.
        RfVec3 w = rf_scale( rf_azimuth_direction( n, u1[i] ), sqrtf( u0[i] ) );
        rf_put( out, i, rf_madd( w, n, sqrtf( 1.0f - u0[i] ) ) );
    }
}
