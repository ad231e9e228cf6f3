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

// The functions of the table.
RfBsdfEvaluate rf_lambert_evaluate, rf_phong_evaluate, rf_ggx_evaluate, rf_coated_evaluate, rf_sheen_evaluate,
    rf_anisotropic_evaluate, rf_iridescent_evaluate, rf_layered_evaluate, rf_translucent_evaluate, rf_glass_evaluate,
    rf_spectral_evaluate;
RfBsdfSample rf_lambert_sample, rf_phong_sample, rf_ggx_sample, rf_coated_sample, rf_sheen_sample, rf_anisotropic_sample,
    rf_iridescent_sample, rf_layered_sample, rf_translucent_sample;
RfBsdfSampleWeighted rf_glass_sample, rf_spectral_sample;

typedef struct RfScattering
{
    RfVec3 f;
    float pdf_solid_angle;
} RfScattering;

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

// The kernels are long dependency chains, longer than the processor can reorder.
// So they run as a few short loops over a block of lanes instead of a long one:
// first all directions to the camera are lifted, then the rest follows.
#define RF_BLOCK 256

typedef struct RfEyeBlock
{
    float x[RF_BLOCK], y[RF_BLOCK], z[RF_BLOCK], cos_o[RF_BLOCK];
} RfEyeBlock;

static inline void rf_lift_block( int first, int count, const RfBsdfLanes* lanes, const float* const wo[3], RfEyeBlock* block )
{
    const float* restrict nx = lanes->n[0] + first, * restrict ny = lanes->n[1] + first;
    const float* restrict nz = lanes->n[2] + first;
    const float* restrict ox = wo[0] + first, * restrict oy = wo[1] + first, * restrict oz = wo[2] + first;
    float* restrict x = block->x, * restrict y = block->y, * restrict z = block->z, * restrict cos_o = block->cos_o;

#pragma omp simd
    for ( int i = 0; i < count; ++i )
    {
        RfEyeLane eye = rf_lift_to_horizon( rf_vec3( nx[i], ny[i], nz[i] ), rf_vec3( ox[i], oy[i], oz[i] ) );
        x[i] = eye.wo.x;
        y[i] = eye.wo.y;
        z[i] = eye.wo.z;
        cos_o[i] = eye.cos_o;
    }
}

// Number of lanes in the block that begins at `first`.
static inline int rf_block_size( int first, int count ) { return count - first < RF_BLOCK ? count - first : RF_BLOCK; }

// The tangent at azimuth φ = 2πu around n: cos φ · t + sin φ · b.
RF_KERNEL RfVec3 rf_azimuth_direction( RfVec3 n, float u )
{
    RfVec3 t, b;
    float s, c;
    rf_basis( n, &t, &b );
    rf_sincos_2pi( u, &s, &c );
    return rf_madd( rf_scale( t, c ), b, s );
}

RF_KERNEL float rf_mean( RfVec3 c ) { return ( c.x + c.y + c.z ) * ( 1.0f / 3.0f ); }

#endif
