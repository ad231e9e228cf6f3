// Tracers for moments of a scene that moves, and what moves in a group of frames.
#include "base/fault.h"
#include "base/layout.h"
#include "scene/moments.h"
#include "trace/tracer.h"

#include <stdlib.h>
#include <string.h>

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

RfResult rf_create_ghosts( int count, const RfTracer* const* posed, RfGhosts** out, RfError* error )
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
        rf_add_ghosts( &posed[i]->bvh, posed[i]->scene, scene );
        ( *out )->reach = rf_maxf( ( *out )->reach, posed[i]->own_reach );
        rf_add_moving_boxes( posed[i]->scene, 1.0f, &( *out )->boxes );
    }
    rf_finish_boxes( &( *out )->boxes );
    if ( rf_tracer_error( posed[0] )[0] == 0 )
        rf_commit_scene( scene );
    ( *out )->embree_scene = scene;
    if ( rf_tracer_error( posed[0] )[0] == 0 )
        return RF_OK;
    rf_destroy_ghosts( *out );
    *out = NULL;
    return fail_build( posed[0]->still, posed[0]->scene, error );
}

void rf_destroy_ghosts( RfGhosts* ghosts )
{
    if ( ghosts == NULL )
        return;
    rtcReleaseScene( ghosts->embree_scene );
    free( ghosts );
}

void rf_set_ghosts( RfTracer* posed, const RfGhosts* ghosts )
{
    if ( posed->ghosts == ghosts )
        return;
    posed->ghosts = ghosts;
    posed->lights.reach = ghosts != NULL ? ghosts->reach : posed->own_reach;
}

bool rf_tracer_has_ghosts( const RfTracer* tracer ) { return tracer->ghosts != NULL; }
