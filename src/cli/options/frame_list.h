// Which frames: "A", "A-B", "A-BxSTEP", "-5--1", with commas between them.
#ifndef REFRAME_CLI_OPTIONS_FRAME_LIST_H
#define REFRAME_CLI_OPTIONS_FRAME_LIST_H

#include "reframe/error.h"
#include "scene/json/scene_file.h"

// The frames that `text` names on a path of `frame_count` frames, as indices
// from 0, ascending, each once, in *frames (to be freed), *count of them.
// Numbers are 1-based, negative ones count from the end. NULL text: all.
RfResult rf_parse_frames( const char* text, int frame_count, int** frames, int* count, RfError* error );

// The same of the command line's text or, where it has none, of the scene
// file's: then a fault is the file's.
RfResult rf_choose_frames( const char* text, const RfSceneFile* file, int frame_count, int** frames, int* count, RfError* error );

#endif
