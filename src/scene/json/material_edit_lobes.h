// Internal to material_edit.h: the scattering models of extras.reframe.
#ifndef REFRAME_SCENE_JSON_MATERIAL_EDIT_LOBES_H
#define REFRAME_SCENE_JSON_MATERIAL_EDIT_LOBES_H

#include "scene/json/json_document.h"

// Copies bsdf, diffuse, specular and exponent of an override into the material.
RfResult rf_edit_lobes( const RfField* override, json_t* material );

// The bsdf of a material; "gltf" unless extras.reframe selects another.
const char* rf_edited_bsdf( const json_t* material );

// The member object of that name, created if missing; NULL if out of memory.
json_t* rf_edit_member( json_t* object, const char* key );

// Fails with RF_ERROR_MEMORY.
RfResult rf_edit_no_memory( const RfField* field );

#endif
