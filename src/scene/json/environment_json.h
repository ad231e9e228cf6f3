// The environment in JSON: in scene files and in the extras of a glTF scene.
#ifndef REFRAME_SCENE_JSON_ENVIRONMENT_JSON_H
#define REFRAME_SCENE_JSON_ENVIRONMENT_JSON_H

#include "scene/json/json_document.h"
#include "scene/scene.h"

// Reads {"radiance": [r, g, b], "map": "file", "rotation": degrees, "visible": true}. Does not
// load the map: *map is its name as written (owned by the JSON), or NULL.
// In a glTF it may have a "bufferView" in place of the file, whose index is *view (−1: none); elsewhere `view` is NULL.
RfResult rf_read_environment( const RfField* object, RfEnvironment* environment, const char** map, int* view );

// Loads the map from `path`; the error also names the field.
RfResult rf_load_environment( const RfField* object, const char* path, RfEnvironment* environment );

// Decodes the map from the bytes of a file.
RfResult rf_decode_environment( const RfField* object, const void* bytes, size_t size, RfEnvironment* environment );

// Continues a hash with the pixels of the map.
uint64_t rf_hash_environment( uint64_t hash, const RfEnvironment* environment );

#endif
