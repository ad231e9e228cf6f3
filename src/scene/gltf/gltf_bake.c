// Bakes primitives into lists of triangles.
#include "scene/gltf/gltf_geometry.h"

#include "scene/deformation.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// Of the other vertex attributes: texture coordinates, colours, tangents. An attribute is allocated when the first mesh has it.
static RfResult reserve_attributes( const RfGltf* gltf, const RfGltfBaker* baker, const RfTriangles* needed, const char* where )
{
    for ( int a = RF_UV; a < RF_ATTRIBUTE_COUNT; ++a )
    {
        float** all = rf_attribute( baker->triangles, a );
        if ( *rf_attribute( (RfTriangles*)needed, a ) == NULL || *all != NULL )
            continue;
        size_t count = (size_t)baker->vertex_capacity * g_rf_attributes[a].components;
        *all = malloc( ( count + 1 ) * sizeof **all );
        if ( *all == NULL )
            return rf_gltf_no_memory( gltf, where );
        for ( size_t i = 0; i < count; ++i )
            ( *all )[i] = g_rf_attributes[a].fill;
    }
    return RF_OK;
}

// Tangents become 0, until they are transformed.
static void copy_attributes( RfTriangles* t, size_t to, const RfGltfPrimitive* primitive, size_t from )
{
    for ( int a = RF_UV; a < RF_ATTRIBUTE_COUNT; ++a )
    {
        const float* values = a != RF_TANGENT ? *rf_attribute( (RfTriangles*)&primitive->t, a ) : NULL;
        float* all = *rf_attribute( t, a );
        for ( size_t i = 0, n = g_rf_attributes[a].components; all != NULL && i < n; ++i )
            all[n * to + i] = values != NULL ? values[n * from + i] : g_rf_attributes[a].fill;
    }
}

// `sign` is −1 for a mirroring matrix.
static void transform_tangent( RfTriangles* t, uint32_t to, const RfGltfPrimitive* primitive, uint32_t from, const RfMat4* matrix,
                               double sign )
{
    if ( primitive->t.tangents == NULL )
        return;
    const float* tangent = primitive->t.tangents + 4 * (size_t)from;
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
    *memory = grown != NULL ? grown : *memory;
    return grown != NULL;
}

static bool grow_numbers( uint32_t** memory, size_t count )
{
    uint32_t* grown = realloc( *memory, count * sizeof *grown );
    *memory = grown != NULL ? grown : *memory;
    return grown != NULL;
}

// Those of all attributes that some mesh has, and in any case positions and normals.
static bool grow_attributes( RfTriangles* t, size_t vertices )
{
    bool room = true;
    for ( int a = 0; a < RF_ATTRIBUTE_COUNT; ++a )
    {
        float** all = rf_attribute( t, a );
        room = ( ( *all == NULL && a >= RF_UV ) || grow_floats( all, vertices * g_rf_attributes[a].components ) ) && room;
    }
    return room;
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
    if ( !grow_attributes( t, capacity ) )
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
    uint32_t vertices = primitive->t.normals != NULL ? primitive->t.vertex_count : primitive->t.count * 3;
    RfResult result = reserve_vertices( gltf, baker, vertices, where );
    if ( result == RF_OK )
        result = reserve_triangles( gltf, baker, primitive->t.count, where );
    if ( result == RF_OK )
        result = reserve_attributes( gltf, baker, &primitive->t, where );
    if ( result != RF_OK || primitive->t.vertex_count <= baker->world_capacity )
        return result;
    if ( grow_floats( &baker->world, (size_t)primitive->t.vertex_count * 3 ) == false )
        return rf_gltf_no_memory( gltf, where );
    baker->world_capacity = primitive->t.vertex_count;
    return RF_OK;
}

static RfResult transform_positions( const RfGltf* gltf, float* world, const RfGltfPrimitive* primitive, const RfMat4* matrix,
                                     const char* where )
{
    for ( size_t v = 0; v < primitive->t.vertex_count; ++v )
    {
        const float* from = primitive->t.positions + 3 * v;
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

// Zero if the normal in the file is zero, or if the matrix collapses it.
static void transform_normal( const RfMat4* matrix, double sign, const float* normal, float* out )
{
    double local[3] = { (double)normal[0], (double)normal[1], (double)normal[2] }, n[3];
    rf_mat4_apply_cofactor( matrix, local, n );
    rf_normalise( n, sign, out );
}

static void append_smooth_vertices( RfTriangles* t, const RfGltfPrimitive* primitive, const RfMat4* matrix, const float* world )
{
    double sign = rf_mat4_det3( matrix ) < 0.0 ? -1.0 : 1.0;
    size_t base = t->vertex_count;
    memcpy( t->positions + 3 * base, world, (size_t)primitive->t.vertex_count * 3 * sizeof( float ) );
    for ( uint32_t v = 0; v < primitive->t.vertex_count; ++v )
    {
        transform_normal( matrix, sign, primitive->t.normals + 3 * (size_t)v, t->normals + 3 * ( base + v ) );
        copy_attributes( t, base + v, primitive, v );
        transform_tangent( t, (uint32_t)base + v, primitive, v, matrix, sign );
    }
    t->vertex_count += primitive->t.vertex_count;
}

static void append_flat_vertex( RfTriangles* t, const RfGltfPrimitive* primitive, const float* world, uint32_t from,
                                const float normal[3] )
{
    size_t at = t->vertex_count++;
    memcpy( t->positions + 3 * at, world + 3 * (size_t)from, 3 * sizeof( float ) );
    memcpy( t->normals + 3 * at, normal, 3 * sizeof( float ) );
    copy_attributes( t, at, primitive, from );
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
        if ( primitive->t.normals == NULL )
        {
            vertex = t->vertex_count;
            append_flat_vertex( t, primitive, world, corners[i], normal );
        }
        else if ( is_zero( t->normals + 3 * (size_t)vertex ) )
            memcpy( t->normals + 3 * (size_t)vertex, normal, 3 * sizeof( float ) );
        t->indices[3 * (size_t)t->count + i] = vertex;
        const float* p = world + 3 * (size_t)corners[i];
        rf_grow_bounds( &baker->bounds_min, &baker->bounds_max, t->count == 0 && i == 0, rf_vec3( p[0], p[1], p[2] ) );
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
    if ( primitive->t.normals != NULL )
        append_smooth_vertices( t, primitive, matrix, baker->world );
    // a mirroring matrix reverses the winding: swap two corners to restore it
    bool mirrored = rf_mat4_det3( matrix ) < 0.0;
    for ( size_t i = 0; i < primitive->t.count; ++i )
    {
        const uint32_t* from = primitive->t.indices + 3 * i;
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
    if ( primitive->t.colors != NULL )
        gltf->scene->materials[primitive->material].textured->vertex_colors = true;
    return RF_OK;
}

void rf_gltf_finish_baker( RfGltfBaker* baker )
{
    RfTriangles* t = baker->triangles;
    if ( t->count > 0 ) // a failure to shrink changes nothing
    {
        grow_attributes( t, t->vertex_count );
        grow_numbers( &t->indices, 3 * (size_t)t->count );
        grow_numbers( &t->material, t->count );
    }
    free( baker->world );
    baker->world = NULL;
}
