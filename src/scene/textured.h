// Materials that vary over a surface: factors times textures times vertex
// colours, and what scattering models make of them.
#ifndef REFRAME_SCENE_TEXTURED_H
#define REFRAME_SCENE_TEXTURED_H

#include "scene/scene.h"

#include <stddef.h>

// glTF's factors of a metallic-roughness material.
typedef struct RfFactors
{
    double base[4];
    double metallic, roughness;
    double specular;
    double specular_color[3];
    double ior;
} RfFactors;

typedef enum RfTextureSlot
{
    RF_TEXTURE_BASE,               // sRGB
    RF_TEXTURE_METALLIC_ROUGHNESS, // roughness in G, metallic in B
    RF_TEXTURE_NORMAL,
    RF_TEXTURE_EMISSIVE,            // sRGB
    RF_TEXTURE_SPECULAR,            // in A
    RF_TEXTURE_SPECULAR_COLOR,      // sRGB
    RF_TEXTURE_TRANSMISSION,        // in R, of glass
    RF_TEXTURE_CLEARCOAT,           // in R; these three of RF_BSDF_COATED
    RF_TEXTURE_CLEARCOAT_ROUGHNESS, // in G
    RF_TEXTURE_CLEARCOAT_NORMAL,
    RF_TEXTURE_SLOT_COUNT
} RfTextureSlot;

// What a hit makes of the base colour there.
typedef enum RfTexturedModel
{
    RF_TEXTURED_COATED,  // Lambert and GGX of glTF's factors
    RF_TEXTURED_GLASS,   // tint and base of RF_BSDF_GLASS
    RF_TEXTURED_UNLIT,   // the emission
    RF_TEXTURED_DIFFUSE, // multiplies the diffuse reflectance of a model of ours
} RfTexturedModel;

struct RfTextured
{
    RfTexturedModel model;
    RfFactors factors;
    double transmission;                   // of glass
    double clearcoat, clearcoat_roughness; // of RF_BSDF_COATED
    RfTextureRef refs[RF_TEXTURE_SLOT_COUNT];
    float normal_scale, clearcoat_normal_scale;
    bool optional;      // nothing varies but what vertex colours may bring: gone after loading without them
    bool vertex_colors; // some primitive with the material has them
    bool masked;        // where alpha is below the cutoff there is no surface
    float alpha_cutoff;
    bool blended; // alpha is the part of the light that the surface takes part in
};

// Below this a surface counts as smooth: its lobe is narrower than RF_MIN_ALPHA's.
#define RF_SMOOTH_ROUGHNESS 0.0316

// The specification's mix of metal and coated base: diffuse, specular, f90,
// coat_f0, coat_f90, alpha of `out`.
void rf_derive_lobes( const RfFactors* factors, RfMaterial* out );

// What glass is made of: diffuse, specular, f90, tint, alpha of `out`.
void rf_derive_glass( const RfFactors* factors, double transmission, RfMaterial* out );

// The coat: clearcoat, clearcoat_alpha of `out`.
void rf_derive_clearcoat( double clearcoat, double roughness, RfMaterial* out );

// The material (`material`, which must have `textured`) at the barycentrics
// (u, v) of a triangle: a copy with everything looked up.
void rf_material_at( const RfScene* scene, const RfMaterial* material, uint32_t triangle, float u, float v, RfMaterial* out );

// Radiance emitted there by a material with `textured`; black where it is cut out.
RfVec3 rf_emission_at( const RfScene* scene, const RfMaterial* material, uint32_t triangle, float u, float v );

// Can a triangle of it emit at all, and an estimate of its mean radiance, which
// is nowhere 0 where the triangle emits somewhere. For picking lights.
RfVec3 rf_mean_emission( const RfScene* scene, const RfMaterial* material, uint32_t triangle );

// The shading normal there by the normal texture: `n` is the unit interpolated
// normal of the front, the result is unit and on the side of `ng`, the front's
// geometric normal.
RfVec3 rf_normal_at( const RfScene* scene, const RfMaterial* material, uint32_t triangle, float u, float v, RfVec3 n, RfVec3 ng );

// The same for its clear coat, which normal textures of the surface below leave
// as it is.
RfVec3 rf_coat_normal_at( const RfScene* scene, const RfMaterial* material, uint32_t triangle, float u, float v, RfVec3 n,
                          RfVec3 ng );

// Is the surface cut out there?
bool rf_is_cut_out( const RfScene* scene, const RfMaterial* material, uint32_t triangle, float u, float v );

// The chance of a ray to meet the surface there, 0 to 1: all or nothing where
// the material is masked, its alpha where it is blended.
float rf_opacity_at( const RfScene* scene, const RfMaterial* material, uint32_t triangle, float u, float v );

static inline bool rf_is_masked( const RfMaterial* m ) { return m->textured != NULL && m->textured->masked; }
static inline bool rf_is_blended( const RfMaterial* m ) { return m->textured != NULL && m->textured->blended; }

#endif
