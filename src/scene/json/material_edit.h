// Overrides of glTF materials by name in a scene file. They are applied to the parsed glTF
// before it is read, so that a value means the same as in the glTF, for every feature of the
// reader.
#ifndef REFRAME_SCENE_JSON_MATERIAL_EDIT_H
#define REFRAME_SCENE_JSON_MATERIAL_EDIT_H

#include "scene/json/json_document.h"

// Applies `materials`, an object of overrides by name, to the glTF `root`. Validates
// everything: names that no material has, unknown keys, values out of range, keys without
// effect on the material's bsdf. An override applies to all materials of that name.
RfResult rf_edit_materials( const RfField* materials, json_t* root );

#endif
