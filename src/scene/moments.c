// Joins the poses of a shutter, and finds triangles between them.
#include "scene/moments.h"

#include "scene/deformation.h"

#include <math.h>
#include <string.h>

static bool is_point( const uint32_t* corners ) { return corners[0] == corners[1] && corners[1] == corners[2]; }

// What a moment does not show stands as at the moment before it, on the way from the middle.
static void stand_in( RfPosedScene* pose, const RfPosedScene* before )
{
    RfPlacement* placements = pose->scene.placements;
    for ( int i = pose->scene.still_placement_count; i < pose->scene.placement_count; ++i )
    {
        const RfPlacement* other = before->scene.placements + i;
        if ( other->shown && !placements[i].shown )
        {
            placements[i] = *other;
            pose->scene.meshes[other->mesh] = before->scene.meshes[other->mesh];
        }
        placements[i].shown = other->shown;
    }
}

// All moments have the triangles of the middle one, which takes those that it lacks from the others.
static void gather_triangles( const RfMoments* moments, RfTriangles* t, int mesh )
{
    for ( size_t i = 0; i < t->count; ++i )
    {
        for ( int k = 0; k <= moments->steps && is_point( t->indices + 3 * i ); ++k )
            memcpy( t->indices + 3 * i, moments->meshes[k][mesh].triangles.indices + 3 * i, 3 * sizeof *t->indices );
    }
}

static bool deforms( const RfMoments* moments, int mesh )
{
    bool any = false;
    for ( int k = 1; k <= moments->steps; ++k )
        any = any || moments->meshes[k][mesh].triangles.positions != moments->meshes[0][mesh].triangles.positions;
    return any;
}

static void bound_triangles( const RfTriangles* t, RfMesh* at )
{
    bool first = true;
    for ( size_t i = 0; i < 3 * (size_t)t->count; ++i )
    {
        const float* p = at->triangles.positions + 3 * (size_t)t->indices[i];
        if ( is_point( t->indices + i / 3 * 3 ) )
            continue;
        rf_grow_bounds( &at->bounds_min, &at->bounds_max, first, rf_vec3( p[0], p[1], p[2] ) );
        first = false;
    }
}

void rf_join_moments( RfPosedScene* poses, int steps, RfMoments* moments )
{
    int middle = rf_middle_moment( steps );
    RfScene* scene = &poses[middle].scene;
    for ( int k = middle + 1; k <= steps; ++k )
        stand_in( poses + k, poses + k - 1 );
    for ( int k = middle - 1; k >= 0; --k )
        stand_in( poses + k, poses + k + 1 );
    *moments = ( RfMoments ){ .steps = steps };
    for ( int k = 0; k <= steps; ++k )
    {
        moments->placements[k] = poses[k].scene.placements;
        moments->meshes[k] = poses[k].scene.meshes;
    }
    for ( int i = scene->still_placement_count; i < scene->placement_count; ++i )
    {
        const RfPlacement* p = scene->placements + i;
        RfTriangles* t = &scene->meshes[p->mesh].triangles;
        if ( !p->shown || !deforms( moments, p->mesh ) )
            continue;
        gather_triangles( moments, t, p->mesh );
        for ( int k = 0; k <= steps; ++k )
            bound_triangles( t, poses[k].scene.meshes + p->mesh );
    }
    scene->moments = moments;
    scene->moment = 0.5f;
}

// Where scene->moment is: `part` of the way from moment `first` to that after it.
typedef struct Segment
{
    int first;
    float part;
} Segment;

static Segment find_segment( const RfScene* scene )
{
    float scaled = scene->moment * (float)scene->moments->steps, whole = floorf( scaled );
    whole = rf_minf( rf_maxf( whole, 0.0f ), (float)( scene->moments->steps - 1 ) );
    return ( Segment ){ (int)whole, scaled - whole };
}

static double mix( double a, double b, double part ) { return a + part * ( b - a ); }

static void mix_corners( const uint32_t* v, int size, const float* a, const float* b, double part, float* out )
{
    for ( int i = 0; i < 3 * size; ++i )
    {
        size_t at = (size_t)size * v[i / size] + (size_t)( i % size );
        out[i] = (float)mix( (double)a[at], (double)b[at], part );
    }
}

static void copy_corners( const uint32_t* v, int size, const float* from, float* out )
{
    for ( int k = 0; k < 3 && from != NULL; ++k )
        memcpy( out + k * size, from + (size_t)size * v[k], (size_t)size * sizeof *out );
}

// The largest magnitudes at one end of the segment.
static void note_rounding( const RfMat4* matrix, const RfTriangles* t, const uint32_t* v, RfBetween* out )
{
    for ( int i = 0; i < 16; ++i )
        out->most.m[i] = fmax( out->most.m[i], fabs( matrix->m[i] ) );
    for ( int k = 0; k < 3; ++k )
    {
        const float* p = t->positions + 3 * (size_t)v[k];
        RfVec3 own = rf_vec3( p[0], p[1], p[2] ), world = rf_place_point( matrix, own );
        out->own = rf_vec3( rf_maxf( out->own.x, fabsf( own.x ) ), rf_maxf( out->own.y, fabsf( own.y ) ),
                            rf_maxf( out->own.z, fabsf( own.z ) ) );
        out->world = rf_vec3( rf_maxf( out->world.x, fabsf( world.x ) ), rf_maxf( out->world.y, fabsf( world.y ) ),
                              rf_maxf( out->world.z, fabsf( world.z ) ) );
    }
}

RfTriangleAt rf_triangle_between( const RfScene* scene, const RfTriangleAt* at, RfBetween* out )
{
    Segment s = find_segment( scene );
    size_t number = (size_t)( at->placement - scene->placements );
    const RfPlacement *a = scene->moments->placements[s.first] + number, *b = scene->moments->placements[s.first + 1] + number;
    const RfTriangles *ta = &scene->moments->meshes[s.first][a->mesh].triangles,
                      *tb = &scene->moments->meshes[s.first + 1][b->mesh].triangles;
    const RfTriangles *from = at->triangles, *nearer = s.part < 0.5f ? ta : tb;
    const uint32_t *v = from->indices + 3 * (size_t)at->index, *own = nearer->indices + 3 * (size_t)at->index;
    double part = (double)s.part;
    out->placement = *at->placement;
    for ( int i = 0; i < 16; ++i )
        out->placement.matrix.m[i] = mix( a->matrix.m[i], b->matrix.m[i], part );
    mix_corners( v, 3, ta->positions, tb->positions, part, out->positions );
    mix_corners( v, 3, ta->normals, tb->normals, part, out->normals );
    if ( from->tangents != NULL )
    {
        mix_corners( v, 4, ta->tangents, tb->tangents, part, out->tangents );
        for ( int k = 0; k < 3; ++k )
            out->tangents[4 * k + 3] = nearer->tangents[4 * (size_t)v[k] + 3];
    }
    copy_corners( v, 2, from->uvs, out->uvs );
    copy_corners( v, 2, from->uvs1, out->uvs1 );
    copy_corners( v, 4, from->colors, out->colors );
    out->material = from->material[at->index];
    for ( uint32_t k = 0; k < 3; ++k )
        out->indices[k] = k;
    out->triangles = ( RfTriangles ){
        .vertex_count = 3,
        .count = 1,
        .positions = out->positions,
        .normals = out->normals,
        .uvs = from->uvs != NULL ? out->uvs : NULL,
        .uvs1 = from->uvs1 != NULL ? out->uvs1 : NULL,
        .colors = from->colors != NULL ? out->colors : NULL,
        .tangents = from->tangents != NULL ? out->tangents : NULL,
        .indices = out->indices,
        .material = &out->material,
    };
    out->most = ( RfMat4 ){ { 0 } };
    out->own = out->world = rf_vec3( 0, 0, 0 );
    note_rounding( &a->matrix, ta, v, out );
    note_rounding( &b->matrix, tb, v, out );
    out->turned = own[0] == v[0] && own[1] == v[2] && own[2] == v[1] && v[1] != v[2];
    return ( RfTriangleAt ){ &out->triangles, 0, &out->placement };
}
