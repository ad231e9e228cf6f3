// From the materials, textures and images of a glTF document to those of the scene, and what changes by keys and is not of a node.
// Internal to the reader.
#ifndef REFRAME_GLTF_GLTF_MATERIAL_H
#define REFRAME_GLTF_GLTF_MATERIAL_H

#include "gltf/gltf_document.h"
#include "scene/movement.h"

// Reads a value of glTF into the struct of its owner's values, and checks its range (gltf_changes.c); one that is missing is left as
// it is. `home`: the object that has it.
RfResult rf_gltf_read_value( const RfGltf* gltf, const RfField* home, RfChangedValue value, void* values );

// Reads all values of an owner.
RfResult rf_gltf_read_values( const RfGltf* gltf, const RfField* owner, RfValueOwner kind, void* values );

// That all keys of a change are values that the file may have (gltf_changes.c).
RfResult rf_gltf_check_change( const RfGltf* gltf, const char* where, const RfChange* change );

// Reads the keys that a scene file gives a material, and adds them.
RfResult rf_gltf_read_keys( RfGltf* gltf, int material );

// Adds a change, whose channel it takes unless it fails.
RfResult rf_gltf_add_change( RfGltf* gltf, const RfChange* change );

// Sorts them by what they are of, and finds their span.
RfResult rf_gltf_sort_changes( RfGltf* gltf );

void rf_gltf_free_changes( RfGltf* gltf );

// The change of a value, or −1 where it stands still or is frozen: `still` is then what it is, unless nothing is said of it.
int rf_gltf_find_change( const RfGltf* gltf, RfChangedValue value, int of, int slot, double* still );

// The changes of all values of an owner, by value: `still` becomes what they are where they stand still, `most` (of the same type)
// the most that they are at any time.
void rf_gltf_find_changes( const RfGltf* gltf, RfValueOwner owner, int of, void* still, void* most, int* changes );

// Says in the list of what is frozen that something changes, where it is frozen.
RfResult rf_gltf_note_frozen( RfGltf* gltf, const char* kind, const char* name );

// Adds to the materials that change.
RfResult rf_gltf_add_moving_material( RfGltf* gltf, const RfMovingMaterial* moving );

// Whether the document changes a light by keys.
bool rf_gltf_light_changes( const RfGltf* gltf, int index );

// Notes a punctual light that moves, is switched or changes. Its node is one of the scene, its changes are numbers of
// rf_gltf_find_change.
RfResult rf_gltf_add_lamp( RfGltf* gltf, const RfMovingLamp* lamp );

// Notes a material that dims or changes, in which its factors are as in the file, and prepares it for that: `out` is as it
// stands still, but for the transforms of textures, which are followed here.
RfResult rf_gltf_change_material( RfGltf* gltf, RfMovingMaterial* moving, RfMaterial* out );

// Moves what has been noted, and is of what is in the scene, to a movement. The nodes of lamps are moving ones by now.
RfResult rf_gltf_move_changes( RfGltf* gltf, RfMovement* movement );

// A use of a texture by its path within a material: its slot, −1 where it is ignored. False: there is no such use
// (gltf_texture.c).
bool rf_gltf_texture_slot( const char* path, size_t length, int* slot );

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

// Has it a texture there?
bool rf_gltf_has_texture( const RfGltfMaterial* material, RfTextureSlot slot );

// Sets the `textured` member of a material, and the transforms of its textures, after all its other properties have been read
// (gltf_texture.c). rf_gltf_load_images removes it again if it is not needed.
RfResult rf_gltf_read_textured( RfGltf* gltf, const RfGltfMaterial* material, RfMovingMaterial* moving, RfMaterial* out );

// A struct without textures; NULL if out of memory.
RfTextured* rf_gltf_textured( const RfFactors* factors );

#endif
