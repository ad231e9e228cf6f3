// Light that leaves an emitter: the start of a light path, with its densities.
#ifndef REFRAME_LIGHT_EMISSION_H
#define REFRAME_LIGHT_EMISSION_H

#include "light/light.h"
#include "light/punctual.h"

// Light that leaves a light: triangles: from a point on them, on the side of `normal`; punctual lights: from their position, or
// a point of those with size; directional lights and the sky: from infinity, in a direction.
typedef struct RfEmission
{
    RfVec3 position;
    RfVec3 normal;    // unit: of the side of a triangle that emits, or of a ball; otherwise `direction`
    RfVec3 direction; // unit, in which the light travels
    RfVec3 radiance;  // triangles, sky: W/(m² sr). Punctual: intensity towards `direction`, W/sr. Directional: irradiance of
                      // a surface that faces it, W/m²
    float pdf_light;  // of selecting the light and its side: half as much for each of two
    float pdf_area;   // of the position: 1/m²; 1 where it is a delta; not at infinity
    float pdf_solid_angle;  // of the direction from infinity: 1/sr; 1 where it is a delta
    float offset;           // lifts the ray's origin off a triangle, along the normal (rf_ray_offset); else 0
    float range;            // of a punctual light, m; infinity: unlimited. The attenuation by range is not in `radiance`
    uint32_t light;         // its number
    const RfPunctual* soft; // such a lamp, or NULL
    bool delta_position;    // point and spot lights and planes, whose points are each a light
    bool delta_direction;   // directional lights
    bool infinite;          // directional lights and the sky
} RfEmission;

// Samples a light that was selected with this probability: lights with a place their position, infinite ones their direction.
// `side`: a number of its own in [0, 1), for two-sided lights. False: nothing is emitted there (a black texel).
bool rf_sample_emitter( const RfLights* lights, const RfScene* scene, uint32_t light, float pdf_light, float side,
                        const float u[2], RfEmission* emission );

// Sets the direction from a place, and the radiance there. Not of infinite lights. False: nothing is emitted in that direction.
bool rf_emit_towards( const RfLights* lights, RfVec3 direction, RfEmission* emission );

static inline bool rf_emits_from_both_sides( const RfLight* light )
{
    return rf_calls_for( light->two_sided, RF_EFFECT_TWO_SIDED_EMISSION );
}

// Sets pdf_light and pdf_area of an emissive triangle that is selected by power.
void rf_find_emission_pdf( const RfLights* lights, RfEmission* emission );

// What is left of the light at this distance where the range is limited; of a soft one, what a disc has of a ball's
// light where the ray first meets something. 1 for others.
static inline float rf_emission_falloff( const RfEmission* emission, RfVec3 first, float distance )
{
    float left = rf_range_falloff( distance * distance, emission->range );
    return emission->soft != NULL ? left * rf_soft_falloff( emission->soft, first ) : left;
}

typedef struct RfLightModel
{
    // Luminance of the flux over π, W, by which lights are selected where there is no tree; at infinity, the flux through the
    // scene's bounding ball. An estimate will do.
    double ( *selection_power )( const RfLights* lights, uint32_t light );
    // Bounds, cone and intensity for the light tree, in radii of the ball. NULL: it competes with the root of the tree.
    RfTreeLight ( *bound )( const RfLights* lights, uint32_t light );
    // rf_sample_emitter, after range, light and pdf_light have been set.
    bool ( *sample_emitter )( const RfLights* lights, const RfScene* scene, float side, const float u[2], RfEmission* e );
    // rf_emit_towards, after the direction has been set. NULL: at infinity.
    bool ( *emit )( const RfLights* lights, RfEmission* e );
} RfLightModel;

extern const RfLightModel g_rf_light_models[];

// The bounds of a triangle of this number, wherever it is.
RfTreeLight rf_bound_triangle( const RfLights* lights, const RfLight* light, uint32_t number );

static inline const RfLightModel* rf_light_model( const RfLights* lights, uint32_t light )
{
    return g_rf_light_models + rf_light_kind( lights, light );
}

#endif
