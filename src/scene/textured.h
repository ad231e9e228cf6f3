// Spatially varying materials: factors times textures times vertex colours, converted to the
// parameters of the scattering models. In large scenes most of the time of a lookup is spent waiting for memory: texels are
// fetched into the cache for many points at once.
#ifndef REFRAME_SCENE_TEXTURED_H
#define REFRAME_SCENE_TEXTURED_H

#include "scene/placement.h"
#include "scene/scene.h"

#include <stddef.h>

// The factors of glTF's metallic-roughness model.
typedef struct RfFactors
{
    double base[4];
    double metallic, roughness;
    double specular;
    double specular_color[3];
    double ior;
    bool coat_is_added;               // to the base, as Blender's Principled does, as far as no energy is gained
    double through, through_color[3]; // diffuse transmission
    // rf_derive_lobes and rf_derive_glass do not read what follows
    double sheen_color[3], sheen_roughness;
    double anisotropy, anisotropy_rotation;       // strength, 0 to 1; radians, counter-clockwise from the tangent
    double film, film_ior, film_least, film_most; // strength of the thin film; thickness in nm where its texture is 0 and 1
    double dispersion;                            // 20 over the Abbe number
} RfFactors;

typedef enum RfTextureSlot
{
    RF_TEXTURE_BASE,               // sRGB
    RF_TEXTURE_METALLIC_ROUGHNESS, // roughness in G, metallic in B
    RF_TEXTURE_NORMAL,
    RF_TEXTURE_EMISSIVE,            // sRGB
    RF_TEXTURE_SPECULAR,            // in A
    RF_TEXTURE_SPECULAR_COLOR,      // sRGB
    RF_TEXTURE_TRANSMISSION,        // in R, for glass
    RF_TEXTURE_CLEARCOAT,           // in R; this and the next two for RF_BSDF_COATED
    RF_TEXTURE_CLEARCOAT_ROUGHNESS, // in G
    RF_TEXTURE_CLEARCOAT_NORMAL,
    RF_TEXTURE_SHEEN_COLOR,     // sRGB
    RF_TEXTURE_SHEEN_ROUGHNESS, // in A
    RF_TEXTURE_ANISOTROPY,      // direction in RG, strength in B
    RF_TEXTURE_FILM,            // in R
    RF_TEXTURE_FILM_THICKNESS,  // in G
    RF_TEXTURE_THROUGH,         // in A
    RF_TEXTURE_THROUGH_COLOR,   // sRGB
    RF_TEXTURE_SLOT_COUNT
} RfTextureSlot;

// What the base colour at a hit controls.
typedef enum RfTexturedModel
{
    RF_TEXTURED_COATED,  // Lambert and GGX, from glTF's factors
    RF_TEXTURED_GLASS,   // tint and base of RF_BSDF_GLASS and RF_BSDF_SPECTRAL
    RF_TEXTURED_UNLIT,   // the emission
    RF_TEXTURED_DIFFUSE, // a factor on the diffuse reflectance
} RfTexturedModel;

struct RfTextured
{
    RfTexturedModel model;
    RfFactors factors;
    double transmission;                   // for glass
    double clearcoat, clearcoat_roughness; // for RF_BSDF_COATED
    RfTextureRef refs[RF_TEXTURE_SLOT_COUNT];
    float normal_scale, clearcoat_normal_scale;
    bool optional;      // only vertex colours may vary it: dropped after loading if there are none
    bool vertex_colors; // some primitive with this material has vertex colours
    bool masked;        // no surface where alpha is below the cutoff
    float alpha_cutoff;
    bool blended;  // alpha is the opacity of the surface
    bool reshapes; // roughness or metallic factor change
    bool glossy;   // A of the texture of the specular colour is a factor of 1 - roughness
    bool turns;    // a normal texture is rotated or scaled, which vertex tangents do not follow
};

// Smoother surfaces are perfectly smooth: their lobe would be narrower than that of
// RF_MIN_ALPHA.
#define RF_SMOOTH_ROUGHNESS 0.0316

// The metallic-roughness model of the glTF specification: sets diffuse, specular, f90,
// coat_f0, coat_f90 and alpha of `out`.
void rf_derive_lobes( const RfFactors* factors, RfMaterial* out );

// Glass: sets diffuse, specular, f90, coat_f0, coat_f90, tint and alpha of `out`.
void rf_derive_glass( const RfFactors* factors, double transmission, RfMaterial* out );

// Sets what a material derives from the factors of its `textured` where no texture varies them.
void rf_derive_material( RfMaterial* m );

// Sets clearcoat and clearcoat_alpha of `out`.
void rf_derive_clearcoat( double clearcoat, double roughness, RfMaterial* out );

// Sets what the layers over the metallic-roughness model and the changes of its lobe have of `out`, except for clear coats.
void rf_derive_layers( const RfFactors* factors, RfMaterial* out );

// A copy of `material` (which must have `textured`) with everything looked up at the
// barycentrics (u, v) of a triangle. Colours are means over an area around the point that is this share of the triangle's, by mip
// levels; share 0: without.
void rf_material_within( const RfScene* scene, const RfMaterial* material, uint32_t triangle, float u, float v, float share,
                         RfMaterial* out );

static inline void rf_material_at( const RfScene* scene, const RfMaterial* material, uint32_t triangle, float u, float v,
                                   RfMaterial* out )
{
    rf_material_within( scene, material, triangle, u, v, 0.0f, out );
}

// Emitted radiance at a point of a material with `textured`, or the mean around it over such a share; black where the point is
// cut out.
RfVec3 rf_emission_within( const RfScene* scene, const RfMaterial* material, uint32_t triangle, float u, float v, float share );

static inline RfVec3 rf_emission_at( const RfScene* scene, const RfMaterial* material, uint32_t triangle, float u, float v )
{
    return rf_emission_within( scene, material, triangle, u, v, 0.0f );
}

// An estimate of the mean emitted radiance of a triangle for light sampling; it is 0 only if
// the triangle does not emit anywhere.
RfVec3 rf_mean_emission( const RfScene* scene, const RfMaterial* material, uint32_t triangle );

// The shading normal from the normal texture: `n` is the unit interpolated normal of the front
// side. The result is a unit vector on the side of `ng`, the geometric normal of the front
// side.
RfVec3 rf_normal_at( const RfScene* scene, const RfMaterial* material, uint32_t triangle, float u, float v, RfVec3 n, RfVec3 ng );

// The shading normal of the clear coat, which has a normal texture of its own.
RfVec3 rf_coat_normal_at( const RfScene* scene, const RfMaterial* material, uint32_t triangle, float u, float v, RfVec3 n,
                          RfVec3 ng );

// The unit vector along which the highlights of an anisotropic material are stretched, at right angles to `n`, the unit shading
// normal of the front side: by `stretch_x` and `stretch_y` of the vertex tangents, else of the texture coordinates, else of an
// arbitrary direction. `material`: with everything looked up (rf_material_at).
RfVec3 rf_stretch_at( const RfScene* scene, const RfMaterial* material, uint32_t triangle, float u, float v, RfVec3 n );

// The opacity of the surface at this point, 0 to 1, which is the probability that a ray hits
// it: 0 or 1 for masked materials, alpha for blended ones.
float rf_opacity_at( const RfScene* scene, const RfMaterial* material, uint32_t triangle, float u, float v );

// The same on a triangle that is located already (rf_locate_triangle).
float rf_opacity_on( const RfScene* scene, const RfMaterial* material, const RfTriangles* triangles, uint32_t index, float u,
                     float v );

// True if the roughness of a material is not the same everywhere and at all times.
static inline bool rf_roughness_varies( const RfMaterial* m )
{
    const RfTextured* t = m->textured;
    return t != NULL && ( t->refs[RF_TEXTURE_METALLIC_ROUGHNESS].texture >= 0 || t->reshapes || t->glossy );
}

// True of glass that frames share (RF_BSDF_FROSTED).
static inline bool rf_is_frosted( const RfMaterial* m )
{
    return m->kind == RF_BSDF_GLASS && m->alpha >= RF_FROSTED_ALPHA && ( m->thin ? m->ior > 0.0f : m->ior >= RF_FROSTED_IOR ) &&
           rf_max_component( m->tint ) > 0.0f && !rf_emits( m ) && !m->changes && !rf_roughness_varies( m );
}

// True if the GGX lobe of a material may be narrower than those of roughness 0.1.
static inline bool rf_may_be_smooth( const RfMaterial* m )
{
    bool varies = rf_roughness_varies( m );
    return m->kind == RF_BSDF_GGX && ( varies || m->alpha < RF_SMOOTH_ALPHA );
}

// True if a surface may throw caustics (path/own_light.h): mirrors, glass, and metals up to RF_CAUSTIC_ALPHA.
static inline bool rf_may_throw_caustics( const RfMaterial* m )
{
    RfBsdfCaustics caustics = rf_bsdf_model( m->kind )->caustics;
    bool metal = m->alpha <= RF_CAUSTIC_ALPHA && !( rf_max_component( m->diffuse ) > 0.0f );
    const RfTextured* t = m->textured;
    bool varied = rf_roughness_varies( m ) && ( t->factors.metallic > 0.0 || t->reshapes || t->glossy );
    return caustics == RF_CAUSTICS_OF_GLASS || ( caustics == RF_CAUSTICS_OF_METAL && ( metal || varied ) );
}

// True if some lobe of a material may mirror a lamp: its alpha, or what is like it, below RF_SHARP_ALPHA.
static inline bool rf_may_be_sharp( const RfMaterial* m )
{
    bool varies = rf_bsdf_model( m->kind )->shape == RF_SHAPE_ALPHA && rf_roughness_varies( m );
    return varies || rf_narrowest_alpha( m->kind, m->alpha, m->clearcoat_alpha ) < RF_SHARP_ALPHA;
}

// True if a texture gives a material colours, which mip levels are for.
bool rf_has_colour_texture( const RfMaterial* m );

static inline bool rf_is_masked( const RfMaterial* m ) { return m->textured != NULL && m->textured->masked; }

static inline bool rf_is_blended( const RfMaterial* m ) { return m->textured != NULL && m->textured->blended; }

// True if a thin wall of glass is smooth and lets light through somewhere.
bool rf_is_clear_somewhere( const RfMaterial* material );

// True if the material is a thin pane (bsdf/bsdf.h), at least where its textures allow.
static inline bool rf_may_be_pane( const RfMaterial* m )
{
    return m->kind >= RF_BSDF_FIRST_SPECULAR && m->thin && rf_is_clear_somewhere( m );
}

// A point on a triangle, by barycentrics, with a material that has `textured`.
typedef struct RfTexturedPoint
{
    const RfMaterial* material;
    uint32_t triangle;
    float u, v;
} RfTexturedPoint;

// Changes nothing but the time that rf_material_at and the other lookups of scene/textured.h take at these points.
void rf_prefetch_textures( const RfScene* scene, const RfTexturedPoint* points, int count );

#endif
