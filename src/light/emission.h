// Light that leaves an emitter: the start of a light path, with its densities.
#ifndef REFRAME_LIGHT_EMISSION_H
#define REFRAME_LIGHT_EMISSION_H

#include "light/light.h"
#include "light/punctual.h"

// A ray that leaves a light. Triangles: a point on them and a direction on the side of `normal`; punctual lights: their
// position, or a point of those with size, and a direction; directional lights and the sky: a point on the disc that covers the scene's bounding ball,
// perpendicular to the direction in which the light travels, on the side where it comes from.
typedef struct RfEmission
{
    RfVec3 position;
    RfVec3 normal;     // unit: of the side of a triangle that emits, or of a ball; otherwise `direction`
    RfVec3 direction;  // unit, in which the light travels
    RfVec3 radiance;   // triangles, sky: W/(m² sr). Punctual: intensity towards `direction`, W/sr. Directional: irradiance of
                       // a surface that faces it, W/m²
    RfVec3 throughput; // radiance · cos / ( pdf_light · pdf_area · pdf_solid_angle ), cos = 1 unless a triangle: W
    float pdf_light;   // of selecting the light, by power, and its side: half as much for each of two
    float pdf_area;    // of the position: 1/m²; 1 where it is a delta
    float pdf_solid_angle;  // of the direction: 1/sr; 1 where it is a delta
    float offset;           // lifts the ray's origin off a triangle, along the normal (rf_ray_offset); else 0
    float range;            // of a punctual light, m; infinity: unlimited. The attenuation by range is not in `radiance`
    uint32_t light;         // its number
    const RfPunctual* soft; // such a lamp, or NULL
    bool delta_position;    // point and spot lights and planes, whose points are each a light
    bool delta_direction;   // directional lights
    bool infinite;          // directional lights and the sky
} RfEmission;

// Samples a ray. u: uniform in [0, 1): 0 and 1 select the light (and the side of a two-sided one), 2 and 3 what stays when
// a ray is steered (the point of a triangle, the direction of the sky), 4 and 5 what steers it (the direction; of infinite
// lights, the point of the disc). False: nothing is emitted there (a black texel, outside of a spot's cone).
bool rf_sample_emission( const RfLights* lights, const RfScene* scene, const float u[6], RfEmission* emission );

// Samples all but what steers the ray, from u[0] to u[3]: light, normal, offset, range, pdf_light, flags. Lights with a
// place: position and pdf_area; infinite ones: direction and pdf_solid_angle. For callers that steer rays themselves.
bool rf_sample_emitter( const RfLights* lights, const RfScene* scene, const float u[4], RfEmission* emission );

// The same of a light that was selected with this probability. `side`: a number of its own in [0, 1), for two-sided lights.
bool rf_sample_emitter_of( const RfLights* lights, const RfScene* scene, uint32_t light, float pdf_light, float side,
                           const float u[2], RfEmission* emission );

// The emission in another direction from the same place: sets direction, radiance, pdf_solid_angle, throughput. Not of
// infinite lights, whose emission does not depend on the place. False: nothing is emitted in that direction.
bool rf_emit_towards( const RfLights* lights, RfVec3 direction, RfEmission* emission );

// Sets pdf_light, pdf_area and pdf_solid_angle of a ray whose light, position and direction are given, as
// rf_sample_emission draws it; one of them is 0 if it never does. A delta is taken to be hit. For MIS.
void rf_find_emission_pdf( const RfLights* lights, RfEmission* emission );

// What is left of the throughput at this distance from a light whose range is limited; of a soft one, what a disc has of a ball's
// light where the ray first meets something. 1 for others.
static inline float rf_emission_falloff( const RfEmission* emission, RfVec3 first, float distance )
{
    float left = rf_range_falloff( distance * distance, emission->range );
    return emission->soft != NULL ? left * rf_soft_falloff( emission->soft, first ) : left;
}

// Luminance of a light's flux, W; of light from infinity through the scene's bounding ball; of a textured triangle an estimate.
double rf_light_power( const RfLights* lights, uint32_t light );

#endif
