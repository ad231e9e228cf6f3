// Inside of material_edit.h: the models of ours that extras.reframe gives.
#ifndef REFRAME_SCENE_JSON_MATERIAL_EDIT_LOBES_H
#define REFRAME_SCENE_JSON_MATERIAL_EDIT_LOBES_H

#include "scene/json/json_document.h"

// Brings bsdf, diffuse, specular and exponent of an override into the material.
RfResult rf_edit_lobes( const RfField* override, json_t* material );

// The bsdf of a material; "gltf" where extras.reframe gives no other.
const char* rf_edited_bsdf( const json_t* material );

// The member object of that name, made where there is none; NULL: no memory.
json_t* rf_edit_dig( json_t* object, const char* key );

RfResult rf_edit_no_memory( const RfField* field );

#endif
