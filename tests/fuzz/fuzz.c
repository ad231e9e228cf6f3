#include "fuzz/fuzz.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define MOST_FILES 4

static char s_folder[64];
static char s_paths[MOST_FILES][128]; // files to remove
static int s_count;

void fuzz_must( int condition )
{
    if ( !condition )
        abort();
}

void fuzz_check( RfResult result, const RfError* error )
{
    if ( result == RF_OK )
        return;
    fuzz_must( error->code == result );
    fuzz_must( error->text[0] != '\0' && strchr( error->text, '\n' ) == NULL );
}

static void clean( void )
{
    for ( int i = 0; i < s_count; ++i )
        unlink( s_paths[i] );
    rmdir( s_folder );
}

// In memory where the system has such a folder: a file is written for each input.
static void make_folder( void )
{
    snprintf( s_folder, sizeof s_folder, "%s/reframe-fuzz-XXXXXX", access( "/dev/shm", W_OK ) == 0 ? "/dev/shm" : "/tmp" );
    fuzz_must( mkdtemp( s_folder ) != NULL );
    atexit( clean );
}

const char* fuzz_file( const char* name, const void* data, size_t size )
{
    char path[128];
    int known = 0;
    if ( s_folder[0] == '\0' )
        make_folder();
    snprintf( path, sizeof path, "%s/%s", s_folder, name );
    while ( known < s_count && strcmp( s_paths[known], path ) != 0 )
        ++known;
    fuzz_must( known < MOST_FILES );
    if ( known == s_count )
        memcpy( s_paths[s_count++], path, sizeof path );
    int file = open( path, O_WRONLY | O_CREAT | O_TRUNC, 0600 );
    fuzz_must( file >= 0 && write( file, data, size ) == (ssize_t)size );
    fuzz_must( close( file ) == 0 );
    return s_paths[known];
}

static void put_chunk( uint8_t** at, const char* kind, const void* data, size_t size, int pad )
{
    uint32_t padded = (uint32_t)( size + 3 ) / 4 * 4;
    memcpy( *at, &padded, 4 );
    memcpy( *at + 4, kind, 4 );
    memset( *at + 8, pad, padded );
    memcpy( *at + 8, data, size );
    *at += 8 + padded;
}

size_t fuzz_glb( uint8_t* out, const char* json, const uint8_t* data, size_t size )
{
    uint8_t* at = out + 12;
    put_chunk( &at, "JSON", json, strlen( json ), ' ' );
    put_chunk( &at, "BIN", data, size, 0 );
    uint32_t header[3] = { 0x46546c67, 2, (uint32_t)( at - out ) };
    memcpy( out, header, 12 );
    return header[2];
}

const char fuzz_room[] =
    "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0,1,2]}],"
    "\"cameras\":[{\"type\":\"perspective\",\"perspective\":{\"yfov\":0.8,\"znear\":0.1}}],"
    "\"nodes\":[{\"name\":\"Eye\",\"camera\":0},{\"name\":\"Side\",\"camera\":0,\"translation\":[1,0,0]},{\"mesh\":0}],"
    "\"meshes\":[{\"primitives\":[{\"attributes\":{\"POSITION\":0},\"material\":2}]}],"
    "\"materials\":[{\"name\":\"vase\",\"extras\":{\"reframe\":{\"bsdf\":\"phong\",\"diffuse\":[0.2,0.1,0.1],"
    "\"specular\":[0.5,0.5,0.5],\"exponent\":60}}},{\"name\":\"floor\",\"pbrMetallicRoughness\":{\"metallicFactor\":0}},"
    "{\"name\":\"lamp\",\"emissiveFactor\":[1,1,1]}],"
    "\"accessors\":[{\"bufferView\":0,\"componentType\":5126,\"count\":3,\"type\":\"VEC3\","
    "\"min\":[-1,-1,-2],\"max\":[1,1,-2]}],\"bufferViews\":[{\"buffer\":0,\"byteLength\":36}],"
    "\"buffers\":[{\"byteLength\":36,\"uri\":\"data:application/octet-stream;base64,"
    "AACAvwAAgL8AAADAAACAPwAAgL8AAADAAAAAAAAAgD8AAADA\"}]}";
