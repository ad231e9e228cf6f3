// Reads regular files up to a limit without blocking on devices or pipes; hashes contents in words of 64 bits.
#include "base/file.h"

#include "base/random.h"
#include "base/words.h"

#include <errno.h>
#include <fcntl.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <sys/stat.h>
#include <unistd.h>

// Largest single read: read() itself is limited to just under 2 GiB.
#define CHUNK ( (size_t)1 << 30 )

static RfResult check_kind( const char* path, const struct stat* info, uint64_t limit, RfError* error )
{
    if ( S_ISDIR( info->st_mode ) )
        return rf_fail( error, RF_ERROR_IO, "%s: is a folder: name a file in it", path );
    if ( S_ISREG( info->st_mode ) == 0 )
        return rf_fail( error, RF_ERROR_IO, "%s: not a regular file: copy its content into one", path );
    if ( (uint64_t)info->st_size > limit )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: has %llu bytes, more than the limit of %llu: make it smaller", path,
                        (unsigned long long)info->st_size, (unsigned long long)limit );
    if ( (uint64_t)info->st_size >= SIZE_MAX )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: is larger than the address space of this machine", path );
    return RF_OK;
}

static RfResult read_all( const char* path, int file, uint8_t* bytes, size_t size, RfError* error )
{
    size_t done = 0;
    while ( done < size )
    {
        size_t want = size - done < CHUNK ? size - done : CHUNK;
        ssize_t got = read( file, bytes + done, want );
        if ( got < 0 && errno == EINTR )
            continue;
        if ( got < 0 )
            return rf_fail( error, RF_ERROR_IO, "%s: cannot be read: %s", path, strerror( errno ) );
        if ( got == 0 )
            return rf_fail( error, RF_ERROR_IO, "%s: became shorter while it was read: try again", path );
        done += (size_t)got;
    }
    return RF_OK;
}

static RfResult read_open( const char* path, int file, uint64_t limit, uint8_t** bytes, size_t* size, RfError* error )
{
    struct stat info;
    if ( fstat( file, &info ) != 0 )
        return rf_fail( error, RF_ERROR_IO, "%s: cannot be examined: %s", path, strerror( errno ) );
    RfResult result = check_kind( path, &info, limit, error );
    if ( result != RF_OK )
        return result;

    *size = (size_t)info.st_size;
    *bytes = malloc( *size > 0 ? *size : 1 );
    if ( *bytes == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory reading its %zu bytes", path, *size );
    result = read_all( path, file, *bytes, *size, error );
    if ( result != RF_OK )
    {
        free( *bytes );
        *bytes = NULL;
        *size = 0;
    }
    return result;
}

bool rf_is_web_address( const char* path )
{
    return strncasecmp( path, "http://", 7 ) == 0 || strncasecmp( path, "https://", 8 ) == 0;
}

RfResult rf_read_file( const char* path, uint64_t limit, uint8_t** bytes, size_t* size, RfError* error )
{
    *bytes = NULL;
    *size = 0;
    // without O_NONBLOCK, opening a pipe would block until it has a writer
    int file = open( path, O_RDONLY | O_NONBLOCK | O_CLOEXEC );
    if ( file < 0 && rf_is_web_address( path ) )
        return rf_fail( error, RF_ERROR_UNSUPPORTED,
                        "%s: is not fetched: download it and the files that it names, and name it where it is then", path );
    if ( file < 0 )
        return rf_fail( error, RF_ERROR_IO, "%s: cannot be opened: %s", path, strerror( errno ) );
    RfResult result = read_open( path, file, limit, bytes, size, error );
    close( file );
    return result;
}

uint64_t rf_hash_bytes( uint64_t hash, const void* bytes, size_t size )
{
    const uint8_t* at = bytes;
    size_t left = size;
    for ( ; left >= 8; at += 8, left -= 8 )
    {
        uint64_t word;
        memcpy( &word, at, 8 );
        hash = rf_mix64( hash ^ word );
    }
    uint64_t tail = 0;
    for ( size_t i = 0; i < left; ++i )
        tail |= (uint64_t)at[i] << ( 8 * i );
    // the size distinguishes trailing zeros
    hash = rf_mix64( hash ^ tail );
    return rf_mix64( hash ^ (uint64_t)size );
}

#define EXPORT "export it by blender -b %.300s -P scripts/blender/export.py -- scene.glb"

// In any case of the letters.
static bool starts_with( const void* bytes, size_t size, const char* magic, size_t length )
{
    return size >= length && strncasecmp( bytes, magic, length ) == 0;
}

// "shot.blend", and its backups "shot.blend1".
static bool is_named_blend( const char* path )
{
    const char* end = strrchr( path, '.' );
    return end != NULL && strncmp( end, ".blend", 6 ) == 0;
}

typedef struct Format
{
    const char *magic, *ending; // what it begins with, or what its name ends in; or NULL
    bool is_model;
    const char *name, *advice;
} Format;

#define USD_ADVICE "export it as glTF, such as by Blender"
#define MODEL_ADVICE "reframe convert makes a .glb of it"

static const Format s_formats[] = {
    { "version https://git-lfs", NULL, false, "a git-lfs pointer", "git lfs pull gets the file" },
    { "<!DOCTYPE", NULL, false, "a web page", "download the file itself" },
    { "<html", NULL, false, "a web page", "download the file itself" },
    { "#usda", NULL, false, "USD", USD_ADVICE },
    { "PXR-USDC", NULL, false, "USD", USD_ADVICE },
    { NULL, ".usdz", false, "USD", USD_ADVICE },
    { "PK\3\4", NULL, false, "a zip archive", "unpack it" },
    { "Kaydara FBX", NULL, true, "FBX", MODEL_ADVICE },
    { "; FBX", NULL, true, "FBX", MODEL_ADVICE },
    { "ply", NULL, true, "PLY", MODEL_ADVICE },
    { NULL, ".fbx", true, "FBX", MODEL_ADVICE },
    { NULL, ".obj", true, "OBJ", MODEL_ADVICE },
    { NULL, ".dae", true, "Collada", MODEL_ADVICE },
};

static RfResult refuse_format( const char* path, const void* bytes, size_t size, bool is_model, RfError* error )
{
    for ( size_t i = 0; i < sizeof s_formats / sizeof s_formats[0]; ++i )
    {
        const Format* f = s_formats + i;
        bool is =
            f->magic != NULL ? starts_with( bytes, size, f->magic, strlen( f->magic ) ) : rf_has_extension( path, f->ending );
        if ( is && !( f->is_model && is_model ) )
            return rf_fail( error, RF_ERROR_UNSUPPORTED, "%.300s: is %s: %s", path, f->name, f->advice );
    }
    return RF_OK;
}

RfResult rf_refuse_foreign_file( const char* path, const void* bytes, size_t size, bool is_model, RfError* error )
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
    return refuse_format( path, bytes, size, is_model, error );
}
