// Bakes primitives into lists of triangles: into the world by the matrix of their node, in double, rounded once; or in their own
// space, for what moves.
#include "gltf/gltf_mesh.h"

#include "base/try.h"
#include "scene/deformation.h"

#include <float.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

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

// Appends the vertices of a primitive. An attribute is allocated when the first primitive has it.
static RfResult append_vertices( const RfGltf* gltf, RfGltfBaker* baker, const RfGltfPrimitive* primitive, const char* where )
{
    RfTriangles* t = baker->triangles;
    size_t base = t->vertex_count, more = primitive->t.vertex_count;
    RfResult result = reserve_vertices( gltf, baker, primitive->t.vertex_count, where );
    for ( int a = 0; result == RF_OK && a < RF_ATTRIBUTE_COUNT; ++a )
    {
        const size_t n = g_rf_attributes[a].components;
        const float* own = *rf_attribute( (RfTriangles*)&primitive->t, a );
        float** all = rf_attribute( t, a );
        bool fresh = *all == NULL && own != NULL;
        if ( fresh && !grow_floats( all, baker->vertex_capacity * n + 1 ) )
            return rf_gltf_no_memory( gltf, where );
        for ( size_t i = fresh ? 0 : n * base; *all != NULL && i < ( own != NULL ? n * base : n * ( base + more ) ); ++i )
            ( *all )[i] = g_rf_attributes[a].fill;
        if ( own != NULL )
            memcpy( *all + n * base, own, n * more * sizeof *own );
    }
    t->vertex_count += result == RF_OK ? primitive->t.vertex_count : 0;
    return result;
}

// `sign` is −1 for a mirroring matrix.
static void transform_tangent( const RfMat4* matrix, double sign, float* tangent )
{
    double local[3] = { (double)tangent[0], (double)tangent[1], (double)tangent[2] }, placed[3];
    rf_mat4_apply( matrix, local, 0.0, placed );
    double length = sqrt( placed[0] * placed[0] + placed[1] * placed[1] + placed[2] * placed[2] );
    bool usable = length > 0.0 && length <= DBL_MAX;
    for ( int i = 0; i < 3; ++i )
        tangent[i] = usable ? (float)( placed[i] / length ) : 0.0f;
    tangent[3] = !usable ? 0.0f : (float)( ( tangent[3] < 0.0f ? -1.0 : 1.0 ) * sign );
}

static RfResult fail_far( const RfGltf* gltf, const char* where, double at, double most )
{
    return rf_gltf_fail( gltf, RF_ERROR_SCENE, where, "a vertex is at %g, beyond %g: scale the scene down", at, most );
}

// Places the vertices from `base` on. The normals of flat faces follow from where they come to lie.
static RfResult transform_vertices( const RfGltf* gltf, RfTriangles* t, uint32_t base, const RfGltfPrimitive* primitive,
                                    const RfMat4* matrix, const char* where )
{
    double sign = rf_mat4_det3( matrix ) < 0.0 ? -1.0 : 1.0;
    bool flat = primitive->flat && primitive->t.tangents == NULL;
    for ( size_t v = base; v < t->vertex_count; ++v )
    {
        float *at = t->positions + 3 * v, *normal = t->normals + 3 * v;
        double local[3] = { (double)at[0], (double)at[1], (double)at[2] }, placed[3],
               own[3] = { (double)normal[0], (double)normal[1], (double)normal[2] }, n[3] = { 0.0 };
        rf_mat4_apply( matrix, local, 1.0, placed );
        for ( int i = 0; i < 3; ++i )
        {
            if ( !( fabs( placed[i] ) <= RF_GLTF_MAX_COORDINATE ) ) // written so that NaN fails
                return fail_far( gltf, where, placed[i], RF_GLTF_MAX_COORDINATE );
            at[i] = (float)placed[i];
        }
        if ( !flat )
            rf_mat4_apply_cofactor( matrix, own, n );
        rf_normalise( n, sign, normal ); // zero if it is zero in the file, or if the matrix collapses it
        if ( primitive->t.tangents != NULL )
            transform_tangent( matrix, sign, t->tangents + 4 * v );
    }
    return RF_OK;
}

static void normalise( float* v ) { rf_normalise( ( const double[3] ){ (double)v[0], (double)v[1], (double)v[2] }, 1.0, v ); }

// In their own space: unit normals and tangents, where they are not 0; tangents with a sign.
static RfResult check_vertices( const RfGltf* gltf, RfTriangles* t, uint32_t base, const char* where )
{
    for ( size_t v = base; v < t->vertex_count; ++v )
    {
        for ( size_t c = 0; c < 3; ++c )
        {
            if ( fabs( (double)t->positions[3 * v + c] ) > RF_MAX_COORDINATE )
                return fail_far( gltf, where, (double)t->positions[3 * v + c], RF_MAX_COORDINATE );
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

// One without area is dropped, except from a mesh that deforms: it may have one in another shape.
static void append_triangle( RfGltfBaker* baker, const uint32_t corners[3], uint32_t material, const char* where )
{
    RfTriangles* t = baker->triangles;
    float normal[3];
    bool whole = rf_face_normal( t->positions, corners, baker->least_double_area, normal );
    if ( !whole && !baker->deforms )
    {
        if ( baker->degenerate++ == 0 )
            baker->first_degenerate = rf_where( "%s", where );
        return;
    }
    for ( size_t i = 0; i < 3; ++i )
    {
        const float* p = t->positions + 3 * (size_t)corners[i];
        float* own = t->normals + 3 * (size_t)corners[i];
        if ( is_zero( own ) )
            memcpy( own, normal, sizeof normal );
        t->indices[3 * (size_t)t->count + i] = corners[i];
        rf_grow_bounds( &baker->bounds_min, &baker->bounds_max, t->count == 0 && i == 0, rf_vec3( p[0], p[1], p[2] ) );
    }
    t->material[t->count++] = material;
}

RfResult rf_gltf_bake( RfGltf* gltf, RfGltfBaker* baker, const RfGltfPrimitive* primitive, const RfMat4* matrix,
                       const char* where )
{
    RfTriangles* t = baker->triangles;
    uint32_t base = t->vertex_count, first = t->count;
    RF_TRY( append_vertices( gltf, baker, primitive, where ) );
    RF_TRY( reserve_triangles( gltf, baker, primitive->t.count, where ) );
    RF_TRY( matrix != NULL ? transform_vertices( gltf, t, base, primitive, matrix, where )
                           : check_vertices( gltf, t, base, where ) );
    // a mirroring matrix reverses the winding: swap two corners to restore it
    bool mirrored = matrix != NULL && rf_mat4_det3( matrix ) < 0.0;
    for ( size_t i = 0; i < primitive->t.count; ++i )
    {
        const uint32_t* from = primitive->t.indices + 3 * i;
        uint32_t corners[3] = { base + from[0], base + from[mirrored ? 2 : 1], base + from[mirrored ? 1 : 2] };
        append_triangle( baker, corners, primitive->material, where );
    }
    if ( t->count == first && matrix != NULL )
        t->vertex_count = base;
    for ( size_t v = base; v < t->vertex_count && !baker->deforms; ++v )
    {
        if ( is_zero( t->normals + 3 * v ) ) // used only by dropped triangles
            t->normals[3 * v + 2] = 1.0f;
    }
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
}

void rf_gltf_warn_of_degenerate( const RfGltf* gltf, const RfGltfBaker* baker )
{
    if ( baker->degenerate > 0 )
        rf_warn( gltf->log, "%s: %llu triangles without area are dropped, the first in %s", gltf->path,
                 (unsigned long long)baker->degenerate, baker->first_degenerate.text );
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
    RfGltfBaker baker;
    bool* flat; // of its vertices
} Reader;

static RfResult add_primitive( Reader* r, const RfField* json, const RfGltfPrimitive* p )
{
    const char* where = json->path;
    RfMesh* mesh = r->out;
    uint32_t base = mesh->triangles.vertex_count;
    r->gltf->shape_triangles += p->t.count;
    if ( r->gltf->shape_triangles > MAX_TRIANGLES )
        return rf_gltf_fail( r->gltf, RF_ERROR_UNSUPPORTED, where, "more than %llu triangles in all that moves: split the scene",
                             (unsigned long long)MAX_TRIANGLES );
    RfResult result = rf_gltf_bake( r->gltf, &r->baker, p, NULL, where );
    bool* flat = realloc( r->flat, ( (size_t)base + p->t.vertex_count + 1 ) * sizeof *flat );
    if ( flat == NULL )
        return rf_gltf_no_memory( r->gltf, where );
    r->flat = flat;
    memset( flat + base, p->flat, p->t.vertex_count );
    if ( result == RF_OK && mesh->deformation != NULL )
        result = rf_gltf_read_targets( r->gltf, json, p, base, mesh->deformation );
    if ( result == RF_OK && r->shape->skinned )
        result = rf_gltf_read_influences( r->gltf, json, p, base, mesh->deformation );
    return result;
}

static RfResult read_primitive( Reader* r, const RfField* json )
{
    RfGltfPrimitive p;
    if ( r->shape->changing_only && !rf_gltf_primitive_changes( r->gltf, json ) )
        return RF_OK;
    RfResult result = rf_gltf_read_primitive( r->gltf, json, false, &p );
    if ( result != RF_OK )
        return result;
    p.material = rf_gltf_tagged_material( r->gltf, r->shape->use, p.material );
    if ( p.t.count > 0 )
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
    RF_TRY( rf_gltf_mesh_targets( r->gltf, r->gltf->uses[r->shape->use].mesh, &count ) );
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
    reader.baker = ( RfGltfBaker ){ .triangles = &out->triangles, .deforms = shape->deforms };
    RfResult result = read_primitives( &reader );
    rf_gltf_finish_baker( &reader.baker );
    out->bounds_min = reader.baker.bounds_min;
    out->bounds_max = reader.baker.bounds_max;
    if ( out->deformation != NULL )
        out->deformation->flat = reader.flat;
    else
        free( reader.flat );
    rf_gltf_warn_of_degenerate( gltf, &reader.baker );
    return result;
}
