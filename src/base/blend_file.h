// Blender's own files, which users give in place of an export.
#ifndef REFRAME_BASE_BLEND_FILE_H
#define REFRAME_BASE_BLEND_FILE_H

#include "reframe/error.h"

#include <stddef.h>

// Fails with RF_ERROR_UNSUPPORTED, and says how to export it, where the first bytes of `path` are those
// of a .blend or of a compressed file, as Blender writes them too (zstd since 3.0, gzip before).
RfResult rf_refuse_blend_file( const char* path, const void* bytes, size_t size, RfError* error );

#endif
