// The lights of a scene: emissive triangles, punctual lights, the environment. Collected once. One is selected in proportion to
// its estimated contribution at the shading point (light/tree.h), or to its power (alias table); triangles are then sampled
// uniformly by area, the environment by direction.
#ifndef REFRAME_LIGHT_LIGHT_H
#define REFRAME_LIGHT_LIGHT_H

#include "base/built_in.h"
#include "base/fault.h"
#include "light/sky.h"
#include "light/tree.h"
#include "reframe/render.h"
#include "scene/light_groups.h"
#include "scene/placement.h"
#include "scene/textured.h"

#include <stddef.h>

// The kinds of a light: X( NAME, name, needs light paths ). One more is a row here and its functions in light/emission.c, whose
// table has the other half of the name; the compiler then names what lacks it: rf_light_kind below, and the switches of
// path/direct.c and light_paths/light_paths.c. A punctual one is a value of RfPunctualKind (scene/scene.h) too, and read by
// gltf/gltf_light.c.
//
// A light needs light paths if little else finds its caustics: no ray hits a punctual one, and of the sky light paths carry
// small bright spots alone, such as the sun.
// clang-format off
#define RF_LIGHT_KINDS( X ) \
    X( TRIANGLE, triangle, false ) \
    X( POINT, point, true ) \
    X( SPOT, spot, true ) \
    X( DIRECTIONAL, directional, true ) \
    X( PLANE, plane, true ) \
    X( SKY, sky, true )
// clang-format on

typedef enum RfLightKind
{
#define RF_LIGHT_KIND( NAME, name, needs_light_paths ) RF_LIGHT_##NAME,
    RF_LIGHT_KINDS( RF_LIGHT_KIND )
#undef RF_LIGHT_KIND
} RfLightKind;

#define RF_ONE_MORE( NAME, name, needs_light_paths ) +1
enum
{
    RF_LIGHT_KIND_COUNT = RF_LIGHT_KINDS( RF_ONE_MORE ) // no value of RfLightKind, which switches would have to name
};
#undef RF_ONE_MORE

// Lights of a group of frames, by part. What holds in all its frames is part 0, or with light groups (scene/light_groups.h) one
// *base part* for each of them: part 0 is the last group's, parts 1, 2 … those of the others. Then come lamps that are dimmed: each
// has a part of its own, as far as there are parts, and a scale in each frame: what it sends is computed as it is at scale 1.
// All else is light of one frame alone, as it is in that, and of the base part RF_PART_OWN − part.
//
// Where nothing moves but punctual lights and the sky, what paths find of light of one frame is the same in all frames but for the
// light itself: they look it up as it is in each of them, and that of each frame is a part, too, with the scale 1 there and 0 in
// the others; of each light group that has such light.
#define RF_DIMMED_MOST 16
#define RF_FRAMES_MOST 9 // of a group whose frames have such parts
#define RF_PARTS_MOST 96
#define RF_PART_OWN 255
_Static_assert( RF_PARTS_MOST >= RF_LIGHT_GROUPS_MOST + RF_DIMMED_MOST + RF_FRAMES_MOST, "parts of one group by frame" );
_Static_assert( RF_PARTS_MOST < RF_PART_OWN - RF_LIGHT_GROUPS_MOST, "light of one frame" );

// Up to so many lights are selected by power: a lamp of two triangles needs no tree.
#define RF_FEW_LIGHTS 2

// An area light.
typedef struct RfLight
{
    RfVec3 p0, e1, e2;
    RfVec3 normal;   // unit, of the front
    RfVec3 radiance; // W/(m² sr); if textured, an estimate of the mean: see rf_light_radiance
    float pdf_area;  // density of its points, given the light: one over the area, 1/m²
    float area;
    float offset; // lifts points off the surface (rf_ray_offset)
    uint32_t triangle;
    bool two_sided;
    bool textured;
} RfLight;

// Lights are numbered: first the triangles, those that move after all others, then the punctual lights, then the sky.
typedef struct RfLights
{
    uint32_t count; // of all
    uint32_t triangle_count;
    RfLight* light; // triangle_count of them
    int punctual_count;
    const RfPunctual* punctual; // the scene's own
    RfSky sky;
    RfVec3 center; // of the bounding ball of the scene's triangles
    float radius;
    float inverse_radius;
    float reach;               // of a ball around center that holds what moves in the frames at hand, too; at least the radius
    RfLightTree tree;          // over all but the sky, in radii of the ball; empty where there are few lights
    float sky_scale;           // times the sky's irradiance: its importance in the unit of the tree's
    float* power_fraction;     // of each light: its power over that of all
    uint32_t* alias_threshold; // alias table, in units of 2⁻³²: below it the column is selected, else its alias
    uint32_t* alias;
    uint32_t* of_triangle;                     // light of each triangle, or RF_NO_LIGHT; NULL without area lights
    struct RfChangingLights* changing;         // what of them moves or changes (light/changing.h); NULL: nothing does
    const RfLightTree* second;                 // over what does, in the frames at hand; NULL: one tree is over all
    float tree_scale, second_scale;            // where there are two: times their importances, in a unit common with the sky's
    uint8_t* part;                             // of each light; NULL: all hold
    uint8_t* material_part;                    // of the triangles that have each material of the scene; set where `part` is
    bool any_own;                              // some light is of one frame alone
    bool all_own;                              // all is, but for lights without power
    int group_count;                           // of light groups: base parts are those below it; 0 or 1: part 0 alone
    int dimmed_count;                          // parts from 1 on
    int frame_count;                           // those behind them, by frame of the group; 0: light of one frame has none
    int frame_groups;                          // so many times, by light group
    uint8_t frame_group[RF_LIGHT_GROUPS_MOST]; // which of these a base part has
    uint8_t base_part[RF_PARTS_MOST + 1];      // of the light group that each part belongs to
    RfVec3 part_scale[RF_PARTS_MOST + 1];      // of each part, in the frame at hand; those of base parts are 1
} RfLights;

// Fails with RF_ERROR_MEMORY only. A scene without emission gives count 0.
RfResult rf_collect_lights( const RfScene* scene, RfLights* lights, RfError* error );
void rf_destroy_lights( RfLights* lights );

// Splits lights that hold by light groups, which `groups` may have none of: sets their base parts. Fails with RF_ERROR_MEMORY.
RfResult rf_split_lights( const RfScene* scene, const RfLightGroups* groups, RfLights* lights, RfError* error );
void rf_join_lights( RfLights* lights );

// The base part of a light group, and the group of a base part.
static inline int rf_part_of_group( int group, int count ) { return ( group + 1 ) % count; }
static inline int rf_group_of_part( int base, int count ) { return ( base + count - 1 ) % count; }
static inline bool rf_is_own_part( int part ) { return part > RF_PART_OWN - RF_LIGHT_GROUPS_MOST; }

static inline int rf_base_part( const RfLights* lights, int part )
{
    return rf_is_own_part( part ) ? RF_PART_OWN - part : lights->base_part[part];
}

static inline int rf_light_part( const RfLights* lights, uint32_t light )
{
    int part = lights->part != NULL ? lights->part[light] : 0;
    return RF_FAULT( own_lights ) && rf_is_own_part( part ) ? RF_PART_OWN - part : part;
}

static inline int rf_material_part( const RfLights* lights, int32_t material )
{
    return lights->part != NULL ? lights->material_part[material] : 0;
}

// What the light of a part is multiplied by in the frame at hand.
static inline RfVec3 rf_part_scale( const RfLights* lights, int part )
{
    return part == 0 || rf_is_own_part( part ) ? rf_vec3( 1, 1, 1 ) : lights->part_scale[part];
}

static inline bool rf_has_sky( const RfLights* lights )
{
    return rf_calls_for( lights->sky.environment != NULL, RF_EFFECT_ENVIRONMENT );
}

// The punctual light of this number, which must be one.
static inline const RfPunctual* rf_punctual_light( const RfLights* lights, uint32_t light )
{
    return lights->punctual + ( light - lights->triangle_count );
}

static inline bool rf_needs_light_paths( RfLightKind kind )
{
#define RF_NEEDS( NAME, name, needs_light_paths ) [RF_LIGHT_##NAME] = needs_light_paths,
    static const bool needs[] = { RF_LIGHT_KINDS( RF_NEEDS ) };
#undef RF_NEEDS
    return needs[kind];
}

static inline RfLightKind rf_light_kind( const RfLights* lights, uint32_t light )
{
    _Static_assert( RF_LIGHT_KIND_COUNT == 6, "numbers of lights: what is neither a triangle nor punctual counts as the sky" );
    if ( light < lights->triangle_count )
        return RF_LIGHT_TRIANGLE;
    if ( rf_calls_for( light - lights->triangle_count < (uint32_t)lights->punctual_count, RF_EFFECT_PUNCTUAL_LIGHTS ) )
    {
        switch ( rf_punctual_light( lights, light )->kind )
        {
            case RF_PUNCTUAL_POINT: return RF_LIGHT_POINT;
            case RF_PUNCTUAL_SPOT: return RF_LIGHT_SPOT;
            case RF_PUNCTUAL_DIRECTIONAL: return RF_LIGHT_DIRECTIONAL;
            case RF_PUNCTUAL_PLANE: return RF_LIGHT_PLANE;
        }
    }
    return RF_LIGHT_SKY;
}

// Radiance at the barycentrics (b1, b2) of an area light, as seen by a light
// sample: other rays hit a blended light with the probability of its alpha,
// light samples always do.
static inline RfVec3 rf_light_radiance( const RfScene* scene, const RfLight* light, float b1, float b2 )
{
    if ( !light->textured )
        return light->radiance;
    const RfMaterial* m = scene->materials + rf_material_of( scene, light->triangle );
    RfVec3 radiance = rf_emission_at( scene, m, light->triangle, b1, b2 );
    return rf_is_blended( m ) ? rf_scale( radiance, rf_opacity_at( scene, m, light->triangle, b1, b2 ) ) : radiance;
}

typedef struct RfLightSelection
{
    uint32_t light; // RF_NO_LIGHT: none can contribute
    float probability;
} RfLightSelection;

// Selects lights by 64 random bits for points x with unit normals n, which are lit from the side of n only. The probabilities
// depend on nothing else, so they are the same for all cameras that see x. lights->count must not be 0.
void rf_select_lights( const RfLights* lights, RfLightSampling sampling, int count, const float* const x[3],
                       const float* const n[3], const uint32_t* const bits[2], RfLightSelection* selection );

// The probability of selecting this light; above 0 unless it cannot contribute at x.
float rf_light_probability( const RfLights* lights, RfLightSampling sampling, uint32_t light, RfVec3 x, RfVec3 n );

static inline uint32_t rf_sky_number( const RfLights* lights ) { return lights->count - 1; }

// One word selects the column, the other decides between it and its alias, so the
// table is accurate to 2⁻³² however many lights there are.
static inline uint32_t rf_select_light_by_power( const RfLights* lights, uint32_t column_bits, uint32_t threshold_bits )
{
    uint32_t column = (uint32_t)( (uint64_t)column_bits * lights->count >> 32 );
    return threshold_bits < lights->alias_threshold[column] ? column : lights->alias[column];
}

#endif
