// Traces arrays of rays in packets of 16 with Embree, and holds the triangle records that hits refer to.
#include "base/fault.h"
#include "trace/tracer.h"

#include "base/float_traps.h"
#include "base/system.h"
#include "light/light.h"
#include "scene/leave_out.h"
#include "trace/bvh.h"

#include <pmmintrin.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <xmmintrin.h>

void rf_set_float_mode( void )
{
    _MM_SET_FLUSH_ZERO_MODE( _MM_FLUSH_ZERO_ON );
    _MM_SET_DENORMALS_ZERO_MODE( _MM_DENORMALS_ZERO_ON );
    if ( !RF_FAULT( rounding ) )
        _MM_SET_ROUNDING_MODE( _MM_ROUND_NEAREST ); // math/fastmath.h rounds by additions
    rf_enable_float_traps();
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
    if ( result == RF_OK )
        tracer->mirror_scene = rf_build_mirror_scene( tracer->device, tracer->scene, tracer->bvh.scale, &tracer->mirrors );
    if ( result == RF_OK && tracer->message[0] != 0 )
        return rf_fail( error, RF_ERROR_DEVICE, "%s: building the BVH failed: %s",
                        tracer->scene->path != NULL ? tracer->scene->path : "scene", tracer->message );
    return result;
}

static RfTriangleRecord make_record( const RfTriangles* t, uint32_t i, uint32_t light, float far_error )
{
    const uint32_t* v = t->indices + 3 * (size_t)i;
    RfTriangleRecord r = { .material = t->material[i], .light = light, .mirror = RF_NO_MIRROR };
    r.p0 = rf_load_vec3( t->positions, v[0] );
    r.e1 = rf_sub( rf_load_vec3( t->positions, v[1] ), r.p0 );
    r.e2 = rf_sub( rf_load_vec3( t->positions, v[2] ), r.p0 );
    r.n0 = rf_load_vec3( t->normals, v[0] );
    r.d1 = rf_sub( rf_load_vec3( t->normals, v[1] ), r.n0 );
    r.d2 = rf_sub( rf_load_vec3( t->normals, v[2] ), r.n0 );
    double twice;
    r.ng = rf_unit_cross( r.e1, r.e2, &twice );
    r.ng = RF_FAULT( unit_cross ) ? rf_normalize( rf_cross( r.e1, r.e2 ) ) : r.ng;
    float largest =
        rf_maxf( rf_largest_coordinate( r.p0 ), rf_maxf( rf_largest_coordinate( rf_load_vec3( t->positions, v[1] ) ),
                                                         rf_largest_coordinate( rf_load_vec3( t->positions, v[2] ) ) ) );
    r.offset = RF_FAULT( fixed_offset ) ? 1e-5f : rf_ray_offset( largest );
    r.offset *= RF_FAULT( ray_offset ) ? 1e-3f : 1.0f;
    r.far = rf_is_far_triangle( t, i, far_error );
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
        tracer->triangles[i] = make_record(
            t, i, tracer->lights.of_triangle != NULL ? tracer->lights.of_triangle[i] : RF_NO_LIGHT, tracer->bvh.far_error );
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
    return rf_create_tracer_by( 0, scene, out, error );
}

RfResult rf_create_tracer_by( int threads, const RfScene* scene, RfTracer** out, RfError* error )
{
    char configuration[64];
    snprintf( configuration, sizeof configuration, "frequency_level=simd512,threads=%d",
              threads > 0 ? threads : rf_core_count() );
    *out = NULL;
    RfTracer* tracer = calloc( 1, sizeof *tracer );
    if ( tracer == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for the ray tracer" );
    tracer->scene = scene;
    for ( uint32_t i = 0; i < scene->material_count; ++i )
        tracer->textured = tracer->textured || scene->materials[i].textured != NULL;
    tracer->textured = tracer->textured || rf_is_forced( scene, RF_EFFECT_TEXTURES );
    tracer->device = rtcNewDevice( configuration );
    if ( tracer->device == NULL )
    {
        free( tracer );
        return rf_fail( error, RF_ERROR_DEVICE, "Embree could not create a device (error %d)", (int)rtcGetDeviceError( NULL ) );
    }
    rtcSetDeviceErrorFunction( tracer->device, on_device_error, tracer );
    rtcSetDeviceMemoryMonitorFunction( tracer->device, on_memory, tracer );
    describe_device( tracer );
    RfResult result = rf_collect_lights( scene, &tracer->lights, error );
    if ( result == RF_OK && rf_runs( scene, true, RF_EFFECT_FLAT_MIRRORS ) )
        result = rf_find_mirrors( scene, &tracer->mirrors, error );
    if ( result == RF_OK )
        result = rf_bound_chains( scene, &tracer->chain_bounds, error );
    if ( result == RF_OK )
        result = build_bvh( tracer, error );
    if ( result == RF_OK )
        result = fill_records( tracer, error );
    tracer->bvh.triangles = tracer->triangles;
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
RfTracerRuns rf_tracer_runs( const RfTracer* tracer )
{
    return ( RfTracerRuns ){ tracer->bvh.blended, tracer->bvh.panes, tracer->textured, tracer->bvh.any_blended,
                             tracer->bvh.partial };
}
const RfMirrors* rf_tracer_mirrors( const RfTracer* tracer ) { return &tracer->mirrors; }
const RfChainBounds* rf_tracer_chain_bounds( const RfTracer* tracer ) { return &tracer->chain_bounds; }
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
