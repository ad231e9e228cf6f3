// How pictures are shown, in JSON: in scene files, and in the extras of a glTF's scene.
#ifndef REFRAME_SCENE_JSON_VIEW_JSON_H
#define REFRAME_SCENE_JSON_VIEW_JSON_H

#include "base/json.h"
#include "scene/scene.h"

// Reads {"transform": "AgX", "look": "AgX - Punchy", "exposure": 0.5, "gamma": 1}; a field without a value changes nothing.
RfResult rf_read_view( const RfField* object, RfViewText* view );

#endif
