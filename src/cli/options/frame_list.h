// Lists of frames: "A", "A-B", "A-BxSTEP", "-5--1", with commas between them.
#ifndef REFRAME_CLI_OPTIONS_FRAME_LIST_H
#define REFRAME_CLI_OPTIONS_FRAME_LIST_H

#include "reframe/camera.h"
#include "scene/json/scene_file.h"

// Parses the frames that `text` names on a path of `frame_count` frames into *frames:
// *count indices from 0, ascending, each once; the caller frees them. Numbers in the text
// start at 1, negative ones count from the end. NULL text: all frames.
RfResult rf_parse_frames( const char* text, int frame_count, int** frames, int* count, RfError* error );

// The same for the frames of a camera path, by their own numbers, and for text from the command line or
// from the scene file; in the latter case errors name the file. Of a path in steps, A-B are the frames in between.
RfResult rf_choose_frames( const char* text, const RfSceneFile* file, const RfCameraPath* path, int** frames, int* count,
                           RfError* error );

#endif
