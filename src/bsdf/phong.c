// Modified Phong (Lafortune, Willems, Using the modified Phong reflectance model
// for physically based rendering, 1994): f = kd/π + ks (n+2)/(2π) cosⁿα, α from
// the mirror direction of wo to wi. One of the two lobes is sampled, with
// probabilities proportional to the means of kd and ks.
#include "base/fault.h"
#include "bsdf/lane.h"

// The probability of sampling the diffuse lobe.
RF_KERNEL float diffuse_probability( RfVec3 diffuse, RfVec3 specular )
{
    float d = rf_mean( diffuse );
    float sum = d + rf_mean( specular );
    float ratio = d / ( sum > 0.0f || RF_FAULT( no_lobe ) ? sum : 1.0f );
    return sum > 0.0f || RF_FAULT( no_lobe ) ? ratio : 1.0f;
}

// 1 − cos α = |wi − r|²/2, r the mirror direction. With h = wo + wi that
// difference is the part of h perpendicular to n plus (cos_i − cos_o) n. A dot
// product of wi and r would be off by 1e-7, a tenth of 1/n at n = 10⁶; this has a
// small relative error, and the same bits for wo and wi exchanged.
RF_KERNEL float one_minus_cos_alpha( RfVec3 n, RfEyeLane eye, RfVec3 wi, float cos_i )
{
    RfVec3 across = rf_cross( n, rf_add( eye.wo, wi ) );
    float along = cos_i - eye.cos_o;
    if ( RF_FAULT( phong_angle ) )
        return rf_maxf( 1.0f - rf_dot( rf_sub( rf_scale( n, 2.0f * eye.cos_o ), eye.wo ), wi ), 0.0f );
    return 0.5f * ( rf_dot( across, across ) + along * along );
}

RF_KERNEL RfScattering scatter( float cos_i, float d, RfVec3 diffuse, RfVec3 specular, float exponent )
{
    float power = rf_pow_one_minus( rf_minf( d, 1.0f ), exponent );
    // the lobe is limited to a hemisphere, also for n = 0
    power = d < 1.0f || RF_FAULT( hemisphere ) ? power * ( 0.5f * RF_INV_PI ) : 0.0f;
    power = cos_i > 0.0f ? power : 0.0f;
    float lit = cos_i > 0.0f ? RF_INV_PI : 0.0f;
    float probability = diffuse_probability( diffuse, specular );

    RfScattering result;
    result.f = rf_madd( rf_scale( diffuse, lit ), specular, ( exponent + 2.0f ) * power );
    result.pdf_solid_angle = probability * lit * cos_i + ( 1.0f - probability ) * ( exponent + 1.0f ) * power;
    return result;
}

RF_KERNEL RfVec3 sample( RfVec3 n, RfEyeLane eye, RfVec3 u, RfVec3 diffuse, RfVec3 specular, float exponent )
{
    RfVec3 mirror = rf_sub( rf_scale( n, 2.0f * eye.cos_o ), eye.wo );
    // The cosine lobe is a Phong lobe about n with exponent 1: the same code samples both.
    bool is_diffuse = u.z < diffuse_probability( diffuse, specular );
    RfVec3 axis = rf_choose( is_diffuse, n, mirror );
    float power = is_diffuse ? 1.0f : exponent;
    // cos α = (1 − u)^(1/(n+1)), computed as 1 − cos α, whose digits a sharp lobe needs.
    float logarithm = rf_log2( 1.0f - u.x ) / ( power + 1.0f );
    float d = RF_FAULT( phong_sample ) ? 1.0f - rf_exp2( logarithm ) : rf_one_minus_exp2( logarithm );
    d = rf_maxf( d, 0.0f );
    RfVec3 w = rf_scale( rf_azimuth_direction( axis, u.y ), sqrtf( d * ( 2.0f - d ) ) );
    return rf_madd( w, axis, 1.0f - d );
}

// Cosines of the directions; a separate loop for the same reason as rf_lift_block.
typedef struct AngleBlock
{
    float cos_i[RF_BLOCK], d[RF_BLOCK];
} AngleBlock;

static void angle_block( int count, const RfBsdfLanes* lanes, const RfEyeBlock* eyes, const float* const wi[3],
                         AngleBlock* restrict block )
{
    const RfLanes3 normal = rf_lanes3( lanes->n ), in = rf_lanes3( wi );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 n = rf_at( normal, i ), w = rf_at( in, i );
        float cos_i = rf_dot( n, w );
        block->cos_i[i] = cos_i;
        block->d[i] = one_minus_cos_alpha( n, rf_eye_at( eyes, i ), w, cos_i );
    }
}

RF_KERNEL void evaluate_block( int count, const RfBsdfLanes* lanes, const AngleBlock* angles, float* const f[3],
                               float* pdf_solid_angle )
{
    const RfLanes3 diffuse = rf_lanes3( lanes->param + RF_PARAM_DIFFUSE ),
                   specular = rf_lanes3( lanes->param + RF_PARAM_SPECULAR );
    const float* exponent = lanes->param[RF_PARAM_SHAPE];
    const RfLanesOut3 out = rf_lanes_out3( f );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfScattering s = scatter( angles->cos_i[i], angles->d[i], rf_at( diffuse, i ), rf_at( specular, i ), exponent[i] );
        if ( f != NULL )
            rf_put( out, i, s.f );
        if ( pdf_solid_angle != NULL )
            pdf_solid_angle[i] = s.pdf_solid_angle;
    }
}

void rf_phong_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                        float* const f[3], float* pdf_solid_angle )
{
    RfEyeBlock eyes;
    AngleBlock angles;
    rf_lift_block( count, lanes->n, wo, &eyes );
    angle_block( count, lanes, &eyes, wi, &angles );
    RF_FOR_OUTPUTS( evaluate_block, count, lanes, &angles );
}

void rf_phong_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3], float* const wi[3] )
{
    RfEyeBlock eyes;
    rf_lift_block( count, lanes->n, wo, &eyes );
    const RfLanes3 n = rf_lanes3( lanes->n ), random = rf_lanes3( u );
    const RfLanes3 diffuse = rf_lanes3( lanes->param + RF_PARAM_DIFFUSE ),
                   specular = rf_lanes3( lanes->param + RF_PARAM_SPECULAR );
    const float* exponent = lanes->param[RF_PARAM_SHAPE];
    const RfLanesOut3 out = rf_lanes_out3( wi );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
        rf_put( out, i,
                sample( rf_at( n, i ), rf_eye_at( &eyes, i ), rf_at( random, i ), rf_at( diffuse, i ), rf_at( specular, i ),
                        exponent[i] ) );
}
