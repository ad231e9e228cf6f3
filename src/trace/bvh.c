// Builds Embree's scene with its filter functions, and corrects hits on triangles of great extent in doubles.
#include "trace/bvh.h"

#include "base/fault.h"
#include "base/float_traps.h"
#include "base/random.h"
#include "bsdf/bsdf.h"
#include "scene/leave_out.h"
#include "scene/textured.h"

#include <stdlib.h>
#include <string.h>

// Embree takes the edges, their cross product N, and N·(p0 − o): at most 8 roundings of 2⁻²⁴ each.
#define EMBREE_ERROR 5e-7f

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

// The largest coordinate of the median corner of a triangle, m: how far out most of the scene is.
static float median_reach( const RfTriangles* t )
{
    float largest[SAMPLES];
    size_t corners = 3 * (size_t)t->count, step = corners / SAMPLES + 1, count = 0;
    for ( size_t i = 0; i < corners; i += step )
    {
        const float* p = t->positions + 3 * (size_t)t->indices[i];
        largest[count++] = rf_largest_coordinate( rf_vec3( p[0], p[1], p[2] ) );
    }
    qsort( largest, count, sizeof *largest, compare );
    return count > 0 ? largest[count / 2] : 0.0f;
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

// How far off its plane Embree may find a triangle that it starts `way` from vertex 0: the products in
// N·way, without their signs, over the length of N.
static float embree_error( RfVec3 e1, RfVec3 e2, RfVec3 way )
{
    double twice;
    rf_unit_cross( e1, e2, &twice );
    double x = fabs( (double)e1.y * (double)e2.z ) + fabs( (double)e1.z * (double)e2.y );
    double y = fabs( (double)e1.z * (double)e2.x ) + fabs( (double)e1.x * (double)e2.z );
    double z = fabs( (double)e1.x * (double)e2.y ) + fabs( (double)e1.y * (double)e2.x );
    double sum = x * fabs( (double)way.x ) + y * fabs( (double)way.y ) + z * fabs( (double)way.z );
    return twice > 0.0 ? EMBREE_ERROR * (float)( sum / twice ) : 0.0f;
}

static RfVec3 corner( const RfTriangles* t, uint32_t triangle, int i )
{
    const float* p = t->positions + 3 * (size_t)t->indices[3 * (size_t)triangle + (size_t)i];
    return rf_vec3( p[0], p[1], p[2] );
}

bool rf_is_far_triangle( const RfTriangles* t, uint32_t triangle, float far_error )
{
    RfVec3 p0 = corner( t, triangle, 0 );
    RfVec3 e1 = rf_sub( corner( t, triangle, 1 ), p0 ), e2 = rf_sub( corner( t, triangle, 2 ), p0 );
    RfVec3 extent = { rf_maxf( fabsf( e1.x ), fabsf( e2.x ) ), rf_maxf( fabsf( e1.y ), fabsf( e2.y ) ),
                      rf_maxf( fabsf( e1.z ), fabsf( e2.z ) ) };
    // slivers have a large bound, but their area is small
    return rf_largest_coordinate( extent ) * 3.0f * EMBREE_ERROR > far_error && embree_error( e1, e2, extent ) > far_error;
}

// The distance, in lengths of d, at which the ray crosses the plane of the triangle, in doubles; false if it
// runs parallel to it.
static bool cross_plane( const RfTriangleRecord* t, RfVec3 o, RfVec3 d, double* distance )
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
    if ( RF_FAULT( far_triangles ) || !cross_plane( t, o, d, &s ) || !( s > 0.0 ) )
        return interpolated;
    RfVec3 p = { (float)( (double)o.x + s * (double)d.x ), (float)( (double)o.y + s * (double)d.y ),
                 (float)( (double)o.z + s * (double)d.z ) };
    // segments end here from places about as far as where this ray started: the largest coordinate counts
    float offset = rf_ray_offset( rf_maxf( rf_largest_coordinate( p ), rf_largest_coordinate( o ) ) );
    if ( !t->far ) // rays that leave must get away from it by Embree's arithmetic
        offset += embree_error( t->e1, t->e2, rf_sub( t->p0, p ) );
    return offset < interpolated.offset ? ( RfHitPoint ){ p, offset } : interpolated;
}

// Offsets of the fields in Embree's packets (the accessors of its header are C++ only).
enum
{
    RAY_ORIGIN = 0,
    RAY_DIRECTION = 4,
    RAY_ID = 10,
    HIT_U = 3,
    HIT_V = 4,
    HIT_NUMBER = 5,
};

static uint32_t ray_bits( const struct RTCFilterFunctionNArguments* args, unsigned int row, unsigned int lane )
{
    return ( (const uint32_t*)(const void*)args->ray )[row * args->N + lane];
}

// Uniform in [0, 1), a hash of the ray and the triangle.
static float random_of_ray( const struct RTCFilterFunctionNArguments* args, unsigned int lane, uint32_t triangle )
{
    uint32_t hash = rf_mix32( triangle + 0x9e3779b9u );
    for ( unsigned int c = 0; c < 3; ++c )
    {
        hash = rf_mix32( hash ^ ray_bits( args, RAY_ORIGIN + c, lane ) );
        hash = rf_mix32( hash ^ ray_bits( args, RAY_DIRECTION + c, lane ) );
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
    RfVec3 d; // of the ray, of any length
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
static RfPane pane_at( const RfBvh* bvh, const Crossing* x, float opacity )
{
    const RfTriangleRecord* t = bvh->triangles + x->triangle;
    const RfMaterial* material = bvh->scene->materials + t->material;
    RfMaterial here;
    RfVec3 n = front_normal( t, x->u, x->v );
    if ( material->textured != NULL )
    {
        rf_material_at( bvh->scene, material, x->triangle, x->u, x->v, &here );
        n = rf_normal_at( bvh->scene, material, x->triangle, x->u, x->v, n, t->ng );
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

static bool hits_pane( const struct RTCFilterFunctionNArguments* args, unsigned int lane, uint32_t triangle, RfPane pane )
{
    RfQuery* query = (RfQuery*)args->context;
    uint32_t id = ray_bits( args, RAY_ID, lane );
    if ( query->kind == RF_QUERY_NEAREST )
    {
        bool hits = random_of_ray( args, lane, triangle ) >= pane.probability;
        query->passed |= !hits;
        return hits;
    }
    query->passed = true;
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
        RfPane pane = pane_at( args->geometryUserPtr, x, opacity );
        if ( pane.probability > 0.0f )
            return hits_pane( args, lane, x->triangle, pane );
    }
    return opacity >= 1.0f || hits_blended( args, lane, x->triangle, opacity );
}

// A far triangle that the ray does not reach, though Embree's floats say so: mostly the one that it starts from.
static bool misses_far( const struct RTCFilterFunctionNArguments* args, unsigned int lane, const RfTriangleRecord* t )
{
    const float* ray = (const float*)(const void*)args->ray + lane;
    const unsigned int n = args->N;
    float scale = 1.0f / ( (const RfBvh*)args->geometryUserPtr )->scale;
    RfVec3 o = rf_scale( rf_vec3( ray[0], ray[n], ray[2 * n] ), scale );
    ray += RAY_DIRECTION * n;
    RfVec3 d = rf_scale( rf_vec3( ray[0], ray[n], ray[2 * n] ), scale );
    double distance;
    if ( !cross_plane( t, o, d, &distance ) || !( distance > 0.0 ) )
        return true;
    return ( (const RfQuery*)args->context )->kind == RF_QUERY_SEGMENTS && distance > 1.0;
}

static void filter_hits( const struct RTCFilterFunctionNArguments* args )
{
    const RfBvh* bvh = args->geometryUserPtr;
    const RfScene* scene = bvh->scene;
    const RfQuery* query = (const RfQuery*)args->context;
    const float* ray = (const float*)(const void*)args->ray + RAY_DIRECTION * args->N;
    const float* u = (const float*)(const void*)args->hit + HIT_U * args->N;
    const float* v = (const float*)(const void*)args->hit + HIT_V * args->N;
    const unsigned int* number = (const unsigned int*)(const void*)args->hit + HIT_NUMBER * args->N;
    for ( unsigned int i = 0; i < args->N; ++i )
    {
        if ( args->valid[i] == 0 )
            continue;
        Crossing x = { .triangle = bvh->order[bvh->masked_first + number[i]], .u = u[i], .v = v[i] };
        const RfTriangleRecord* t = bvh->triangles + x.triangle;
        if ( t->far && !RF_FAULT( far_filter ) && misses_far( args, i, t ) )
        {
            args->valid[i] = 0;
            continue;
        }
        const RfMaterial* material = scene->materials + t->material;
        bool may_be_pane = query->pass_panes && rf_may_be_pane( material );
        bool ignored = query->kind == RF_QUERY_PANES && ( !may_be_pane || x.triangle == query->hit[ray_bits( args, RAY_ID, i )] );
        float opacity = material->textured != NULL ? rf_opacity_at( scene, material, x.triangle, u[i], v[i] ) : 1.0f;
        x.d = rf_vec3( ray[i], ray[args->N + i], ray[2 * args->N + i] );
        if ( ignored || opacity <= 0.0f || !is_hit( args, i, &x, opacity, may_be_pane ) || query->kind == RF_QUERY_PANES )
            args->valid[i] = 0;
    }
}

// Rejects hits where the surface is masked out. On a blended surface, rays hit with
// probability alpha, by a hash of the ray; segments are attenuated by 1 − alpha. Thin panes
// are passed likewise, and their factors accumulated for segments.
static void rf_filter_hits( const struct RTCFilterFunctionNArguments* args )
{
    // Embree, which calls this, runs without traps
    rf_resume_float_traps( ( (const RfQuery*)args->context )->traps );
    filter_hits( args );
    rf_pause_float_traps();
}

// Embree's geometry ids.
enum
{
    OPAQUE,
    MASKED,
};

static bool is_pane( const RfScene* scene, const RfMaterial* m )
{
    return rf_may_be_pane( m ) && rf_runs( scene, true, RF_EFFECT_PANES );
}

static bool has_filter( const RfBvh* bvh, uint32_t triangle )
{
    const RfMaterial* m = bvh->scene->materials + bvh->scene->triangles.material[triangle];
    return rf_runs( bvh->scene, rf_is_masked( m ), RF_EFFECT_ALPHA_MASK ) || rf_is_blended( m ) || is_pane( bvh->scene, m ) ||
           rf_is_far_triangle( &bvh->scene->triangles, triangle, bvh->far_error );
}

// Masked and blended triangles, panes and far triangles form a geometry of their own, so that the others need no
// filter. Sorts the triangles: unfiltered first.
static RfResult sort_masked( RfBvh* bvh, RfError* error )
{
    const RfScene* scene = bvh->scene;
    const RfTriangles* t = &scene->triangles;
    uint32_t masked = 0;
    bvh->panes = rf_is_forced( scene, RF_EFFECT_PANES );
    for ( uint32_t i = 0; i < t->count; ++i )
    {
        const RfMaterial* m = scene->materials + t->material[i];
        masked += has_filter( bvh, i );
        bvh->any_blended = bvh->any_blended || rf_is_blended( m );
        bvh->panes = bvh->panes || is_pane( scene, m );
        bvh->partial = bvh->partial || rf_is_blended( m ) || is_pane( scene, m );
    }
    bvh->blended = bvh->any_blended || rf_is_forced( scene, RF_EFFECT_ALPHA_BLEND );
    bvh->masked_first = t->count - masked;
    if ( masked == 0 )
        return RF_OK;
    bvh->order = malloc( (size_t)t->count * sizeof *bvh->order );
    if ( bvh->order == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for the order of %u triangles", t->count );
    uint32_t next[2] = { 0, bvh->masked_first };
    for ( uint32_t i = 0; i < t->count; ++i )
        bvh->order[next[has_filter( bvh, i )]++] = i;
    return RF_OK;
}

// Shared by both geometries. Embree may read 16 bytes at each vertex of 12, hence the padding.
static RTCBuffer copy_positions( RTCDevice device, const RfTriangles* t, float scale )
{
    size_t bytes = (size_t)t->vertex_count * 12;
    RTCBuffer buffer = rtcNewBuffer( device, bytes + 16 );
    char* memory = buffer != NULL ? rtcGetBufferData( buffer ) : NULL;
    if ( memory == NULL )
        return buffer; // reported by the device's error handler
    float* positions = (float*)(void*)memory;
    for ( size_t i = 0; i < 3 * (size_t)t->vertex_count; ++i )
        positions[i] = scale * t->positions[i];
    memset( memory + bytes, 0, 16 );
    return buffer;
}

static RTCGeometry make_geometry( RTCDevice device, const RfBvh* bvh, RTCBuffer positions, uint32_t first, uint32_t count )
{
    const RfTriangles* t = &bvh->scene->triangles;
    RTCGeometry geometry = rtcNewGeometry( device, RTC_GEOMETRY_TYPE_TRIANGLE );
    rtcSetGeometryBuffer( geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions, 0, 12, t->vertex_count );
    if ( bvh->order == NULL )
    {
        rtcSetSharedGeometryBuffer( geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, t->indices, 0, 12, count );
        return geometry;
    }
    uint32_t* indices = rtcSetNewGeometryBuffer( geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count );
    for ( uint32_t i = 0; indices != NULL && i < count; ++i )
        memcpy( indices + 3 * (size_t)i, t->indices + 3 * (size_t)bvh->order[first + i], 12 );
    return geometry;
}

static void attach( RTCDevice device, RfBvh* bvh, RTCBuffer positions, uint32_t first, uint32_t count, unsigned int id )
{
    if ( count == 0 )
        return;
    RTCGeometry geometry = make_geometry( device, bvh, positions, first, count );
    if ( id == MASKED )
    {
        rtcSetGeometryUserData( geometry, bvh );
        rtcSetGeometryIntersectFilterFunction( geometry, rf_filter_hits );
        rtcSetGeometryOccludedFilterFunction( geometry, rf_filter_hits );
    }
    rtcCommitGeometry( geometry );
    rtcAttachGeometryByID( bvh->embree_scene, geometry, id );
    rtcReleaseGeometry( geometry );
}

static void commit( RTCScene scene )
{
    int traps = rf_pause_float_traps(); // see query.c; its threads inherit them
    rtcCommitScene( scene );
    rf_resume_float_traps( traps );
}

// Build quality MEDIUM with ROBUST is deterministic with any number of threads; HIGH is not.
RfResult rf_build_bvh( RTCDevice device, const RfScene* scene, RfBvh* bvh, RfError* error )
{
    float reach = median_reach( &scene->triangles );
    *bvh = ( RfBvh ){ .scene = scene,
                      .scale = rf_embree_scale( reach ),
                      .far_error = rf_far_error( reach ),
                      .halved = rf_halves_packets( device ) };
    RfResult result = sort_masked( bvh, error );
    if ( result != RF_OK )
        return result;
    bvh->embree_scene = rtcNewScene( device );
    rtcSetSceneBuildQuality( bvh->embree_scene, RTC_BUILD_QUALITY_MEDIUM );
    rtcSetSceneFlags( bvh->embree_scene, RTC_SCENE_FLAG_ROBUST );
    RTCBuffer positions = copy_positions( device, &scene->triangles, bvh->scale );
    attach( device, bvh, positions, 0, bvh->masked_first, OPAQUE );
    attach( device, bvh, positions, bvh->masked_first, scene->triangles.count - bvh->masked_first, MASKED );
    if ( positions != NULL )
        rtcReleaseBuffer( positions );
    commit( bvh->embree_scene );
    return RF_OK;
}

RTCScene rf_build_mirror_scene( RTCDevice device, const RfScene* scene, float scale, const RfMirrors* mirrors )
{
    if ( mirrors->triangle_count == 0 )
        return NULL;
    RTCScene out = rtcNewScene( device );
    RTCGeometry geometry = rtcNewGeometry( device, RTC_GEOMETRY_TYPE_TRIANGLE );
    RTCBuffer positions = copy_positions( device, &scene->triangles, scale );
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
    commit( out );
    return out;
}

void rf_restore_order( const RfBvh* bvh, int count, const unsigned int* geometry, uint32_t* triangle )
{
    for ( int i = 0; i < count; ++i )
    {
        if ( geometry[i] != RTC_INVALID_GEOMETRY_ID )
            triangle[i] = bvh->order[triangle[i] + ( geometry[i] == MASKED ? bvh->masked_first : 0 )];
    }
}

void rf_destroy_bvh( RfBvh* bvh )
{
    if ( bvh->embree_scene != NULL )
        rtcReleaseScene( bvh->embree_scene );
    free( bvh->order );
    *bvh = ( RfBvh ){ 0 };
}
