// The records of triangles that hits refer to.
#include "trace/tracer.h"

#include "base/fault.h"
#include "scene/moments.h"

#include <float.h>
#include <stdlib.h>

// Triangles of great extent: which they are, and their hits in doubles.

float rf_embree_error( RfVec3 e1, RfVec3 e2, RfVec3 way )
{
    double twice;
    rf_unit_cross( e1, e2, &twice );
    double x = fabs( (double)e1.y * (double)e2.z ) + fabs( (double)e1.z * (double)e2.y );
    double y = fabs( (double)e1.z * (double)e2.x ) + fabs( (double)e1.x * (double)e2.z );
    double z = fabs( (double)e1.x * (double)e2.y ) + fabs( (double)e1.y * (double)e2.x );
    double sum = x * fabs( (double)way.x ) + y * fabs( (double)way.y ) + z * fabs( (double)way.z );
    return twice > 0.0 ? RF_EMBREE_ERROR * (float)( sum / twice ) : 0.0f;
}

bool rf_cross_plane( const RfTriangleRecord* t, RfVec3 o, RfVec3 d, double* distance )
{
    // products of two floats are exact in doubles
    double x1 = (double)t->e1.x, y1 = (double)t->e1.y, z1 = (double)t->e1.z;
    double x2 = (double)t->e2.x, y2 = (double)t->e2.y, z2 = (double)t->e2.z;
    double nx = y1 * z2 - z1 * y2, ny = z1 * x2 - x1 * z2, nz = x1 * y2 - y1 * x2;
    double along = nx * (double)d.x + ny * (double)d.y + nz * (double)d.z;
    double away =
        nx * ( (double)t->p0.x - (double)o.x ) + ny * ( (double)t->p0.y - (double)o.y ) + nz * ( (double)t->p0.z - (double)o.z );
    *distance = away / along;
    return along != 0.0;
}

RfHitPoint rf_hit_far_triangle( const RfTriangleRecord* t, RfVec3 o, RfVec3 d, RfHitPoint interpolated )
{
    double s;
    // instances are off by their matrix as well, which only the check in doubles knows
    if ( t->placed && !t->far )
        return interpolated;
    if ( RF_FAULT( far_triangles ) || !rf_cross_plane( t, o, d, &s ) || !( s > 0.0 ) )
        return interpolated;
    RfVec3 p = { (float)( (double)o.x + s * (double)d.x ), (float)( (double)o.y + s * (double)d.y ),
                 (float)( (double)o.z + s * (double)d.z ) };
    // segments end here from places about as far as where this ray started: the largest coordinate counts
    float offset = rf_ray_offset( rf_maxf( rf_largest_coordinate( p ), rf_largest_coordinate( o ) ) );
    if ( !t->far ) // rays that leave must get away from it by Embree's arithmetic
        offset += rf_embree_error( t->e1, t->e2, rf_sub( t->p0, p ) );
    return offset < interpolated.offset ? ( RfHitPoint ){ p, offset } : interpolated;
}

RfPlacedBvh rf_note_matrix( const RfMat4* matrix, const RfMat4* most )
{
    RfPlacedBvh placed = { .side = 1.0f };
    double det = rf_mat4_det3( matrix );
    if ( det == 0.0 )
        return placed;
    placed.side = det < 0.0 ? -1.0f : 1.0f;
    for ( int r = 0; r < 3; ++r )
    {
        for ( int c = 0; c < 3; ++c )
        {
            // the minor without column r and row c
            const double *a = most->m + 4 * ( ( r + 1 ) % 3 ), *b = most->m + 4 * ( ( r + 2 ) % 3 );
            int i = ( c + 1 ) % 3, k = ( c + 2 ) % 3;
            placed.inverse[r][c] = (float)( ( fabs( a[i] * b[k] ) + fabs( a[k] * b[i] ) ) / fabs( det ) );
        }
    }
    return placed;
}

// Roundings of 2⁻²⁴ in the inverse of a matrix and in what it transforms. 1 does, with the offset that triangles have anyway.
#define PLACED_ROUNDINGS 4.0f

static RfVec3 load_vec3( const float* values, uint32_t index )
{
    return rf_vec3( values[3 * (size_t)index], values[3 * (size_t)index + 1], values[3 * (size_t)index + 2] );
}

static void set_corners( RfTriangleRecord* r, RfVec3 a, RfVec3 b, RfVec3 c )
{
    r->p0 = a;
    r->e1 = rf_sub( b, a );
    r->e2 = rf_sub( c, a );
    double twice;
    r->ng = rf_unit_cross( r->e1, r->e2, &twice );
    r->ng = RF_FAULT( unit_cross ) ? rf_normalize( rf_cross( r->e1, r->e2 ) ) : r->ng;
    float largest = rf_maxf( rf_largest_coordinate( a ), rf_maxf( rf_largest_coordinate( b ), rf_largest_coordinate( c ) ) );
    r->offset = RF_FAULT( fixed_offset ) ? 1e-5f : rf_ray_offset( largest );
    r->offset *= RF_FAULT( ray_offset ) ? 1e-3f : 1.0f;
}

// At the corners, where ng is known.
static void set_normals( RfTriangleRecord* r, RfVec3 a, RfVec3 b, RfVec3 c )
{
    r->n0 = a;
    r->d1 = rf_sub( b, a );
    r->d2 = rf_sub( c, a );
    r->flat = rf_dot( r->d1, r->d1 ) == 0.0f && rf_dot( r->d2, r->d2 ) == 0.0f && rf_dot( r->n0, r->ng ) > 0.999999f;
}

static RfTriangleRecord world_record( const RfTriangles* t, uint32_t i, uint32_t light, float far_error )
{
    const uint32_t* v = t->indices + 3 * (size_t)i;
    RfTriangleRecord r = { .material = t->material[i], .light = light, .mirror = RF_NO_MIRROR };
    set_corners( &r, load_vec3( t->positions, v[0] ), load_vec3( t->positions, v[1] ), load_vec3( t->positions, v[2] ) );
    set_normals( &r, load_vec3( t->normals, v[0] ), load_vec3( t->normals, v[1] ), load_vec3( t->normals, v[2] ) );
    r.far = rf_is_far_triangle( t, i, far_error, false );
    return r;
}

RfResult rf_fill_records( RfTracer* tracer, RfError* error )
{
    const RfTriangles* t = &tracer->scene->triangles;
    uint32_t count = t->count;
    tracer->triangles = malloc( ( (size_t)count + 1 ) * sizeof *tracer->triangles );
    if ( tracer->triangles == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the surfaces of %u triangles", count );
    for ( uint32_t i = 0; i < count; ++i )
        tracer->triangles[i] = world_record(
            t, i, tracer->lights.of_triangle != NULL ? tracer->lights.of_triangle[i] : RF_NO_LIGHT, tracer->bvh.base.far_error );
    for ( uint32_t i = 0; i < tracer->mirrors.triangle_count; ++i )
        tracer->triangles[tracer->mirrors.triangle[i]].mirror = tracer->mirrors.of_triangle[i];
    const RfScene* scene = tracer->scene;
    bool moves = scene->still_placement_count < scene->placement_count;
    uint32_t moving = moves ? scene->placements[scene->still_placement_count].first : RF_MISS;
    tracer->known = ( RfTracerRecords ){ tracer->triangles, count, moving, scene->placement_count > 0 };
    return RF_OK;
}

static RfVec3 largest_of( RfVec3 a, RfVec3 b )
{
    return rf_vec3( rf_maxf( fabsf( a.x ), fabsf( b.x ) ), rf_maxf( fabsf( a.y ), fabsf( b.y ) ),
                    rf_maxf( fabsf( a.z ), fabsf( b.z ) ) );
}

// How far off its plane, of normal n, Embree may find a placed triangle whose corners have coordinates up to `own` in the mesh's
// space and `world` in the world: by the errors of the ray in the mesh's space, and of the matrix.
static float placed_error( const RfPlacedBvh* placed, const RfMat4* matrix, RfVec3 own, RfVec3 world, RfVec3 n )
{
    const double* m = matrix->m;
    const float normal[3] = { n.x, n.y, n.z };
    float x = world.x + (float)fabs( m[12] ), y = world.y + (float)fabs( m[13] ), z = world.z + (float)fabs( m[14] ), sum = 0.0f;
    for ( int k = 0; k < 3; ++k )
    {
        float slope = fabsf( (float)m[4 * k] * n.x + (float)m[4 * k + 1] * n.y + (float)m[4 * k + 2] * n.z );
        float moved = (float)fabs( m[k] ) * own.x + (float)fabs( m[4 + k] ) * own.y + (float)fabs( m[8 + k] ) * own.z;
        sum += slope * ( placed->inverse[k][0] * x + placed->inverse[k][1] * y + placed->inverse[k][2] * z ) +
               fabsf( normal[k] ) * ( moved + (float)fabs( m[12 + k] ) );
    }
    return PLACED_ROUNDINGS * 0x1p-24f * sum;
}

// The normal of the front side, by the corners in the mesh's space.
static RfVec3 own_normal( const RfTriangles* t, const uint32_t v[3], const RfMat4* matrix, double side )
{
    RfVec3 a = load_vec3( t->positions, v[0] );
    double twice;
    RfVec3 n =
        rf_unit_cross( rf_sub( load_vec3( t->positions, v[1] ), a ), rf_sub( load_vec3( t->positions, v[2] ), a ), &twice );
    return rf_place_normal( matrix, side, n );
}

// A triangle where `at` has it, within instances of `placed`. `most`: magnitudes that Embree's floats are rounded by, of the
// matrix; `own` and `world`: of coordinates, at least. `turned`: its corners are in reverse order.
static void make_record( const RfMeshBvh* mesh, const RfTriangleAt* at, const RfPlacedBvh* placed, const RfMat4* most, RfVec3 own,
                         RfVec3 world, bool turned, RfTriangleRecord* place )
{
    const RfTriangles* t = at->triangles;
    const uint32_t* v = t->indices + 3 * (size_t)at->index;
    const RfMat4* matrix = &at->placement->matrix;
    RfVec3 p[3], n[3];
    for ( int k = 0; k < 3; ++k )
    {
        RfVec3 corner = load_vec3( t->positions, v[k] );
        p[k] = rf_place_point( matrix, corner );
        n[k] = rf_place_normal( matrix, (double)placed->side, load_vec3( t->normals, v[k] ) );
        own = largest_of( own, corner );
        world = largest_of( world, p[k] );
    }
    RfTriangleRecord r = { .material = t->material[at->index], .light = RF_NO_LIGHT, .mirror = RF_NO_MIRROR, .placed = 1 };
    set_corners( &r, p[0], p[1], p[2] );
    float side = turned ? -placed->side : placed->side;
    r.ng = rf_scale( r.ng, side );          // a mirroring matrix reverses the winding
    if ( !( rf_dot( r.ng, r.ng ) > 0.5f ) ) // far out, where rounding joins corners that Embree keeps apart in the mesh's space
        r.ng = own_normal( t, v, matrix, (double)side );
    set_normals( &r, n[0], n[1], n[2] );
    r.far = mesh->far && rf_is_far_triangle( t, at->index, mesh->far_error, true );
    r.offset += placed_error( placed, most, own, world, r.ng );
    *place = r;
}

static void make_placed( const RfTracer* tracer, const RfTriangleAt* at, RfTriangleRecord* place )
{
    const RfPlacement* p = at->placement;
    const RfMeshBvh* mesh = tracer->bvh.meshes + p->mesh;
    RfVec3 none = { 0, 0, 0 };
    if ( !rf_is_between( tracer->scene, p ) )
    {
        make_record( mesh, at, tracer->bvh.placed + ( p - tracer->scene->placements ), &p->matrix, none, none, false, place );
        return;
    }
    RfBetween between;
    RfTriangleAt then = rf_triangle_between( tracer->scene, at, &between );
    RfPlacedBvh placed = rf_note_matrix( &between.placement.matrix, &between.most );
    make_record( mesh, &then, &placed, &between.most, between.own, between.world, between.turned, place );
    place->offset = rf_maxf( place->offset, rf_ray_offset( rf_largest_coordinate( between.world ) ) );
}

// The record of a placement's triangle, made at `place`.
static void make_placed_record( const RfTracer* tracer, const RfTriangleAt* at, RfTriangleRecord* place )
{
    make_placed( tracer, at, place );
    place->light = rf_moving_light( &tracer->lights, at->placement->first + at->index );
}

const RfTriangleRecord* rf_place_triangle_record( const RfTracer* tracer, uint32_t triangle, RfTriangleRecord* place )
{
    RfTriangleAt at = rf_locate_placed_triangle( tracer->scene, triangle );
    make_placed_record( tracer, &at, place );
    return place;
}

uint32_t rf_placed_material( const RfTracer* tracer, uint32_t triangle )
{
    RfTriangleAt at = rf_locate_placed_triangle( tracer->scene, triangle );
    return at.triangles->material[at.index];
}

uint32_t rf_placed_light( const RfTracer* tracer, uint32_t triangle ) { return rf_moving_light( &tracer->lights, triangle ); }
