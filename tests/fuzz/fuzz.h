// What the fuzz targets share. A target is one fuzz_*.c with LLVMFuzzerTestOneInput: built with REFRAME_SANITIZE=fuzzer it is
// a program of libFuzzer, else one that replays the files of its corpus (replay.c).
#ifndef REFRAME_TESTS_FUZZ_FUZZ_H
#define REFRAME_TESTS_FUZZ_FUZZ_H

#include "reframe/error.h"

#include <stddef.h>
#include <stdint.h>

int LLVMFuzzerTestOneInput( const uint8_t* data, size_t size );

// Writes the bytes to a file of this name in a folder of the process's own, and returns its path, valid until the next call.
const char* fuzz_file( const char* name, const void* data, size_t size );

// Makes a .glb of a document and its binary chunk, and returns its size; `out` has room for both and 40 bytes.
size_t fuzz_glb( uint8_t* out, const char* json, const uint8_t* data, size_t size );

// Aborts unless a failure has a code and one line of text.
void fuzz_check( RfResult result, const RfError* error );

// Aborts where the condition does not hold; NDEBUG changes nothing.
void fuzz_must( int condition );

// A glTF with a mesh, two cameras and materials for scene files and camera paths to refer to.
extern const char fuzz_room[];

#endif
