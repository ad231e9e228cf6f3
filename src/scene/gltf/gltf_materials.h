// From the materials, textures and images of a glTF document to those of the scene. Internal to the reader.
#ifndef REFRAME_SCENE_GLTF_GLTF_MATERIALS_H
#define REFRAME_SCENE_GLTF_GLTF_MATERIALS_H

#include "scene/gltf/gltf_document.h"
#include "scene/movement.h"

// Reads all materials (gltf_material.c).
RfResult rf_gltf_load_materials( RfGltf* gltf );

// The index of the material for primitives without one, created on first use.
RfResult rf_gltf_use_default_material( RfGltf* gltf, uint32_t* index );

// Has a material in extras.reframe a scattering model that glTF lacks (gltf_own_model.c)? Reads that model, if there is one; and
// reads what else these extras say, before.
bool rf_gltf_has_own_model( const json_t* material );
RfResult rf_gltf_read_own_model( const RfField* material, RfMaterial* out );
void rf_gltf_read_material_extras( const RfField* material, RfFactors* factors, RfMaterial* out );

// Gives a material, after its glass and before its coat, what extensions do to it that lay something over the metallic-roughness
// model or change its lobes (gltf_surface.c).
void rf_gltf_apply_surface( RfGltf* gltf, const json_t* material, const RfMaterialValues* values, RfMaterial* out );

// KHR_materials_volume_scatter: where a body is dense, `dense` is set, and its values become those of an opaque surface with the
// albedo of a half-space of what is inside (src/reuse/estimators.md, section 21).
RfResult rf_gltf_apply_scatter( const RfField* material, RfMaterialValues* values, bool* dense );

// Sets the `textured` member of a material, and the transforms of its textures, after all its other properties have been read
// (gltf_texture.c). rf_gltf_load_images removes it again if it is not needed.
RfResult rf_gltf_read_textured( RfGltf* gltf, const RfField* json, RfMovingMaterial* moving, RfMaterial* out );

// A struct without textures; NULL if out of memory.
RfTextured* rf_gltf_textured( const RfFactors* factors );

// Decodes the images that materials of triangles use (gltf_texture.c); called after the meshes
// are loaded.
RfResult rf_gltf_load_images( RfGltf* gltf );

// True for materials with KHR_materials_unlit (gltf_surface.c).
bool rf_gltf_is_unlit( const json_t* material );

// Image sequences (gltf_sequence.c). Whether an image is one, of several images that are not frozen.
RfResult rf_gltf_plays( const RfGltf* gltf, int image, bool* plays );

// Makes a texture of the scene of a sequence, if the image is one, which `given` says.
RfResult rf_gltf_load_sequence( RfGltf* gltf, int image, bool srgb, RfTexture* out, bool* given );

// Limits the values of the images that a texture of the scene shows.
void rf_gltf_limit_sequence( RfGltf* gltf, int texture, double most );

#endif
