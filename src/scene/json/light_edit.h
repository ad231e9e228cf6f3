// What a scene file gives lamps of the glTF by name, which glTF itself lacks. It is put into the parsed glTF before that is read.
#ifndef REFRAME_SCENE_JSON_LIGHT_EDIT_H
#define REFRAME_SCENE_JSON_LIGHT_EDIT_H

#include "base/json.h"

// Applies `lights`, an object by name of what `extras.reframe` of a light may hold (gltf_light.c), to the glTF `root`; the reader of
// the glTF validates the values. The file of "ies" lies beside the scene file. Names that no light has and unknown keys are errors.
RfResult rf_edit_lights( const RfField* lights, json_t* root );

#endif
