// From the materials, textures and images of a glTF document to those of the scene. Internal to the reader.
#ifndef REFRAME_SCENE_GLTF_GLTF_MATERIALS_H
#define REFRAME_SCENE_GLTF_GLTF_MATERIALS_H

#include "scene/gltf/gltf_document.h"
#include "scene/movement.h"

// Reads all materials (gltf_material.c).
RfResult rf_gltf_load_materials( RfGltf* gltf );

// The index of the material for primitives without one, created on first use.
RfResult rf_gltf_use_default_material( RfGltf* gltf, uint32_t* index );

// A scattering model of extras.reframe.
typedef struct RfGltfModel RfGltfModel;

// What is said of a material.
typedef struct RfGltfMaterial
{
    int index;
    RfField json;             // by the document
    RfField own;              // by its extras.reframe
    RfField edit;             // by a scene file, which goes first
    RfField glossiness;       // by KHR_materials_pbrSpecularGlossiness, in the place of the metallic-roughness model
    const RfGltfModel* model; // NULL: glTF's
    bool chosen;              // by the scene file
    bool textures;            // it has those of the document
    bool unlit;
} RfGltfMaterial;

RfResult rf_gltf_open_material( RfGltf* gltf, int index, RfGltfMaterial* out );

// Has it a texture there?
bool rf_gltf_has_texture( const RfGltfMaterial* material, RfTextureSlot slot );

// Sets the `textured` member of a material, and the transforms of its textures, after all its other properties have been read
// (gltf_texture.c). rf_gltf_load_images removes it again if it is not needed.
RfResult rf_gltf_read_textured( RfGltf* gltf, const RfGltfMaterial* material, RfMovingMaterial* moving, RfMaterial* out );

// A struct without textures; NULL if out of memory.
RfTextured* rf_gltf_textured( const RfFactors* factors );

// Decodes the images that materials of triangles use (gltf_texture.c); called after the meshes
// are loaded.
RfResult rf_gltf_load_images( RfGltf* gltf );

#endif
