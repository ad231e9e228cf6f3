// Vertices of meshes: equal ones become one, and normals follow morph targets.
#include "import/assimp_import.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

// One of the arrays of a mesh, by vertices.
typedef struct Column
{
    char* data;
    size_t size; // of a vertex
} Column;

static void add_column( Column* columns, size_t* count, void* data, size_t size )
{
    if ( data != NULL )
        columns[( *count )++] = ( Column ){ data, size };
}

static uint64_t hash_vertex( const Column* columns, size_t count, size_t vertex )
{
    uint64_t hash = 1469598103934665603ull;
    for ( size_t i = 0; i < count; ++i )
    {
        const char* at = columns[i].data + vertex * columns[i].size;
        for ( size_t k = 0; k < columns[i].size; k += 4 )
        {
            uint32_t word;
            memcpy( &word, at + k, 4 );
            hash = ( hash ^ word ) * 1099511628211ull;
            hash ^= hash >> 29;
        }
    }
    return hash;
}

static bool is_same( const Column* columns, size_t count, size_t a, size_t b )
{
    for ( size_t i = 0; i < count; ++i )
    {
        size_t size = columns[i].size;
        if ( memcmp( columns[i].data + a * size, columns[i].data + b * size, size ) != 0 )
            return false;
    }
    return true;
}

// assimp would compare neither bones nor, in floats, what lies close together.
bool rf_join_vertices( RfModelMesh* mesh )
{
    size_t count = 0, vertices = mesh->vertex_count, corners = 3 * (size_t)mesh->triangle_count, room = 1;
    Column* columns = malloc( ( 6 + 2 * (size_t)mesh->morph_count ) * sizeof *columns );
    while ( room < 2 * vertices )
        room *= 2;
    uint32_t* table = malloc( room * sizeof *table ); // of new vertices, by hash
    uint32_t* target = malloc( ( vertices + 1 ) * sizeof *target );
    bool good = columns != NULL && table != NULL && target != NULL;
    if ( good )
    {
        add_column( columns, &count, mesh->positions, 12 );
        add_column( columns, &count, mesh->normals, 12 );
        add_column( columns, &count, mesh->uvs, 8 );
        add_column( columns, &count, mesh->colors, 16 );
        if ( mesh->skin != NULL )
        {
            add_column( columns, &count, mesh->skin->influences, 2 * RF_MODEL_INFLUENCES );
            add_column( columns, &count, mesh->skin->weights, 4 * RF_MODEL_INFLUENCES );
        }
        for ( int i = 0; i < mesh->morph_count; ++i )
        {
            add_column( columns, &count, mesh->morphs[i].positions, 12 );
            add_column( columns, &count, mesh->morphs[i].normals, 12 );
        }
        memset( table, 0xff, room * sizeof *table );
        memset( target, 0xff, ( vertices + 1 ) * sizeof *target );
        for ( size_t i = 0; i < corners; ++i )
            target[mesh->indices[i]] = 0; // used
    }
    uint32_t next = 0;
    for ( size_t v = 0; good && v < vertices; ++v )
    {
        if ( target[v] == UINT32_MAX )
            continue;
        size_t at = (size_t)hash_vertex( columns, count, v ) & ( room - 1 );
        while ( table[at] != UINT32_MAX && !is_same( columns, count, table[at], v ) )
            at = ( at + 1 ) & ( room - 1 );
        if ( table[at] == UINT32_MAX )
        {
            for ( size_t i = 0; i < count && next < v; ++i )
                memcpy( columns[i].data + next * columns[i].size, columns[i].data + v * columns[i].size, columns[i].size );
            table[at] = next++;
        }
        target[v] = table[at];
    }
    for ( size_t i = 0; good && i < corners; ++i )
        mesh->indices[i] = target[mesh->indices[i]];
    if ( good )
        mesh->vertex_count = next;
    free( columns );
    free( table );
    free( target );
    return good;
}

// The number of the first vertex that has the position and normal of each; NULL: out of memory.
static uint32_t* find_corners( const RfModelMesh* mesh )
{
    const Column columns[2] = { { (char*)mesh->positions, 12 }, { (char*)mesh->normals, 12 } };
    size_t vertices = mesh->vertex_count, room = 1;
    while ( room < 2 * vertices )
        room *= 2;
    uint32_t *table = malloc( room * sizeof *table ), *first = malloc( ( vertices + 1 ) * sizeof *first );
    if ( table == NULL || first == NULL )
    {
        free( table );
        free( first );
        return NULL;
    }
    memset( table, 0xff, room * sizeof *table );
    for ( size_t v = 0; v < vertices; ++v )
    {
        size_t at = (size_t)hash_vertex( columns, 2, v ) & ( room - 1 );
        while ( table[at] != UINT32_MAX && !is_same( columns, 2, table[at], v ) )
            at = ( at + 1 ) & ( room - 1 );
        if ( table[at] == UINT32_MAX )
            table[at] = (uint32_t)v;
        first[v] = table[at];
    }
    free( table );
    return first;
}

// The normals of faces around each corner, by their areas; `steps`, which may be NULL, is added to the positions.
static void add_faces( const RfModelMesh* mesh, const float* steps, const uint32_t* first, double* sums )
{
    memset( sums, 0, 3 * (size_t)mesh->vertex_count * sizeof *sums );
    for ( size_t i = 0; i < mesh->triangle_count; ++i )
    {
        const uint32_t* corner = mesh->indices + 3 * i;
        double p[3][3];
        for ( int k = 0; k < 9; ++k )
        {
            size_t at = 3 * (size_t)corner[k / 3] + (size_t)( k % 3 );
            p[k / 3][k % 3] = (double)mesh->positions[at] + ( steps != NULL ? (double)steps[at] : 0.0 );
        }
        for ( int k = 0; k < 9; ++k )
        {
            int x = ( k % 3 + 1 ) % 3, y = ( k % 3 + 2 ) % 3;
            double n = ( p[1][x] - p[0][x] ) * ( p[2][y] - p[0][y] ) - ( p[1][y] - p[0][y] ) * ( p[2][x] - p[0][x] );
            sums[3 * (size_t)first[corner[k / 3]] + (size_t)( k % 3 )] += n;
        }
    }
}

static float* turn_normals( const RfModelMesh* mesh, const uint32_t* first, const double* before, const double* after )
{
    float* out = malloc( 3 * (size_t)mesh->vertex_count * sizeof *out );
    for ( size_t v = 0; out != NULL && v < mesh->vertex_count; ++v )
    {
        const double *a = before + 3 * (size_t)first[v], *b = after + 3 * (size_t)first[v];
        double was = sqrt( a[0] * a[0] + a[1] * a[1] + a[2] * a[2] ), is = sqrt( b[0] * b[0] + b[1] * b[1] + b[2] * b[2] );
        for ( size_t k = 0; k < 3; ++k )
            out[3 * v + k] =
                was > 0.0 && is > 0.0 && isfinite( was ) && isfinite( is ) ? (float)( b[k] / is - a[k] / was ) : 0.0f;
    }
    return out;
}

bool rf_turn_normals( RfModelMesh* mesh )
{
    uint32_t* first = NULL;
    double *before = NULL, *after = NULL;
    bool good = true;
    for ( int i = 0; good && mesh->normals != NULL && i < mesh->morph_count; ++i )
    {
        RfModelMorph* morph = mesh->morphs + i;
        if ( morph->normals != NULL )
            continue;
        if ( first == NULL )
        {
            first = find_corners( mesh );
            before = malloc( 3 * (size_t)mesh->vertex_count * sizeof *before );
            after = malloc( 3 * (size_t)mesh->vertex_count * sizeof *after );
            good = first != NULL && before != NULL && after != NULL;
            if ( good )
                add_faces( mesh, NULL, first, before );
        }
        if ( !good )
            break;
        add_faces( mesh, morph->positions, first, after );
        good = ( morph->normals = turn_normals( mesh, first, before, after ) ) != NULL;
    }
    free( first );
    free( before );
    free( after );
    return good;
}
