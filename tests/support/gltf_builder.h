// Small glTF files made in memory, for tests: accessors are added one by one,
// the rest of the JSON is given as text, and the whole is written as .gltf
// with a data URI or as .glb.
#ifndef REFRAME_TESTS_GLTF_BUILDER_H
#define REFRAME_TESTS_GLTF_BUILDER_H

#include <stddef.h>
#include <stdint.h>

typedef struct GltfBuilder
{
    uint8_t bin[16384];
    size_t bin_size;
    int count; // accessors, each with a view of its own
    char views[8192];
    char accessors[8192];
    char json[32768];
} GltfBuilder;

typedef struct GltfFolder
{
    char path[64];
    char file[128]; // last name made by folder_file
} GltfFolder;

// A fresh folder under /tmp; removed again with the files of the names that the
// tests use: a.gltf, a.glb, a.bin, "b c.bin".
GltfFolder make_folder( void );
void remove_folder( GltfFolder* folder );
// The path of a file in it, valid until the next call.
const char* folder_file( GltfFolder* folder, const char* name );
const char* write_bytes( GltfFolder* folder, const char* name, const void* bytes, size_t size );

// Each adds data, a view and an accessor, and returns its index. `more` is
// further JSON of the accessor, such as ",\"normalized\":true".
int add_gltf_accessor( GltfBuilder* b, int component_type, const char* type, int count, const void* data, size_t size,
                       const char* more );
int add_gltf_floats( GltfBuilder* b, const char* type, int components, int count, const float* data );
int add_gltf_u16( GltfBuilder* b, int count, const uint16_t* data );

// A string for the caller to free.
char* gltf_base64( const uint8_t* bytes, size_t size );

// The JSON with a buffer that `uri` names (NULL: the chunk of a .glb), and the
// test's own members, `rest`, after it.
const char* build_gltf_json( GltfBuilder* b, const char* uri, const char* rest );
// Writes a.gltf with a data URI; returns its path.
const char* write_gltf( GltfBuilder* b, GltfFolder* folder, const char* rest );
// The bytes of a .glb; the caller frees them.
uint8_t* build_glb( GltfBuilder* b, const char* rest, size_t* size );

// One mutation, the same for the same number: flips, truncations, and digits
// or brackets of the JSON replaced by others. The container's own length is
// mended most of the time, else nothing behind it would be reached. Returns
// the new size, at most the old one.
size_t mutate_bytes( uint8_t* bytes, size_t size, uint64_t number );

#endif
