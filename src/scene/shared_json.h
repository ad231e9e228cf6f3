// What scene files and the extras of a glTF say alike: the environment, image sequences, views, and `keys`, values by time or frame.
#ifndef REFRAME_SCENE_SHARED_JSON_H
#define REFRAME_SCENE_SHARED_JSON_H

#include "base/json.h"
#include "scene/movement.h"
#include "scene/scene.h"
#include "scene/texture.h"

// What the JSON says of one.
typedef struct RfEnvironmentText
{
    RfEnvironment environment; // without its map
    const char* map;           // its name as written (owned by the JSON), or NULL
    int view;                  // of a glTF: the "bufferView" in its place; −1: none
    const char* light_group;   // likewise
    RfChannel changes[3];      // by keys: strength, a factor on the radiance; radiance; rotation, radians
    double outside;            // share of the map's light that is outside Rec. 709 and was clipped
    bool in_frames;            // keys are numbers of frames
} RfEnvironmentText;

// Reads {"radiance": [r, g, b], "map": "file", "strength": 1, "rotation": degrees, "visible": true, "keys": […],
// "light_group": "sky"}, in a glTF with a "bufferView" in place of the file; frames of keys are counted at `fps`. Free with rf_destroy_environment_text, also on failure.
RfResult rf_read_environment( const RfField* object, bool in_gltf, RfFps fps, RfEnvironmentText* text );

void rf_destroy_environment_text( RfEnvironmentText* text );

// Loads the map from `path`; the error also names the field.
RfResult rf_load_environment( const RfField* object, const char* path, RfEnvironmentText* text );

// Decodes the map from the bytes of a file.
RfResult rf_decode_environment( const RfField* object, const void* bytes, size_t size, RfEnvironmentText* text );

// Gives the scene the environment and what changes it, out of the text. A constant one does not turn.
RfResult rf_give_environment( const RfField* object, RfEnvironmentText* text, RfScene* scene, RfLog* log );

// Lets an environment that changes be as it is at `time`, and lists that in scene->unrendered.
RfResult rf_freeze_environment( RfScene* scene, double time, RfError* error );

// Continues a hash with the pixels of the map.
uint64_t rf_hash_environment( uint64_t hash, const RfEnvironment* environment );

// Reads {"frames": "film.####.png", "first": 1, "last": 48, "start": 0, "fps": 24, "repeat": "hold"}. `frames` is the pattern as
// written (owned by the JSON); sequence->pattern is left to the caller, and fps is 0 where nothing is said.
RfResult rf_read_sequence( const RfField* object, RfImageSequence* sequence, const char** frames );

// Reads {"transform": "AgX", "look": "AgX - Punchy", "exposure": 0.5, "gamma": 1}; a field without a value changes nothing.
RfResult rf_read_view( const RfField* object, RfViewText* view );

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
