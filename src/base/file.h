// Whole files into memory, and a hash to tell one content from another.
#ifndef REFRAME_BASE_FILE_H
#define REFRAME_BASE_FILE_H

#include "reframe/error.h"

#include <stddef.h>
#include <stdint.h>

// Reads a regular file of at most `limit` bytes; the caller frees `*bytes`,
// which is never NULL on success. A folder, a device or a pipe is refused, so
// that no name can make this wait or read without end.
RfResult rf_read_file( const char* path, uint64_t limit, uint8_t** bytes, size_t* size, RfError* error );

#define RF_HASH_START 0xcbf29ce484222325ull

// Continues `hash` (RF_HASH_START at first) with some bytes; eight at a time,
// as fast as they come from memory. For telling contents apart, not for
// secrets. Hashing a, then b is not the same as hashing a and b joined.
uint64_t rf_hash_bytes( uint64_t hash, const void* bytes, size_t size );

#endif
