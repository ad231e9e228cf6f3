// The scattering models: what a material is made of, the parameters that are
// kept for each hit, and one table row per model. Everything that has to know
// of a new parameter or model is listed here; see README.md.
#ifndef REFRAME_BSDF_MODELS_H
#define REFRAME_BSDF_MODELS_H

#include "base/built_in.h"
#include "math/vec3.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// The order matters: hits are sorted by model. LAMBERT comes first, then the
// glossy models, then the specular ones.
typedef enum RfBsdfKind
{
    RF_BSDF_LAMBERT,     // diffuse only: looks the same to every camera
    RF_BSDF_PHONG,       // Lambert + modified Phong lobe (Lafortune, Willems 1994)
    RF_BSDF_GGX,         // dielectric GGX coat over a Lambert base, or metal
    RF_BSDF_COATED,      // GGX under a clear coat (KHR_materials_clearcoat)
    RF_BSDF_SHEEN,       // GGX under sheen (KHR_materials_sheen)
    RF_BSDF_ANISOTROPIC, // GGX with two roughnesses (KHR_materials_anisotropy)
    RF_BSDF_IRIDESCENT,  // GGX with a thin film (KHR_materials_iridescence)
    RF_BSDF_LAYERED,     // any of coat, sheen, anisotropy and film together
    RF_BSDF_TRANSLUCENT, // GGX whose base also scatters to the other side (KHR_materials_diffuse_transmission)
    RF_BSDF_FROSTED,     // rough glass at first hits that the frames of a group share; materials are RF_BSDF_GLASS
    RF_BSDF_GLASS,       // perfect mirrors; glass, smooth or rough
    RF_BSDF_SPECTRAL,    // glass with dispersion or a thin film (KHR_materials_dispersion, _iridescence)
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
        float alpha;    // roughness², in [RF_MIN_ALPHA, 1]; GLASS: 0 is smooth
    };
    float f90;             // GGX: reflectance at grazing incidence; GLASS: metallic fraction
    float coat_f0;         // GGX: Fresnel reflectance that the base loses, at normal and
    float coat_f90;        //      at grazing incidence (scalars: the largest channel);
                           // GLASS: the share of the surface that is base, and of that what has no coat
    float clearcoat;       // COATED: strength, 0 to 1
    float clearcoat_alpha; // COATED: roughness² of the coat, in [RF_MIN_ALPHA, 1]
    union
    {
        RfVec3 tint;    // GLASS: transmittance of the surface, times 1 − F; 0 for mirrors
        RfVec3 through; // TRANSLUCENT: reflectance of the base to the other side; `diffuse` has what is left for this side
    };
    float ior; // GLASS: of the inside, outside 1; 0: a mirror, Schlick's Fresnel from `specular`
    bool thin; // GLASS: a wall without an inside: no refraction, no absorption
    bool double_sided;
    uint16_t light_group; // of what it emits: 1 + its number in the scene's list; 0: none
    RfVec3 absorption;    // GLASS: absorption coefficient of the inside, 1/m
    RfVec3 sheen;         // SHEEN, LAYERED: colour; 0: none
    float sheen_alpha;    // SHEEN, LAYERED: roughness² of the sheen, in [RF_MIN_SHEEN_ALPHA, 1]
    float anisotropy;     // ANISOTROPIC, LAYERED: strength, 0 to 1: alpha along the tangent is alpha + (1 − alpha) strength²
    float stretch_x;      // ANISOTROPIC, LAYERED: the direction along which highlights are stretched, across the scratches:
    float stretch_y;      //      unit vector by tangent and bitangent
    float film;           // IRIDESCENT, LAYERED, SPECTRAL: strength of the thin film, 0 to 1
    float film_ior;       // its index of refraction
    float film_thickness; // nm
    float dispersion;     // SPECTRAL: 20 over the Abbe number; 0: none
    RfVec3 emission;      // radiance, W/(m² sr), on the front (on both sides if double_sided)
    // in 32 bits: the size of a material is a factor of few instructions wherever one is looked up
    bool dims : 1;                // its emission changes: `emission` is the most of each channel, a pose has that of its time
    bool unlit : 1;               // `emission` is for the eye alone: it lights nothing
    bool changes : 1;             // something else of it does: only what moves (scene/movement.h) has it
    unsigned int pass_index : 24; // a number for compositors; 0: none
    struct RfTextured* textured;  // what varies over the surface (scene/textured.h); NULL: nothing
} RfMaterial;

// Whether it lights anything.
static inline bool rf_emits( const RfMaterial* m ) { return !m->unlit && rf_max_component( m->emission ) > 0.0f; }

// True of the surfaces that light paths follow: perfect mirrors and smooth glass with an inside, without textures.
static inline bool rf_is_chain_surface( const RfMaterial* m )
{
    return m->kind == RF_BSDF_GLASS && m->alpha == 0.0f && m->textured == NULL && !m->thin;
}

#define RF_FROSTED_ALPHA 0.04f // roughness 0.2: below, what one camera sees through it says little about another
#define RF_FROSTED_IOR 1.1f    // below, facets hardly refract, and lobes are narrow whatever their roughness is

#define RF_PLATE_ALPHA 0.04f // roughness 0.2

// True of the metals that light paths of lamps without size follow, by facets: smooth enough to throw that light as a caustic, no
// textures.
static inline bool rf_is_plate( const RfMaterial* m )
{
    return m->kind == RF_BSDF_GGX && m->alpha <= RF_PLATE_ALPHA && m->textured == NULL && m->diffuse.x == 0.0f &&
           m->diffuse.y == 0.0f && m->diffuse.z == 0.0f;
}

// True of opaque models with a lobe of GGX over a Lambert base.
static inline bool rf_is_ggx( RfBsdfKind kind ) { return kind >= RF_BSDF_GGX && kind <= RF_BSDF_TRANSLUCENT; }

// The model of an opaque surface of GGX with these on top of it or in its lobe.
static inline RfBsdfKind rf_layered_kind( bool coat, bool sheen, bool anisotropy, bool film )
{
    if ( coat + sheen + anisotropy + film > 1 )
        return RF_BSDF_LAYERED;
    return coat         ? RF_BSDF_COATED
           : sheen      ? RF_BSDF_SHEEN
           : anisotropy ? RF_BSDF_ANISOTROPIC
           : film       ? RF_BSDF_IRIDESCENT
                        : RF_BSDF_GGX;
}

#define RF_MAX_CHAIN 8 // vertices of a chain that light paths follow

#define RF_MIN_ALPHA 1e-3f
#define RF_MIN_SHEEN_ALPHA 0.0049f // roughness 0.07

// GGX lobes with a smaller alpha (roughness 0.1) are so narrow that directions of other paths do not fall into them.
#define RF_SMOOTH_ALPHA 0.01f

// Metals up to this alpha (roughness 0.32) throw caustics (path/own_light.h).
#define RF_CAUSTIC_ALPHA 0.1f

// Lobes with a smaller alpha (roughness 0.25) may mirror a lamp in few of a pixel's points.
#define RF_SHARP_ALPHA 0.0625f

// Chooses the model of an opaque surface of GGX by what the material has of layers. What it lacks gets parameters that models of
// several layers can read.
static inline void rf_choose_layers( RfMaterial* m )
{
    bool coat = m->clearcoat > 0.0f, sheen = m->sheen.x > 0.0f || m->sheen.y > 0.0f || m->sheen.z > 0.0f;
    bool anisotropy = m->anisotropy > 0.0f, film = m->film > 0.0f;
    m->kind = rf_layered_kind( coat, sheen, anisotropy, film );
    m->clearcoat_alpha = coat ? m->clearcoat_alpha : 1.0f;
    m->sheen_alpha = sheen ? m->sheen_alpha : 1.0f;
    m->stretch_x = anisotropy ? m->stretch_x : 1.0f;
    m->stretch_y = anisotropy ? m->stretch_y : 0.0f;
    m->film_ior = film ? m->film_ior : 1.0f;
    m->film_thickness = film ? m->film_thickness : 0.0f;
}

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
    RF_PARAM_THROUGH = RF_PARAM_TINT, // of TRANSLUCENT
    RF_PARAM_IOR = RF_PARAM_TINT + 3, // of the far side over the near one; negative: thin wall; 0: mirror
    RF_PARAM_SHEEN,                   // this and those after it: of no model up to COATED, nor of GLASS
    RF_PARAM_SHEEN_ALPHA = RF_PARAM_SHEEN + 3,
    RF_PARAM_ANISOTROPY,
    RF_PARAM_TANGENT, // unit vector along which highlights are stretched, at right angles to n
    RF_PARAM_FILM = RF_PARAM_TANGENT + 3,
    RF_PARAM_FILM_IOR,
    RF_PARAM_FILM_THICKNESS,
    RF_PARAM_DISPERSION,
    RF_PARAM_CHOICE, // what was drawn with the hit: TRANSLUCENT, FROSTED: 1, light arrives on the side that is seen, or −1, on the
                     // other, where n is then; SPECTRAL: the channel
    RF_PARAM_COUNT
} RfBsdfParam;

// A mask of parameters: bit p is parameter p.
typedef uint64_t RfBsdfParams;

_Static_assert( RF_PARAM_COUNT + 16 <= 8 * sizeof( RfBsdfParams ), "no room for the parameters of another lobe" );

#define RF_PARAM_BIT( param ) ( (RfBsdfParams)1 << ( param ) )
#define RF_PARAM_BITS3( param ) ( (RfBsdfParams)7 << ( param ) )

static inline bool rf_has_param( RfBsdfParams params, RfBsdfParam param ) { return ( params >> param & 1u ) != 0; }

// The first parameter of a mask, which is not empty.
static inline RfBsdfParam rf_first_param( RfBsdfParams params ) { return (RfBsdfParam)__builtin_ctzll( params ); }

// Not copied from the material but set by path/surface.c from the hit.
#define RF_PARAMS_OF_HIT                                                                                                         \
    ( RF_PARAM_BITS3( RF_PARAM_CLEARCOAT_N ) | RF_PARAM_BIT( RF_PARAM_IOR ) | RF_PARAM_BITS3( RF_PARAM_TANGENT ) |               \
      RF_PARAM_BIT( RF_PARAM_CHOICE ) )

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
        COLOUR( RF_PARAM_SHEEN, sheen ),
        FLOAT( RF_PARAM_SHEEN_ALPHA, sheen_alpha ),
        FLOAT( RF_PARAM_ANISOTROPY, anisotropy ),
        FLOAT( RF_PARAM_FILM, film ),
        FLOAT( RF_PARAM_FILM_IOR, film_ior ),
        FLOAT( RF_PARAM_FILM_THICKNESS, film_thickness ),
        FLOAT( RF_PARAM_DISPERSION, dispersion ),
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

// What RF_PARAM_SHAPE of a model is.
typedef enum RfBsdfShape
{
    RF_SHAPE_NONE,     // not a parameter of the model, which is Lambert's alone
    RF_SHAPE_EXPONENT, // Phong's
    RF_SHAPE_ALPHA,    // of GGX
} RfBsdfShape;

// Whether light that a surface sends on falls on others as a caustic (rf_throws_caustics).
typedef enum RfBsdfCaustics
{
    RF_CAUSTICS_NEVER,
    RF_CAUSTICS_OF_METAL, // without a base, up to RF_CAUSTIC_ALPHA
    RF_CAUSTICS_OF_GLASS, // without a base; mirrors
} RfBsdfCaustics;

// A row of the table of models: all that other folders know of a model alone.
typedef struct RfBsdfModel
{
    const char* name;
    RfBsdfParams params;
    uint64_t built_by[2]; // two sets of RF_EFFECT_BITs: a build without all of one set is without the model; empty: no condition
    uint64_t forced_by;   // a set of them: the effects that run the model where they are forced
    RfBsdfShape shape;
    bool matte; // a wide RF_PARAM_SHAPE makes all of the model wide (rf_is_matte)
    RfBsdfCaustics caustics;
    RfBsdfEvaluate* evaluate;
    RfBsdfSample* sample;                  // NULL for specular models,
    RfBsdfSampleWeighted* sample_weighted; // which have this instead
} RfBsdfModel;

extern const RfBsdfModel g_rf_bsdf_models[RF_BSDF_KIND_COUNT];

static inline const RfBsdfModel* rf_bsdf_model( RfBsdfKind kind ) { return g_rf_bsdf_models + kind; }

static inline bool rf_is_model_built( RfBsdfKind kind )
{
    for ( int k = 0; k < 2 && RF_EFFECTS_NOT_BUILT != 0; ++k )
    {
        uint64_t any = rf_bsdf_model( kind )->built_by[k];
        if ( any != 0 && ( any & ~RF_EFFECTS_NOT_BUILT ) == 0 )
            return false;
    }
    return true;
}

// True of a set of models, bit k for kind k, with a specular one among them.
static inline bool rf_has_specular( unsigned kinds ) { return ( kinds & ~0u << RF_BSDF_FIRST_SPECULAR ) != 0; }

// True of non-specular surfaces that scatter so widely that a direction drawn by the cosine serves as well as one drawn by the
// model, by parameters of the material alone. `shape`: RF_PARAM_SHAPE.
static inline bool rf_is_matte( RfBsdfKind kind, float shape )
{
    const RfBsdfModel* model = rf_bsdf_model( kind );
    switch ( model->shape )
    {
        case RF_SHAPE_NONE: break;
        case RF_SHAPE_EXPONENT: return model->matte && shape <= 8.0f;
        case RF_SHAPE_ALPHA: return model->matte && shape >= 0.25f;
    }
    return model->matte;
}

// The alpha of the narrowest lobe, or what is like it; of Lambert 1. `shape`, `clearcoat_alpha`: RF_PARAM_SHAPE and
// RF_PARAM_CLEARCOAT_ALPHA, if the model has them.
static inline float rf_narrowest_alpha( RfBsdfKind kind, float shape, float clearcoat_alpha )
{
    const RfBsdfModel* model = rf_bsdf_model( kind );
    switch ( model->shape )
    {
        case RF_SHAPE_NONE: break;
        case RF_SHAPE_EXPONENT: return sqrtf( 2.0f / ( shape + 2.0f ) );
        case RF_SHAPE_ALPHA:
            return rf_has_param( model->params, RF_PARAM_CLEARCOAT_ALPHA ) ? rf_minf( shape, clearcoat_alpha ) : shape;
    }
    return 1.0f;
}

// The lanes from `first` on of arrays, those that the model reads.
static inline RfBsdfLanes rf_bsdf_lanes( RfBsdfKind kind, const float* const n[3], const float* const param[RF_PARAM_COUNT],
                                         int first )
{
    RfBsdfLanes lanes = { .n = { n[0] + first, n[1] + first, n[2] + first } };
    for ( RfBsdfParams left = rf_bsdf_model( kind )->params; left != 0; left &= left - 1 )
    {
        RfBsdfParam p = rf_first_param( left );
        lanes.param[p] = param[p] + first;
    }
    return lanes;
}

#endif
