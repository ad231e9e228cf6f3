// Writes the seeds of the targets draco and meshopt: make_fuzz_packed CORPUS
#include "support/draco_encode.h"

#include <meshoptimizer.h>

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define SIDE 5
#define POINTS ( SIDE * SIDE )
#define FACES ( 2 * ( SIDE - 1 ) * ( SIDE - 1 ) )

static float s_positions[3 * POINTS], s_normals[3 * POINTS], s_uvs[2 * POINTS];
static uint8_t s_colors[4 * POINTS];
static uint32_t s_indices[3 * FACES];

static void save( const char* folder, const char* name, const void* head, size_t head_size, const void* bytes, size_t size )
{
    char path[1024];
    snprintf( path, sizeof path, "%s/%s", folder, name );
    FILE* file = fopen( path, "wb" );
    if ( file == NULL || fwrite( head, 1, head_size, file ) != head_size || fwrite( bytes, 1, size, file ) != size ||
         fclose( file ) != 0 )
    {
        perror( path );
        exit( 1 );
    }
}

static void make_square( void )
{
    for ( int i = 0; i < POINTS; ++i )
    {
        float x = (float)( i % SIDE ), y = (float)( i / SIDE );
        memcpy( s_positions + 3 * i, ( float[3] ){ x, y, 0.25f * (float)( i * i % 7 ) }, 12 );
        memcpy( s_normals + 3 * i, ( float[3] ){ 0.6f, 0, 0.8f }, 12 );
        memcpy( s_uvs + 2 * i, ( float[2] ){ 0.25f * x, 0.25f * y }, 8 );
        memcpy( s_colors + 4 * i, ( uint8_t[4] ){ (uint8_t)( 10 * i ), 255, 0, 128 }, 4 );
    }
    for ( uint32_t f = 0; f < FACES; ++f )
    {
        uint32_t cell = f / 2, a = cell / ( SIDE - 1 ) * SIDE + cell % ( SIDE - 1 );
        const uint32_t corners[2][3] = { { a, a + 1, a + SIDE }, { a + 1, a + SIDE + 1, a + SIDE } };
        memcpy( s_indices + 3 * f, corners[f % 2], 12 );
    }
}

static void make_draco( const char* folder )
{
    for ( int i = 0; i < 4; ++i )
    {
        int bits = i < 2 ? 0 : 10;
        size_t size;
        char name[64];
        DracoInput input = { .points = POINTS,
                             .faces = FACES,
                             .indices = s_indices,
                             .sequential = i % 2 == 0,
                             .attribute_count = 4,
                             .attributes = { { 'p', 5126, 3, false, bits, s_positions },
                                             { 'n', 5126, 3, false, bits, s_normals },
                                             { 't', 5126, 2, false, bits, s_uvs },
                                             { 'c', 5121, 4, true, 0, s_colors } } };
        uint8_t* bytes = encode_draco( &input, &size );
        snprintf( name, sizeof name, "draco/%s-%d.drc", input.sequential ? "sequential" : "edgebreaker", bits );
        save( folder, name, "", 0, bytes, size );
        free( bytes );
    }
}

// As fuzz_meshopt.c reads it: mode, filter, stride, count.
static void make_meshopt( const char* folder )
{
    uint8_t bytes[4096];
    static const struct
    {
        const char* name;
        uint8_t filter, stride;
        const void* values;
    } s_views[] = { { "meshopt/positions", 0, 2, s_positions }, { "meshopt/exponential", 3, 2, s_positions },
                    { "meshopt/colors", 4, 0, s_colors },       { "meshopt/octahedral", 1, 0, s_colors },
                    { "meshopt/quaternions", 2, 1, s_uvs },     { "meshopt/wide", 4, 1, s_uvs } };
    for ( size_t i = 0; i < sizeof s_views / sizeof s_views[0]; ++i )
    {
        const uint8_t head[4] = { 0, s_views[i].filter, s_views[i].stride, POINTS - 1 };
        size_t size =
            meshopt_encodeVertexBuffer( bytes, sizeof bytes, s_views[i].values, POINTS, 4 + 4 * (size_t)s_views[i].stride );
        save( folder, s_views[i].name, head, 4, bytes, size );
    }
    const uint8_t head[2][4] = { { 1, 0, 0, 3 * FACES - 1 }, { 2, 0, 1, 3 * FACES - 1 } };
    size_t size = meshopt_encodeIndexBuffer( bytes, sizeof bytes, s_indices, 3 * FACES );
    save( folder, "meshopt/triangles", head[0], 4, bytes, size );
    size = meshopt_encodeIndexSequence( bytes, sizeof bytes, s_indices, 3 * FACES );
    save( folder, "meshopt/indices", head[1], 4, bytes, size );
}

int main( int argc, char** argv )
{
    if ( argc != 2 )
    {
        fprintf( stderr, "make_fuzz_packed: name the folder of the corpus\n" );
        return 2;
    }
    make_square();
    make_draco( argv[1] );
    make_meshopt( argv[1] );
    return 0;
}
