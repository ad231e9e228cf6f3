// Emissive triangles as area lights: collected once, picked in proportion to
// their power (alias table), sampled uniformly by area.
#ifndef REFRAME_LIGHT_LIGHT_H
#define REFRAME_LIGHT_LIGHT_H

#include "scene/scene.h"

typedef struct RfLight
{
    RfVec3 p0, e1, e2;
    RfVec3 normal;   // unit, of the front
    RfVec3 radiance; // W/(m² sr)
    float pdf_area;  // probability of the pick over the area: density of its points, 1/m²
    float area;
    uint32_t triangle;
    bool two_sided;
} RfLight;

typedef struct RfLights
{
    uint32_t count;
    RfLight* light;
    float* alias_share;    // alias table: below the share take the column, else its alias
    uint32_t* alias;
    uint32_t* of_triangle; // light of each triangle, or RF_NO_LIGHT; NULL without lights
} RfLights;

// Fails with RF_ERROR_MEMORY only. A scene without emission gives count 0.
RfResult rf_collect_lights( const RfScene* scene, RfLights* lights, RfError* error );
void rf_destroy_lights( RfLights* lights );

// The light for a uniform number in [0, 1). `count` must not be 0.
static inline uint32_t rf_pick_light( const RfLights* lights, float u )
{
    float scaled = u * (float)lights->count;
    uint32_t column = (uint32_t)scaled;
    column = column < lights->count ? column : lights->count - 1;
    return scaled - (float)column < lights->alias_share[column] ? column : lights->alias[column];
}

#endif
