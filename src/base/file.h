// Reads whole files into memory, hashes their contents, and refuses what users give in place of a scene.
#ifndef REFRAME_BASE_FILE_H
#define REFRAME_BASE_FILE_H

#include "reframe/error.h"

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

bool rf_is_web_address( const char* path );

// Reads a regular file of at most `limit` bytes; the caller frees `*bytes`, which is never
// NULL on success. Folders, devices and pipes are rejected, so that no path can block the call
// or make it read forever. Addresses of the web are refused with what to do.
RfResult rf_read_file( const char* path, uint64_t limit, uint8_t** bytes, size_t* size, RfError* error );

#define RF_HASH_START 0xcbf29ce484222325ull

// Extends `hash` (RF_HASH_START initially) by some bytes, eight at a time. Not cryptographic.
// Hashing a and then b differs from hashing their concatenation.
uint64_t rf_hash_bytes( uint64_t hash, const void* bytes, size_t size );

// Fails with RF_ERROR_UNSUPPORTED, and says what to do, where the first bytes of `path` are those of a .blend or of a compressed file, as
// Blender writes them too (zstd since 3.0, gzip before), of USD, an archive, a web page or a git-lfs pointer; with
// `is_model` false also those of a model that `convert` reads, or its ending.
RfResult rf_refuse_foreign_file( const char* path, const void* bytes, size_t size, bool is_model, RfError* error );

#endif
