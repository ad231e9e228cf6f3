// The scattering models: what a material is made of, the parameters that are
// kept for each hit, and one table row per model. Everything that has to know
// of a new parameter or model is listed here; see README.md.
#ifndef REFRAME_BSDF_MODELS_H
#define REFRAME_BSDF_MODELS_H

#include "math/vec3.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// The order matters: hits are sorted by model. LAMBERT comes first, then the
// glossy models, then the specular ones.
typedef enum RfBsdfKind
{
    RF_BSDF_LAMBERT, // diffuse only: looks the same to every camera
    RF_BSDF_PHONG,   // Lambert + modified Phong lobe (Lafortune, Willems 1994)
    RF_BSDF_GGX,     // dielectric GGX coat over a Lambert base, or metal
    RF_BSDF_COATED,  // GGX under a clear coat (KHR_materials_clearcoat)
    RF_BSDF_GLASS,   // perfect mirrors; glass, smooth or rough
    RF_BSDF_KIND_COUNT
} RfBsdfKind;

#define RF_BSDF_FIRST_GLOSSY RF_BSDF_PHONG

// Models from this one on scatter along directions that no density of another
// camera covers (delta lobes, refraction): only the hit's own frame uses them.
#define RF_BSDF_FIRST_SPECULAR RF_BSDF_GLASS

// Reflectances are linear RGB in [0, 1].
typedef struct RfMaterial
{
    char* name;
    RfBsdfKind kind;
    RfVec3 diffuse;  // Lambert reflectance (GGX: of the base, times 1 − metallic)
    RfVec3 specular; // PHONG: lobe reflectance; GGX: reflectance at normal incidence F0;
                     // GLASS: F0 of the metallic fraction
    union
    {
        float exponent; // PHONG: n of cosⁿ, ≥ 0
        float alpha;    // GGX, COATED: roughness², in [RF_MIN_ALPHA, 1]; GLASS: likewise, or 0: smooth
    };
    float f90;             // GGX: reflectance at grazing incidence; GLASS: metallic fraction
    float coat_f0;         // GGX: Fresnel reflectance that the base loses, at normal and
    float coat_f90;        //      at grazing incidence (scalars: the largest channel);
                           // GLASS: the share of the surface that is base, and of that what has no coat
    float clearcoat;       // COATED: strength, 0 to 1
    float clearcoat_alpha; // COATED: roughness² of the coat, in [RF_MIN_ALPHA, 1]
    RfVec3 tint;           // GLASS: transmittance of the surface, times 1 − F; 0 for mirrors
    float ior;             // GLASS: of the inside, outside 1; 0: a mirror, Schlick's Fresnel from `specular`
    bool thin;             // GLASS: a wall without an inside: no refraction, no absorption
    RfVec3 absorption;     // GLASS: absorption coefficient of the inside, 1/m
    RfVec3 emission;       // radiance, W/(m² sr), on the front (on both sides if double_sided)
    bool double_sided;
    bool dims;                   // its emission changes: `emission` is the most of each channel, a pose has that of its time
    bool changes;                // something else of it does: only what moves (scene/movement.h) has it
    struct RfTextured* textured; // what varies over the surface (scene/textured.h); NULL: nothing
} RfMaterial;

// True of the surfaces that light paths follow: perfect mirrors and smooth glass with an inside, without textures.
static inline bool rf_is_chain_surface( const RfMaterial* m )
{
    return m->kind == RF_BSDF_GLASS && m->alpha == 0.0f && m->textured == NULL && !m->thin;
}

#define RF_PLATE_ALPHA 0.04f // roughness 0.2

// True of the metals that light paths of lamps without size follow, by facets: smooth enough to throw that light as a caustic, no
// textures.
static inline bool rf_is_plate( const RfMaterial* m )
{
    return m->kind == RF_BSDF_GGX && m->alpha <= RF_PLATE_ALPHA && m->textured == NULL && m->diffuse.x == 0.0f &&
           m->diffuse.y == 0.0f && m->diffuse.z == 0.0f;
}

// True of non-specular surfaces that scatter so widely that a direction drawn by the cosine serves as well as one drawn by the
// model. `shape`: Phong's exponent, or alpha.
static inline bool rf_is_matte( RfBsdfKind kind, float shape )
{
    return kind == RF_BSDF_LAMBERT || ( kind == RF_BSDF_GGX && shape >= 0.25f ) || ( kind == RF_BSDF_PHONG && shape <= 8.0f );
}

#define RF_MAX_CHAIN 8 // vertices of a chain that light paths follow

#define RF_MIN_ALPHA 1e-3f

// GGX lobes with a smaller alpha (roughness 0.1) are so narrow that directions of other paths do not fall into them.
#define RF_SMOOTH_ALPHA 0.01f

// Metals up to this alpha (roughness 0.32) throw caustics (path/own_light.h).
#define RF_CAUSTIC_ALPHA 0.1f

// Lobes with a smaller alpha (roughness 0.25) may mirror a lamp in few of a pixel's points.
#define RF_SHARP_ALPHA 0.0625f

// Parameters of a hit, one per float; colours and vectors take three in a row.
typedef enum RfBsdfParam
{
    RF_PARAM_DIFFUSE,
    RF_PARAM_SPECULAR = RF_PARAM_DIFFUSE + 3,
    RF_PARAM_SHAPE = RF_PARAM_SPECULAR + 3, // Phong's exponent, or alpha
    RF_PARAM_F90,
    RF_PARAM_COAT_F0,
    RF_PARAM_COAT_F90,
    RF_PARAM_CLEARCOAT,
    RF_PARAM_CLEARCOAT_ALPHA,
    RF_PARAM_CLEARCOAT_N, // unit shading normal of the coat, on the side of n
    RF_PARAM_TINT = RF_PARAM_CLEARCOAT_N + 3,
    RF_PARAM_IOR = RF_PARAM_TINT + 3, // of the far side over the near one; negative: thin wall; 0: mirror
    RF_PARAM_COUNT
} RfBsdfParam;

_Static_assert( RF_PARAM_COUNT <= 32, "a mask of parameters has 32 bits" );

// Masks of parameters: bit p is parameter p.
#define RF_PARAM_BIT( param ) ( 1u << ( param ) )
#define RF_PARAM_BITS3( param ) ( 7u << ( param ) )

// Not copied from the material but set by path/surface.c from the hit.
#define RF_PARAMS_OF_HIT ( RF_PARAM_BITS3( RF_PARAM_CLEARCOAT_N ) | RF_PARAM_BIT( RF_PARAM_IOR ) )

// A parameter as the material has it; not of those above.
static inline const float* rf_material_param( const RfMaterial* material, RfBsdfParam param )
{
#define FLOAT( param, member ) [param] = offsetof( RfMaterial, member )
#define COLOUR( param, member ) FLOAT( param, member.x ), FLOAT( ( param ) + 1, member.y ), FLOAT( ( param ) + 2, member.z )
    static const size_t s_offset[RF_PARAM_COUNT] = {
        COLOUR( RF_PARAM_DIFFUSE, diffuse ),
        COLOUR( RF_PARAM_SPECULAR, specular ),
        FLOAT( RF_PARAM_SHAPE, alpha ), // or exponent, in the same place
        FLOAT( RF_PARAM_F90, f90 ),
        FLOAT( RF_PARAM_COAT_F0, coat_f0 ),
        FLOAT( RF_PARAM_COAT_F90, coat_f90 ),
        FLOAT( RF_PARAM_CLEARCOAT, clearcoat ),
        FLOAT( RF_PARAM_CLEARCOAT_ALPHA, clearcoat_alpha ),
        COLOUR( RF_PARAM_TINT, tint ),
    };
#undef FLOAT
#undef COLOUR
    return (const float*)( (const char*)material + s_offset[param] );
}

// The shading normals and parameters of some hits: an array per parameter, of
// which a model reads those in its mask.
typedef struct RfBsdfLanes
{
    const float* n[3];
    const float* param[RF_PARAM_COUNT];
} RfBsdfLanes;

// See rf_bsdf_evaluate, rf_bsdf_sample and rf_bsdf_sample_weighted in bsdf.h.
typedef void RfBsdfEvaluate( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const wi[3],
                             float* const f[3], float* pdf_solid_angle );
typedef void RfBsdfSample( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                           float* const wi[3] );
typedef void RfBsdfSampleWeighted( int count, const RfBsdfLanes* lanes, const float* const wo[3], const float* const u[3],
                                   float* const wi[3], float* const weight[3], float* pdf_solid_angle );

RfBsdfEvaluate rf_lambert_evaluate, rf_phong_evaluate, rf_ggx_evaluate, rf_coated_evaluate, rf_glass_evaluate;
RfBsdfSample rf_lambert_sample, rf_phong_sample, rf_ggx_sample, rf_coated_sample;
RfBsdfSampleWeighted rf_glass_sample;

typedef struct RfBsdfModel
{
    const char* name;
    uint32_t params;
    RfBsdfEvaluate* evaluate;
    RfBsdfSample* sample;                  // NULL for specular models,
    RfBsdfSampleWeighted* sample_weighted; // which have this instead
} RfBsdfModel;

static inline const RfBsdfModel* rf_bsdf_model( RfBsdfKind kind )
{
    enum
    {
        LAMBERT = RF_PARAM_BITS3( RF_PARAM_DIFFUSE ),
        PHONG = LAMBERT | RF_PARAM_BITS3( RF_PARAM_SPECULAR ) | RF_PARAM_BIT( RF_PARAM_SHAPE ),
        GGX = PHONG | RF_PARAM_BIT( RF_PARAM_F90 ) | RF_PARAM_BIT( RF_PARAM_COAT_F0 ) | RF_PARAM_BIT( RF_PARAM_COAT_F90 ),
        COATED = GGX | RF_PARAM_BIT( RF_PARAM_CLEARCOAT ) | RF_PARAM_BIT( RF_PARAM_CLEARCOAT_ALPHA ) |
                 RF_PARAM_BITS3( RF_PARAM_CLEARCOAT_N ),
        GLASS = GGX | RF_PARAM_BITS3( RF_PARAM_TINT ) | RF_PARAM_BIT( RF_PARAM_IOR ),
    };
    static const RfBsdfModel s_models[RF_BSDF_KIND_COUNT] = {
        [RF_BSDF_LAMBERT] = { "lambert", LAMBERT, rf_lambert_evaluate, rf_lambert_sample, NULL },
        [RF_BSDF_PHONG] = { "phong", PHONG, rf_phong_evaluate, rf_phong_sample, NULL },
        [RF_BSDF_GGX] = { "ggx", GGX, rf_ggx_evaluate, rf_ggx_sample, NULL },
        [RF_BSDF_COATED] = { "coated", COATED, rf_coated_evaluate, rf_coated_sample, NULL },
        [RF_BSDF_GLASS] = { "glass", GLASS, rf_glass_evaluate, NULL, rf_glass_sample },
    };
    return s_models + kind;
}

static inline bool rf_has_param( uint32_t params, RfBsdfParam param ) { return ( params >> param & 1u ) != 0; }

// The lanes from `first` on of arrays, those that the model reads.
static inline RfBsdfLanes rf_bsdf_lanes( RfBsdfKind kind, const float* const n[3], const float* const param[RF_PARAM_COUNT],
                                         int first )
{
    RfBsdfLanes lanes = { .n = { n[0] + first, n[1] + first, n[2] + first } };
    uint32_t params = rf_bsdf_model( kind )->params;
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
        lanes.param[p] = rf_has_param( params, (RfBsdfParam)p ) ? param[p] + first : NULL;
    return lanes;
}

#endif
