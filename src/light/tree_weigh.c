#include "light/tree.h"

// Cosines may be off by so much: less is no proof that nothing arrives.
#define COS_SLACK 1e-3f
#define LEAST 1e-37f // of what may arrive

// The cosine of an angle that is taken off another one, which ends at 0.
static inline float cos_of_rest( float cos_a, float sin_a, float cos_b, float sin_b )
{
    return cos_a > cos_b ? 1.0f : cos_a * cos_b + sin_a * sin_b;
}

static inline float sine( float cosine ) { return sqrtf( rf_maxf( 1.0f - cosine * cosine, 0.0f ) ); }

void rf_weigh_lights( const RfLightNode* restrict node, RfVec3 x, RfVec3 n, float weight[RF_LIGHT_CHILDREN] )
{
    float* restrict out = weight;
#pragma omp simd
    for ( int k = 0; k < RF_LIGHT_CHILDREN; ++k )
    {
        RfVec3 d = rf_vec3( node->center[0][k] - x.x, node->center[1][k] - x.y, node->center[2][k] - x.z );
        float d2 = rf_dot( d, d ), r2 = node->radius[k] * node->radius[k];
        float inverse = 1.0f / sqrtf( rf_maxf( d2, 1e-30f ) );
        // the ball as seen from x; from inside it is everywhere
        float sin_ball = rf_minf( node->radius[k] * inverse, 1.0f );
        float cos_ball = d2 > r2 ? sine( sin_ball ) : -1.0f;
        float along = -( node->axis[0][k] * d.x + node->axis[1][k] * d.y + node->axis[2][k] * d.z ) * inverse;
        along = node->two_sided[k] > 0.0f ? fabsf( along ) : along;
        float across = sine( along ), cos_o = node->cos_spread[k], sin_o = node->sin_spread[k];
        // the least angle between x and an orientation of the lights
        float cos_rest = cos_of_rest( along, across, cos_o, sin_o );
        float sin_rest = along > cos_o ? 0.0f : across * cos_o - along * sin_o;
        float cos_light = cos_of_rest( cos_rest, sin_rest, cos_ball, sin_ball );
        // and between the ball and the normal
        float facing = rf_dot( n, d ) * inverse;
        float cos_x = cos_of_rest( facing, sine( facing ), cos_ball, sin_ball );
        int arrives = ( cos_light > node->cos_emission[k] - COS_SLACK ) & ( cos_x > -COS_SLACK ) & ( node->intensity[k] > 0.0f );
        float w = node->intensity[k] * rf_maxf( cos_light, COS_SLACK ) * rf_maxf( cos_x, COS_SLACK ) / rf_maxf( d2, r2 );
        out[k] = arrives ? rf_maxf( w, LEAST ) : 0.0f;
    }
}
