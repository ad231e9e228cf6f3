// Overrides of glTF materials by name in a scene file. Numbers go to the reader of glTF; all else is applied to the parsed glTF
// before it is read, so that it means the same as there, for every feature of the reader.
#ifndef REFRAME_SCENE_JSON_MATERIAL_EDIT_H
#define REFRAME_SCENE_JSON_MATERIAL_EDIT_H

#include "base/json.h"
#include "scene/movement.h"

// Values of materials, and their keys.
typedef struct RfMaterialKeys
{
    RfFps fps; // by which frames are counted; 0/0: as the glTF asks for
    int count;
    RfChange*
        changes;    // of materials of the glTF, by their numbers there; without keys: of what stands still, whatever the glTF has
    bool in_frames; // some are numbers of frames
    int override_count;
    RfOverride* overrides; // of materials, likewise
} RfMaterialKeys;

void rf_destroy_material_keys( RfMaterialKeys* keys );

// Applies `materials`, an object of overrides by name, to the glTF `root`. Validates
// everything: names that no material has, unknown keys, values out of range, keys without
// effect on the material's bsdf. An override applies to all materials of that name. Numbers and keys are added to `keys`, which starts
// as zeros but for its fps; free it, also on failure. They are set in the options of the reader.
struct RfGltfOptions;
RfResult rf_edit_materials( const RfField* materials, json_t* root, RfMaterialKeys* keys, struct RfGltfOptions* options );

#endif
