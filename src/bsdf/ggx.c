// Metallic-roughness: an isotropic GGX lobe (Walter et al. 2007) with
// height-correlated Smith shadowing (Heitz 2014) and Schlick's Fresnel, over a
// Lambert base attenuated both ways by the transmission of a smooth coat:
//
//   f = D G2 F / (4 μo μi) + ρ/π (1 − Fc(μo)) (1 − Fc(μi))
//
// Reciprocal and energy-conserving. One of the two lobes is sampled; the specular
// one by visible normals.
#include "base/fault.h"
#include "bsdf/lane.h"

typedef struct Parameters
{
    RfVec3 diffuse, f0;
    float alpha, f90, coat_f0, coat_f90;
} Parameters;

RF_KERNEL Parameters parameters_at( const RfGgxLanes* in, int i )
{
    return ( Parameters ){ rf_at( in->diffuse, i ), rf_at( in->specular, i ), in->alpha[i], in->f90[i],
                           in->coat_f0[i],          in->coat_f90[i] };
}

RF_KERNEL float coat_transmission( const Parameters* p, float weight )
{
    return 1.0f - ( p->coat_f0 + ( p->coat_f90 - p->coat_f0 ) * weight );
}

// The probability of sampling the specular lobe, from Schlick's weight of μo.
RF_KERNEL float specular_probability( const Parameters* p, float weight )
{
    float f0 = rf_mean( p->f0 );
    float specular = f0 + ( p->f90 - f0 ) * weight;
    float base = rf_mean( p->diffuse ) * coat_transmission( p, weight );
    float sum = specular + base;
    float ratio = specular / ( sum > 0.0f ? sum : 1.0f );
    return sum > 0.0f ? ratio : 1.0f;
}

RF_KERNEL RfScattering scatter( RfVec3 n, RfEyeLane eye, RfVec3 wi, Parameters p )
{
    float cos_o = eye.cos_o;
    float dot_i = rf_dot( n, wi );
    float cos_i = rf_maxf( dot_i, 0.0f );

    // The half vector h stays unnormalised; its components along and across n are
    // computed separately. For α = 10⁻³ the whole lobe has 1 − cos²θ < 10⁻⁵: the
    // difference would keep two digits only, |n × h|² keeps them all.
    float along = cos_o + cos_i;
    RfVec3 half = rf_add( eye.wo, wi ), cross = rf_cross( n, half );
    float across2 = RF_FAULT( ggx_across ) ? rf_dot( half, half ) - along * along : rf_dot( cross, cross );
    float length2 = along * along + across2;

    // D = α² / (π (α² cos²θ + sin²θ)²)
    float alpha2 = p.alpha * p.alpha;
    float q = length2 / ( alpha2 * along * along + across2 );
    float d = alpha2 * RF_INV_PI * q * q;

    // Smith: G1(μ) = 2μ / (μ + s), G2 = 2 μo μi / (μo si + μi so)
    float so = sqrtf( alpha2 + ( 1.0f - alpha2 ) * cos_o * cos_o );
    float si = sqrtf( alpha2 + ( 1.0f - alpha2 ) * cos_i * cos_i );
    float lobe = 0.5f * d / ( cos_o * si + cos_i * so ); // D G2 / (4 μo μi)

    // wo · h = |wo + wi| / 2
    float weight_h = rf_schlick_weight( 0.5f * sqrtf( length2 ) );
    float weight_o = rf_schlick_weight( cos_o );
    float weight_i = rf_schlick_weight( cos_i );
    float base = RF_INV_PI * ( coat_transmission( &p, weight_o ) * coat_transmission( &p, weight_i ) );

    float lit = dot_i > 0.0f ? 1.0f : 0.0f;
    lobe *= lit;
    base *= lit;
    float constant = lobe * ( 1.0f - weight_h );
    float grazing = lobe * weight_h * p.f90;
    RfScattering result;
    result.f.x = p.f0.x * constant + grazing + p.diffuse.x * base;
    result.f.y = p.f0.y * constant + grazing + p.diffuse.y * base;
    result.f.z = p.f0.z * constant + grazing + p.diffuse.z * base;

    float probability = specular_probability( &p, weight_o );
    float visible = lit * 0.5f * d / ( cos_o + so ); // D G1(μo) / (4 μo)
    result.pdf_solid_angle = probability * visible + ( 1.0f - probability ) * ( cos_i * RF_INV_PI );
    return result;
}

// Samples a visible normal, not normalised (Dupuy, Benyoub, Sampling Visible GGX
// Normals with Spherical Caps, 2023: the distribution of Heitz, JCGT 2018, without
// a second frame). Everything is split along n and across it: the height z of the
// cap, measured from −Vz, and 1 − z² are sums and products of positive terms, so
// nothing cancels for sharp lobes or grazing views, and no normal lies below the
// surface.
RF_KERNEL RfVec3 sample_normal( RfVec3 n, RfEyeLane eye, RfVec3 azimuth, float u, float alpha )
{
    RfVec3 across = rf_madd( eye.wo, n, -eye.cos_o );
    float across2 = alpha * alpha * rf_dot( across, across );
    float inverse = 1.0f / sqrtf( across2 + eye.cos_o * eye.cos_o );
    float one_plus_vz = 1.0f + eye.cos_o * inverse;
    float height = ( 1.0f - u ) * one_plus_vz;                                          // z + Vz
    float radius = sqrtf( u * ( height * one_plus_vz + across2 * inverse * inverse ) ); // √(1 − z²)
    RfVec3 h = rf_madd( rf_scale( azimuth, radius ), across, alpha * inverse );
    return rf_madd( rf_scale( h, alpha ), n, height );
}

RF_KERNEL RfVec3 sample( RfVec3 n, RfEyeLane eye, RfVec3 azimuth, float u, float u_lobe, Parameters p )
{
    RfVec3 h = sample_normal( n, eye, azimuth, u, p.alpha );
    RfVec3 mirrored = rf_sub( rf_scale( h, 2.0f * rf_dot( eye.wo, h ) / rf_dot( h, h ) ), eye.wo );
    RfVec3 base = rf_madd( rf_scale( azimuth, sqrtf( u ) ), n, sqrtf( 1.0f - u ) );
    bool is_specular = u_lobe < specular_probability( &p, rf_schlick_weight( eye.cos_o ) );
    return rf_choose( is_specular, mirrored, base );
}

RF_KERNEL void evaluate_block( int count, const RfBsdfLanes* lanes, const RfEyeBlock* eyes, const float* const wi[3],
                               float* const f[3], float* pdf_solid_angle )
{
    const RfGgxLanes given = rf_ggx_lanes( lanes );
    const RfLanes3 in = rf_lanes3( wi );
    const RfLanesOut3 out = rf_lanes_out3( f );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfScattering s = scatter( rf_at( given.n, i ), rf_eye_at( eyes, i ), rf_at( in, i ), parameters_at( &given, i ) );
        if ( f != NULL )
            rf_put( out, i, s.f );
        if ( pdf_solid_angle != NULL )
            pdf_solid_angle[i] = s.pdf_solid_angle;
    }
}

void rf_ggx_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3], float* const f[3],
                      float* pdf_solid_angle )
{
    RfEyeBlock eyes;
    rf_lift_block( count, lanes->n, wo, &eyes );
    RF_FOR_OUTPUTS( evaluate_block, count, lanes, &eyes, wi );
}

// A separate loop for the same reason as rf_lift_block.
typedef struct AzimuthBlock
{
    float x[RF_BLOCK], y[RF_BLOCK], z[RF_BLOCK];
} AzimuthBlock;

static void azimuth_block( int count, const RfBsdfLanes* lanes, const float* u, AzimuthBlock* restrict block )
{
    const RfLanes3 n = rf_lanes3( lanes->n );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 azimuth = rf_azimuth_direction( rf_at( n, i ), u[i] );
        block->x[i] = azimuth.x;
        block->y[i] = azimuth.y;
        block->z[i] = azimuth.z;
    }
}

void rf_ggx_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3], float* const wi[3] )
{
    RfEyeBlock eyes;
    AzimuthBlock azimuths;
    rf_lift_block( count, lanes->n, wo, &eyes );
    azimuth_block( count, lanes, u[1], &azimuths );
    const RfGgxLanes given = rf_ggx_lanes( lanes );
    const RfLanesOut3 out = rf_lanes_out3( wi );
    const float *u0 = u[0], *u2 = u[2];
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 azimuth = rf_vec3( azimuths.x[i], azimuths.y[i], azimuths.z[i] );
        rf_put( out, i, sample( rf_at( given.n, i ), rf_eye_at( &eyes, i ), azimuth, u0[i], u2[i], parameters_at( &given, i ) ) );
    }
}
