#include "scene/gltf/glb.h"

#include <string.h>

#define MAGIC "glTF"
#define CHUNK_JSON 0x4e4f534au
#define CHUNK_BIN 0x004e4942u
#define HEADER_SIZE 12
#define CHUNK_HEADER_SIZE 8

static uint32_t read_u32( const uint8_t* at )
{
    return (uint32_t)at[0] | (uint32_t)at[1] << 8 | (uint32_t)at[2] << 16 | (uint32_t)at[3] << 24;
}

bool rf_is_glb( const uint8_t* bytes, size_t size ) { return size >= 4 && memcmp( bytes, MAGIC, 4 ) == 0; }

static RfResult check_header( const char* path, const uint8_t* bytes, size_t size, RfError* error )
{
    if ( size < HEADER_SIZE )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: GLB header: the file ends inside it: copy or export it again", path );
    uint32_t version = read_u32( bytes + 4 );
    if ( version != 2 )
        return rf_fail( error, RF_ERROR_UNSUPPORTED, "%s: GLB header: version %u, not 2: export it as glTF 2.0", path, version );
    uint32_t length = read_u32( bytes + 8 );
    if ( length != size )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: GLB header: says %u bytes, the file has %zu: copy or export it again", path,
                        length, size );
    return RF_OK;
}

RfResult rf_split_glb( const char* path, const uint8_t* bytes, size_t size, RfGlb* glb, RfError* error )
{
    *glb = ( RfGlb ){ 0 };
    RfResult result = check_header( path, bytes, size, error );
    if ( result != RF_OK )
        return result;

    size_t at = HEADER_SIZE;
    for ( int chunk = 0; at < size; ++chunk )
    {
        if ( size - at < CHUNK_HEADER_SIZE )
            return rf_fail( error, RF_ERROR_FORMAT, "%s: GLB chunk %d: the file ends inside its header: export it again", path,
                            chunk );
        uint32_t length = read_u32( bytes + at ), type = read_u32( bytes + at + 4 );
        at += CHUNK_HEADER_SIZE;
        if ( length > size - at )
            return rf_fail( error, RF_ERROR_FORMAT,
                            "%s: GLB chunk %d: says %u bytes, %zu are left in the file: copy or export it again", path, chunk,
                            length, size - at );
        if ( ( chunk == 0 ) != ( type == CHUNK_JSON ) )
            return rf_fail( error, RF_ERROR_FORMAT,
                            "%s: GLB chunk %d: the first chunk, and no other, must be JSON: export it again", path, chunk );
        if ( chunk == 0 )
        {
            glb->json = bytes + at;
            glb->json_size = length;
        }
        else if ( chunk == 1 && type == CHUNK_BIN )
        {
            glb->bin = bytes + at;
            glb->bin_size = length;
        }
        // other chunks belong to extensions and are skipped, as the specification requires
        at += length;
    }
    if ( glb->json == NULL )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: GLB: has no JSON chunk: export it again", path );
    return RF_OK;
}
