// The binary container of glTF: a header, a chunk of JSON, a chunk of bytes.
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
    const uint8_t* bin; // NULL: there is none
    size_t bin_size;
} RfGlb;

// Whether the bytes begin as a .glb does; names say nothing.
bool rf_is_glb( const uint8_t* bytes, size_t size );

// Finds the chunks. `path` is for the error line only.
RfResult rf_split_glb( const char* path, const uint8_t* bytes, size_t size, RfGlb* glb, RfError* error );

#endif
