// The GLB container of glTF: a header, a JSON chunk, a binary chunk.
#ifndef REFRAME_SCENE_GLTF_GLB_H
#define REFRAME_SCENE_GLTF_GLB_H

#include "reframe/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

// Views into the bytes of the file.
typedef struct RfGlb
{
    const uint8_t* json;
    size_t json_size;
    const uint8_t* bin; // NULL: none
    size_t bin_size;
} RfGlb;

// True if the bytes begin with the GLB header; the file name does not matter.
bool rf_is_glb( const uint8_t* bytes, size_t size );

// Finds the chunks. `path` is only for messages.
RfResult rf_split_glb( const char* path, const uint8_t* bytes, size_t size, RfGlb* glb, RfError* error );

#endif
