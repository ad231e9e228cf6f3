#include "base/blend_file.h"

#include <stdbool.h>
#include <string.h>

#define EXPORT "export it by blender -b %.300s -P scripts/blender/export.py -- scene.glb"

static bool starts_with( const void* bytes, size_t size, const char* magic, size_t length )
{
    return size >= length && memcmp( bytes, magic, length ) == 0;
}

// "shot.blend", and its backups "shot.blend1".
static bool is_named_blend( const char* path )
{
    const char* end = strrchr( path, '.' );
    return end != NULL && strncmp( end, ".blend", 6 ) == 0;
}

RfResult rf_refuse_blend_file( const char* path, const void* bytes, size_t size, RfError* error )
{
    bool zstd = starts_with( bytes, size, "\x28\xb5\x2f\xfd", 4 ), gzip = starts_with( bytes, size, "\x1f\x8b", 2 );
    const char* by = zstd ? "zstd" : "gzip";
    if ( starts_with( bytes, size, "BLENDER", 7 ) )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%.300s: is a Blender file: " EXPORT, path, path );
    if ( ( zstd || gzip ) && is_named_blend( path ) )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%.300s: is a Blender file, compressed by %s: " EXPORT, path, by, path );
    if ( zstd || gzip )
        return rf_fail( error, RF_ERROR_UNSUPPORTED,
                        "%.300s: is compressed by %s: uncompress it first, or if it is a Blender file " EXPORT, path, by, path );
    return RF_OK;
}
