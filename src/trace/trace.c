#include "trace/trace.h"

#include "light/light.h"
#include "trace/filter.h"

#include <embree3/rtcore.h>
#include <pmmintrin.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>

struct RfTracer
{
    const RfScene* scene;
    RTCDevice device;
    RfBvh bvh;
    RfLights lights;
    RfMirrors mirrors;
    RTCScene mirror_scene; // the triangles of the mirrors alone; NULL: none
    RfTriangleRecord* triangles;
    bool textured;
    long bytes;
    char text[64];
    char message[256]; // the first error of Embree
};

void rf_set_float_mode( void )
{
    _MM_SET_FLUSH_ZERO_MODE( _MM_FLUSH_ZERO_ON );
    _MM_SET_DENORMALS_ZERO_MODE( _MM_DENORMALS_ZERO_ON );
}

static void on_device_error( void* user, enum RTCError code, const char* text )
{
    RfTracer* tracer = user;
    if ( tracer->message[0] == 0 )
        snprintf( tracer->message, sizeof tracer->message, "Embree error %d: %s", (int)code, text != NULL ? text : "" );
}

static bool on_memory( void* user, ssize_t bytes, bool post )
{
    (void)post;
    RfTracer* tracer = user;
    __atomic_add_fetch( &tracer->bytes, (long)bytes, __ATOMIC_RELAXED );
    return true;
}

static RfResult build_bvh( RfTracer* tracer, RfError* error )
{
    RfResult result = rf_build_bvh( tracer->device, tracer->scene, &tracer->bvh, error );
    if ( result == RF_OK && tracer->message[0] != 0 )
        return rf_fail( error, RF_ERROR_DEVICE, "%s: building the BVH failed: %s",
                        tracer->scene->path != NULL ? tracer->scene->path : "scene", tracer->message );
    return result;
}

static RfVec3 load_vec3( const float* values, uint32_t index )
{
    return rf_vec3( values[3 * (size_t)index], values[3 * (size_t)index + 1], values[3 * (size_t)index + 2] );
}

static RfTriangleRecord make_record( const RfTriangles* t, uint32_t i, uint32_t light )
{
    const uint32_t* v = t->indices + 3 * (size_t)i;
    RfTriangleRecord r = { .material = t->material[i], .light = light, .mirror = RF_NO_MIRROR };
    r.p0 = load_vec3( t->positions, v[0] );
    r.e1 = rf_sub( load_vec3( t->positions, v[1] ), r.p0 );
    r.e2 = rf_sub( load_vec3( t->positions, v[2] ), r.p0 );
    r.n0 = load_vec3( t->normals, v[0] );
    r.d1 = rf_sub( load_vec3( t->normals, v[1] ), r.n0 );
    r.d2 = rf_sub( load_vec3( t->normals, v[2] ), r.n0 );
    double twice;
    r.ng = rf_unit_cross( r.e1, r.e2, &twice );
    float largest = rf_maxf( rf_largest_coordinate( r.p0 ), rf_maxf( rf_largest_coordinate( load_vec3( t->positions, v[1] ) ),
                                                                     rf_largest_coordinate( load_vec3( t->positions, v[2] ) ) ) );
    r.offset = rf_ray_offset( largest );
    r.flat = rf_dot( r.d1, r.d1 ) == 0.0f && rf_dot( r.d2, r.d2 ) == 0.0f && rf_dot( r.n0, r.ng ) > 0.999999f;
    return r;
}

static RfResult fill_records( RfTracer* tracer, RfError* error )
{
    const RfTriangles* t = &tracer->scene->triangles;
    tracer->triangles = malloc( ( (size_t)t->count + 1 ) * sizeof *tracer->triangles );
    if ( tracer->triangles == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for the surfaces of %u triangles", t->count );
    for ( uint32_t i = 0; i < t->count; ++i )
        tracer->triangles[i] =
            make_record( t, i, tracer->lights.of_triangle != NULL ? tracer->lights.of_triangle[i] : RF_NO_LIGHT );
    for ( uint32_t i = 0; i < tracer->mirrors.triangle_count; ++i )
        tracer->triangles[tracer->mirrors.triangle[i]].mirror = tracer->mirrors.of_triangle[i];
    return RF_OK;
}

static void describe_device( RfTracer* tracer )
{
    long version = (long)rtcGetDeviceProperty( tracer->device, RTC_DEVICE_PROPERTY_VERSION );
    const char* isa = __builtin_cpu_supports( "avx512f" ) && __builtin_cpu_supports( "avx512dq" ) &&
                              __builtin_cpu_supports( "avx512vl" ) && __builtin_cpu_supports( "avx512bw" )
                          ? "avx512"
                          : ( __builtin_cpu_supports( "avx2" ) ? "avx2" : "sse" );
    snprintf( tracer->text, sizeof tracer->text, "embree %ld.%ld.%ld %s", version / 10000, version / 100 % 100, version % 100,
              isa );
}

RfResult rf_create_tracer( const RfScene* scene, RfTracer** out, RfError* error )
{
    *out = NULL;
    RfTracer* tracer = calloc( 1, sizeof *tracer );
    if ( tracer == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for the ray tracer" );
    tracer->scene = scene;
    for ( uint32_t i = 0; i < scene->material_count; ++i )
        tracer->textured = tracer->textured || scene->materials[i].textured != NULL;
    tracer->device = rtcNewDevice( "frequency_level=simd512" );
    if ( tracer->device == NULL )
    {
        free( tracer );
        return rf_fail( error, RF_ERROR_DEVICE, "Embree could not create a device (error %d)", (int)rtcGetDeviceError( NULL ) );
    }
    rtcSetDeviceErrorFunction( tracer->device, on_device_error, tracer );
    rtcSetDeviceMemoryMonitorFunction( tracer->device, on_memory, tracer );
    describe_device( tracer );
    RfResult result = rf_collect_lights( scene, &tracer->lights, error );
    if ( result == RF_OK )
        result = build_bvh( tracer, error );
    if ( result == RF_OK )
        result = rf_find_mirrors( scene, &tracer->mirrors, error );
    if ( result == RF_OK )
        tracer->mirror_scene = rf_build_mirror_scene( tracer->device, scene, &tracer->mirrors );
    if ( result == RF_OK )
        result = fill_records( tracer, error );
    if ( result != RF_OK )
    {
        rf_destroy_tracer( tracer );
        return result;
    }
    *out = tracer;
    return RF_OK;
}

void rf_destroy_tracer( RfTracer* tracer )
{
    if ( tracer == NULL )
        return;
    rf_destroy_bvh( &tracer->bvh );
    if ( tracer->mirror_scene != NULL )
        rtcReleaseScene( tracer->mirror_scene );
    rf_destroy_mirrors( &tracer->mirrors );
    rtcReleaseDevice( tracer->device );
    rf_destroy_lights( &tracer->lights );
    free( tracer->triangles );
    free( tracer );
}

const RfScene* rf_tracer_scene( const RfTracer* tracer ) { return tracer->scene; }
bool rf_tracer_is_textured( const RfTracer* tracer ) { return tracer->textured; }
bool rf_tracer_is_blended( const RfTracer* tracer ) { return tracer->bvh.blended; }
const RfMirrors* rf_tracer_mirrors( const RfTracer* tracer ) { return &tracer->mirrors; }
const RfLights* rf_tracer_lights( const RfTracer* tracer ) { return &tracer->lights; }

bool rf_tracer_has_light( const RfTracer* tracer )
{
    const RfLights* lights = rf_tracer_lights( tracer );
    return lights->count > 0 || rf_has_sky( lights );
}
const RfTriangleRecord* rf_tracer_triangles( const RfTracer* tracer ) { return tracer->triangles; }
const char* rf_tracer_device( const RfTracer* tracer ) { return tracer->text; }
size_t rf_tracer_bytes( const RfTracer* tracer )
{
    return (size_t)tracer->bytes + (size_t)tracer->scene->triangles.count * sizeof( RfTriangleRecord );
}

static RfQuery begin_query( bool segments, bool coherent )
{
    RfQuery query;
    rtcInitIntersectContext( &query.context );
    query.context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    query.segments = segments;
    for ( int i = 0; i < RF_PACKET; ++i )
        query.transmittance[i] = 1.0f;
    return query;
}

static void reset_transmittance( const RfTracer* tracer, RfQuery* query )
{
    for ( int i = 0; i < RF_PACKET && tracer->bvh.blended; ++i )
        query->transmittance[i] = 1.0f;
}

// Masks the lanes of a packet beyond `count`.
static int set_valid( int* valid, int first, int count )
{
    int lanes = count - first < RF_PACKET ? count - first : RF_PACKET;
    for ( int i = 0; i < RF_PACKET; ++i )
        valid[i] = i < lanes ? -1 : 0;
    return lanes;
}

static void set_ray( struct RTCRay16* ray, int lanes, const float* const d[3], int first, float far )
{
    for ( int i = 0; i < lanes; ++i )
    {
        ray->dir_x[i] = d[0][first + i];
        ray->dir_y[i] = d[1][first + i];
        ray->dir_z[i] = d[2][first + i];
    }
    for ( int i = 0; i < RF_PACKET; ++i )
    {
        ray->tnear[i] = 0.0f;
        ray->tfar[i] = far;
        ray->time[i] = 0.0f;
        ray->mask[i] = 0xffffffffu;
        ray->id[i] = (unsigned int)i;
        ray->flags[i] = 0;
    }
}

static void set_origins( struct RTCRay16* ray, int lanes, const float* const o[3], int first )
{
    for ( int i = 0; i < lanes; ++i )
    {
        ray->org_x[i] = o[0][first + i];
        ray->org_y[i] = o[1][first + i];
        ray->org_z[i] = o[2][first + i];
    }
}

void rf_trace_nearest( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], bool coherent,
                       uint32_t* triangle, float* u, float* v )
{
    RfQuery query = begin_query( false, coherent );
    _Alignas( 64 ) int valid[RF_PACKET];
    struct RTCRayHit16 packet;
    memset( &packet, 0, sizeof packet );
    for ( int first = 0; first < count; first += RF_PACKET )
    {
        int lanes = set_valid( valid, first, count );
        set_origins( &packet.ray, lanes, o, first );
        set_ray( &packet.ray, lanes, d, first, INFINITY );
        for ( int i = 0; i < RF_PACKET; ++i )
            packet.hit.geomID[i] = packet.hit.primID[i] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect16( valid, tracer->bvh.embree_scene, &query.context, &packet );
        for ( int i = 0; i < lanes; ++i )
        {
            triangle[first + i] = packet.hit.primID[i];
            u[first + i] = packet.hit.u[i];
            v[first + i] = packet.hit.v[i];
        }
        if ( tracer->bvh.order != NULL )
            rf_restore_order( &tracer->bvh, lanes, packet.hit.geomID, triangle + first );
    }
}

void rf_trace_segments( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3], float* visible )
{
    RfQuery query = begin_query( true, false );
    _Alignas( 64 ) int valid[RF_PACKET];
    struct RTCRay16 ray;
    memset( &ray, 0, sizeof ray );
    for ( int first = 0; first < count; first += RF_PACKET )
    {
        int lanes = set_valid( valid, first, count );
        set_origins( &ray, lanes, o, first );
        set_ray( &ray, lanes, d, first, 1.0f );
        rtcOccluded16( valid, tracer->bvh.embree_scene, &query.context, &ray );
        for ( int i = 0; i < lanes; ++i )
            visible[first + i] = ray.tfar[i] < 0.0f ? 0.0f : query.transmittance[i]; // −inf if occluded
        reset_transmittance( tracer, &query );
    }
}

// Fills the segments of a packet; returns the number of lanes to test.
static int set_segments( struct RTCRay16* ray, int* valid, RfVec3 origin, int lanes, const float* const point[3], int first,
                         const float* weight )
{
    int tested = 0;
#pragma omp simd reduction( + : tested )
    for ( int i = 0; i < lanes; ++i )
    {
        ray->dir_x[i] = point[0][first + i] - origin.x;
        ray->dir_y[i] = point[1][first + i] - origin.y;
        ray->dir_z[i] = point[2][first + i] - origin.z;
        valid[i] = weight[first + i] > 0.0f ? -1 : 0;
        tested -= valid[i];
    }
    return tested;
}

int rf_trace_from_origin( const RfTracer* tracer, RfVec3 origin, int count, const float* const point[3], float* weight )
{
    // although these rays are coherent, Embree's incoherent packet traversal is faster here
    RfQuery query = begin_query( true, false );
    _Alignas( 64 ) int valid[RF_PACKET];
    struct RTCRay16 ray;
    memset( &ray, 0, sizeof ray );
    for ( int i = 0; i < RF_PACKET; ++i )
    {
        ray.id[i] = (unsigned int)i;
        ray.org_x[i] = origin.x;
        ray.org_y[i] = origin.y;
        ray.org_z[i] = origin.z;
        ray.mask[i] = 0xffffffffu;
    }
    int sum = 0;
    for ( int first = 0; first < count; first += RF_PACKET )
    {
        int lanes = set_valid( valid, first, count );
        int tested = set_segments( &ray, valid, origin, lanes, point, first, weight );
        if ( tested == 0 )
            continue;
        for ( int i = 0; i < RF_PACKET; ++i )
            ray.tfar[i] = 1.0f;
        rtcOccluded16( valid, tracer->bvh.embree_scene, &query.context, &ray );
        for ( int i = 0; i < lanes; ++i )
            weight[first + i] = ray.tfar[i] < 0.0f ? 0.0f : weight[first + i] * query.transmittance[i]; // −inf if occluded
        reset_transmittance( tracer, &query );
        sum += tested;
    }
    return sum;
}

void rf_trace_mirrors( const RfTracer* tracer, RfVec3 origin, int count, const float* const point[3], const uint8_t* mirror,
                       float* const hit[3], float* weight )
{
    RfQuery query = begin_query( false, true );
    _Alignas( 64 ) int valid[RF_PACKET];
    struct RTCRayHit16 packet;
    memset( &packet, 0, sizeof packet );
    for ( int first = 0; first < count; first += RF_PACKET )
    {
        int lanes = set_valid( valid, first, count );
        set_segments( &packet.ray, valid, origin, lanes, point, first, weight );
        for ( int i = 0; i < RF_PACKET; ++i )
        {
            packet.ray.org_x[i] = origin.x;
            packet.ray.org_y[i] = origin.y;
            packet.ray.org_z[i] = origin.z;
            packet.ray.tnear[i] = 0.0f;
            packet.ray.tfar[i] = INFINITY;
            packet.ray.mask[i] = 0xffffffffu;
            packet.hit.geomID[i] = packet.hit.primID[i] = RTC_INVALID_GEOMETRY_ID;
        }
        rtcIntersect16( valid, tracer->mirror_scene, &query.context, &packet );
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
            const RfTriangleRecord* t = tracer->triangles + tracer->mirrors.triangle[number];
            RfVec3 p = rf_add( t->p0, rf_add( rf_scale( t->e1, packet.hit.u[i] ), rf_scale( t->e2, packet.hit.v[i] ) ) );
            float side = rf_dot( t->ng, rf_sub( origin, p ) ) < 0.0f ? -1.0f : 1.0f;
            p = rf_madd( p, t->ng, side * t->offset );
            hit[0][first + i] = p.x;
            hit[1][first + i] = p.y;
            hit[2][first + i] = p.z;
        }
    }
}
