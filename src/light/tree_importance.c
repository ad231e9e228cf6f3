#include "light/tree.h"

#define SLACK 1e-3f  // tolerance of cosines: only a light below −SLACK is certain to be under a horizon
#define LEAST 1e-37f // smallest importance of a child that can contribute

// How much the radius of a ball adds to the cosines of its centre; the least noise
// measured in halls of 10 to 1000 lamps.
#define WIDTH 0.2f

void rf_light_importance( const RfLightNode* node, RfVec3 x, RfVec3 n, float importance[RF_LIGHT_CHILDREN] )
{
    const float *cx = node->center[0], *cy = node->center[1], *cz = node->center[2];
    const float *radius = node->radius, *inverse_radius = node->inverse_radius;
    const float *ax = node->axis[0], *ay = node->axis[1], *az = node->axis[2], *flip = node->flip;
    const float *cos_turn = node->cos_turn, *sin_turn = node->sin_turn, *full = node->full, *intensity = node->intensity;
    float* restrict out = importance;
#pragma omp simd
    for ( int k = 0; k < RF_LIGHT_CHILDREN; ++k )
    {
        float dx = cx[k] - x.x, dy = cy[k] - x.y, dz = cz[k] - x.z;
        float d2 = dx * dx + dy * dy + dz * dz;
        float inverse = 1.0f / sqrtf( rf_maxf( d2, 1e-30f ) );
        // sine of the half angle of the ball as seen from x; inside, it covers everything
        float sin_ball = rf_minf( radius[k] * inverse, 1.0f );
        // cosines at the centre of the ball: of emission, and at x
        float along = -( ax[k] * dx + ay[k] * dy + az[k] * dz ) * inverse;
        along = rf_maxf( along, along * flip[k] );
        float across = sqrtf( rf_maxf( 1.0f - along * along, 0.0f ) );
        float turned = along * cos_turn[k] + across * sin_turn[k];
        float cos_light = along > full[k] ? 1.0f : turned;
        float cos_x = ( n.x * dx + n.y * dy + n.z * dz ) * inverse;
        // if both are above −sin_ball, some of the ball may be above both horizons
        float arrives = rf_minf( rf_minf( cos_light, cos_x ) + sin_ball + SLACK, intensity[k] );
        float spread = WIDTH * sin_ball + SLACK;
        cos_light = rf_maxf( cos_light, 0.0f ) + spread;
        cos_x = rf_maxf( cos_x, 0.0f ) + spread;
        float near = rf_minf( inverse, inverse_radius[k] ); // no nearer than its radius
        float w = rf_maxf( intensity[k] * cos_light * cos_x * ( near * near ), LEAST );
        out[k] = arrives > 0.0f ? w : 0.0f;
    }
}
