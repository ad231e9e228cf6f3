// Creates tracers: Embree's device and scenes, the lights, the mirrors and the triangle records that hits refer to.
#include "trace/trace.h"

#include "base/fault.h"
#include "base/float_mode.h"
#include "base/float_traps.h"
#include "base/layout.h"
#include "base/remedy.h"
#include "base/system.h"
#include "scene/leave_out.h"
#include "scene/moments.h"
#include "trace/bvh.h"
#include "trace/tracer.h"

#include <fenv.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void rf_set_float_mode( void )
{
    rf_flush_subnormals( true );
    if ( !RF_FAULT( rounding ) )
        fesetround( FE_TONEAREST ); // math/fastmath.h rounds by additions
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

// The kernels that Embree takes.
static const char* find_isa( void )
{
#ifdef __aarch64__
    return "neon";
#else
    return __builtin_cpu_supports( "avx512f" ) && __builtin_cpu_supports( "avx512dq" ) && __builtin_cpu_supports( "avx512vl" ) &&
                   __builtin_cpu_supports( "avx512bw" )
               ? "avx512"
               : ( __builtin_cpu_supports( "avx2" ) ? "avx2" : "sse" );
#endif
}

static void describe_device( RfTracer* tracer )
{
    long version = (long)rtcGetDeviceProperty( tracer->device, RTC_DEVICE_PROPERTY_VERSION );
    snprintf( tracer->text, sizeof tracer->text, "embree %ld.%ld.%ld %s", version / 10000, version / 100 % 100, version % 100,
              find_isa() );
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

// Tracers for moments of a scene that moves, and what moves in a group of frames.

#define ROUNDING 1e-5f

// How far what moves reaches from the middle of the ball that lights have around the scene. Loaders measure it at some times
// alone; rays to the sky have to pass all that is there.
static float find_reach( const RfScene* posed, const RfLights* lights )
{
    float reach = lights->radius;
    int moving = posed->placement_count - posed->still_placement_count;
    for ( int n = 0; n < moving * rf_moment_count( posed ); ++n )
    {
        const RfPlacement* p = rf_placements_at( posed, n / moving ) + posed->still_placement_count + n % moving;
        const RfMesh* mesh = rf_meshes_at( posed, n / moving ) + p->mesh;
        const RfVec3 *low = &mesh->bounds_min, *high = &mesh->bounds_max;
        for ( int k = 0; p->shown && k < 8 && !RF_FAULT( sky_reach ); ++k )
        {
            RfVec3 corner = rf_vec3( ( k & 1 ) != 0 ? low->x : high->x, ( k & 2 ) != 0 ? low->y : high->y,
                                     ( k & 4 ) != 0 ? low->z : high->z );
            float away = rf_length( rf_sub( rf_place_point( &p->matrix, corner ), lights->center ) );
            reach = rf_maxf( reach, ( 1.0f + ROUNDING ) * away );
        }
    }
    return reach;
}

// Lights that move are where hits find them, at the tracer's moment: with the same corners, and as far as rays start off them.
static void place_moving_lights( const RfTracer* posed, RfLight* light )
{
    const RfLights* lights = &posed->lights;
    for ( uint32_t i = lights->changing->still_triangles; i < lights->triangle_count; ++i )
    {
        RfTriangleRecord place;
        double twice;
        if ( !( light[i].area > 0.0f ) )
            continue;
        const RfTriangleRecord* t = rf_place_triangle_record( posed, light[i].triangle, &place );
        rf_unit_cross( t->e1, t->e2, &twice );
        light[i].p0 = t->p0;
        light[i].e1 = t->e1;
        light[i].e2 = t->e2;
        light[i].normal = t->ng;
        light[i].offset = t->offset;
        light[i].area = (float)( 0.5 * twice );
        light[i].pdf_area = light[i].area > 0.0f ? 1.0f / light[i].area : 1.0f;
        if ( light[i].area > 0.0f )
            continue;
        light[i].radiance = rf_vec3( 0, 0, 0 );
        light[i].textured = false;
    }
}

void rf_set_lights( RfTracer* posed, RfLights* lights )
{
    float reach = posed->lights.reach;
    posed->lights = lights != NULL ? *lights : posed->still->lights;
    posed->lights.reach = reach;
    if ( lights != NULL )
        place_moving_lights( posed, lights->light );
}

static RfResult fail_build( const RfTracer* still, const RfScene* posed, RfError* error )
{
    return rf_fail( error, RF_ERROR_DEVICE, "%s: building the BVH failed: %s", posed->path != NULL ? posed->path : "scene",
                    rf_tracer_error( still ) );
}

RfResult rf_create_posed_tracer( const RfTracer* still, const RfScene* posed, RfTracer** out, RfError* error )
{
    *out = NULL;
    RfTracer* tracer = malloc( sizeof *tracer );
    if ( tracer == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the ray tracer" );
    *tracer = *still;
    tracer->still = still;
    tracer->scene = posed;
    tracer->moment = posed->moments != NULL ? posed->moment : 0.0f;
    tracer->lights.reach = tracer->own_reach = find_reach( posed, &still->lights );
    tracer->chain_bounds = ( RfChainBounds ){ 0 };
    tracer->bvh = ( RfBvh ){ 0 };
    RfResult result = rf_bound_chains( posed, &tracer->chain_bounds, error );
    if ( result == RF_OK )
        result = rf_build_posed_bvh( still->device, &still->bvh, posed, &tracer->bvh, error );
    if ( rf_tracer_error( still )[0] != 0 )
        result = fail_build( still, posed, error );
    if ( result != RF_OK )
    {
        rf_destroy_posed_tracer( tracer );
        return result;
    }
    *out = tracer;
    return RF_OK;
}

typedef struct TracerAt
{
    RfTracer tracer;
    RfScene scene;
    RfLight* light;
} TracerAt;

static TracerAt* place_tracer_at( uint32_t lights, RfLayout* layout )
{
    TracerAt* at = rf_take( layout, 1, sizeof *at );
    RF_PLACE( layout, at->light, lights );
    return at;
}

size_t rf_tracer_at_bytes( uint32_t lights )
{
    RfLayout layout = { 0 };
    place_tracer_at( lights, &layout );
    return layout.bytes;
}

const RfTracer* rf_tracer_at( const RfTracer* posed, float moment, void* memory )
{
    if ( posed->scene->moments == NULL )
        return posed;
    const RfLights* still = &posed->lights;
    bool moves = still->changing != NULL && still->changing->still_triangles != still->triangle_count;
    TracerAt* at = place_tracer_at( moves ? still->triangle_count : 0, &( RfLayout ){ .memory = memory } );
    at->tracer = *posed;
    at->scene = *posed->scene;
    at->scene.moment = at->tracer.moment = moment;
    at->tracer.scene = &at->scene;
    if ( !moves )
        return &at->tracer;
    memcpy( at->light, still->light, still->triangle_count * sizeof *at->light );
    at->tracer.lights.light = at->light;
    place_moving_lights( &at->tracer, at->light );
    return &at->tracer;
}

void rf_destroy_posed_tracer( RfTracer* tracer )
{
    rf_destroy_posed_bvh( &tracer->bvh );
    free( tracer );
}

RfResult rf_create_swept( int count, const RfTracer* const* posed, RfSwept** out, RfError* error )
{
    *out = malloc( sizeof **out );
    if ( *out == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory posing %d frames", count );
    ( *out )->reach = 0.0f;
    RTCScene scene = rtcNewScene( posed[0]->device );
    rtcSetSceneFlags( scene, RTC_SCENE_FLAG_ROBUST );
    ( *out )->boxes = rf_no_boxes();
    for ( int i = 0; i < count; ++i )
    {
        rf_add_swept( &posed[i]->bvh, posed[i]->scene, scene );
        ( *out )->reach = rf_maxf( ( *out )->reach, posed[i]->own_reach );
        rf_add_moving_boxes( posed[i]->scene, 1.0f, &( *out )->boxes );
    }
    rf_finish_boxes( &( *out )->boxes );
    if ( rf_tracer_error( posed[0] )[0] == 0 )
        rf_commit_scene( scene );
    ( *out )->embree_scene = scene;
    if ( rf_tracer_error( posed[0] )[0] == 0 )
        return RF_OK;
    rf_destroy_swept( *out );
    *out = NULL;
    return fail_build( posed[0]->still, posed[0]->scene, error );
}

void rf_destroy_swept( RfSwept* swept )
{
    if ( swept == NULL )
        return;
    rtcReleaseScene( swept->embree_scene );
    free( swept );
}

void rf_set_swept( RfTracer* posed, const RfSwept* swept )
{
    if ( posed->swept == swept )
        return;
    posed->swept = swept;
    posed->lights.reach = swept != NULL ? swept->reach : posed->own_reach;
}

bool rf_tracer_has_swept( const RfTracer* tracer ) { return tracer->swept != NULL; }

// Puts lights out, and splits them by groups.

struct RfRelitTracer
{
    RfTracer tracer;
    RfScene scene;
    RfEnvironment environment;
    RfPunctual* punctual;
    RfLight* light;
};

static const RfVec3 s_black = { 0, 0, 0 };

static void put_out( RfRelitTracer* relit, uint32_t number )
{
    RfLights* lights = &relit->tracer.lights;
    if ( number < lights->triangle_count )
    {
        relit->light[number].radiance = s_black;
        relit->light[number].textured = false; // or it would be looked up
    }
    else if ( number - lights->triangle_count < (uint32_t)lights->punctual_count )
        relit->punctual[number - lights->triangle_count].intensity = s_black;
    else
        relit->environment.radiance = s_black;
}

RfResult rf_create_relit_tracer( const RfTracer* tracer, RfIsLit* is_lit, void* user, RfRelitTracer** out, RfError* error )
{
    const RfLights* of = &tracer->lights;
    size_t triangles = of->triangle_count, lamps = (size_t)of->punctual_count;
    RfRelitTracer* relit = *out = malloc( sizeof *relit );
    if ( relit != NULL )
        *relit = ( RfRelitTracer ){ .tracer = *tracer,
                                    .scene = *tracer->scene,
                                    .punctual = malloc( ( lamps + 1 ) * sizeof *relit->punctual ),
                                    .light = malloc( ( triangles + 1 ) * sizeof *relit->light ) };
    if ( relit == NULL || relit->punctual == NULL || relit->light == NULL )
    {
        rf_destroy_relit_tracer( relit );
        *out = NULL;
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for a copy of %u lights", of->count );
    }
    if ( lamps > 0 )
        memcpy( relit->punctual, of->punctual, lamps * sizeof *relit->punctual );
    if ( triangles > 0 )
        memcpy( relit->light, of->light, triangles * sizeof *relit->light );
    relit->tracer.scene = &relit->scene;
    relit->scene.movement = NULL;
    relit->tracer.lights.punctual = relit->punctual;
    relit->tracer.lights.light = relit->light;
    if ( of->sky.environment != NULL )
    {
        relit->environment = *of->sky.environment;
        relit->tracer.lights.sky.environment = &relit->environment;
    }
    for ( uint32_t i = 0; i < of->count; ++i )
    {
        if ( !is_lit( user, i ) )
            put_out( relit, i );
    }
    return RF_OK;
}

void rf_destroy_relit_tracer( RfRelitTracer* relit )
{
    if ( relit == NULL )
        return;
    free( relit->punctual );
    free( relit->light );
    free( relit );
}

const RfTracer* rf_relit_tracer( const RfRelitTracer* relit ) { return &relit->tracer; }

RfResult rf_create_split_tracer( const RfTracer* tracer, const RfLightGroups* groups, RfTracer** out, RfError* error )
{
    RfTracer* split = *out = malloc( sizeof *split );
    if ( split == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the groups of %u lights", tracer->lights.count );
    *split = *tracer;
    split->still = tracer;
    RfResult result = rf_split_lights( tracer->scene, groups, &split->lights, error );
    if ( result == RF_OK )
        return RF_OK;
    rf_destroy_split_tracer( split );
    *out = NULL;
    return result;
}

void rf_destroy_split_tracer( RfTracer* split )
{
    if ( split == NULL )
        return;
    rf_join_lights( &split->lights );
    free( split );
}
