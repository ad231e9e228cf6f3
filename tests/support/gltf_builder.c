#include "support/gltf_builder.h"

#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

GltfFolder make_folder( void )
{
    GltfFolder folder = { .path = "/tmp/reframe-gltf-XXXXXX" };
    if ( mkdtemp( folder.path ) == NULL )
        abort();
    return folder;
}

const char* folder_file( GltfFolder* folder, const char* name )
{
    snprintf( folder->file, sizeof folder->file, "%s/%s", folder->path, name );
    return folder->file;
}

const char* write_bytes( GltfFolder* folder, const char* name, const void* bytes, size_t size )
{
    FILE* file = fopen( folder_file( folder, name ), "wb" );
    if ( file == NULL || fwrite( bytes, 1, size, file ) != size || fclose( file ) != 0 )
        abort();
    return folder->file;
}

void remove_folder( GltfFolder* folder )
{
    static const char* const s_names[] = { "a.gltf", "a.glb", "a.bin", "b c.bin" };
    for ( size_t i = 0; i < sizeof s_names / sizeof s_names[0]; ++i )
        unlink( folder_file( folder, s_names[i] ) );
    rmdir( folder->path );
}

__attribute__( ( format( printf, 3, 4 ) ) ) static void append_text( char* text, size_t size, const char* format, ... )
{
    size_t used = strlen( text );
    va_list args;
    va_start( args, format );
    int n = vsnprintf( text + used, size - used, format, args );
    va_end( args );
    if ( n < 0 || (size_t)n >= size - used )
        abort();
}

int add_gltf_accessor( GltfBuilder* b, int component_type, const char* type, int count, const void* data, size_t size,
                       const char* more )
{
    if ( b->bin_size + size + 4 > sizeof b->bin )
        abort();
    memcpy( b->bin + b->bin_size, data, size );
    const char* comma = b->count > 0 ? "," : "";
    append_text( b->views, sizeof b->views, "%s{\"buffer\":0,\"byteOffset\":%zu,\"byteLength\":%zu}", comma, b->bin_size, size );
    append_text( b->accessors, sizeof b->accessors, "%s{\"bufferView\":%d,\"componentType\":%d,\"count\":%d,\"type\":\"%s\"%s}",
                 comma, b->count, component_type, count, type, more );
    b->bin_size += ( size + 3 ) / 4 * 4;
    return b->count++;
}

int add_gltf_floats( GltfBuilder* b, const char* type, int components, int count, const float* data )
{
    return add_gltf_accessor( b, 5126, type, count, data, (size_t)( components * count ) * sizeof *data, "" );
}

int add_gltf_u16( GltfBuilder* b, int count, const uint16_t* data )
{
    return add_gltf_accessor( b, 5123, "SCALAR", count, data, (size_t)count * sizeof *data, "" );
}

const char* build_gltf_json( GltfBuilder* b, const char* uri, const char* rest )
{
    b->json[0] = 0;
    append_text( b->json, sizeof b->json, "{\"asset\":{\"version\":\"2.0\"}" );
    if ( b->count > 0 )
    {
        append_text( b->json, sizeof b->json, ",\"buffers\":[{\"byteLength\":%zu", b->bin_size );
        if ( uri != NULL )
            append_text( b->json, sizeof b->json, ",\"uri\":\"%s\"", uri );
        append_text( b->json, sizeof b->json, "}],\"bufferViews\":[%s],\"accessors\":[%s]", b->views, b->accessors );
    }
    append_text( b->json, sizeof b->json, "%s%s}", rest[0] != 0 ? "," : "", rest );
    return b->json;
}

char* gltf_base64( const uint8_t* bytes, size_t size )
{
    static const char s_digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    char* text = calloc( size / 3 * 4 + 8, 1 );
    char* out = text;
    for ( size_t i = 0; text != NULL && i < size; i += 3 )
    {
        uint32_t word = (uint32_t)bytes[i] << 16;
        word |= i + 1 < size ? (uint32_t)bytes[i + 1] << 8 : 0;
        word |= i + 2 < size ? bytes[i + 2] : 0;
        for ( int d = 0; d < 4; ++d )
            *out++ = i + (size_t)d > size ? '=' : s_digits[word >> ( 18 - 6 * d ) & 63];
    }
    return text;
}

const char* write_gltf( GltfBuilder* b, GltfFolder* folder, const char* rest )
{
    char* data = gltf_base64( b->bin, b->bin_size );
    char* uri = calloc( strlen( data ) + 64, 1 );
    sprintf( uri, "data:application/octet-stream;base64,%s", data );
    build_gltf_json( b, uri, rest );
    free( data );
    free( uri );
    return write_bytes( folder, "a.gltf", b->json, strlen( b->json ) );
}

static void put_u32( uint8_t* at, uint32_t value )
{
    for ( int i = 0; i < 4; ++i )
        at[i] = (uint8_t)( value >> ( 8 * i ) );
}

uint8_t* build_glb( GltfBuilder* b, const char* rest, size_t* size )
{
    build_gltf_json( b, NULL, rest );
    size_t length = strlen( b->json ), padded = ( length + 3 ) / 4 * 4;
    *size = 12 + 8 + padded + 8 + b->bin_size;
    uint8_t* bytes = calloc( *size, 1 );
    memcpy( bytes, "glTF", 4 );
    put_u32( bytes + 4, 2 );
    put_u32( bytes + 8, (uint32_t)*size );
    put_u32( bytes + 12, (uint32_t)padded );
    memcpy( bytes + 16, "JSON", 4 );
    memset( bytes + 20, ' ', padded );
    memcpy( bytes + 20, b->json, length );
    put_u32( bytes + 20 + padded, (uint32_t)b->bin_size );
    memcpy( bytes + 24 + padded, "BIN\0", 4 );
    memcpy( bytes + 28 + padded, b->bin, b->bin_size );
    return bytes;
}

size_t mutate_bytes( uint8_t* bytes, size_t size, uint64_t number )
{
    static const char s_swaps[] = "0123456789-.eE\"[]{},:tfn ";
    uint64_t state = number * 0x9e3779b97f4a7c15ull + 1;
    int changes = 0, wanted = 1 + (int)( number % 4 );
    for ( int tries = 0; changes < wanted && tries < 1000; ++tries )
    {
        state ^= state << 13, state ^= state >> 7, state ^= state << 17;
        size_t at = (size_t)( ( state >> 16 ) % size );
        if ( number % 3 == 0 )
            bytes[at] ^= (uint8_t)( 1u << ( state & 7 ) );
        else if ( number % 3 == 1 && bytes[at] >= '0' && bytes[at] <= '9' )
            bytes[at] = (uint8_t)s_swaps[( state >> 8 ) % 15];
        else if ( number % 3 == 2 && at < size )
            bytes[at] = (uint8_t)s_swaps[( state >> 8 ) % ( sizeof s_swaps - 1 )];
        else
            continue;
        changes += 1;
    }
    if ( number % 17 == 0 )
        size = (size_t)( ( state >> 12 ) % size );
    if ( number % 5 != 0 && size >= 12 )
    {
        memcpy( bytes, "glTF\2\0\0\0", 8 );
        put_u32( bytes + 8, (uint32_t)size );
    }
    return size;
}
