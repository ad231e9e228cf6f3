// Bakes primitives into lists of triangles.
#include "gltf/gltf_geometry.h"

#include "scene/deformation.h"
#include "scene/merge.h"

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

// Meshes in their own space: all primitives of one, for what moves.

// Of all meshes in their own space.
#define MAX_TRIANGLES ( (uint64_t)1 << 28 )

#define EIGHT 8
#define FOUR 4

// What is read of one mesh.
typedef struct Reader
{
    RfGltf* gltf;
    const RfGltfShape* shape;
    RfMesh* out;
    bool* flat; // of its vertices
    uint64_t degenerate;
    RfWhere first_degenerate;
} Reader;

static bool append_vertices( Reader* r, const RfGltfPrimitive* p )
{
    size_t before = r->out->triangles.vertex_count;
    bool* flat = realloc( r->flat, ( before + p->t.vertex_count + 1 ) * sizeof *flat );
    if ( flat == NULL )
        return false;
    r->flat = flat;
    memset( flat + before, p->flat, p->t.vertex_count );
    return rf_append_vertices( &r->out->triangles, &p->t );
}

static void normalise( float* v ) { rf_normalise( ( const double[3] ){ (double)v[0], (double)v[1], (double)v[2] }, 1.0, v ); }

// Unit normals and tangents, where they are not 0; tangents with a sign.
static RfResult check_vertices( const Reader* r, uint32_t base, const char* where )
{
    RfTriangles* t = &r->out->triangles;
    for ( size_t v = base; v < t->vertex_count; ++v )
    {
        for ( size_t c = 0; c < 3; ++c )
        {
            double at = (double)t->positions[3 * v + c];
            if ( fabs( at ) > RF_MAX_COORDINATE )
                return rf_gltf_fail( r->gltf, RF_ERROR_SCENE, where, "a vertex is at %g, beyond %g: scale the scene down", at,
                                     RF_MAX_COORDINATE );
        }
        normalise( t->normals + 3 * v );
        if ( t->tangents == NULL )
            continue;
        float* tangent = t->tangents + 4 * v;
        normalise( tangent );
        bool usable = tangent[0] != 0.0f || tangent[1] != 0.0f || tangent[2] != 0.0f;
        tangent[3] = !usable ? 0.0f : tangent[3] < 0.0f ? -1.0f : 1.0f;
    }
    return RF_OK;
}

// A rigid mesh loses the triangles without area; others may have one in another shape.
static void append_own_triangle( Reader* r, uint32_t base, const uint32_t* from, uint32_t material, const char* where )
{
    RfMesh* mesh = r->out;
    RfTriangles* t = &mesh->triangles;
    uint32_t* corners = t->indices + 3 * (size_t)t->count;
    float normal[3];
    for ( int i = 0; i < 3; ++i )
        corners[i] = base + from[i];
    bool whole = rf_face_normal( t->positions, corners, 0.0, normal );
    if ( !whole && !r->shape->deforms )
    {
        if ( r->degenerate++ == 0 )
            r->first_degenerate = rf_where( "%s", where );
        return;
    }
    for ( int i = 0; i < 3; ++i )
    {
        const float* p = t->positions + 3 * (size_t)corners[i];
        float* own = t->normals + 3 * (size_t)corners[i];
        if ( is_zero( own ) )
            memcpy( own, normal, 3 * sizeof *own );
        rf_grow_bounds( &mesh->bounds_min, &mesh->bounds_max, t->count == 0 && i == 0, rf_vec3( p[0], p[1], p[2] ) );
    }
    t->material[t->count++] = material;
}

static RfResult append_triangles( Reader* r, uint32_t base, const RfGltfPrimitive* p, const char* where )
{
    RfTriangles* t = &r->out->triangles;
    size_t all = (size_t)t->count + p->t.count;
    r->gltf->shape_triangles += p->t.count;
    if ( r->gltf->shape_triangles > MAX_TRIANGLES )
        return rf_gltf_fail( r->gltf, RF_ERROR_UNSUPPORTED, where, "more than %llu triangles in all that moves: split the scene",
                             (unsigned long long)MAX_TRIANGLES );
    uint32_t* indices = realloc( t->indices, ( 3 * all + 1 ) * sizeof *indices );
    t->indices = indices != NULL ? indices : t->indices;
    uint32_t* material = realloc( t->material, ( all + 1 ) * sizeof *material );
    t->material = material != NULL ? material : t->material;
    if ( indices == NULL || material == NULL )
        return rf_gltf_no_memory( r->gltf, where );
    for ( size_t i = 0; i < p->t.count; ++i )
        append_own_triangle( r, base, p->t.indices + 3 * i, p->material, where );
    if ( !r->shape->deforms )
        finish_normals( t, base );
    return RF_OK;
}

static RfResult add_primitive( Reader* r, const RfField* json, const RfGltfPrimitive* p )
{
    const char* where = json->path;
    RfMesh* mesh = r->out;
    uint32_t base = mesh->triangles.vertex_count;
    if ( p->t.vertex_count > UINT32_MAX - base )
        return rf_gltf_fail( r->gltf, RF_ERROR_UNSUPPORTED, where, "too many vertices in one mesh: split it" );
    if ( !append_vertices( r, p ) )
        return rf_gltf_no_memory( r->gltf, where );
    RfResult result = check_vertices( r, base, where );
    if ( result == RF_OK && mesh->deformation != NULL )
        result = rf_gltf_read_targets( r->gltf, json, p, base, mesh->deformation );
    if ( result == RF_OK && r->shape->skinned )
        result = rf_gltf_read_influences( r->gltf, json, p, base, mesh->deformation );
    if ( result == RF_OK )
        result = append_triangles( r, base, p, where );
    if ( result == RF_OK && p->t.colors != NULL )
        r->gltf->scene->materials[p->material].textured->vertex_colors = true;
    return result;
}

static RfResult read_primitive( Reader* r, const RfField* json )
{
    const char* where = json->path;
    RfGltfPrimitive p;
    if ( r->shape->changing_only && !rf_gltf_primitive_changes( r->gltf, json ) )
        return RF_OK;
    RfResult result = rf_gltf_read_primitive( r->gltf, json, false, &p );
    if ( result != RF_OK )
        return result;
    p.material = rf_gltf_tagged_material( r->gltf, r->shape->use, p.material );
    if ( p.t.count > 0 && p.t.normals == NULL )
        result = rf_gltf_make_flat( r->gltf, where, &p );
    if ( result == RF_OK && p.t.count > 0 )
        result = add_primitive( r, json, &p );
    rf_gltf_free_primitive( &p );
    return result;
}

static RfResult begin_deformation( const Reader* r, const json_t* primitives, const char* where )
{
    RfDeformation* deformation = calloc( 1, sizeof *deformation );
    r->out->deformation = deformation;
    if ( deformation == NULL )
        return rf_gltf_no_memory( r->gltf, where );
    for ( size_t i = 0; r->shape->skinned && i < json_array_size( primitives ); ++i )
    {
        if ( deformation->influences < EIGHT )
            deformation->influences = rf_gltf_has_eight_joints( json_array_get( primitives, i ) ) ? EIGHT : FOUR;
    }
    int count;
    RfResult result = rf_gltf_mesh_targets( r->gltf, r->gltf->uses[r->shape->use].mesh, &count );
    if ( result != RF_OK )
        return result;
    deformation->targets = calloc( (size_t)count + 1, sizeof *deformation->targets );
    if ( deformation->targets == NULL )
        return rf_gltf_no_memory( r->gltf, where );
    deformation->target_count = count;
    return RF_OK;
}

static RfResult read_primitives( Reader* r )
{
    RfField primitives = rf_gltf_primitives( r->gltf, r->gltf->uses[r->shape->use].mesh );
    RfResult result = rf_json_result( &primitives );
    if ( result == RF_OK && r->shape->deforms )
        result = begin_deformation( r, primitives.json, primitives.path );
    for ( size_t i = 0; result == RF_OK && i < json_array_size( primitives.json ); ++i )
    {
        RfField primitive = rf_field_item( &primitives, i );
        result = read_primitive( r, &primitive );
    }
    return result;
}

// On failure, what was read stays with the scene, which is destroyed.
RfResult rf_gltf_read_shape( RfGltf* gltf, const RfGltfShape* shape, RfMesh* out )
{
    Reader reader = { .gltf = gltf, .shape = shape, .out = out };
    RfResult result = read_primitives( &reader );
    if ( out->deformation != NULL )
        out->deformation->flat = reader.flat;
    else
        free( reader.flat );
    if ( reader.degenerate > 0 )
        rf_warn( gltf->log, "%s: %llu triangles without area are dropped, the first in %s", gltf->path,
                 (unsigned long long)reader.degenerate, reader.first_degenerate.text );
    return result;
}
