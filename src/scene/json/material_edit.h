// Materials of a glTF that a scene file overrides by name. The override goes
// into the parsed glTF before it is read, so that it means what the same value
// in the file would mean, for every feature the reader has.
#ifndef REFRAME_SCENE_JSON_MATERIAL_EDIT_H
#define REFRAME_SCENE_JSON_MATERIAL_EDIT_H

#include "scene/json/json_document.h"

// `materials` is the object of overrides by name, `root` the glTF. Everything
// is checked: names that no material has, unknown keys, values out of range,
// keys without an effect on the material's bsdf. Several materials of a name
// all get what is said of it.
RfResult rf_edit_materials( const RfField* materials, json_t* root );

#endif
