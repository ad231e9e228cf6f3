#include "light/tree.h"

// Cosines may be off by so much: less is no proof that nothing arrives.
#define COS_SLACK 1e-3f
#define LEAST 1e-37f // of what may arrive

// The cosine of what is left of angle a when b is taken off it, which ends at 0.
static inline float cos_of_rest( float cos_a, float sin_a, float cos_b, float sin_b )
{
    float rest = cos_a * cos_b + sin_a * sin_b;
    return cos_a > cos_b ? 1.0f : rest;
}

static inline float sine( float cosine ) { return sqrtf( rf_maxf( 1.0f - cosine * cosine, 0.0f ) ); }

void rf_weigh_lights( const RfLightNode* node, RfVec3 x, RfVec3 n, float weight[RF_LIGHT_CHILDREN] )
{
    const float *cx = node->center[0], *cy = node->center[1], *cz = node->center[2], *radius = node->radius;
    const float *ax = node->axis[0], *ay = node->axis[1], *az = node->axis[2], *two_sided = node->two_sided;
    const float *cos_spread = node->cos_spread, *sin_spread = node->sin_spread;
    const float *cos_emission = node->cos_emission, *intensity = node->intensity;
    const float* inverse_radius = node->inverse_radius;
    float* restrict out = weight;
#pragma omp simd
    for ( int k = 0; k < RF_LIGHT_CHILDREN; ++k )
    {
        float dx = cx[k] - x.x, dy = cy[k] - x.y, dz = cz[k] - x.z;
        float d2 = dx * dx + dy * dy + dz * dz, r2 = radius[k] * radius[k];
        float inverse = 1.0f / sqrtf( rf_maxf( d2, 1e-30f ) );
        // the ball as seen from x; from inside it is everywhere
        float sin_ball = rf_minf( radius[k] * inverse, 1.0f ), cos_outside = sine( sin_ball );
        float cos_ball = d2 > r2 ? cos_outside : -1.0f;
        // the least angle between x and an orientation of the lights
        float along = -( ax[k] * dx + ay[k] * dy + az[k] * dz ) * inverse;
        along = two_sided[k] > 0.0f ? fabsf( along ) : along;
        float across = sine( along ), cos_o = cos_spread[k], sin_o = sin_spread[k];
        float cos_rest = cos_of_rest( along, across, cos_o, sin_o ), sin_rest = across * cos_o - along * sin_o;
        sin_rest = along > cos_o ? 0.0f : sin_rest;
        float cos_light = cos_of_rest( cos_rest, sin_rest, cos_ball, sin_ball );
        // and between the ball and the normal
        float facing = ( n.x * dx + n.y * dy + n.z * dz ) * inverse;
        float cos_x = cos_of_rest( facing, sine( facing ), cos_ball, sin_ball );
        float arrives = rf_minf( rf_minf( cos_light - cos_emission[k] + COS_SLACK, cos_x + COS_SLACK ), intensity[k] );
        float near = rf_minf( inverse, inverse_radius[k] ); // no nearer than the ball is wide
        float w = intensity[k] * rf_maxf( cos_light, COS_SLACK ) * rf_maxf( cos_x, COS_SLACK ) * near * near;
        w = rf_maxf( w, LEAST );
        out[k] = arrives > 0.0f ? w : 0.0f;
    }
}
