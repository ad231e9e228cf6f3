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
    RfVec3 axis = rf_vec3( is_diffuse ? n.x : mirror.x, is_diffuse ? n.y : mirror.y, is_diffuse ? n.z : mirror.z );
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

static void angle_block( int first, int count, const RfBsdfLanes* lanes, const RfEyeBlock* eyes, const float* const wi[3],
                         AngleBlock* block )
{
    const float* restrict nx = lanes->n[0] + first, * restrict ny = lanes->n[1] + first;
    const float* restrict nz = lanes->n[2] + first;
    const float* restrict ox = eyes->x, * restrict oy = eyes->y, * restrict oz = eyes->z;
    const float* restrict cos_o = eyes->cos_o;
    const float* restrict ix = wi[0] + first, * restrict iy = wi[1] + first, * restrict iz = wi[2] + first;
    float* restrict cos_i = block->cos_i, * restrict d = block->d;

#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfVec3 n = rf_vec3( nx[i], ny[i], nz[i] ), w = rf_vec3( ix[i], iy[i], iz[i] );
        RfEyeLane eye = { rf_vec3( ox[i], oy[i], oz[i] ), cos_o[i] };
        cos_i[i] = rf_dot( n, w );
        d[i] = one_minus_cos_alpha( n, eye, w, cos_i[i] );
    }
}

RF_KERNEL void evaluate_block( int first, int count, const RfBsdfLanes* lanes, const AngleBlock* angles, float* const f[3],
                               float* pdf_solid_angle )
{
    const float* restrict dx = lanes->param[RF_PARAM_DIFFUSE] + first, * restrict dy = lanes->param[RF_PARAM_DIFFUSE + 1] + first;
    const float* restrict dz = lanes->param[RF_PARAM_DIFFUSE + 2] + first;
    const float* restrict sx = lanes->param[RF_PARAM_SPECULAR] + first, * restrict sy =
                                                                            lanes->param[RF_PARAM_SPECULAR + 1] + first;
    const float* restrict sz = lanes->param[RF_PARAM_SPECULAR + 2] + first;
    const float* restrict cos_i = angles->cos_i, * restrict d = angles->d;
    const float* restrict exponent = lanes->param[RF_PARAM_SHAPE] + first;
    float* restrict fx = f != NULL ? f[0] + first : NULL;
    float* restrict fy = f != NULL ? f[1] + first : NULL;
    float* restrict fz = f != NULL ? f[2] + first : NULL;
    float* restrict pdf = pdf_solid_angle != NULL ? pdf_solid_angle + first : NULL;

#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfScattering s = scatter( cos_i[i], d[i], rf_vec3( dx[i], dy[i], dz[i] ), rf_vec3( sx[i], sy[i], sz[i] ), exponent[i] );
        if ( f != NULL )
        {
            fx[i] = s.f.x;
            fy[i] = s.f.y;
            fz[i] = s.f.z;
        }
        if ( pdf != NULL )
            pdf[i] = s.pdf_solid_angle;
    }
}

void rf_phong_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                        float* const f[3], float* pdf_solid_angle )
{
    for ( int first = 0; first < count; first += RF_BLOCK )
    {
        RfEyeBlock eyes;
        AngleBlock angles;
        int size = rf_block_size( first, count );
        rf_lift_block( first, size, lanes, wo, &eyes );
        angle_block( first, size, lanes, &eyes, wi, &angles );
        if ( f != NULL && pdf_solid_angle != NULL )
            evaluate_block( first, size, lanes, &angles, f, pdf_solid_angle );
        else if ( f != NULL )
            evaluate_block( first, size, lanes, &angles, f, NULL );
        else if ( pdf_solid_angle != NULL )
            evaluate_block( first, size, lanes, &angles, NULL, pdf_solid_angle );
    }
}

static void sample_block( int first, int count, const RfBsdfLanes* lanes, const RfEyeBlock* eyes, const float* const u[3],
                          float* const wi[3] )
{
    const float* restrict nx = lanes->n[0] + first, * restrict ny = lanes->n[1] + first;
    const float* restrict nz = lanes->n[2] + first;
    const float* restrict dx = lanes->param[RF_PARAM_DIFFUSE] + first, * restrict dy = lanes->param[RF_PARAM_DIFFUSE + 1] + first;
    const float* restrict dz = lanes->param[RF_PARAM_DIFFUSE + 2] + first;
    const float* restrict sx = lanes->param[RF_PARAM_SPECULAR] + first, * restrict sy =
                                                                            lanes->param[RF_PARAM_SPECULAR + 1] + first;
    const float* restrict sz = lanes->param[RF_PARAM_SPECULAR + 2] + first;
    const float* restrict ox = eyes->x, * restrict oy = eyes->y, * restrict oz = eyes->z;
    const float* restrict cos_o = eyes->cos_o;
    const float* restrict u0 = u[0] + first, * restrict u1 = u[1] + first, * restrict u2 = u[2] + first;
    const float* restrict exponent = lanes->param[RF_PARAM_SHAPE] + first;
    float* restrict ix = wi[0] + first, * restrict iy = wi[1] + first, * restrict iz = wi[2] + first;

#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfEyeLane eye = { rf_vec3( ox[i], oy[i], oz[i] ), cos_o[i] };
        RfVec3 w = sample( rf_vec3( nx[i], ny[i], nz[i] ), eye, rf_vec3( u0[i], u1[i], u2[i] ), rf_vec3( dx[i], dy[i], dz[i] ),
                           rf_vec3( sx[i], sy[i], sz[i] ), exponent[i] );
        ix[i] = w.x;
        iy[i] = w.y;
        iz[i] = w.z;
    }
}

void rf_phong_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3], float* const wi[3] )
{
    for ( int first = 0; first < count; first += RF_BLOCK )
    {
        RfEyeBlock eyes;
        int size = rf_block_size( first, count );
        rf_lift_block( first, size, lanes, wo, &eyes );
        sample_block( first, size, lanes, &eyes, u, wi );
    }
}
