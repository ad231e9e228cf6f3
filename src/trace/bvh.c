// Embree's scenes, that of the world and those of meshes that are placed, and its filter function: what is there in part, and hits
// that its floats invent.
#include "trace/bvh.h"

#include "base/fault.h"
#include "base/float_traps.h"
#include "base/random.h"
#include "bsdf/bsdf.h"
#include "scene/leave_out.h"
#include "scene/moments.h"
#include "scene/placement.h"
#include "scene/textured.h"
#include "trace/tracer.h"

#include <float.h>
#include <stdlib.h>
#include <string.h>

// Offsets of the fields in Embree's packets (the accessors of its header are C++ only).
enum
{
    RAY_ORIGIN = 0,
    RAY_DIRECTION = 4,
    RAY_FAR = 8, // of the hit
    RAY_ID = 10,
    HIT_U = 3,
    HIT_V = 4,
    HIT_NUMBER = 5,
    HIT_INSTANCE = 7,
};

static uint32_t ray_bits( const struct RTCFilterFunctionNArguments* args, unsigned int row, unsigned int lane )
{
    return ( (const uint32_t*)(const void*)args->ray )[row * args->N + lane];
}

// Origin (0 to 2) and direction (3 to 5) of the ray, in Embree's scene of the world: within an instance it has them in the
// mesh's.
static uint32_t world_bits( const struct RTCFilterFunctionNArguments* args, unsigned int row, unsigned int lane )
{
    const RfQuery* query = (const RfQuery*)args->context;
    if ( query->tracer->bvh.placed == NULL )
        return ray_bits( args, row < 3 ? RAY_ORIGIN + row : RAY_DIRECTION + row - 3, lane );
    uint32_t bits;
    memcpy( &bits, query->world[row] + ray_bits( args, RAY_ID, lane ), sizeof bits );
    return bits;
}

static RfVec3 world_vec3( const struct RTCFilterFunctionNArguments* args, unsigned int row, unsigned int lane )
{
    float v[3];
    for ( unsigned int c = 0; c < 3; ++c )
    {
        uint32_t bits = world_bits( args, row + c, lane );
        memcpy( v + c, &bits, sizeof bits );
    }
    return rf_vec3( v[0], v[1], v[2] );
}

// Uniform in [0, 1), a hash of the ray and the triangle.
static float random_of_ray( const struct RTCFilterFunctionNArguments* args, unsigned int lane, uint32_t triangle )
{
    uint32_t hash = rf_mix32( triangle + 0x9e3779b9u );
    for ( unsigned int c = 0; c < 3; ++c )
    {
        hash = rf_mix32( hash ^ world_bits( args, c, lane ) );
        hash = rf_mix32( hash ^ world_bits( args, 3 + c, lane ) );
    }
    return (float)( hash >> 8 ) * 0x1p-24f;
}

// Decides stochastically whether the ray hits a blended surface.
static bool hits_blended( const struct RTCFilterFunctionNArguments* args, unsigned int lane, uint32_t triangle, float opacity )
{
    RfQuery* query = (RfQuery*)args->context;
    if ( query->kind == RF_QUERY_NEAREST )
        return random_of_ray( args, lane, triangle ) < opacity;
    float* left = query->transmittance + ray_bits( args, RAY_ID, lane );
    *left *= 1.0f - opacity;
    return *left <= 0.0f;
}

// A point on a triangle that a ray meets.
typedef struct Crossing
{
    uint32_t triangle;
    float u, v;
    RfVec3 d; // of the ray, of any length; where the triangle may be a pane
} Crossing;

static RfVec3 front_normal( const RfTriangleRecord* t, float u, float v )
{
    if ( t->flat )
        return t->ng;
    RfVec3 n = rf_add( t->n0, rf_add( rf_scale( t->d1, u ), rf_scale( t->d2, v ) ) );
    float length2 = rf_dot( n, n );
    n = rf_scale( n, 1.0f / sqrtf( length2 ) );
    return rf_dot( n, t->ng ) > 0.0f && length2 > 1e-12f ? n : t->ng;
}

// The pane at a crossing, with the holes that its alpha leaves.
static RfPane pane_at( const RfTracer* tracer, const Crossing* x, float opacity )
{
    RfTriangleRecord place;
    const RfTriangleRecord* t = rf_triangle_record( tracer, x->triangle, &place );
    const RfScene* scene = tracer->scene;
    const RfMaterial* material = scene->materials + t->material;
    RfMaterial here;
    RfVec3 n = front_normal( t, x->u, x->v );
    if ( material->textured != NULL )
    {
        rf_material_at( scene, material, x->triangle, x->u, x->v, &here );
        n = rf_normal_at( scene, material, x->triangle, x->u, x->v, n, t->ng );
        material = &here;
    }
    float cos_o = rf_dot( n, x->d ) / rf_length( x->d );
    RfPane pane = rf_pane_of_material( material, rf_dot( t->ng, x->d ) < 0.0f ? -cos_o : cos_o );
    float hole = 1.0f - opacity;
    if ( !( pane.probability > 0.0f ) || hole <= 0.0f )
        return pane;
    return ( RfPane ){
        hole + opacity * pane.probability,
        rf_add( rf_vec3( hole, hole, hole ), rf_scale( pane.colour, opacity ) ),
    };
}

// Panes come in any order.
static void note_first( RfQuery* query, uint32_t id, uint32_t triangle, uint32_t bits )
{
    float at;
    memcpy( &at, &bits, sizeof at );
    bool before = at < query->first_at[id];
    query->first_pane[id] = before ? triangle : query->first_pane[id];
    query->first_at[id] = before ? at : query->first_at[id];
}

static bool hits_pane( const struct RTCFilterFunctionNArguments* args, unsigned int lane, uint32_t triangle, RfPane pane )
{
    RfQuery* query = (RfQuery*)args->context;
    uint32_t id = ray_bits( args, RAY_ID, lane );
    if ( query->kind == RF_QUERY_NEAREST )
    {
        bool hits = !query->surely && random_of_ray( args, lane, triangle ) >= pane.probability;
        query->passed |= !hits;
        return hits;
    }
    query->passed = true;
    if ( query->notes_first )
        note_first( query, id, triangle, ray_bits( args, RAY_FAR, lane ) );
    query->pane_probability[id] *= pane.probability;
    query->pane_weight[0][id] *= pane.colour.x / pane.probability;
    query->pane_weight[1][id] *= pane.colour.y / pane.probability;
    query->pane_weight[2][id] *= pane.colour.z / pane.probability;
    return query->pane_probability[id] <= 0.0f;
}

// Whether a surface that is there in part, or a pane, stops the ray.
static bool is_hit( const struct RTCFilterFunctionNArguments* args, unsigned int lane, const Crossing* x, float opacity,
                    bool may_be_pane )
{
    if ( may_be_pane )
    {
        RfPane pane = pane_at( ( (const RfQuery*)args->context )->tracer, x, opacity );
        if ( pane.probability > 0.0f )
            return hits_pane( args, lane, x->triangle, pane );
    }
    return opacity >= 1.0f || hits_blended( args, lane, x->triangle, opacity );
}

// A far triangle that the ray does not reach, though Embree's floats say so: mostly the one that it starts from.
static bool misses_far( const struct RTCFilterFunctionNArguments* args, unsigned int lane, uint32_t triangle )
{
    const RfQuery* query = (const RfQuery*)args->context;
    RfTriangleRecord place;
    const RfTriangleRecord* t = rf_triangle_record( query->tracer, triangle, &place );
    float scale = 1.0f / query->tracer->bvh.base.scale;
    RfVec3 o = rf_scale( world_vec3( args, 0, lane ), scale ), d = rf_scale( world_vec3( args, 3, lane ), scale );
    double distance;
    if ( !t->far )
        return false;
    if ( !rf_cross_plane( t, o, d, &distance ) || !( distance > 0.0 ) )
        return true;
    return query->kind == RF_QUERY_SEGMENTS && distance > 1.0;
}

static RfTriangleAt locate_hit( const struct RTCFilterFunctionNArguments* args, unsigned int lane, uint32_t* triangle )
{
    const RfMeshBvh* mesh = args->geometryUserPtr;
    const RfTracer* tracer = ( (const RfQuery*)args->context )->tracer;
    const unsigned int* hit = (const unsigned int*)(const void*)args->hit + lane;
    RfTriangleAt at = { mesh->triangles, mesh->order[mesh->masked_first + hit[HIT_NUMBER * args->N]], NULL };
    *triangle = at.index;
    if ( tracer->bvh.placed == NULL || hit[HIT_INSTANCE * args->N] == RTC_INVALID_GEOMETRY_ID )
        return at;
    at.placement = tracer->scene->placements + ( hit[HIT_INSTANCE * args->N] - RF_GEOMETRY_PLACEMENTS );
    *triangle += at.placement->first;
    return at;
}

static void filter_hits( const struct RTCFilterFunctionNArguments* args )
{
    const RfMeshBvh* mesh = args->geometryUserPtr;
    const RfQuery* query = (const RfQuery*)args->context;
    const RfScene* scene = query->tracer->scene;
    const float* u = (const float*)(const void*)args->hit + HIT_U * args->N;
    const float* v = (const float*)(const void*)args->hit + HIT_V * args->N;
    for ( unsigned int i = 0; i < args->N; ++i )
    {
        if ( args->valid[i] == 0 )
            continue;
        Crossing x = { .u = u[i], .v = v[i] };
        RfTriangleAt at = locate_hit( args, i, &x.triangle );
        if ( mesh->far && !RF_FAULT( far_filter ) && misses_far( args, i, x.triangle ) )
        {
            args->valid[i] = 0;
            continue;
        }
        const RfMaterial* material = scene->materials + at.triangles->material[at.index];
        bool may_be_pane = query->pass_panes && rf_may_be_pane( material );
        bool ignored = query->kind == RF_QUERY_PANES && ( !may_be_pane || x.triangle == query->hit[ray_bits( args, RAY_ID, i )] );
        float opacity = material->textured != NULL ? rf_opacity_on( scene, material, at.triangles, at.index, u[i], v[i] ) : 1.0f;
        if ( may_be_pane )
            x.d = world_vec3( args, 3, i );
        if ( ignored || opacity <= 0.0f || !is_hit( args, i, &x, opacity, may_be_pane ) || query->kind == RF_QUERY_PANES )
            args->valid[i] = 0;
    }
}

// Embree's filter function for geometries whose user pointer is their RfMeshBvh. Rejects hits where the surface
// is masked out. On a blended surface, rays hit with probability alpha, by a hash of the ray; segments are attenuated by
// 1 − alpha. Thin panes are passed by a hash of the ray, and their factors accumulated for segments.
static void filter_packet( const struct RTCFilterFunctionNArguments* args )
{
    if ( ( (const RfQuery*)args->context )->kind == RF_QUERY_SWEPT )
        return; // swept geometry is there as a whole
    // Embree, which calls this, runs without traps
    rf_resume_float_traps( ( (const RfQuery*)args->context )->traps );
    filter_hits( args );
    rf_pause_float_traps();
}

// Times the ray offset at the median distance: only what reaches some 30 times as far pays for the check.
#define FAR_RATIO 64.0f

#define SAMPLES 1024

// Scenes of 2^-20 to 2^20 m, some micrometres to 1000 km, need no scale.
#define LEAST_EXPONENT 20

static int compare( const void* a, const void* b )
{
    float x = *(const float*)a, y = *(const float*)b;
    return ( x > y ) - ( x < y );
}

static float median( float* values, size_t count )
{
    qsort( values, count, sizeof *values, compare );
    return count > 0 ? values[count / 2] : 0.0f;
}

// The largest coordinate of the median corner of a triangle, m: how far out most of the scene is.
static float median_reach( const RfScene* scene )
{
    float largest[SAMPLES];
    size_t corners = 3 * (size_t)rf_triangle_count( scene ), step = corners / SAMPLES + 1, count = 0;
    for ( size_t i = 0; i < corners; i += step )
        largest[count++] = rf_largest_coordinate( rf_triangle_corner( scene, (uint32_t)( i / 3 ), (int)( i % 3 ) ) );
    return median( largest, count );
}

// That of a mesh, in its own space.
static float median_mesh_reach( const RfTriangles* t )
{
    float largest[SAMPLES];
    size_t corners = 3 * (size_t)t->count, step = corners / SAMPLES + 1, count = 0;
    for ( size_t i = 0; i < corners; i += step )
    {
        const float* p = t->positions + 3 * (size_t)t->indices[i];
        largest[count++] = rf_largest_coordinate( rf_vec3( p[0], p[1], p[2] ) );
    }
    return median( largest, count );
}

// The error of hits, in scene units off the plane, beyond which a triangle is far: well above that of triangles
// within reach.
static float rf_far_error( float reach ) { return FAR_RATIO * rf_ray_offset( reach ); }

// The scale of Embree's scene: its products of four lengths leave the range of floats below 1e-9 and above 1e9 m.
static float rf_embree_scale( float reach )
{
    int exponent;
    frexpf( reach, &exponent );
    bool ordinary = reach == 0.0f || ( exponent > -LEAST_EXPONENT && exponent < LEAST_EXPONENT );
    return ordinary || RF_FAULT( embree_scale ) ? 1.0f : ldexpf( 1.0f, -exponent );
}

static bool is_pane( const RfScene* scene, const RfMaterial* m )
{
    return rf_may_be_pane( m ) && rf_runs( scene, true, RF_EFFECT_PANES );
}

// Whether hits on its triangles are looked at, whatever their extent.
static bool is_filtered( const RfScene* scene, const RfMaterial* m )
{
    return rf_runs( scene, rf_is_masked( m ), RF_EFFECT_ALPHA_MASK ) || rf_is_blended( m ) || is_pane( scene, m );
}

// What a material of the scene's triangles calls for.
static void note_material( const RfScene* scene, const RfMaterial* m, RfBvh* bvh )
{
    bvh->any_blended = bvh->any_blended || rf_is_blended( m );
    bvh->panes = bvh->panes || is_pane( scene, m );
    bvh->partial = bvh->partial || rf_is_blended( m ) || is_pane( scene, m );
}

// The vertices of a mesh at the moments of the shutter at which they differ: often a single one.
typedef struct Positions
{
    int moments;
    const float* positions[RF_MAX_BLUR_STEPS + 1];
} Positions;

static Positions positions_of( const RfScene* scene, int mesh )
{
    const RfTriangles* t = &scene->meshes[mesh].triangles;
    Positions all = { 1, { t->positions } };
    int count = rf_moment_count( scene );
    bool deforms = false;
    for ( int k = 0; k < count && count > 1; ++k )
    {
        all.positions[k] = rf_meshes_at( scene, k )[mesh].triangles.positions;
        deforms = deforms || ( all.positions[k] != all.positions[0] &&
                               memcmp( all.positions[k], all.positions[0], 12 * (size_t)t->vertex_count ) != 0 );
    }
    all.moments = deforms ? count : 1;
    return all;
}

static bool is_far( const Positions* at, const RfMeshBvh* mesh, uint32_t triangle )
{
    bool far = false;
    RfTriangles t = *mesh->triangles;
    for ( int k = 0; k < at->moments && !far; ++k )
    {
        t.positions = (float*)at->positions[k];
        far = rf_is_far_triangle( &t, triangle, mesh->far_error, mesh->placed );
    }
    return far;
}

// Masked and blended triangles, panes and far triangles form a geometry of their own, so that the others need no
// filter. Sorts the triangles: unfiltered first.
static RfResult sort_masked( const RfScene* scene, const Positions* at, RfBvh* bvh, RfMeshBvh* mesh, RfError* error )
{
    const RfTriangles* t = mesh->triangles;
    uint32_t masked = 0;
    bool filtered = false;
    for ( uint32_t i = 0; i < t->count; ++i )
    {
        if ( i == 0 || t->material[i] != t->material[i - 1] )
        {
            const RfMaterial* m = scene->materials + t->material[i];
            note_material( scene, m, bvh );
            filtered = is_filtered( scene, m );
        }
        bool far = is_far( at, mesh, i );
        mesh->far = mesh->far || far;
        masked += filtered || far;
    }
    mesh->masked_first = t->count - masked;
    bvh->filtered = bvh->filtered || masked > 0;
    if ( masked == 0 )
        return RF_OK;
    mesh->order = malloc( (size_t)t->count * sizeof *mesh->order );
    if ( mesh->order == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the order of %u triangles", t->count );
    uint32_t next[2] = { 0, mesh->masked_first };
    for ( uint32_t i = 0; i < t->count; ++i )
    {
        bool has_filter = is_filtered( scene, scene->materials + t->material[i] ) || is_far( at, mesh, i );
        mesh->order[next[has_filter]++] = i;
    }
    return RF_OK;
}

// Shared by both geometries. Embree may read 16 bytes at each vertex of 12, hence the padding.
static RTCBuffer copy_positions( RTCDevice device, uint32_t vertices, const float* from, float scale )
{
    size_t bytes = (size_t)vertices * 12;
    RTCBuffer buffer = rtcNewBuffer( device, bytes + 16 );
    char* memory = buffer != NULL ? rtcGetBufferData( buffer ) : NULL;
    if ( memory == NULL )
        return buffer; // reported by the device's error handler
    float* positions = (float*)(void*)memory;
    for ( size_t i = 0; i < 3 * (size_t)vertices; ++i )
        positions[i] = scale * from[i];
    memset( memory + bytes, 0, 16 );
    return buffer;
}

// The vertices of a mesh, at each of the moments at which they differ.
typedef struct Vertices
{
    int moments;
    RTCBuffer positions[RF_MAX_BLUR_STEPS + 1];
} Vertices;

static RTCGeometry make_geometry( RTCDevice device, const RfMeshBvh* mesh, const Vertices* v, uint32_t first, uint32_t count )
{
    const RfTriangles* t = mesh->triangles;
    RTCGeometry geometry = rtcNewGeometry( device, RTC_GEOMETRY_TYPE_TRIANGLE );
    if ( v->moments > 1 )
        rtcSetGeometryTimeStepCount( geometry, (unsigned int)v->moments );
    for ( int k = 0; k < v->moments; ++k )
        rtcSetGeometryBuffer( geometry, RTC_BUFFER_TYPE_VERTEX, (unsigned int)k, RTC_FORMAT_FLOAT3, v->positions[k], 0, 12,
                              t->vertex_count );
    if ( mesh->order == NULL )
    {
        rtcSetSharedGeometryBuffer( geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, t->indices, 0, 12, count );
        return geometry;
    }
    uint32_t* indices = rtcSetNewGeometryBuffer( geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count );
    for ( uint32_t i = 0; indices != NULL && i < count; ++i )
        memcpy( indices + 3 * (size_t)i, t->indices + 3 * (size_t)mesh->order[first + i], 12 );
    return geometry;
}

static void attach( RTCDevice device, RfMeshBvh* mesh, const Vertices* v, uint32_t first, uint32_t count, unsigned int id )
{
    if ( count == 0 )
        return;
    RTCGeometry geometry = make_geometry( device, mesh, v, first, count );
    if ( id == RF_GEOMETRY_FILTERED )
    {
        rtcSetGeometryUserData( geometry, mesh );
        rtcSetGeometryIntersectFilterFunction( geometry, filter_packet );
        rtcSetGeometryOccludedFilterFunction( geometry, filter_packet );
    }
    rtcCommitGeometry( geometry );
    rtcAttachGeometryByID( mesh->embree_scene, geometry, id );
    rtcReleaseGeometry( geometry );
}

void rf_commit_scene( RTCScene scene )
{
    int traps = rf_pause_float_traps(); // see query.c; its threads inherit them
    rtcCommitScene( scene );
    rf_resume_float_traps( traps );
}

// What Embree failed to make must not go into its other scenes: building those would crash. The device's error handler has the
// message.
static RfResult note_failure( RTCDevice device, RfError* error )
{
    return rtcGetDeviceError( device ) == RTC_ERROR_NONE ? RF_OK : rf_fail( error, RF_ERROR_DEVICE, "building the BVH failed" );
}

// Embree's scene of a mesh whose triangles are sorted, not yet committed. Build quality MEDIUM with ROBUST is deterministic with
// any number of threads; HIGH is not.
static void begin_mesh( RTCDevice device, const Positions* at, RfMeshBvh* mesh )
{
    const RfTriangles* t = mesh->triangles;
    Vertices v = { .moments = at->moments };
    mesh->embree_scene = rtcNewScene( device );
    rtcSetSceneBuildQuality( mesh->embree_scene, RTC_BUILD_QUALITY_MEDIUM );
    rtcSetSceneFlags( mesh->embree_scene, RTC_SCENE_FLAG_ROBUST );
    for ( int k = 0; k < v.moments; ++k )
        v.positions[k] = copy_positions( device, t->vertex_count, at->positions[k], mesh->scale );
    attach( device, mesh, &v, 0, mesh->masked_first, RF_GEOMETRY_OPAQUE );
    attach( device, mesh, &v, mesh->masked_first, t->count - mesh->masked_first, RF_GEOMETRY_FILTERED );
    for ( int k = 0; k < v.moments; ++k )
    {
        if ( v.positions[k] != NULL )
            rtcReleaseBuffer( v.positions[k] );
    }
}

// The most by which a placement of the mesh lengthens an edge.
static double most_stretch( const RfScene* scene, int mesh )
{
    double most = 0.0;
    int count = scene->placement_count;
    for ( int i = 0; i < count * rf_moment_count( scene ); ++i )
    {
        const RfPlacement* p = rf_placements_at( scene, i / count ) + i % count;
        if ( p->mesh != mesh || !p->shown )
            continue;
        double squares = 0.0;
        for ( int k = 0; k < 12; ++k )
            squares += k % 4 < 3 ? p->matrix.m[k] * p->matrix.m[k] : 0.0;
        most = fmax( most, sqrt( squares ) );
    }
    return most;
}

// What deforms is never met as it was loaded: each pose has a mesh of its own.
static bool is_left_to_poses( const RfScene* scene, int mesh )
{
    bool left = scene->meshes[mesh].deformation != NULL;
    for ( int i = 0; i < scene->still_placement_count && left; ++i )
        left = scene->placements[i].mesh != mesh;
    return left;
}

// Those from `first` on.
static RfResult build_meshes( RTCDevice device, const RfScene* scene, int first, RfBvh* bvh, RfError* error )
{
    bvh->meshes = calloc( (size_t)scene->mesh_count + 1, sizeof *bvh->meshes );
    if ( bvh->meshes == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for %d meshes", scene->mesh_count );
    bvh->mesh_count = scene->mesh_count;
    bvh->shared_meshes = first;
    for ( int m = first; m < scene->mesh_count; ++m )
    {
        const RfTriangles* t = &scene->meshes[m].triangles;
        bvh->meshes[m].triangles = t;
        if ( t->count == 0 ) // that a pose has no need of
            continue;
        double far_error = (double)bvh->base.far_error / fmax( most_stretch( scene, m ), 1e-30 );
        bvh->meshes[m] = ( RfMeshBvh ){ .triangles = t,
                                        .placed = true,
                                        .scale = rf_embree_scale( median_mesh_reach( t ) ),
                                        .far_error = (float)fmin( far_error, (double)FLT_MAX ) };
        Positions at = positions_of( scene, m );
        RfResult result = sort_masked( scene, &at, bvh, bvh->meshes + m, error );
        if ( result != RF_OK )
            return result;
        if ( is_left_to_poses( scene, m ) )
            continue;
        begin_mesh( device, &at, bvh->meshes + m );
        result = note_failure( device, error );
        if ( result != RF_OK )
            return result;
        rf_commit_scene( bvh->meshes[m].embree_scene );
    }
    return note_failure( device, error );
}

// From Embree's scene of a mesh to that of the world.
static void set_transform( RTCGeometry instance, int moment, const RfMat4* matrix, double base_scale, double mesh_scale )
{
    float columns[12];
    for ( int k = 0; k < 12; ++k )
    {
        int column = k / 3;
        columns[k] = (float)( matrix->m[4 * column + k % 3] * base_scale / ( column < 3 ? mesh_scale : 1.0 ) );
    }
    rtcSetGeometryTransform( instance, (unsigned int)moment, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, columns );
}

// The moments at which a placement stands differently; 1: it is the same at all.
static int placement_moments( const RfScene* scene, int placement )
{
    const RfMat4* matrix = &rf_placements_at( scene, 0 )[placement].matrix;
    bool moves = false;
    for ( int k = 1; k < rf_moment_count( scene ); ++k )
        moves = moves || memcmp( &rf_placements_at( scene, k )[placement].matrix, matrix, sizeof *matrix ) != 0;
    return moves ? rf_moment_count( scene ) : 1;
}

// Placements [first, end).
static void attach_placements( RTCDevice device, const RfScene* scene, const RfBvh* bvh, int first, int end, RTCScene to )
{
    for ( int i = first; i < end; ++i )
    {
        const RfPlacement* p = scene->placements + i;
        const RfMeshBvh* mesh = bvh->meshes + p->mesh;
        if ( !p->shown || mesh->triangles->count == 0 )
            continue;
        RTCGeometry instance = rtcNewGeometry( device, RTC_GEOMETRY_TYPE_INSTANCE );
        rtcSetGeometryInstancedScene( instance, mesh->embree_scene );
        int moments = placement_moments( scene, i );
        if ( moments > 1 )
            rtcSetGeometryTimeStepCount( instance, (unsigned int)moments );
        for ( int k = 0; k < moments; ++k )
            set_transform( instance, k, &rf_placements_at( scene, k )[i].matrix, (double)bvh->base.scale, (double)mesh->scale );
        rtcCommitGeometry( instance );
        rtcAttachGeometryByID( to, instance, RF_GEOMETRY_PLACEMENTS + (unsigned int)i );
        rtcReleaseGeometry( instance );
    }
}

static RfResult note_placements( const RfScene* scene, RfBvh* bvh, RfError* error )
{
    bvh->placed = calloc( (size_t)scene->placement_count, sizeof *bvh->placed );
    if ( bvh->placed == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for %d instances", scene->placement_count );
    for ( int i = 0; i < scene->placement_count; ++i )
    {
        const RfPlacement* p = scene->placements + i;
        bvh->placed[i] = p->shown ? rf_note_matrix( &p->matrix, &p->matrix ) : ( RfPlacedBvh ){ .side = 1.0f };
    }
    return RF_OK;
}

static RfResult place_meshes( RTCDevice device, const RfScene* scene, RfBvh* bvh, RfError* error )
{
    RfResult result = note_placements( scene, bvh, error );
    if ( result == RF_OK )
        result = build_meshes( device, scene, 0, bvh, error );
    if ( result == RF_OK )
        attach_placements( device, scene, bvh, 0, scene->still_placement_count, bvh->base.embree_scene );
    return result;
}

static bool is_attached( const RfScene* scene, int placement )
{
    const RfPlacement* p = scene->placements + placement;
    return p->shown && scene->meshes[p->mesh].triangles.count > 0;
}

RfResult rf_build_posed_bvh( RTCDevice device, const RfBvh* still, const RfScene* posed, RfBvh* bvh, RfError* error )
{
    *bvh = *still;
    bvh->meshes = NULL;
    bvh->placed = NULL;
    bvh->mesh_count = 0;
    bvh->boxes = rf_no_boxes();
    RfResult result = note_placements( posed, bvh, error );
    if ( result == RF_OK )
        result = build_meshes( device, posed, still->mesh_count, bvh, error );
    if ( result != RF_OK )
        return result;
    if ( still->mesh_count > 0 )
        memcpy( bvh->meshes, still->meshes, (size_t)still->mesh_count * sizeof *bvh->meshes );
    bool any = false;
    for ( int i = posed->still_placement_count; i < posed->placement_count && !any; ++i )
        any = is_attached( posed, i );
    if ( !any )
        return RF_OK;
    bvh->moving = rtcNewScene( device );
    rtcSetSceneFlags( bvh->moving, RTC_SCENE_FLAG_ROBUST );
    attach_placements( device, posed, bvh, posed->still_placement_count, posed->placement_count, bvh->moving );
    rf_add_moving_boxes( posed, bvh->base.scale, &bvh->boxes );
    rf_finish_boxes( &bvh->boxes );
    result = note_failure( device, error );
    if ( result == RF_OK )
        rf_commit_scene( bvh->moving );
    return result;
}

void rf_add_swept( const RfBvh* posed, const RfScene* scene, RTCScene swept )
{
    for ( int i = scene->still_placement_count; i < scene->placement_count && posed->moving != NULL; ++i )
    {
        if ( is_attached( scene, i ) )
            rtcAttachGeometry( swept, rtcGetGeometry( posed->moving, RF_GEOMETRY_PLACEMENTS + (unsigned int)i ) );
    }
}

RfResult rf_build_bvh( RTCDevice device, const RfScene* scene, RfBvh* bvh, RfError* error )
{
    float reach = median_reach( scene );
    *bvh = ( RfBvh ){
        .base = { .triangles = &scene->triangles, .scale = rf_embree_scale( reach ), .far_error = rf_far_error( reach ) },
        .halved = rf_halves_packets( device ),
        .panes = rf_is_forced( scene, RF_EFFECT_PANES )
    };
    Positions at = { 1, { scene->triangles.positions } };
    RfResult result = sort_masked( scene, &at, bvh, &bvh->base, error );
    if ( result == RF_OK )
        begin_mesh( device, &at, &bvh->base );
    if ( result == RF_OK && scene->placement_count > 0 )
        result = place_meshes( device, scene, bvh, error );
    bvh->blended = bvh->any_blended || rf_is_forced( scene, RF_EFFECT_ALPHA_BLEND );
    if ( result == RF_OK )
        result = note_failure( device, error );
    if ( result == RF_OK )
        rf_commit_scene( bvh->base.embree_scene );
    return result;
}

RTCScene rf_build_mirror_scene( RTCDevice device, const RfScene* scene, float scale, const RfMirrors* mirrors )
{
    if ( mirrors->triangle_count == 0 )
        return NULL;
    RTCScene out = rtcNewScene( device );
    RTCGeometry geometry = rtcNewGeometry( device, RTC_GEOMETRY_TYPE_TRIANGLE );
    RTCBuffer positions = copy_positions( device, scene->triangles.vertex_count, scene->triangles.positions, scale );
    rtcSetGeometryBuffer( geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions, 0, 12,
                          scene->triangles.vertex_count );
    uint32_t* indices =
        rtcSetNewGeometryBuffer( geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mirrors->triangle_count );
    for ( uint32_t i = 0; indices != NULL && i < mirrors->triangle_count; ++i )
        memcpy( indices + 3 * (size_t)i, scene->triangles.indices + 3 * (size_t)mirrors->triangle[i], 12 );
    rtcSetSceneFlags( out, RTC_SCENE_FLAG_ROBUST );
    rtcCommitGeometry( geometry );
    rtcAttachGeometry( out, geometry );
    rtcReleaseGeometry( geometry );
    if ( positions != NULL )
        rtcReleaseBuffer( positions );
    rf_commit_scene( out );
    return out;
}

static void destroy_mesh( RfMeshBvh* mesh )
{
    if ( mesh->embree_scene != NULL )
        rtcReleaseScene( mesh->embree_scene );
    free( mesh->order );
}

void rf_destroy_posed_bvh( RfBvh* bvh )
{
    if ( bvh->moving != NULL )
        rtcReleaseScene( bvh->moving );
    for ( int m = bvh->shared_meshes; m < bvh->mesh_count; ++m )
        destroy_mesh( bvh->meshes + m );
    free( bvh->meshes );
    free( bvh->placed );
    *bvh = ( RfBvh ){ 0 };
}

void rf_destroy_bvh( RfBvh* bvh )
{
    destroy_mesh( &bvh->base );
    rf_destroy_posed_bvh( bvh );
}
