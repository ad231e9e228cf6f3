// Rays and segments, in packets of 16.
#include "base/fault.h"
#include "base/float_traps.h"
#include "trace/bvh.h"
#include "trace/tracer.h"

#include <math.h>
#include <string.h>

// Embree's traversal raises the flag for invalid operations: empty slots of its nodes have infinite bounds.
static inline __attribute__( ( always_inline ) ) void intersect( const int* valid, RTCScene scene, RfQuery* query,
                                                                 struct RTCRayHit16* packet )
{
    query->traps = rf_pause_float_traps();
    rf_intersect_packet( valid, scene, &query->context, packet );
    rf_resume_float_traps( query->traps );
}

static inline __attribute__( ( always_inline ) ) void occluded( const int* valid, RTCScene scene, RfQuery* query,
                                                                struct RTCRay16* ray )
{
    query->traps = rf_pause_float_traps();
    rf_occlude_packet( valid, scene, &query->context, ray );
    rf_resume_float_traps( query->traps );
}

static void keep_rays( RfQuery* query, const struct RTCRay16* ray )
{
    memcpy( query->world[0], ray->org_x, 3 * sizeof ray->org_x );
    memcpy( query->world[3], ray->dir_x, 3 * sizeof ray->dir_x );
}

static inline bool find_near( const RfBvh* bvh, const struct RTCRay16* ray, const int* valid, int* near )
{
    const float *o[3] = { ray->org_x, ray->org_y, ray->org_z }, *d[3] = { ray->dir_x, ray->dir_y, ray->dir_z };
    return rf_find_near_lanes( &bvh->boxes, o, d, ray->tfar, valid, near );
}

// With instances; out of line, to leave registers to the others.
static __attribute__( ( noinline ) ) void intersect_placed( const int* valid, RfQuery* query, struct RTCRayHit16* packet )
{
    const RfBvh* bvh = &query->tracer->bvh;
    _Alignas( 64 ) int near[RF_PACKET];
    if ( bvh->filtered )
        keep_rays( query, &packet->ray );
    intersect( valid, bvh->base.embree_scene, query, packet );
    if ( bvh->moving != NULL && find_near( bvh, &packet->ray, valid, near ) )
        intersect( near, bvh->moving, query, packet );
}

// What nothing that stands still is in the way of may be behind what moves.
static __attribute__( ( noinline ) ) void occlude_placed( const int* valid, RfQuery* query, struct RTCRay16* ray )
{
    const RfBvh* bvh = &query->tracer->bvh;
    _Alignas( 64 ) int open[RF_PACKET], near[RF_PACKET];
    if ( bvh->filtered )
        keep_rays( query, ray );
    occluded( valid, bvh->base.embree_scene, query, ray );
    if ( bvh->moving == NULL )
        return;
    for ( int i = 0; i < RF_PACKET; ++i )
        open[i] = ray->tfar[i] < 0.0f ? 0 : valid[i];
    if ( find_near( bvh, ray, open, near ) )
        occluded( near, bvh->moving, query, ray );
}

// The nearer hit of what stands still and what moves.
static inline __attribute__( ( always_inline ) ) void intersect_world( const int* valid, RfQuery* query,
                                                                       struct RTCRayHit16* packet )
{
    if ( query->tracer->bvh.placed != NULL )
        intersect_placed( valid, query, packet );
    else
        intersect( valid, query->tracer->bvh.base.embree_scene, query, packet );
}

static inline __attribute__( ( always_inline ) ) void occlude_world( const int* valid, RfQuery* query, struct RTCRay16* ray )
{
    if ( query->tracer->bvh.placed != NULL )
        occlude_placed( valid, query, ray );
    else
        occluded( valid, query->tracer->bvh.base.embree_scene, query, ray );
}

static void reset_panes( RfQuery* query )
{
    query->passed = false;
    for ( int i = 0; i < RF_PACKET; ++i )
        query->pane_probability[i] = query->pane_weight[0][i] = query->pane_weight[1][i] = query->pane_weight[2][i] = 1.0f;
}

static void reset_first( RfQuery* query )
{
    for ( int i = 0; i < RF_PACKET; ++i )
    {
        query->first_pane[i] = RF_MISS;
        query->first_at[i] = INFINITY;
    }
}

// With panes->first the query notes which panes come first.
static void begin_first( RfQuery* query, const RfPaneLanes* panes )
{
    query->notes_first = panes != NULL && panes->first != NULL;
    if ( query->notes_first )
        reset_first( query );
}

static RfQuery begin_query( const RfTracer* tracer, RfQueryKind kind, bool coherent, bool pass_panes )
{
    RfQuery query;
    rf_init_ray_context( &query.context, coherent, tracer->bvh.halved );
    query.tracer = tracer;
    query.kind = kind;
    query.pass_panes = pass_panes;
    query.surely = false;
    query.notes_first = false;
    for ( int i = 0; i < RF_PACKET; ++i )
        query.transmittance[i] = 1.0f;
    if ( pass_panes )
        reset_panes( &query );
    return query;
}

static void reset_transmittance( const RfTracer* tracer, RfQuery* query )
{
    for ( int i = 0; i < RF_PACKET && tracer->bvh.blended; ++i )
        query->transmittance[i] = 1.0f;
}

// Copies what was accumulated for a packet of segments or rays, and starts anew.
static void take_panes( RfQuery* query, int lanes, int first, const RfPaneLanes* panes )
{
    size_t bytes = (size_t)lanes * sizeof( float );
    memcpy( panes->probability + first, query->pane_probability, bytes );
    for ( int c = 0; c < 3; ++c )
        memcpy( panes->weight[c] + first, query->pane_weight[c], bytes );
    if ( query->notes_first )
    {
        memcpy( panes->first + first, query->first_pane, (size_t)lanes * sizeof *panes->first );
        reset_first( query );
    }
    if ( query->passed )
        reset_panes( query );
}

// Rays this long end before they begin. Embree 3 on processors that have packets of 4 alone traces those of 16 without
// regard to `valid`: lanes that must not be traced need such a length as well.
#define NO_RAY ( -INFINITY )

// Masks the lanes of a packet beyond `count`.
static int set_valid( int* valid, int first, int count )
{
    int lanes = count - first < RF_PACKET ? count - first : RF_PACKET;
    for ( int i = 0; i < RF_PACKET; ++i )
        valid[i] = i < lanes ? -1 : 0;
    return lanes;
}

// What is the same in all packets of a query.
static void begin_rays( const RfTracer* tracer, struct RTCRay16* ray )
{
    memset( ray, 0, sizeof *ray );
    for ( int i = 0; i < RF_PACKET; ++i )
    {
        ray->time[i] = tracer->moment;
        ray->tnear[i] = RF_FAULT( near_0 ) ? 1e-4f : 0.0f;
        ray->mask[i] = 0xffffffffu;
        ray->id[i] = (unsigned int)i;
    }
}

// Rays are scaled as the BVH is; segments, which have a length, in their direction too.
static void set_ray( struct RTCRay16* ray, int lanes, const float* const d[3], int first, float scale, float far )
{
    for ( int i = 0; i < lanes; ++i )
    {
        ray->dir_x[i] = scale * d[0][first + i];
        ray->dir_y[i] = scale * d[1][first + i];
        ray->dir_z[i] = scale * d[2][first + i];
    }
    for ( int i = 0; i < RF_PACKET; ++i )
        ray->tfar[i] = i < lanes ? far : NO_RAY;
}

static void set_origins( struct RTCRay16* ray, int lanes, const float* const o[3], int first, float scale )
{
    for ( int i = 0; i < lanes; ++i )
    {
        ray->org_x[i] = scale * o[0][first + i];
        ray->org_y[i] = scale * o[1][first + i];
        ray->org_z[i] = scale * o[2][first + i];
    }
}

// What a packet passed on its way to its hits. The filter sees hits in any order, those beyond the nearest as
// well, so only a second traversal, up to the hits, knows.
static void find_panes( const RfTracer* tracer, const int* valid, const struct RTCRayHit16* found, int lanes,
                        const uint32_t* triangle, RfQuery* out )
{
    struct RTCRayHit16 packet = *found;
    *out = begin_query( tracer, RF_QUERY_PANES, false, true );
    memcpy( out->hit, triangle, (size_t)lanes * sizeof *triangle );
    for ( int i = 0; i < RF_PACKET; ++i )
        packet.hit.geomID[i] = packet.hit.primID[i] = RTC_INVALID_GEOMETRY_ID;
    intersect_world( valid, out, &packet );
}

static void restore_order( const RfMeshBvh* mesh, int count, const unsigned int* geometry, uint32_t* triangle )
{
    for ( int i = 0; i < count; ++i )
    {
        if ( geometry[i] != RTC_INVALID_GEOMETRY_ID )
            triangle[i] = rf_mesh_triangle( mesh, geometry[i], triangle[i] );
    }
}

// From primitives of geometries to triangle numbers.
static void number_hits( const RfTracer* tracer, int count, const struct RTCHit16* hit, uint32_t* triangle )
{
    for ( int i = 0; i < count; ++i )
    {
        if ( hit->geomID[i] == RTC_INVALID_GEOMETRY_ID )
            continue;
        if ( hit->instID[0][i] == RTC_INVALID_GEOMETRY_ID )
        {
            triangle[i] = rf_mesh_triangle( &tracer->bvh.base, hit->geomID[i], triangle[i] );
            continue;
        }
        const RfPlacement* p = tracer->scene->placements + ( hit->instID[0][i] - RF_GEOMETRY_PLACEMENTS );
        triangle[i] = p->first + rf_mesh_triangle( tracer->bvh.meshes + p->mesh, hit->geomID[i], triangle[i] );
    }
}

// `panes`: NULL if they are surfaces like any others.
static void trace_nearest( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], bool coherent,
                           bool surely, uint32_t* triangle, float* u, float* v, const RfPaneLanes* panes )
{
    RfQuery query = begin_query( tracer, RF_QUERY_NEAREST, coherent, panes != NULL );
    query.surely = surely;
    _Alignas( 64 ) int valid[RF_PACKET];
    struct RTCRayHit16 packet;
    memset( &packet.hit, 0, sizeof packet.hit );
    begin_rays( tracer, &packet.ray );
    for ( int first = 0; first < count; first += RF_PACKET )
    {
        int lanes = set_valid( valid, first, count );
        set_origins( &packet.ray, lanes, o, first, tracer->bvh.base.scale );
        set_ray( &packet.ray, lanes, d, first, 1.0f, INFINITY );
        for ( int i = 0; i < RF_PACKET; ++i )
            packet.hit.geomID[i] = packet.hit.primID[i] = RTC_INVALID_GEOMETRY_ID;
        intersect_world( valid, &query, &packet );
        for ( int i = 0; i < lanes; ++i )
        {
            triangle[first + i] = packet.hit.primID[i];
            u[first + i] = packet.hit.u[i];
            v[first + i] = packet.hit.v[i];
        }
        if ( tracer->bvh.placed != NULL )
            number_hits( tracer, lanes, &packet.hit, triangle + first );
        else if ( tracer->bvh.base.order != NULL )
            restore_order( &tracer->bvh.base, lanes, packet.hit.geomID, triangle + first );
        if ( panes == NULL )
            continue;
        RfQuery passed = query;
        if ( query.passed )
            find_panes( tracer, valid, &packet, lanes, triangle + first, &passed );
        take_panes( &passed, lanes, first, panes );
        query.passed = false;
    }
}

void rf_trace_nearest( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], bool coherent,
                       uint32_t* triangle, float* u, float* v )
{
    trace_nearest( tracer, count, o, d, coherent, false, triangle, u, v, NULL );
}

void rf_trace_nearest_past_panes( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3],
                                  uint32_t* triangle, float* u, float* v, const RfPaneLanes* panes )
{
    trace_nearest( tracer, count, o, d, false, false, triangle, u, v, panes );
}

void rf_trace_nearest_through_panes( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3],
                                     uint32_t* triangle, float* u, float* v, const RfPaneLanes* panes )
{
    trace_nearest( tracer, count, o, d, false, true, triangle, u, v, panes );
}

// A packet of listed segments, this many times as long.
static void gather_segments( struct RTCRay16* ray, int lanes, const float* const o[3], const float* const d[3],
                             const int32_t* listed, float scale, float length )
{
    for ( int i = 0; i < lanes; ++i )
    {
        int32_t from = listed[i];
        ray->org_x[i] = scale * o[0][from];
        ray->org_y[i] = scale * o[1][from];
        ray->org_z[i] = scale * o[2][from];
        ray->dir_x[i] = scale * d[0][from];
        ray->dir_y[i] = scale * d[1][from];
        ray->dir_z[i] = scale * d[2][from];
    }
    for ( int i = 0; i < RF_PACKET; ++i )
        ray->tfar[i] = i < lanes ? length : NO_RAY;
}

static void scatter_panes( RfQuery* query, int lanes, const int32_t* to, const RfPaneLanes* panes )
{
    for ( int i = 0; i < lanes; ++i )
    {
        panes->probability[to[i]] = query->pane_probability[i];
        for ( int c = 0; c < 3; ++c )
            panes->weight[c][to[i]] = query->pane_weight[c][i];
    }
    if ( query->notes_first )
    {
        for ( int i = 0; i < lanes; ++i )
            panes->first[to[i]] = query->first_pane[i];
        reset_first( query );
    }
    if ( query->passed )
        reset_panes( query );
}

// `listed`: which; NULL: the first `count`.
static void trace_segments( const RfTracer* tracer, int count, const int32_t* listed, const float* const o[3],
                            const float* const d[3], float* visible, const RfPaneLanes* panes )
{
    RfQuery query = begin_query( tracer, RF_QUERY_SEGMENTS, false, panes != NULL );
    begin_first( &query, panes );
    _Alignas( 64 ) int valid[RF_PACKET];
    struct RTCRay16 ray;
    begin_rays( tracer, &ray );
    for ( int first = 0; first < count; first += RF_PACKET )
    {
        int lanes = set_valid( valid, first, count );
        if ( listed == NULL )
        {
            set_origins( &ray, lanes, o, first, tracer->bvh.base.scale );
            set_ray( &ray, lanes, d, first, tracer->bvh.base.scale, 1.0f );
        }
        else
            gather_segments( &ray, lanes, o, d, listed + first, tracer->bvh.base.scale, 1.0f );
        occlude_world( valid, &query, &ray );
        for ( int i = 0; i < lanes; ++i )
            visible[listed == NULL ? first + i : listed[first + i]] =
                ray.tfar[i] < 0.0f ? 0.0f : query.transmittance[i]; // −inf if occluded
        reset_transmittance( tracer, &query );
        if ( panes != NULL && listed == NULL )
            take_panes( &query, lanes, first, panes );
        else if ( panes != NULL )
            scatter_panes( &query, lanes, listed + first, panes );
    }
}

void rf_trace_segments( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], float* visible )
{
    trace_segments( tracer, count, NULL, o, d, visible, NULL );
}

void rf_trace_segments_past_panes( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3],
                                   float* visible, const RfPaneLanes* panes )
{
    trace_segments( tracer, count, NULL, o, d, visible, panes );
}

void rf_trace_listed_segments( const RfTracer* tracer, int count, const int32_t* listed, const float* const o[3],
                               const float* const d[3], float* visible, const RfPaneLanes* panes )
{
    trace_segments( tracer, count, listed, o, d, visible, panes );
}

static void clear_panes( int count, const RfPaneLanes* panes )
{
    for ( int i = 0; i < count; ++i )
        panes->probability[i] = panes->weight[0][i] = panes->weight[1][i] = panes->weight[2][i] = 1.0f;
    for ( int i = 0; i < count && panes->first != NULL; ++i )
        panes->first[i] = RF_MISS;
}

// Fills a packet with the segments to the next points to test, from *at on. Returns how many.
static int gather_points( struct RTCRay16* ray, RfVec3 origin, int count, const float* const point[3], const float* weight,
                          float scale, int* at, int32_t to[RF_PACKET] )
{
    int lanes = 0, i = *at;
    for ( ; i < count && lanes < RF_PACKET; ++i )
    {
        to[lanes] = i;
        lanes += weight[i] > 0.0f;
    }
    *at = i;
    for ( int k = 0; k < lanes; ++k )
    {
        ray->dir_x[k] = scale * ( point[0][to[k]] - origin.x );
        ray->dir_y[k] = scale * ( point[1][to[k]] - origin.y );
        ray->dir_z[k] = scale * ( point[2][to[k]] - origin.z );
    }
    for ( int k = 0; k < RF_PACKET; ++k )
        ray->tfar[k] = k >= lanes ? NO_RAY : RF_FAULT( sides ) ? 0.9999f : 1.0f;
    return lanes;
}

// Packets are filled with points that have a weight: Embree traces those of less than 15 rays one by one. They are not coherent ones to
// Embree: its traversal by a frustum shows the filter some hits several times, and with instances it may not end.
static int trace_from_origin( const RfTracer* tracer, RfVec3 origin, int count, const float* const point[3], float* weight,
                              const RfPaneLanes* panes )
{
    RfQuery query = begin_query( tracer, RF_QUERY_SEGMENTS, false, panes != NULL );
    begin_first( &query, panes );
    float scale = tracer->bvh.base.scale;
    _Alignas( 64 ) int valid[RF_PACKET];
    struct RTCRay16 ray;
    begin_rays( tracer, &ray );
    for ( int i = 0; i < RF_PACKET; ++i )
    {
        ray.org_x[i] = scale * origin.x;
        ray.org_y[i] = scale * origin.y;
        ray.org_z[i] = scale * origin.z;
    }
    if ( panes != NULL )
        clear_panes( count, panes );
    int sum = 0, lanes = RF_PACKET;
    for ( int at = 0; at < count; sum += lanes )
    {
        int32_t to[RF_PACKET];
        lanes = gather_points( &ray, origin, count, point, weight, scale, &at, to );
        if ( lanes == 0 )
            break;
        set_valid( valid, 0, lanes );
        occlude_world( valid, &query, &ray );
        for ( int i = 0; i < lanes; ++i )
        {
            bool hidden = ray.tfar[i] < 0.0f && !RF_FAULT( occlusion ); // −inf
            weight[to[i]] = hidden ? 0.0f : weight[to[i]] * query.transmittance[i];
        }
        reset_transmittance( tracer, &query );
        if ( panes != NULL )
            scatter_panes( &query, lanes, to, panes );
    }
    return sum;
}

int rf_trace_from_origin( const RfTracer* tracer, RfVec3 origin, int count, const float* const point[3], float* weight )
{
    return trace_from_origin( tracer, origin, count, point, weight, NULL );
}

int rf_trace_from_origin_past_panes( const RfTracer* tracer, RfVec3 origin, int count, const float* const point[3], float* weight,
                                     const RfPaneLanes* panes )
{
    return trace_from_origin( tracer, origin, count, point, weight, panes );
}

void rf_trace_mirrors( const RfTracer* tracer, RfVec3 origin, int count, const float* const point[3], const uint8_t* mirror,
                       float* const hit[3], uint32_t* triangle, float* weight )
{
    RfQuery query = begin_query( tracer, RF_QUERY_NEAREST, true, false );
    float scale = tracer->bvh.base.scale;
    float least = rf_ray_offset( rf_largest_coordinate( origin ) ); // clear of the rounding of its coordinates
    _Alignas( 64 ) int valid[RF_PACKET];
    struct RTCRayHit16 packet;
    memset( &packet.hit, 0, sizeof packet.hit );
    begin_rays( tracer, &packet.ray );
    for ( int first = 0; first < count; first += RF_PACKET )
    {
        int lanes = set_valid( valid, first, count );
        for ( int i = 0; i < lanes; ++i )
        {
            packet.ray.dir_x[i] = scale * ( point[0][first + i] - origin.x );
            packet.ray.dir_y[i] = scale * ( point[1][first + i] - origin.y );
            packet.ray.dir_z[i] = scale * ( point[2][first + i] - origin.z );
            valid[i] = weight[first + i] > 0.0f ? -1 : 0;
        }
        for ( int i = 0; i < RF_PACKET; ++i )
        {
            packet.ray.org_x[i] = scale * origin.x;
            packet.ray.org_y[i] = scale * origin.y;
            packet.ray.org_z[i] = scale * origin.z;
            packet.ray.tfar[i] = valid[i] != 0 ? INFINITY : NO_RAY;
            packet.hit.geomID[i] = packet.hit.primID[i] = RTC_INVALID_GEOMETRY_ID;
        }
        intersect( valid, tracer->mirror_scene, &query, &packet );
        for ( int i = 0; i < lanes; ++i )
        {
            uint32_t number = packet.hit.primID[i];
            bool found =
                valid[i] != 0 && number != RTC_INVALID_GEOMETRY_ID && tracer->mirrors.of_triangle[number] == mirror[first + i];
            if ( !found )
            {
                weight[first + i] = 0.0f;
                continue;
            }
            triangle[first + i] = tracer->mirrors.triangle[number];
            const RfTriangleRecord* t = tracer->triangles + triangle[first + i];
            RfVec3 d = rf_vec3( packet.ray.dir_x[i], packet.ray.dir_y[i], packet.ray.dir_z[i] );
            RfHitPoint at = rf_hit_point( t, packet.hit.u[i], packet.hit.v[i], origin, d );
            float side = rf_dot( t->ng, rf_sub( origin, at.p ) ) < 0.0f ? -1.0f : 1.0f;
            RfVec3 p = rf_madd( at.p, t->ng, side * rf_maxf( at.offset, least ) );
            RF_PUT3( hit, first + i, p );
        }
    }
}

void rf_find_swept( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], float length,
                    uint8_t* touched )
{
    if ( tracer->swept == NULL || RF_FAULT( swept ) )
        return;
    RTCScene swept = RF_FAULT( swept_of_group ) ? tracer->bvh.moving : tracer->swept->embree_scene;
    if ( swept == NULL )
        return;
    RfQuery query = begin_query( tracer, RF_QUERY_SWEPT, false, false );
    _Alignas( 64 ) int valid[RF_PACKET];
    struct RTCRay16 ray;
    begin_rays( tracer, &ray );
    // rays that may meet swept geometry, of all blocks, in full packets
    int32_t near[RF_PACKET + RF_BOX_BLOCK];
    int listed = 0;
    for ( int first = 0; first < count; first += RF_BOX_BLOCK )
    {
        const float *from[3] = { o[0] + first, o[1] + first, o[2] + first },
                    *way[3] = { d[0] + first, d[1] + first, d[2] + first };
        int block = count - first < RF_BOX_BLOCK ? count - first : RF_BOX_BLOCK;
        int found = rf_list_near_rays( &tracer->swept->boxes, block, from, way, length, touched + first, near + listed );
        for ( int k = 0; k < found; ++k )
            near[listed + k] += first;
        listed += found;
        int traced = 0, least = first + block < count ? RF_PACKET : 1;
        for ( int lanes; listed - traced >= least; traced += lanes )
        {
            lanes = set_valid( valid, traced, listed );
            gather_segments( &ray, lanes, o, d, near + traced, tracer->bvh.base.scale, length );
            occluded( valid, swept, &query, &ray );
            for ( int i = 0; i < lanes; ++i )
                touched[near[traced + i]] |= ray.tfar[i] < 0.0f;
        }
        listed -= traced;
        memmove( near, near + traced, (size_t)listed * sizeof *near );
    }
}
