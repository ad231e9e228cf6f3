// Creates tracers: Embree's device and scenes, the lights, the mirrors and the triangle records that hits refer to.
#include "base/fault.h"
#include "trace/tracer.h"

#include "base/float_traps.h"
#include "base/remedy.h"
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
        tracer->mirror_scene = rf_build_mirror_scene( tracer->device, tracer->scene, tracer->bvh.base.scale, &tracer->mirrors );
    if ( tracer->message[0] != 0 )
        return rf_fail( error, RF_ERROR_DEVICE, "%s: building the BVH failed: %s",
                        tracer->scene->path != NULL ? tracer->scene->path : "scene", tracer->message );
    return result;
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

// Those of the render, and as many of Embree's; both have this one.
static RfResult check_threads( int threads, RfError* error )
{
    int possible = ( rf_possible_threads( 2 * threads - 1 ) + 1 ) / 2;
    if ( possible >= threads )
        return RF_OK;
    rf_fail( error, RF_ERROR_MEMORY, "system limits allow %d of %d threads", possible, threads );
    return rf_advise( RF_ERROR_MEMORY, RF_REMEDY_THREADS, 0, error );
}

RfResult rf_create_tracer_by( int threads, const RfScene* scene, RfTracer** out, RfError* error )
{
    char configuration[64];
    threads = threads > 0 ? threads : rf_core_count();
    snprintf( configuration, sizeof configuration, "frequency_level=simd512,threads=%d", threads );
    *out = NULL;
    RfResult result = rf_check_rendered( scene, error );
    if ( result == RF_OK )
        result = check_threads( threads, error );
    if ( result != RF_OK )
        return result;
    RfTracer* tracer = calloc( 1, sizeof *tracer );
    if ( tracer == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the ray tracer" );
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
    result = rf_collect_lights( scene, &tracer->lights, error );
    if ( result == RF_OK && rf_runs( scene, true, RF_EFFECT_FLAT_MIRRORS ) )
        result = rf_find_mirrors( scene, &tracer->mirrors, error );
    if ( result == RF_OK )
        result = rf_bound_chains( scene, &tracer->chain_bounds, error );
    if ( result == RF_OK )
        result = build_bvh( tracer, error );
    if ( result == RF_OK )
        result = rf_fill_records( tracer, error );
    if ( result == RF_OK )
        tracer->occluders = rf_find_occluders( tracer );
    if ( result == RF_OK && tracer->occluders == NULL )
        result = rf_fail( error, RF_ERROR_MEMORY, "out of memory for the largest occluders" );
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
    if ( tracer->still != NULL )
    {
        rf_destroy_posed_tracer( tracer );
        return;
    }
    rf_destroy_bvh( &tracer->bvh );
    if ( tracer->mirror_scene != NULL )
        rtcReleaseScene( tracer->mirror_scene );
    rf_destroy_mirrors( &tracer->mirrors );
    rtcReleaseDevice( tracer->device );
    rf_destroy_lights( &tracer->lights );
    free( (void*)tracer->occluders );
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
const char* rf_tracer_device( const RfTracer* tracer ) { return tracer->text; }
size_t rf_tracer_bytes( const RfTracer* tracer )
{
    return (size_t)tracer->bytes + (size_t)tracer->scene->triangles.count * sizeof( RfTriangleRecord ) +
           (size_t)tracer->scene->placement_count * sizeof( RfPlacedBvh );
}
