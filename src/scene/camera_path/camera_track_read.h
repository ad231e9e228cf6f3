// What the readers of camera paths and of objects that move share; users include scene/camera_path/camera_track.h.
#ifndef REFRAME_SCENE_CAMERA_PATH_CAMERA_TRACK_READ_H
#define REFRAME_SCENE_CAMERA_PATH_CAMERA_TRACK_READ_H

#include "scene/camera_path/camera_track.h"
#include "base/json.h"

#define RF_MAX_TRACK_SECONDS 1e6
#define RF_MAX_TRACK_FRAMES 1e6
#define RF_DEFAULT_FOV 40.0 // degrees
#define RF_MAX_SHIFT 1000.0 // heights of the picture

// Reads a rotation, which is required.
RfResult rf_read_rotation( const RfField* field, double q[4] ); // required

// Reads whether keys are joined linearly, rather than smoothly; false where nothing is said.
RfResult rf_read_interpolation( const RfField* object, bool* linear );

// Reads when key `index` is, in seconds or as the number of a frame, which must be later than the key before it.
RfResult rf_read_key_time( const RfField* key, bool in_frames, int index, double* times );

#endif
