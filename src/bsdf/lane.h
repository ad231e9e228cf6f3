// Shared by the models: what their loops need for one lane.
#ifndef REFRAME_BSDF_LANE_H
#define REFRAME_BSDF_LANE_H

#include "base/fault.h"
#include "bsdf/bsdf.h"
#include "math/fastmath.h"

#include <stdbool.h>
#include <stddef.h>

// A function call keeps a loop from being vectorised, so kernels must always be
// inlined.
#if defined( __GNUC__ )
#define RF_KERNEL static inline __attribute__( ( always_inline ) )
#else
#define RF_KERNEL static inline
#endif

// The functions of the table, and those of GGX with anisotropy and a film together.
RfBsdfEvaluate rf_lambert_evaluate, rf_phong_evaluate, rf_ggx_evaluate, rf_coated_evaluate, rf_sheen_evaluate,
    rf_anisotropic_evaluate, rf_iridescent_evaluate, rf_facets_evaluate, rf_layered_evaluate, rf_translucent_evaluate,
    rf_frosted_evaluate, rf_glass_evaluate, rf_spectral_evaluate;
RfBsdfSample rf_lambert_sample, rf_phong_sample, rf_ggx_sample, rf_coated_sample, rf_sheen_sample, rf_anisotropic_sample,
    rf_iridescent_sample, rf_facets_sample, rf_layered_sample, rf_translucent_sample, rf_frosted_sample;
RfBsdfSampleWeighted rf_glass_sample, rf_spectral_sample;

typedef struct RfScattering
{
    RfVec3 f;
    float pdf_solid_angle;
} RfScattering;

// The functions of a model from the kernels `evaluate` and `sample` of its file, compiled for `of`.
#define RF_MODEL_FUNCTIONS( model, of )                                                                                          \
    void rf_##model##_evaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],         \
                                float* const f[3], float* pdf_solid_angle )                                                      \
    {                                                                                                                            \
        evaluate( of, count, lanes, wo, wi, f, pdf_solid_angle );                                                                \
    }                                                                                                                            \
    void rf_##model##_sample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],            \
                              float* const wi[3] )                                                                               \
    {                                                                                                                            \
        sample( of, count, lanes, wo, u, wi );                                                                                   \
    }

// wo and its cosine; if below the shading horizon, lifted to it along n.
// The lifted length is never near 0: its part along n is RF_MIN_COS.
typedef struct RfEyeLane
{
    RfVec3 wo;
    float cos_o;
} RfEyeLane;

RF_KERNEL RfEyeLane rf_lift_to_horizon( RfVec3 n, RfVec3 wo )
{
    float missing = RF_FAULT( horizon ) ? 0.0f : RF_MIN_COS - rf_dot( n, wo );
    RfVec3 raised = rf_madd( wo, n, rf_maxf( missing, 0.0f ) );
    float inverse = 1.0f / sqrtf( rf_dot( raised, raised ) );
    float scale = missing > 0.0f ? inverse : 1.0f;
    return ( RfEyeLane ){ rf_scale( raised, scale ), rf_dot( n, raised ) * scale };
}

// Models get at most so many lanes at once. Their kernels are long dependency chains, longer than the processor can reorder: so
// they run as a few short loops over the lanes instead of a long one, first one that lifts all directions to the camera.
#define RF_BLOCK 256

// Three arrays of lanes: a vector or a colour.
typedef struct RfLanes3
{
    const float *x, *y, *z;
} RfLanes3;

RF_KERNEL RfLanes3 rf_lanes3( const float* const v[3] ) { return ( RfLanes3 ){ v[0], v[1], v[2] }; }

RF_KERNEL RfVec3 rf_at( RfLanes3 v, int i ) { return rf_vec3( v.x[i], v.y[i], v.z[i] ); }

typedef struct RfLanesOut3
{
    float *x, *y, *z;
} RfLanesOut3;

// `v` may be NULL.
RF_KERNEL RfLanesOut3 rf_lanes_out3( float* const v[3] )
{
    return v != NULL ? ( RfLanesOut3 ){ v[0], v[1], v[2] } : ( RfLanesOut3 ){ NULL, NULL, NULL };
}

RF_KERNEL void rf_put( RfLanesOut3 out, int i, RfVec3 v )
{
    out.x[i] = v.x;
    out.y[i] = v.y;
    out.z[i] = v.z;
}

// Ends a call of a kernel by its outputs `f` and `pdf_solid_angle`: NULL, those that are not asked for, are constants in it.
#define RF_FOR_OUTPUTS( kernel, ... )                                                                                            \
    do                                                                                                                           \
    {                                                                                                                            \
        if ( f != NULL && pdf_solid_angle != NULL )                                                                              \
            kernel( __VA_ARGS__, f, pdf_solid_angle );                                                                           \
        else if ( f != NULL )                                                                                                    \
            kernel( __VA_ARGS__, f, NULL );                                                                                      \
        else if ( pdf_solid_angle != NULL )                                                                                      \
            kernel( __VA_ARGS__, NULL, pdf_solid_angle );                                                                        \
    } while ( 0 )

typedef struct RfEyeBlock
{
    float x[RF_BLOCK], y[RF_BLOCK], z[RF_BLOCK], cos_o[RF_BLOCK];
} RfEyeBlock;

RF_KERNEL RfEyeLane rf_eye_at( const RfEyeBlock* eyes, int i )
{
    return ( RfEyeLane ){ rf_vec3( eyes->x[i], eyes->y[i], eyes->z[i] ), eyes->cos_o[i] };
}

// Lifted to the horizon of the normals `normal`.
static inline void rf_lift_block( int count, const float* const normal[3], const float* const wo[3], RfEyeBlock* restrict block )
{
    const RfLanes3 n = rf_lanes3( normal ), o = rf_lanes3( wo );
#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfEyeLane eye = rf_lift_to_horizon( rf_at( n, i ), rf_at( o, i ) );
        block->x[i] = eye.wo.x;
        block->y[i] = eye.wo.y;
        block->z[i] = eye.wo.z;
        block->cos_o[i] = eye.cos_o;
    }
}

// The parameters that all opaque models with a lobe of GGX have.
typedef struct RfGgxLanes
{
    RfLanes3 n, diffuse, specular;
    const float *alpha, *f90, *coat_f0, *coat_f90;
} RfGgxLanes;

RF_KERNEL RfGgxLanes rf_ggx_lanes( const RfBsdfLanes* lanes )
{
    const float* const* p = lanes->param;
    return ( RfGgxLanes ){ rf_lanes3( lanes->n ),
                           rf_lanes3( p + RF_PARAM_DIFFUSE ),
                           rf_lanes3( p + RF_PARAM_SPECULAR ),
                           p[RF_PARAM_SHAPE],
                           p[RF_PARAM_F90],
                           p[RF_PARAM_COAT_F0],
                           p[RF_PARAM_COAT_F90] };
}

// The tangent at azimuth φ = 2πu around n: cos φ · t + sin φ · b.
RF_KERNEL RfVec3 rf_azimuth_direction( RfVec3 n, float u )
{
    RfVec3 t, b;
    float s, c;
    rf_basis( n, &t, &b );
    rf_sincos_2pi( u, &s, &c );
    return rf_madd( rf_scale( t, c ), b, s );
}

// The number for what is below a layer that is sampled with this probability by u, or −1 where it is the layer.
RF_KERNEL float rf_below_layer( float u, float probability )
{
    float below = rf_minf( ( u - probability ) / ( 1.0f - probability ), 0x1.fffffep-1f );
    return u < probability ? -1.0f : below;
}

RF_KERNEL RfVec3 rf_choose( bool first, RfVec3 a, RfVec3 b )
{
    return rf_vec3( first ? a.x : b.x, first ? a.y : b.y, first ? a.z : b.z );
}

// (1 − cos)⁵ of Schlick's Fresnel; rounding may have made the cosine exceed 1.
RF_KERNEL float rf_schlick_weight( float cos_theta )
{
    float m = rf_maxf( 1.0f - cos_theta, 0.0f ), m2 = m * m;
    return m2 * m2 * m;
}

RF_KERNEL float rf_mean( RfVec3 c ) { return ( c.x + c.y + c.z ) * ( 1.0f / 3.0f ); }

#endif
