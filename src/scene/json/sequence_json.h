// Image sequences in JSON: of a material's texture in scene files, and in the extras of an image of a glTF.
#ifndef REFRAME_SCENE_JSON_SEQUENCE_JSON_H
#define REFRAME_SCENE_JSON_SEQUENCE_JSON_H

#include "scene/image_sequence.h"
#include "base/json.h"

// Reads {"frames": "film.####.png", "first": 1, "last": 48, "start": 0, "fps": 24, "repeat": "hold"}. `frames` is the pattern as
// written (owned by the JSON); sequence->pattern is left to the caller, and fps is 0 where nothing is said.
RfResult rf_read_sequence( const RfField* object, RfImageSequence* sequence, const char** frames );

#endif
