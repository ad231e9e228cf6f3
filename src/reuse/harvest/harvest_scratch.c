// The layout of the workspace in which a batch is traced.
#include "reuse/harvest/harvest_steps.h"

static size_t scratch_struct_bytes( void ) { return ( sizeof( RfHarvestScratch ) + 63 ) / 64 * 64; }

static size_t eyes_bytes( const RfBatchShape* shape )
{
    return rf_is_blurred_shape( shape ) ? ( (size_t)shape->eyes * sizeof( RfEye ) + 63 ) / 64 * 64 : 0;
}

static size_t tracer_list_bytes( const RfBatchShape* shape )
{
    return ( (size_t)shape->eyes * sizeof( const RfTracer* ) + 63 ) / 64 * 64;
}

static size_t tracers_bytes( const RfBatchShape* shape )
{
    return shape->moments ? tracer_list_bytes( shape ) + (size_t)shape->eyes * rf_tracer_at_bytes( shape->moving_lights ) : 0;
}

static size_t tile_bytes( const RfBatchShape* shape )
{
    return rf_tile_reuse_bytes( rf_light_directions( shape ) + shape->connections, shape->tile_pixels, shape->panes,
                                shape->own_light, shape->dimmed, shape->groups );
}

// What light groups need for the base parts from 1 on, and the base parts of light by chains.
static size_t group_bytes( const RfBatchShape* shape )
{
    if ( shape->groups < 2 )
        return 0;
    size_t lanes = sizeof( RfChainGroup ) + sizeof( RfOwnGroup ) + sizeof( RfArrivals ) + 3 * RF_LANES * sizeof( float );
    return (size_t)( shape->groups - 1 ) * lanes + 2 * RF_LANES + 64;
}

static void lay_out_groups( const RfBatchShape* shape, char* memory, RfHarvestScratch* scratch )
{
    int count = shape->groups - 1;
    RfChainGroup* chains = (RfChainGroup*)(void*)( memory + ( 64 - (uintptr_t)memory % 64 ) % 64 );
    RfOwnGroup* own = (RfOwnGroup*)(void*)( chains + count );
    RfArrivals* own_arrivals = (RfArrivals*)(void*)( own + count );
    float( *samples )[3][RF_LANES] = (void*)( own_arrivals + count );
    uint8_t* part = (uint8_t*)( samples + count );
    if ( scratch->chains != NULL )
        scratch->chains->groups = chains;
    if ( scratch->own != NULL )
    {
        scratch->own->groups = own;
        scratch->own->paths.of_groups = own_arrivals;
    }
    if ( scratch->chain_samples != NULL )
    {
        scratch->chain_samples->of_groups = samples;
        scratch->chain_samples->part = part;
        scratch->chain_light->part = part + RF_LANES;
    }
    if ( scratch->tiles != NULL )
        scratch->tiles->slots.chain_light.part = part + RF_LANES;
}

static size_t pass_bytes( const RfBatchShape* shape )
{
    if ( !shape->passes )
        return 0;
    return ( shape->chains ? sizeof( RfChainPasses ) : 0 ) + ( shape->own_light ? sizeof( RfOwnPasses ) : 0 ) + 64;
}

static void lay_out_passes( const RfBatchShape* shape, char* memory, RfHarvestScratch* scratch )
{
    RfOwnPasses* own = (RfOwnPasses*)(void*)( memory + ( 64 - (uintptr_t)memory % 64 ) % 64 );
    scratch->own_passes = shape->passes && shape->own_light ? own : NULL;
    RfChainPasses* events = (RfChainPasses*)(void*)( own + ( scratch->own_passes != NULL ) );
    if ( scratch->chains != NULL )
        scratch->chains->by_event = shape->passes ? events : NULL;
}

size_t rf_harvest_scratch_bytes( const RfBatchShape* shape )
{
    size_t lanes = RF_LANES * sizeof( float );
    return scratch_struct_bytes() + eyes_bytes( shape ) + tracers_bytes( shape ) +
           (size_t)rf_light_directions( shape ) * sizeof( RfLightLanes ) + (size_t)shape->eyes * lanes +
           (size_t)rf_direction_count( shape ) * lanes + tile_bytes( shape ) + ( shape->chains ? sizeof( RfChains ) + 64 : 0 ) +
           ( shape->connections ? sizeof( RfConnectionLanes ) + 64 : 0 ) +
           ( shape->chain_samples > 0 ? sizeof( RfChainSamples ) + sizeof( RfChainLight ) + 64 : 0 ) +
           ( shape->own_light ? sizeof( RfOwnHits ) + 64 : 0 ) +
           ( shape->dimmed > 0 ? (size_t)shape->dimmed * sizeof( RfArrivals ) + 64 : 0 ) +
           ( shape->clamped ? sizeof( RfClampHits ) + 64 : 0 ) + ( shape->surfaces ? sizeof( RfSurfaceLanes ) + 64 : 0 ) +
           ( shape->features ? sizeof( RfFeatures ) + 64 : 0 ) + ( shape->filtered ? 2 * lanes : 0 ) +
           ( rf_has_covering( shape ) && shape->chains ? 2 * lanes : 0 ) + group_bytes( shape ) + pass_bytes( shape );
}

RfHarvestScratch* rf_lay_out_harvest_scratch( const RfBatchShape* shape, void* memory )
{
    RfHarvestScratch* scratch = memory;
    scratch->occluders = ( RfOccluders ){ .of = NULL };
    scratch->eyes = (RfEye*)(void*)( (char*)memory + scratch_struct_bytes() );
    char* tracers = (char*)memory + scratch_struct_bytes() + eyes_bytes( shape );
    scratch->tracers = shape->moments ? (const RfTracer**)(void*)tracers : NULL;
    scratch->at_moment = shape->moments ? tracers + tracer_list_bytes( shape ) : NULL;
    scratch->direct = (RfLightLanes*)( tracers + tracers_bytes( shape ) );
    scratch->density = (float*)( scratch->direct + rf_light_directions( shape ) );
    scratch->mixture = scratch->density + (size_t)shape->eyes * RF_LANES;
    char* rest = (char*)( scratch->mixture + (size_t)rf_direction_count( shape ) * RF_LANES );
    scratch->tiles = rf_lay_out_tile_reuse( rf_light_directions( shape ) + shape->connections, shape->tile_pixels, shape->panes,
                                            shape->own_light, shape->dimmed, shape->groups, rest );
    rest += tile_bytes( shape );
    scratch->chains = shape->chains ? (RfChains*)(void*)( rest + ( 64 - (uintptr_t)rest % 64 ) % 64 ) : NULL;
    rest = shape->chains ? (char*)( scratch->chains + 1 ) : rest;
    scratch->connections = shape->connections ? (RfConnectionLanes*)(void*)( rest + ( 64 - (uintptr_t)rest % 64 ) % 64 ) : NULL;
    rest = shape->connections ? (char*)( scratch->connections + 1 ) : rest;
    bool samples = shape->chain_samples > 0;
    scratch->chain_samples = samples ? (RfChainSamples*)(void*)( rest + ( 64 - (uintptr_t)rest % 64 ) % 64 ) : NULL;
    scratch->chain_light = samples ? (RfChainLight*)(void*)( scratch->chain_samples + 1 ) : NULL;
    rest = samples ? (char*)( scratch->chain_light + 1 ) : rest;
    scratch->own = shape->own_light ? (RfOwnHits*)(void*)( rest + ( 64 - (uintptr_t)rest % 64 ) % 64 ) : NULL;
    rest = shape->own_light ? (char*)( scratch->own + 1 ) : rest;
    scratch->dimmed = shape->dimmed > 0 ? (RfArrivals*)(void*)( rest + ( 64 - (uintptr_t)rest % 64 ) % 64 ) : NULL;
    rest = shape->dimmed > 0 ? (char*)( scratch->dimmed + shape->dimmed ) : rest;
    scratch->part = 0;
    scratch->clamp = shape->clamped ? (RfClampHits*)(void*)( rest + ( 64 - (uintptr_t)rest % 64 ) % 64 ) : NULL;
    rest = shape->clamped ? (char*)( scratch->clamp + 1 ) : rest;
    scratch->surfaces = shape->surfaces ? (RfSurfaceLanes*)(void*)( rest + ( 64 - (uintptr_t)rest % 64 ) % 64 ) : NULL;
    rest = shape->surfaces ? (char*)( scratch->surfaces + 1 ) : rest;
    scratch->features = shape->features ? (RfFeatures*)(void*)( rest + ( 64 - (uintptr_t)rest % 64 ) % 64 ) : NULL;
    rest = shape->features ? (char*)( scratch->features + 1 ) : rest;
    for ( int c = 0; c < 2; ++c )
        scratch->place[c] = shape->filtered ? (float*)(void*)rest + c * RF_LANES : NULL;
    rest += shape->filtered ? 2 * RF_LANES * sizeof( float ) : 0;
    bool covering = rf_has_covering( shape ) && shape->chains;
    scratch->first_seen = covering ? (uint32_t*)(void*)rest : NULL;
    if ( shape->chains )
        scratch->chains->triangle = covering ? scratch->first_seen + RF_LANES : NULL;
    rest += covering ? 2 * RF_LANES * sizeof( float ) : 0;
    if ( shape->groups > 1 )
        lay_out_groups( shape, rest, scratch );
    lay_out_passes( shape, rest + group_bytes( shape ), scratch );
    return scratch;
}
