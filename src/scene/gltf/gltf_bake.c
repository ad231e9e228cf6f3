// Bakes primitives into lists of triangles.
#include "scene/gltf/gltf_geometry.h"

#include "scene/deformation.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// Bakes the other vertex attributes: texture coordinates, colours, tangents.

// Allocates an attribute when the first mesh has it; vertices before it get `fill`.
static RfResult reserve_attribute( const RfGltf* gltf, const RfGltfBaker* baker, const char* where, const float* needed,
                                   int components, float fill, float** all )
{
    if ( needed == NULL || *all != NULL )
        return RF_OK;
    size_t count = (size_t)baker->vertex_capacity * (size_t)components;
    *all = malloc( ( count + 1 ) * sizeof **all );
    if ( *all == NULL )
        return rf_gltf_no_memory( gltf, where );
    for ( size_t i = 0; i < count; ++i )
        ( *all )[i] = fill;
    return RF_OK;
}

// Bakes texture coordinates, colours and tangents.
static RfResult reserve_attributes( const RfGltf* gltf, const RfGltfBaker* baker, const RfGltfPrimitive* primitive,
                                    const char* where )
{
    RfTriangles* t = baker->triangles;
    RfResult result = reserve_attribute( gltf, baker, where, primitive->uvs, 2, 0.0f, &t->uvs );
    if ( result == RF_OK )
        result = reserve_attribute( gltf, baker, where, primitive->uvs1, 2, 0.0f, &t->uvs1 );
    if ( result == RF_OK )
        result = reserve_attribute( gltf, baker, where, primitive->colors, 4, 1.0f, &t->colors );
    if ( result == RF_OK )
        result = reserve_attribute( gltf, baker, where, primitive->tangents, 4, 0.0f, &t->tangents );
    return result;
}

static void copy_attribute( float* all, const float* values, int components, float fill, uint32_t to, uint32_t from )
{
    if ( all == NULL )
        return;
    for ( size_t i = 0, n = (size_t)components; i < n; ++i )
        all[n * to + i] = values != NULL ? values[n * from + i] : fill;
}

static void copy_attributes( RfTriangles* t, uint32_t to, const RfGltfPrimitive* primitive, uint32_t from )
{
    copy_attribute( t->uvs, primitive->uvs, 2, 0.0f, to, from );
    copy_attribute( t->uvs1, primitive->uvs1, 2, 0.0f, to, from );
    copy_attribute( t->colors, primitive->colors, 4, 1.0f, to, from );
    copy_attribute( t->tangents, NULL, 4, 0.0f, to, from );
}

// `sign` is −1 for a mirroring matrix.
static void transform_tangent( RfTriangles* t, uint32_t to, const RfGltfPrimitive* primitive, uint32_t from, const RfMat4* matrix,
                               double sign )
{
    if ( primitive->tangents == NULL )
        return;
    const float* tangent = primitive->tangents + 4 * (size_t)from;
    float* out = t->tangents + 4 * (size_t)to;
    double local[3] = { (double)tangent[0], (double)tangent[1], (double)tangent[2] }, placed[3];
    rf_mat4_apply( matrix, local, 0.0, placed );
    double length = sqrt( placed[0] * placed[0] + placed[1] * placed[1] + placed[2] * placed[2] );
    bool usable = length > 0.0 && length <= DBL_MAX;
    for ( int i = 0; i < 3; ++i )
        out[i] = usable ? (float)( placed[i] / length ) : 0.0f;
    out[3] = !usable ? 0.0f : (float)( ( tangent[3] < 0.0f ? -1.0 : 1.0 ) * sign );
}

// Bakes primitives into world-space triangles by the matrix of their node, in double, rounded
// once.

#define MAX_VERTICES ( 3u << 28 )

static bool grow_floats( float** memory, size_t count )
{
    float* grown = realloc( *memory, count * sizeof *grown );
    if ( grown == NULL )
        return false;
    *memory = grown;
    return true;
}

static bool grow_numbers( uint32_t** memory, size_t count )
{
    uint32_t* grown = realloc( *memory, count * sizeof *grown );
    if ( grown == NULL )
        return false;
    *memory = grown;
    return true;
}

static uint32_t next_capacity( uint32_t capacity, uint32_t need, uint32_t most )
{
    uint32_t larger = capacity < most / 2 ? capacity + capacity / 2 : most;
    return larger > need ? larger : need;
}

static RfResult reserve_vertices( const RfGltf* gltf, RfGltfBaker* baker, uint32_t more, const char* where )
{
    RfTriangles* t = baker->triangles;
    if ( more > MAX_VERTICES - t->vertex_count )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where, "more than %u vertices in all: split the scene", MAX_VERTICES );
    if ( t->vertex_count + more <= baker->vertex_capacity )
        return RF_OK;
    size_t capacity = next_capacity( baker->vertex_capacity, t->vertex_count + more, MAX_VERTICES );
    if ( grow_floats( &t->positions, capacity * 3 ) == false || grow_floats( &t->normals, capacity * 3 ) == false ||
         ( t->uvs != NULL && grow_floats( &t->uvs, capacity * 2 ) == false ) ||
         ( t->uvs1 != NULL && grow_floats( &t->uvs1, capacity * 2 ) == false ) ||
         ( t->colors != NULL && grow_floats( &t->colors, capacity * 4 ) == false ) ||
         ( t->tangents != NULL && grow_floats( &t->tangents, capacity * 4 ) == false ) )
        return rf_gltf_no_memory( gltf, where );
    baker->vertex_capacity = (uint32_t)capacity;
    return RF_OK;
}

static RfResult reserve_triangles( const RfGltf* gltf, RfGltfBaker* baker, uint32_t more, const char* where )
{
    RfTriangles* t = baker->triangles;
    // dropped triangles count too, else a small file could request any amount of work
    if ( more > RF_GLTF_MAX_TRIANGLES - baker->placed )
        return rf_gltf_fail( gltf, RF_ERROR_UNSUPPORTED, where, "more than %u triangles in all: split the scene",
                             RF_GLTF_MAX_TRIANGLES );
    baker->placed += more;
    if ( t->count + more <= baker->triangle_capacity )
        return RF_OK;
    size_t capacity = next_capacity( baker->triangle_capacity, t->count + more, RF_GLTF_MAX_TRIANGLES );
    if ( grow_numbers( &t->indices, capacity * 3 ) == false || grow_numbers( &t->material, capacity ) == false )
        return rf_gltf_no_memory( gltf, where );
    baker->triangle_capacity = (uint32_t)capacity;
    return RF_OK;
}

static RfResult reserve( const RfGltf* gltf, RfGltfBaker* baker, const RfGltfPrimitive* primitive, const char* where )
{
    uint32_t vertices = primitive->normals != NULL ? primitive->vertex_count : primitive->triangle_count * 3;
    RfResult result = reserve_vertices( gltf, baker, vertices, where );
    if ( result == RF_OK )
        result = reserve_triangles( gltf, baker, primitive->triangle_count, where );
    if ( result == RF_OK )
        result = reserve_attributes( gltf, baker, primitive, where );
    if ( result != RF_OK || primitive->vertex_count <= baker->world_capacity )
        return result;
    if ( grow_floats( &baker->world, (size_t)primitive->vertex_count * 3 ) == false )
        return rf_gltf_no_memory( gltf, where );
    baker->world_capacity = primitive->vertex_count;
    return RF_OK;
}

static RfResult transform_positions( const RfGltf* gltf, float* world, const RfGltfPrimitive* primitive, const RfMat4* matrix,
                                     const char* where )
{
    for ( size_t v = 0; v < primitive->vertex_count; ++v )
    {
        const float* from = primitive->positions + 3 * v;
        double local[3] = { (double)from[0], (double)from[1], (double)from[2] }, placed[3];
        rf_mat4_apply( matrix, local, 1.0, placed );
        for ( int i = 0; i < 3; ++i )
        {
            // written so that NaN fails
            if ( ( fabs( placed[i] ) <= RF_GLTF_MAX_COORDINATE ) == false )
                return rf_gltf_fail( gltf, RF_ERROR_SCENE, where, "a vertex is at %g, beyond %g: scale the scene down", placed[i],
                                     RF_GLTF_MAX_COORDINATE );
            world[3 * v + (size_t)i] = (float)placed[i];
        }
    }
    return RF_OK;
}

static void store( float* out, const double v[3], double scale )
{
    for ( int i = 0; i < 3; ++i )
        out[i] = (float)( v[i] * scale );
}

// Zero if the normal in the file is zero, or if the matrix collapses it.
static void transform_normal( const RfMat4* matrix, double sign, const float* normal, float* out )
{
    double local[3] = { (double)normal[0], (double)normal[1], (double)normal[2] }, n[3];
    rf_mat4_apply_cofactor( matrix, local, n );
    double largest = fmax( fabs( n[0] ), fmax( fabs( n[1] ), fabs( n[2] ) ) );
    if ( ( largest > 0.0 && largest <= DBL_MAX ) == false )
    {
        out[0] = out[1] = out[2] = 0.0f;
        return;
    }
    for ( int i = 0; i < 3; ++i )
        n[i] /= largest;
    store( out, n, sign / sqrt( n[0] * n[0] + n[1] * n[1] + n[2] * n[2] ) );
}

static void grow_bounds( RfGltfBaker* baker, bool first, const float* p )
{
    RfVec3 at = rf_vec3( p[0], p[1], p[2] );
    RfVec3 low = first ? at : baker->bounds_min, high = first ? at : baker->bounds_max;
    baker->bounds_min = rf_vec3( rf_minf( low.x, at.x ), rf_minf( low.y, at.y ), rf_minf( low.z, at.z ) );
    baker->bounds_max = rf_vec3( rf_maxf( high.x, at.x ), rf_maxf( high.y, at.y ), rf_maxf( high.z, at.z ) );
}

static void append_smooth_vertices( RfTriangles* t, const RfGltfPrimitive* primitive, const RfMat4* matrix, const float* world )
{
    double sign = rf_mat4_det3( matrix ) < 0.0 ? -1.0 : 1.0;
    size_t base = t->vertex_count;
    memcpy( t->positions + 3 * base, world, (size_t)primitive->vertex_count * 3 * sizeof( float ) );
    for ( uint32_t v = 0; v < primitive->vertex_count; ++v )
    {
        transform_normal( matrix, sign, primitive->normals + 3 * (size_t)v, t->normals + 3 * ( base + v ) );
        copy_attributes( t, (uint32_t)base + v, primitive, v );
        transform_tangent( t, (uint32_t)base + v, primitive, v, matrix, sign );
    }
    t->vertex_count += primitive->vertex_count;
}

static void append_flat_vertex( RfTriangles* t, const RfGltfPrimitive* primitive, const float* world, uint32_t from,
                                const float normal[3] )
{
    size_t at = t->vertex_count++;
    memcpy( t->positions + 3 * at, world + 3 * (size_t)from, 3 * sizeof( float ) );
    memcpy( t->normals + 3 * at, normal, 3 * sizeof( float ) );
    copy_attributes( t, (uint32_t)at, primitive, from );
}

static bool is_zero( const float* v ) { return v[0] == 0.0f && v[1] == 0.0f && v[2] == 0.0f; }

static void append_triangle( RfGltfBaker* baker, const RfGltfPrimitive* primitive, uint32_t base, const uint32_t corners[3],
                             const float normal[3] )
{
    RfTriangles* t = baker->triangles;
    const float* world = baker->world;
    for ( size_t i = 0; i < 3; ++i )
    {
        uint32_t vertex = base + corners[i];
        if ( primitive->normals == NULL )
        {
            vertex = t->vertex_count;
            append_flat_vertex( t, primitive, world, corners[i], normal );
        }
        else if ( is_zero( t->normals + 3 * (size_t)vertex ) )
            memcpy( t->normals + 3 * (size_t)vertex, normal, 3 * sizeof( float ) );
        t->indices[3 * (size_t)t->count + i] = vertex;
        grow_bounds( baker, t->count == 0 && i == 0, world + 3 * (size_t)corners[i] );
    }
    t->material[t->count++] = primitive->material;
}

// Vertices used only by dropped triangles must still have a unit normal.
static void finish_normals( RfTriangles* t, uint32_t base )
{
    for ( size_t v = base; v < t->vertex_count; ++v )
    {
        if ( is_zero( t->normals + 3 * v ) )
            t->normals[3 * v + 2] = 1.0f;
    }
}

RfResult rf_gltf_bake( RfGltf* gltf, RfGltfBaker* baker, const RfGltfPrimitive* primitive, const RfMat4* matrix,
                       const char* where )
{
    RfResult result = reserve( gltf, baker, primitive, where );
    if ( result == RF_OK )
        result = transform_positions( gltf, baker->world, primitive, matrix, where );
    if ( result != RF_OK )
        return result;

    RfTriangles* t = baker->triangles;
    uint32_t base = t->vertex_count, first = t->count;
    if ( primitive->normals != NULL )
        append_smooth_vertices( t, primitive, matrix, baker->world );
    // a mirroring matrix reverses the winding: swap two corners to restore it
    bool mirrored = rf_mat4_det3( matrix ) < 0.0;
    for ( size_t i = 0; i < primitive->triangle_count; ++i )
    {
        const uint32_t* from = primitive->indices + 3 * i;
        uint32_t corners[3] = { from[0], from[mirrored ? 2 : 1], from[mirrored ? 1 : 2] };
        float normal[3];
        if ( rf_face_normal( baker->world, corners, baker->least_double_area, normal ) )
            append_triangle( baker, primitive, base, corners, normal );
        else if ( baker->degenerate++ == 0 )
            baker->first_degenerate = rf_where( "%s", where );
    }
    if ( t->count == first )
        t->vertex_count = base;
    finish_normals( t, base );
    if ( primitive->colors != NULL )
        gltf->scene->materials[primitive->material].textured->vertex_colors = true;
    return RF_OK;
}

// Releases spare capacity; a failure to shrink changes nothing.
static void shrink( RfTriangles* t )
{
    size_t vertices = t->vertex_count, triangles = t->count;
    if ( triangles == 0 )
        return;
    grow_floats( &t->positions, vertices * 3 );
    grow_floats( &t->normals, vertices * 3 );
    if ( t->uvs != NULL )
        grow_floats( &t->uvs, vertices * 2 );
    if ( t->uvs1 != NULL )
        grow_floats( &t->uvs1, vertices * 2 );
    if ( t->colors != NULL )
        grow_floats( &t->colors, vertices * 4 );
    if ( t->tangents != NULL )
        grow_floats( &t->tangents, vertices * 4 );
    grow_numbers( &t->indices, triangles * 3 );
    grow_numbers( &t->material, triangles );
}

void rf_gltf_finish_baker( RfGltfBaker* baker )
{
    shrink( baker->triangles );
    free( baker->world );
    baker->world = NULL;
}
