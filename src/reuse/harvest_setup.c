// What a group asks of the harvest: the shape of its batches, and their workspace.
#include "reuse/harvest_internal.h"

// Tiles share all light but that of light samples at first hits, which are cheap beside the rest of a path: with tiles there
// are as many at least (src/reuse/measurements.md, "The second light sample").
#define DIRECT_SAMPLES 2

static int direct_samples( const RfEstimatorGroup* group, int tile_pixels, bool connections )
{
    int least = tile_pixels == 1 || connections || group->even_light_samples ? 1 : DIRECT_SAMPLES;
    return group->settings->light_samples > least ? group->settings->light_samples : least;
}

// Chain samples of a hit behind a chain (path/chain_samples.h): in the still life 8 bring no more than they cost.
#define CHAIN_SAMPLES 4

RfBatchShape rf_batch_shape( const RfEstimatorGroup* group )
{
    const RfRenderSettings* settings = group->settings;
    bool specular = ( group->traits.kinds & ~0u << RF_BSDF_FIRST_SPECULAR ) != 0;
    int tile_pixels = rf_tile_pixels( &settings->tile );
    bool chains = rf_wants_chains( &group->traits, settings, tile_pixels );
    bool connections = rf_wants_light_paths( &group->traits, settings );
    bool samples = chains && group->traits.chain_triangles > 0 && !connections && !group->even_light_samples; // not in gradients
    return ( RfBatchShape ){
        .eyes = group->eye_count,
        .light_samples = direct_samples( group, tile_pixels, connections ),
        .tile_pixels = tile_pixels,
        .params = rf_glossy_params( group->traits.kinds ),
        .eq15 = settings->weights == RF_WEIGHTS_EQ15,
        .blurred = rf_is_blurred( &group->traits ),
        .blended = group->traits.blended,
        .panes = group->traits.panes,
        .own_frame_light = specular || chains || group->traits.sky,
        .filtered = !rf_is_plain_filter( settings ),
        .chains = chains,
        .chain_samples = rf_calls_for( samples, RF_EFFECT_CHAINS ) ? CHAIN_SAMPLES : 0,
        .connections = connections,
    };
}

RfHarvest rf_make_harvest( const RfEstimatorGroup* group )
{
    const RfRenderSettings* settings = group->settings;
    return ( RfHarvest ){
        .path = { group->tracer, group->max_depth, settings->light_samples, settings->light_sampling, NULL },
        .shape = rf_batch_shape( group ),
        .patches = rf_lay_out_patches( &settings->tile, group->traits.scattered, group->width, group->height ),
        .tile_roulette = settings->tile_roulette,
        .weights = settings->weights,
        .alpha = rf_calls_for( ( settings->aovs & RF_AOV_BIT( RF_AOV_ALPHA ) ) != 0, RF_EFFECT_ALPHA ),
        .seed = settings->seed,
        .drawn_by = group->need != NULL ? group->filter : NULL,
        .eyes = group->eyes,
        .first_frame = group->first_frame,
        .group = group->number,
        .pieces = settings->pieces,
        .need = group->need,
        .round = group->round,
        .packed = group->packed,
        .first_hits_only = group->first_hits_only,
        .light_paths = rf_drawn_light_paths( group->shared ),
        .kernel_normalization = settings->kernel_normalization,
    };
}

static size_t scratch_struct_bytes( void ) { return ( sizeof( RfHarvestScratch ) + 63 ) / 64 * 64; }

static size_t eyes_bytes( const RfBatchShape* shape )
{
    return rf_is_blurred_shape( shape ) ? ( (size_t)shape->eyes * sizeof( RfEye ) + 63 ) / 64 * 64 : 0;
}

size_t rf_harvest_scratch_bytes( const RfBatchShape* shape )
{
    size_t lanes = RF_LANES * sizeof( float );
    return scratch_struct_bytes() + eyes_bytes( shape ) + (size_t)shape->light_samples * sizeof( RfLightLanes ) +
           (size_t)shape->eyes * lanes + (size_t)rf_direction_count( shape ) * lanes +
           rf_tile_reuse_bytes( shape->light_samples + shape->connections, shape->tile_pixels, shape->panes ) +
           ( shape->chains ? sizeof( RfChains ) + 64 : 0 ) + ( shape->connections ? sizeof( RfConnectionLanes ) + 64 : 0 ) +
           ( shape->chain_samples > 0 ? sizeof( RfChainSamples ) + sizeof( RfChainLight ) + 64 : 0 ) +
           ( shape->filtered ? 2 * lanes : 0 );
}

RfHarvestScratch* rf_lay_out_harvest_scratch( const RfBatchShape* shape, void* memory )
{
    RfHarvestScratch* scratch = memory;
    scratch->eyes = (RfEye*)(void*)( (char*)memory + scratch_struct_bytes() );
    scratch->direct = (RfLightLanes*)( (char*)memory + scratch_struct_bytes() + eyes_bytes( shape ) );
    scratch->density = (float*)( scratch->direct + shape->light_samples );
    scratch->mixture = scratch->density + (size_t)shape->eyes * RF_LANES;
    char* rest = (char*)( scratch->mixture + (size_t)rf_direction_count( shape ) * RF_LANES );
    scratch->tiles = rf_lay_out_tile_reuse( shape->light_samples + shape->connections, shape->tile_pixels, shape->panes, rest );
    rest += rf_tile_reuse_bytes( shape->light_samples + shape->connections, shape->tile_pixels, shape->panes );
    scratch->chains = shape->chains ? (RfChains*)(void*)( rest + ( 64 - (uintptr_t)rest % 64 ) % 64 ) : NULL;
    rest = shape->chains ? (char*)( scratch->chains + 1 ) : rest;
    scratch->connections = shape->connections ? (RfConnectionLanes*)(void*)( rest + ( 64 - (uintptr_t)rest % 64 ) % 64 ) : NULL;
    rest = shape->connections ? (char*)( scratch->connections + 1 ) : rest;
    bool samples = shape->chain_samples > 0;
    scratch->chain_samples = samples ? (RfChainSamples*)(void*)( rest + ( 64 - (uintptr_t)rest % 64 ) % 64 ) : NULL;
    scratch->chain_light = samples ? (RfChainLight*)(void*)( scratch->chain_samples + 1 ) : NULL;
    rest = samples ? (char*)( scratch->chain_light + 1 ) : rest;
    for ( int c = 0; c < 2; ++c )
        scratch->place[c] = shape->filtered ? (float*)(void*)rest + c * RF_LANES : NULL;
    return scratch;
}
