// Meshes in their own space: all primitives of one, for what moves.
#include "scene/gltf/gltf_geometry.h"

#include "scene/merge.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

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

static bool is_zero( const float* v ) { return v[0] == 0.0f && v[1] == 0.0f && v[2] == 0.0f; }

// A rigid mesh loses the triangles without area; others may have one in another shape.
static void append_triangle( Reader* r, uint32_t base, const uint32_t* from, uint32_t material, const char* where )
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
        append_triangle( r, base, p->t.indices + 3 * i, p->material, where );
    for ( size_t v = base; v < t->vertex_count; ++v )
    {
        if ( is_zero( t->normals + 3 * v ) && !r->shape->deforms )
            t->normals[3 * v + 2] = 1.0f;
    }
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
    RfResult result = rf_gltf_mesh_targets( r->gltf, rf_gltf_mesh_of( r->gltf, r->shape->use ), &count );
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
    RfField primitives = rf_gltf_primitives( r->gltf, rf_gltf_mesh_of( r->gltf, r->shape->use ) );
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
