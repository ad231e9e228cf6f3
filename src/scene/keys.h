// `keys` in scene files: values by time or frame, of objects, materials and the environment.
#ifndef REFRAME_SCENE_KEYS_H
#define REFRAME_SCENE_KEYS_H

#include "base/json.h"
#include "scene/movement.h"

// A value that keys may have.
typedef struct RfKeyed
{
    const char* name;
    RfAnimatedPath path;
    int components; // numbers of it
    double low, high;
    double unit;                                               // by which the numbers are multiplied
    RfResult ( *read )( const RfField* field, double* value ); // NULL: numbers in that range
} RfKeyed;

// How a value of a scene is read from a scene file.
RfKeyed rf_keyed_value( RfChangedValue value );

// Reads one of these values; one that is missing is left as it is.
RfResult rf_read_keyed( const RfField* field, const RfKeyed* kind, double* value );

// Reads the members "keys" and "interpolation" of an object: for each kind a channel in seconds of the scene, of node −1, without
// keys where none has it. Frames are counted at `fps`, the first is 1, at 0 s; `in_frames`: there are such. Fails where
// keys and the object itself give a value. The channels are to be freed, also on failure.
RfResult rf_read_keys( const RfField* object, RfFps fps, const RfKeyed* kinds, int count, RfChannel* channels, bool* in_frames );

#endif
