// From the materials, textures and images of a glTF document to those of the scene. Internal to the reader.
#ifndef REFRAME_SCENE_GLTF_GLTF_MATERIALS_H
#define REFRAME_SCENE_GLTF_GLTF_MATERIALS_H

#include "scene/gltf/gltf_document.h"

// Reads all materials (gltf_material.c, gltf_lobe.c).
RfResult rf_gltf_load_materials( RfGltf* gltf );

// The index of the material for primitives without one, created on first use.
RfResult rf_gltf_use_default_material( RfGltf* gltf, uint32_t* index );

// Reads the scattering model in extras.reframe, if any (gltf_lobe.c).
RfResult rf_gltf_read_lobes( const RfGltf* gltf, const json_t* material, const char* where, RfMaterial* out );

// Has a material in extras.reframe a scattering model that glTF lacks (gltf_lobe.c)?
bool rf_gltf_has_own_model( const json_t* material );

// Reads from extras.reframe, if it has no scattering model, whether the coat is added to the base (gltf_lobe.c).
RfResult rf_gltf_read_coat( const RfGltf* gltf, const json_t* material, const char* where, RfFactors* out );

// Reads a use of a texture, `key` of `parent` (gltf_texture.c); `info` is NULL if there is
// none. Until rf_gltf_load_images, `texture` is 2 · image + srgb.
RfResult rf_gltf_read_texture_info( RfGltf* gltf, const json_t* parent, const char* owner, const char* key, bool srgb,
                                    RfTextureRef* out, const json_t** info );

// Sets the `textured` member of a material after all its other properties have been read
// (gltf_textured.c). rf_gltf_load_images removes it again if it is not needed.
RfResult rf_gltf_read_textured( RfGltf* gltf, const json_t* json, const char* where, const RfFactors* factors, RfMaterial* out );

// A struct without textures; NULL if out of memory.
RfTextured* rf_gltf_textured( const RfFactors* factors );

// Decodes the images that materials of triangles use (gltf_image.c); called after the meshes
// are loaded.
RfResult rf_gltf_load_images( RfGltf* gltf );

// Reads KHR_materials_transmission, _volume and _unlit, and metals without roughness, after
// all other factors (gltf_glass.c).
RfResult rf_gltf_read_glass( const RfGltf* gltf, const json_t* material, const char* where, const RfFactors* factors,
                             RfMaterial* out );

// Reads KHR_materials_clearcoat, the last of the extensions (gltf_clearcoat.c).
RfResult rf_gltf_read_clearcoat( RfGltf* gltf, const json_t* material, const char* where, RfMaterial* out );

// True for materials with KHR_materials_unlit.
bool rf_gltf_is_unlit( const json_t* material );

#endif
