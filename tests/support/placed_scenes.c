#include "support/placed_scenes.h"

#include "base/random.h"
#include "scene/placement.h"

#include <stdlib.h>
#include <string.h>

static double number_of( uint32_t dimension, int number )
{
    return (double)rf_random( rf_pixel_key( rf_pass_key( 11, 0, 0, 0 ), (uint32_t)number ), dimension );
}

static RfMat4 rotation( uint32_t dimension, int number )
{
    double q[4], sum = 0.0, none[3] = { 0, 0, 0 }, one[3] = { 1, 1, 1 };
    for ( uint32_t k = 0; k < 4; ++k )
    {
        q[k] = number_of( dimension + k, number ) - 0.45;
        sum += q[k] * q[k];
    }
    for ( int k = 0; k < 4; ++k )
        q[k] /= sqrt( sum );
    return rf_mat4_from_trs( none, q, one );
}

RfMat4 placing_matrix( PlacedKind kind, int number )
{
    double s[3] = { 1, 1, 1 }, t[3], unit[4] = { 0, 0, 0, 1 };
    for ( uint32_t k = 0; k < 3; ++k )
    {
        t[k] = 4.0 * number_of( 10 + k, number ) - 2.0;
        if ( kind == PLACED_STRETCHED )
            s[k] = exp( 3.0 * number_of( 20 + k, number ) - 1.5 );
    }
    double even = kind == PLACED_SCALED ? exp( 8.0 * number_of( 30, number ) - 4.0 ) : 1.0;
    for ( int k = 0; k < 3; ++k )
        s[k] *= even;
    if ( kind == PLACED_MIRRORED || ( kind == PLACED_STRETCHED && number % 2 == 1 ) )
        s[number % 3] *= -1.0;
    RfMat4 first = rotation( 0, number ), scale = rf_mat4_from_trs( t, unit, s ), last = rotation( 40, number );
    RfMat4 turned = rf_mat4_mul( &scale, &first );
    for ( int k = 0; k < 3; ++k )
        turned.m[12 + k] = t[k];
    return kind == PLACED_STRETCHED ? rf_mat4_mul( &last, &turned ) : turned;
}

RfMat4 inverse_matrix( const RfMat4* m )
{
    RfMat4 out = rf_mat4_identity();
    double det = rf_mat4_det3( m );
    for ( int c = 0; c < 3; ++c )
    {
        double unit[3] = { c == 0, c == 1, c == 2 }, cofactor[3];
        rf_mat4_apply_cofactor( m, unit, cofactor );
        for ( int r = 0; r < 3; ++r ) // transposed
            out.m[4 * r + c] = cofactor[r] / det;
    }
    double back[3];
    rf_mat4_apply( &out, m->m + 12, 0.0, back );
    for ( int r = 0; r < 3; ++r )
        out.m[12 + r] = -back[r];
    return out;
}

static void* grow( void* memory, size_t bytes )
{
    void* grown = realloc( memory, bytes );
    if ( grown == NULL )
        abort();
    return grown;
}

static void grow_floats( float** values, bool wanted, size_t components, uint32_t vertices, uint32_t before, float fill )
{
    if ( !wanted && *values == NULL )
        return;
    bool fresh = *values == NULL;
    *values = grow( *values, ( (size_t)vertices * components + 1 ) * sizeof **values );
    for ( size_t i = fresh ? 0 : before * components; i < vertices * components; ++i )
        ( *values )[i] = fill;
}

static void put( float* out, RfVec3 v ) { memcpy( out, &v, sizeof v ); }

static RfVec3 get( const float* values, uint32_t vertex )
{
    return rf_vec3( values[3 * (size_t)vertex], values[3 * (size_t)vertex + 1], values[3 * (size_t)vertex + 2] );
}

// Appends a triangle with vertices of its own, transformed; corners 1 and 2 change places where the matrix mirrors, if asked.
static void append( RfTriangles* to, const RfTriangles* from, uint32_t triangle, const RfMat4* matrix, bool keep_winding )
{
    uint32_t before = to->vertex_count, after = before + 3;
    double side = rf_mat4_det3( matrix ) < 0.0 ? -1.0 : 1.0;
    grow_floats( &to->positions, true, 3, after, before, 0.0f );
    grow_floats( &to->normals, true, 3, after, before, 0.0f );
    grow_floats( &to->uvs, from->uvs != NULL, 2, after, before, 0.0f );
    grow_floats( &to->uvs1, from->uvs1 != NULL, 2, after, before, 0.0f );
    grow_floats( &to->colors, from->colors != NULL, 4, after, before, 1.0f );
    grow_floats( &to->tangents, from->tangents != NULL, 4, after, before, 0.0f );
    to->indices = grow( to->indices, 3 * ( (size_t)to->count + 1 ) * sizeof *to->indices );
    to->material = grow( to->material, ( (size_t)to->count + 1 ) * sizeof *to->material );
    for ( uint32_t k = 0; k < 3; ++k )
    {
        uint32_t v = from->indices[3 * (size_t)triangle + k];
        uint32_t corner = keep_winding && side < 0.0 && k > 0 ? 3 - k : k;
        size_t at = before + corner;
        put( to->positions + 3 * at, rf_place_point( matrix, get( from->positions, v ) ) );
        put( to->normals + 3 * at, rf_place_normal( matrix, side, get( from->normals, v ) ) );
        if ( from->uvs != NULL )
            memcpy( to->uvs + 2 * at, from->uvs + 2 * (size_t)v, 2 * sizeof( float ) );
        if ( from->uvs1 != NULL )
            memcpy( to->uvs1 + 2 * at, from->uvs1 + 2 * (size_t)v, 2 * sizeof( float ) );
        if ( from->colors != NULL )
            memcpy( to->colors + 4 * at, from->colors + 4 * (size_t)v, 4 * sizeof( float ) );
        if ( from->tangents != NULL )
        {
            const float* t = from->tangents + 4 * (size_t)v;
            put( to->tangents + 4 * at, rf_place_direction( matrix, rf_vec3( t[0], t[1], t[2] ) ) );
            to->tangents[4 * at + 3] = t[3] * (float)side;
        }
        to->indices[3 * (size_t)to->count + k] = before + k;
    }
    to->vertex_count = after;
    to->material[to->count++] = from->material[triangle];
}

static void bound_mesh( RfMesh* mesh )
{
    mesh->bounds_min = rf_vec3( INFINITY, INFINITY, INFINITY );
    mesh->bounds_max = rf_scale( mesh->bounds_min, -1.0f );
    RfVec3 *low = &mesh->bounds_min, *high = &mesh->bounds_max;
    for ( uint32_t v = 0; v < mesh->triangles.vertex_count; ++v )
    {
        RfVec3 p = get( mesh->triangles.positions, v );
        *low = rf_vec3( rf_minf( low->x, p.x ), rf_minf( low->y, p.y ), rf_minf( low->z, p.z ) );
        *high = rf_vec3( rf_maxf( high->x, p.x ), rf_maxf( high->y, p.y ), rf_maxf( high->z, p.z ) );
    }
}

void add_placement( RfScene* scene, int mesh, RfMat4 matrix )
{
    scene->placements = grow( scene->placements, ( (size_t)scene->placement_count + 1 ) * sizeof *scene->placements );
    scene->placements[scene->placement_count++] = ( RfPlacement ){ .mesh = mesh, .matrix = matrix, .shown = true, .mover = -1 };
}

static int add_mesh( RfScene* scene, RfTriangles triangles )
{
    scene->meshes = grow( scene->meshes, ( (size_t)scene->mesh_count + 1 ) * sizeof *scene->meshes );
    scene->meshes[scene->mesh_count] = ( RfMesh ){ .triangles = triangles };
    bound_mesh( scene->meshes + scene->mesh_count );
    return scene->mesh_count++;
}

int take_mesh( RfScene* scene )
{
    RfTriangles all = scene->triangles;
    scene->triangles = ( RfTriangles ){ 0 };
    return add_mesh( scene, all );
}

static bool goes( const RfScene* scene, uint32_t triangle, bool mirrors )
{
    const RfMaterial* m = scene->materials + scene->triangles.material[triangle];
    bool may_be_mirror = m->kind == RF_BSDF_GLASS && m->alpha == 0.0f && m->textured == NULL;
    return !( rf_max_component( m->emission ) > 0.0f ) && ( mirrors || !may_be_mirror );
}

void place_scene( RfScene* scene, PlacedKind kind, int meshes, bool mirrors )
{
    RfTriangles all = scene->triangles, rest = { 0 };
    RfMat4 identity = rf_mat4_identity();
    double size = (double)rf_length( rf_sub( scene->bounds_max, scene->bounds_min ) ) / 6.0;
    for ( int m = 0; m < meshes; ++m )
    {
        RfTriangles own = { 0 };
        RfMat4 matrix = placing_matrix( kind, m );
        for ( int c = 12; c < 15; ++c )
            matrix.m[c] *= size;
        RfMat4 inverse = inverse_matrix( &matrix );
        for ( uint32_t i = 0; i < all.count; ++i )
        {
            if ( goes( scene, i, mirrors ) && (int)( i / 2 % (uint32_t)meshes ) == m )
                append( &own, &all, i, &inverse, true );
        }
        if ( own.count > 0 )
            add_placement( scene, add_mesh( scene, own ), matrix );
    }
    for ( uint32_t i = 0; i < all.count; ++i )
    {
        if ( !goes( scene, i, mirrors ) )
            append( &rest, &all, i, &identity, true );
    }
    rf_destroy_triangles( &scene->triangles );
    scene->triangles = rest;
    if ( rf_finish_placements( scene, NULL ) != RF_OK )
        abort();
}

void flatten_scene( RfScene* scene )
{
    RfTriangles all = { 0 };
    for ( uint32_t i = 0; i < rf_triangle_count( scene ); ++i )
    {
        RfMat4 identity = rf_mat4_identity();
        RfTriangleAt at = rf_locate_triangle( scene, i );
        append( &all, at.triangles, at.index, at.placement != NULL ? &at.placement->matrix : &identity, true );
    }
    rf_destroy_triangles( &scene->triangles );
    for ( int m = 0; m < scene->mesh_count; ++m )
        rf_destroy_triangles( &scene->meshes[m].triangles );
    free( scene->meshes );
    free( scene->placements );
    free( scene->placement_blocks );
    scene->triangles = all;
    scene->meshes = NULL;
    scene->placements = NULL;
    scene->placement_blocks = NULL;
    scene->mesh_count = scene->placement_count = scene->still_placement_count = 0;
    scene->triangle_count = all.count;
}
