#include "trace/trace.h"

#include "light/light.h"
#include "scene/textured.h"

#include <embree3/rtcore.h>
#include <pmmintrin.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>

#define PACKET 16

// The two geometries of the BVH.
enum
{
    OPAQUE,
    MASKED,
};

struct RfTracer
{
    const RfScene* scene;
    RTCDevice device;
    RTCScene embree_scene;
    RfLights lights;
    RfTriangleRecord* triangles;
    uint32_t masked_first; // first of the order below that may be cut out
    uint32_t* order;       // the scene's triangles in the order of the BVH's two geometries; NULL: the scene's own order
    long bytes;
    char text[64];
    char message[256]; // Embree's last error
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

// Masked materials are a geometry of their own, so that all others go without
// its filter: first the triangles without, then those with.
static RfResult sort_masked( RfTracer* tracer, RfError* error )
{
    const RfScene* scene = tracer->scene;
    const RfTriangles* t = &scene->triangles;
    uint32_t masked = 0;
    for ( uint32_t i = 0; i < t->count; ++i )
        masked += rf_is_masked( scene->materials + t->material[i] );
    tracer->masked_first = t->count - masked;
    if ( masked == 0 )
        return RF_OK;
    tracer->order = malloc( (size_t)t->count * sizeof *tracer->order );
    if ( tracer->order == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for the order of %u triangles", t->count );
    uint32_t next[2] = { 0, tracer->masked_first };
    for ( uint32_t i = 0; i < t->count; ++i )
        tracer->order[next[rf_is_masked( scene->materials + t->material[i] )]++] = i;
    return RF_OK;
}

// Lets rays through where the surface is cut out. A packet's hits are rows of N:
// the normal's x, y, z, then u, v and the number of the triangle (the accessors
// of Embree's header are for C++).
static void filter_masked( const struct RTCFilterFunctionNArguments* args )
{
    const RfTracer* tracer = args->geometryUserPtr;
    const RfScene* scene = tracer->scene;
    const float *u = (const float*)(const void*)args->hit + 3 * args->N, *v = u + args->N;
    const unsigned int* number = (const unsigned int*)(const void*)args->hit + 5 * args->N;
    for ( unsigned int i = 0; i < args->N; ++i )
    {
        if ( args->valid[i] == 0 )
            continue;
        uint32_t triangle = tracer->order[tracer->masked_first + number[i]];
        const RfMaterial* material = scene->materials + scene->triangles.material[triangle];
        if ( rf_is_cut_out( scene, material, triangle, u[i], v[i] ) )
            args->valid[i] = 0;
    }
}

// For both geometries. Embree may read 16 bytes at each vertex of 12.
static RTCBuffer copy_positions( const RfTracer* tracer )
{
    const RfTriangles* t = &tracer->scene->triangles;
    size_t bytes = (size_t)t->vertex_count * 12;
    RTCBuffer buffer = rtcNewBuffer( tracer->device, bytes + 16 );
    char* memory = buffer != NULL ? rtcGetBufferData( buffer ) : NULL;
    if ( memory == NULL )
        return buffer; // the device's error handler knows
    if ( bytes > 0 )
        memcpy( memory, t->positions, bytes );
    memset( memory + bytes, 0, 16 );
    return buffer;
}

static RTCGeometry make_geometry( const RfTracer* tracer, RTCBuffer positions, uint32_t first, uint32_t count )
{
    const RfTriangles* t = &tracer->scene->triangles;
    RTCGeometry geometry = rtcNewGeometry( tracer->device, RTC_GEOMETRY_TYPE_TRIANGLE );
    rtcSetGeometryBuffer( geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, positions, 0, 12, t->vertex_count );
    if ( tracer->order == NULL )
    {
        rtcSetSharedGeometryBuffer( geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, t->indices, 0, 12, count );
        return geometry;
    }
    uint32_t* indices = rtcSetNewGeometryBuffer( geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, count );
    for ( uint32_t i = 0; indices != NULL && i < count; ++i )
        memcpy( indices + 3 * (size_t)i, t->indices + 3 * (size_t)tracer->order[first + i], 12 );
    return geometry;
}

static void attach( RfTracer* tracer, RTCBuffer positions, uint32_t first, uint32_t count, unsigned int id )
{
    if ( count == 0 )
        return;
    RTCGeometry geometry = make_geometry( tracer, positions, first, count );
    if ( id == MASKED )
    {
        rtcSetGeometryUserData( geometry, tracer );
        rtcSetGeometryIntersectFilterFunction( geometry, filter_masked );
        rtcSetGeometryOccludedFilterFunction( geometry, filter_masked );
    }
    rtcCommitGeometry( geometry );
    rtcAttachGeometryByID( tracer->embree_scene, geometry, id );
    rtcReleaseGeometry( geometry );
}

// Build quality MEDIUM with ROBUST is deterministic over threads; HIGH is not.
static RfResult build_bvh( RfTracer* tracer, RfError* error )
{
    RfResult result = sort_masked( tracer, error );
    if ( result != RF_OK )
        return result;
    uint32_t count = tracer->scene->triangles.count;
    tracer->embree_scene = rtcNewScene( tracer->device );
    rtcSetSceneBuildQuality( tracer->embree_scene, RTC_BUILD_QUALITY_MEDIUM );
    rtcSetSceneFlags( tracer->embree_scene, RTC_SCENE_FLAG_ROBUST );
    RTCBuffer positions = copy_positions( tracer );
    attach( tracer, positions, 0, tracer->masked_first, OPAQUE );
    attach( tracer, positions, tracer->masked_first, count - tracer->masked_first, MASKED );
    if ( positions != NULL )
        rtcReleaseBuffer( positions );
    rtcCommitScene( tracer->embree_scene );
    if ( tracer->message[0] != 0 )
        return rf_fail( error, RF_ERROR_DEVICE, "%s: building the BVH failed: %s",
                        tracer->scene->path != NULL ? tracer->scene->path : "scene", tracer->message );
    return RF_OK;
}

static RfVec3 load_vec3( const float* values, uint32_t index )
{
    return rf_vec3( values[3 * (size_t)index], values[3 * (size_t)index + 1], values[3 * (size_t)index + 2] );
}

// In doubles: needles and tiny triangles keep their normal.
static RfVec3 unit_cross( RfVec3 a, RfVec3 b )
{
    double x = (double)a.y * (double)b.z - (double)a.z * (double)b.y;
    double y = (double)a.z * (double)b.x - (double)a.x * (double)b.z;
    double z = (double)a.x * (double)b.y - (double)a.y * (double)b.x;
    double length = sqrt( x * x + y * y + z * z );
    double scale = length > 0.0 ? 1.0 / length : 0.0;
    return rf_vec3( (float)( x * scale ), (float)( y * scale ), (float)( z * scale ) );
}

static RfTriangleRecord make_record( const RfTriangles* t, uint32_t i, uint32_t light )
{
    const uint32_t* v = t->indices + 3 * (size_t)i;
    RfTriangleRecord r = { .material = t->material[i], .light = light };
    r.p0 = load_vec3( t->positions, v[0] );
    r.e1 = rf_sub( load_vec3( t->positions, v[1] ), r.p0 );
    r.e2 = rf_sub( load_vec3( t->positions, v[2] ), r.p0 );
    r.n0 = load_vec3( t->normals, v[0] );
    r.d1 = rf_sub( load_vec3( t->normals, v[1] ), r.n0 );
    r.d2 = rf_sub( load_vec3( t->normals, v[2] ), r.n0 );
    r.ng = unit_cross( r.e1, r.e2 );
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
        tracer->triangles[i] = make_record( t, i, tracer->lights.of_triangle != NULL ? tracer->lights.of_triangle[i] : RF_NO_LIGHT );
    return RF_OK;
}

static void describe_device( RfTracer* tracer )
{
    long version = (long)rtcGetDeviceProperty( tracer->device, RTC_DEVICE_PROPERTY_VERSION );
    const char* isa = __builtin_cpu_supports( "avx512f" ) && __builtin_cpu_supports( "avx512dq" ) &&
                              __builtin_cpu_supports( "avx512vl" ) && __builtin_cpu_supports( "avx512bw" )
                          ? "avx512"
                          : ( __builtin_cpu_supports( "avx2" ) ? "avx2" : "sse" );
    snprintf( tracer->text, sizeof tracer->text, "embree %ld.%ld.%ld %s", version / 10000, version / 100 % 100,
              version % 100, isa );
}

RfResult rf_create_tracer( const RfScene* scene, RfTracer** out, RfError* error )
{
    *out = NULL;
    RfTracer* tracer = calloc( 1, sizeof *tracer );
    if ( tracer == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for the ray tracer" );
    tracer->scene = scene;
    tracer->device = rtcNewDevice( "frequency_level=simd512" );
    if ( tracer->device == NULL )
    {
        free( tracer );
        return rf_fail( error, RF_ERROR_DEVICE, "Embree gave no device (error %d)", (int)rtcGetDeviceError( NULL ) );
    }
    rtcSetDeviceErrorFunction( tracer->device, on_device_error, tracer );
    rtcSetDeviceMemoryMonitorFunction( tracer->device, on_memory, tracer );
    describe_device( tracer );
    RfResult result = rf_collect_lights( scene, &tracer->lights, error );
    if ( result == RF_OK )
        result = build_bvh( tracer, error );
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
    if ( tracer->embree_scene != NULL )
        rtcReleaseScene( tracer->embree_scene );
    rtcReleaseDevice( tracer->device );
    rf_destroy_lights( &tracer->lights );
    free( tracer->triangles );
    free( tracer->order );
    free( tracer );
}

const RfScene* rf_tracer_scene( const RfTracer* tracer ) { return tracer->scene; }
const RfLights* rf_tracer_lights( const RfTracer* tracer ) { return &tracer->lights; }
const RfTriangleRecord* rf_tracer_triangles( const RfTracer* tracer ) { return tracer->triangles; }
const char* rf_tracer_device( const RfTracer* tracer ) { return tracer->text; }
size_t rf_tracer_bytes( const RfTracer* tracer )
{
    return (size_t)tracer->bytes + (size_t)tracer->scene->triangles.count * sizeof( RfTriangleRecord );
}

// The lanes of a packet beyond `count` get no ray: their valid mask is 0.
static int set_valid( int* valid, int first, int count )
{
    int lanes = count - first < PACKET ? count - first : PACKET;
    for ( int i = 0; i < PACKET; ++i )
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
    for ( int i = 0; i < PACKET; ++i )
    {
        ray->tnear[i] = 0.0f;
        ray->tfar[i] = far;
        ray->time[i] = 0.0f;
        ray->mask[i] = 0xffffffffu;
        ray->id[i] = 0;
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

// From numbers within a geometry to the scene's.
static void restore_order( const RfTracer* tracer, int lanes, const unsigned int* geometry, uint32_t* triangle )
{
    for ( int i = 0; i < lanes; ++i )
    {
        if ( triangle[i] != RF_MISS )
            triangle[i] = tracer->order[triangle[i] + ( geometry[i] == MASKED ? tracer->masked_first : 0 )];
    }
}

void rf_trace_nearest( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3],
                       bool coherent, uint32_t* triangle, float* u, float* v )
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext( &context );
    context.flags = coherent ? RTC_INTERSECT_CONTEXT_FLAG_COHERENT : RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    _Alignas( 64 ) int valid[PACKET];
    struct RTCRayHit16 packet;
    memset( &packet, 0, sizeof packet );
    for ( int first = 0; first < count; first += PACKET )
    {
        int lanes = set_valid( valid, first, count );
        set_origins( &packet.ray, lanes, o, first );
        set_ray( &packet.ray, lanes, d, first, INFINITY );
        for ( int i = 0; i < PACKET; ++i )
            packet.hit.geomID[i] = packet.hit.primID[i] = RTC_INVALID_GEOMETRY_ID;
        rtcIntersect16( valid, tracer->embree_scene, &context, &packet );
        for ( int i = 0; i < lanes; ++i )
        {
            triangle[first + i] = packet.hit.primID[i];
            u[first + i] = packet.hit.u[i];
            v[first + i] = packet.hit.v[i];
        }
        if ( tracer->order != NULL )
            restore_order( tracer, lanes, packet.hit.geomID, triangle + first );
    }
}

static void occluded_packet( const RfTracer* tracer, struct RTCIntersectContext* context, const int* valid,
                             struct RTCRay16* ray, int lanes, uint8_t* visible )
{
    rtcOccluded16( valid, tracer->embree_scene, context, ray );
    for ( int i = 0; i < lanes; ++i )
        visible[i] = ray->tfar[i] >= 0.0f; // −inf where something is in the way
}

void rf_trace_segments( const RfTracer* tracer, int count, const float* const o[3], const float* const d[3],
                        uint8_t* visible )
{
    struct RTCIntersectContext context;
    rtcInitIntersectContext( &context );
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    _Alignas( 64 ) int valid[PACKET];
    struct RTCRay16 ray;
    memset( &ray, 0, sizeof ray );
    for ( int first = 0; first < count; first += PACKET )
    {
        int lanes = set_valid( valid, first, count );
        set_origins( &ray, lanes, o, first );
        set_ray( &ray, lanes, d, first, 1.0f );
        occluded_packet( tracer, &context, valid, &ray, lanes, visible + first );
    }
}

// Fills a packet's segments; returns how many lanes are to be tested.
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
    // coherent as they are, Embree's traversal for incoherent packets is the faster one here
    struct RTCIntersectContext context;
    rtcInitIntersectContext( &context );
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT;
    _Alignas( 64 ) int valid[PACKET];
    struct RTCRay16 ray;
    memset( &ray, 0, sizeof ray );
    for ( int i = 0; i < PACKET; ++i )
    {
        ray.org_x[i] = origin.x;
        ray.org_y[i] = origin.y;
        ray.org_z[i] = origin.z;
        ray.mask[i] = 0xffffffffu;
    }
    int sum = 0;
    for ( int first = 0; first < count; first += PACKET )
    {
        int lanes = set_valid( valid, first, count );
        int tested = set_segments( &ray, valid, origin, lanes, point, first, weight );
        if ( tested == 0 )
            continue;
        for ( int i = 0; i < PACKET; ++i )
            ray.tfar[i] = 1.0f;
        rtcOccluded16( valid, tracer->embree_scene, &context, &ray );
        for ( int i = 0; i < lanes; ++i )
            weight[first + i] = ray.tfar[i] < 0.0f ? 0.0f : weight[first + i]; // −inf where blocked
        sum += tested;
    }
    return sum;
}
