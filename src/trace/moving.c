// Tracers for moments of a scene that moves, and what moves in a group of frames.
#include "trace/tracer.h"

#include <stdlib.h>

RfResult rf_create_posed_tracer( const RfTracer* still, const RfScene* posed, RfTracer** out, RfError* error )
{
    *out = NULL;
    RfTracer* tracer = malloc( sizeof *tracer );
    if ( tracer == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for the ray tracer" );
    *tracer = *still;
    tracer->still = still;
    tracer->scene = posed;
    tracer->chain_bounds = ( RfChainBounds ){ 0 };
    tracer->bvh = ( RfBvh ){ 0 };
    RfResult result = rf_bound_chains( posed, &tracer->chain_bounds, error );
    if ( result == RF_OK )
        result = rf_build_posed_bvh( still->device, &still->bvh, posed, &tracer->bvh, error );
    if ( result == RF_OK && still->message[0] != 0 )
        result = rf_fail( error, RF_ERROR_DEVICE, "%s: building the BVH failed: %s", posed->path != NULL ? posed->path : "scene",
                          still->message );
    if ( result != RF_OK )
    {
        rf_destroy_posed_tracer( tracer );
        return result;
    }
    *out = tracer;
    return RF_OK;
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
        return rf_fail( error, RF_ERROR_MEMORY, "no memory for what moves in %d frames", count );
    RTCScene scene = rtcNewScene( posed[0]->device );
    rtcSetSceneFlags( scene, RTC_SCENE_FLAG_ROBUST );
    for ( int i = 0; i < count; ++i )
        rf_add_ghosts( &posed[i]->bvh, posed[i]->scene, scene );
    rf_commit_scene( scene );
    ( *out )->embree_scene = scene;
    return RF_OK;
}

void rf_destroy_ghosts( RfGhosts* ghosts )
{
    if ( ghosts == NULL )
        return;
    rtcReleaseScene( ghosts->embree_scene );
    free( ghosts );
}

void rf_set_ghosts( RfTracer* posed, const RfGhosts* ghosts ) { posed->ghosts = ghosts; }

bool rf_tracer_has_ghosts( const RfTracer* tracer ) { return tracer->ghosts != NULL || tracer->scene->feigned != NULL; }
