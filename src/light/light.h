// The lights of a scene: emissive triangles, lights without size, the sky.
// Collected once; picked in proportion to what they may send to the point that is
// lit (light/tree.h), or to their power (alias table); triangles are sampled
// uniformly by area, the sky by direction.
#ifndef REFRAME_LIGHT_LIGHT_H
#define REFRAME_LIGHT_LIGHT_H

#include "light/sky.h"
#include "light/tree.h"
#include "reframe/render.h"
#include "scene/textured.h"

#include <stddef.h>

// An area light.
typedef struct RfLight
{
    RfVec3 p0, e1, e2;
    RfVec3 normal;   // unit, of the front
    RfVec3 radiance; // W/(m² sr); where textured about the mean: rf_light_radiance tells it at a point
    float pdf_area;  // density of its points, once it is picked: one over the area, 1/m²
    float area;
    float offset; // what lifts a point off it (rf_ray_offset)
    uint32_t triangle;
    bool two_sided;
    bool textured;
} RfLight;

// Picked by number: first the triangles, then the punctual lights, then the sky.
typedef struct RfLights
{
    uint32_t count; // of all
    uint32_t triangle_count;
    RfLight* light; // triangle_count of them
    int punctual_count;
    const RfPunctual* punctual; // the scene's own
    RfSky sky;
    RfVec3 center; // of a ball around the scene: what is beyond `radius` of it is as far as the sky
    float radius;
    float inverse_radius;
    RfLightTree tree;      // of all but the sky, in units of the ball; none where there are few lights
    float sky_scale;       // of the sky's irradiance, to compare with the tree's weights
    float* share;          // of each light in the power of all
    uint32_t* alias_share; // alias table, in units of 2⁻³²: below the share take the column, else its alias
    uint32_t* alias;
    uint32_t* of_triangle; // light of each triangle, or RF_NO_LIGHT; NULL without area lights
} RfLights;

// Fails with RF_ERROR_MEMORY only. A scene without emission gives count 0.
RfResult rf_collect_lights( const RfScene* scene, RfLights* lights, RfError* error );
void rf_destroy_lights( RfLights* lights );

static inline bool rf_has_sky( const RfLights* lights ) { return lights->sky.environment != NULL; }

// Radiance at the barycentrics (b1, b2) of an area light, as a light sample
// gets it: a blended light is met by other rays with the chance of its alpha,
// by light samples always.
static inline RfVec3 rf_light_radiance( const RfScene* scene, const RfLight* light, float b1, float b2 )
{
    if ( !light->textured )
        return light->radiance;
    const RfMaterial* m = scene->materials + scene->triangles.material[light->triangle];
    RfVec3 radiance = rf_emission_at( scene, m, light->triangle, b1, b2 );
    return rf_is_blended( m ) ? rf_scale( radiance, rf_opacity_at( scene, m, light->triangle, b1, b2 ) ) : radiance;
}

typedef struct RfLightSelection
{
    uint32_t light; // RF_NO_LIGHT: none of them can send anything
    float chance;
} RfLightSelection;

// A light for 64 random bits at the point x with unit normal n, which light
// arrives at from the side of n only. The chances depend on nothing else, so
// they are the same for all eyes that see x. `count` must not be 0.
RfLightSelection rf_select_light( const RfLights* lights, RfLightSampling picking, RfVec3 x, RfVec3 n, const uint32_t bits[2] );

// The same for arrays of points.
void rf_select_lights( const RfLights* lights, RfLightSampling picking, int count, const float* const x[3],
                       const float* const n[3], const uint32_t* const bits[2], RfLightSelection* pick );

// With which chance that picks this light; above 0 unless it can send nothing to x.
float rf_light_probability( const RfLights* lights, RfLightSampling picking, uint32_t light, RfVec3 x, RfVec3 n );

// The sky's number; there must be one.
static inline uint32_t rf_sky_number( const RfLights* lights ) { return lights->count - 1; }

// One word picks the column, the other decides between it and its alias, so that
// shares of the table are met to 2⁻³² however many lights there are.
static inline uint32_t rf_select_light_by_power( const RfLights* lights, uint32_t column_bits, uint32_t share_bits )
{
    uint32_t column = (uint32_t)( (uint64_t)column_bits * lights->count >> 32 );
    return share_bits < lights->alias_share[column] ? column : lights->alias[column];
}

#endif
