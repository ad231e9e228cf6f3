// A group in the terms of the harvest: what its batches are made of, and what they share.
#include "reuse/harvest/harvest.h"

// Light samples per first hit with tiles, at least. Tiles share all other light, and these samples are cheap beside the rest of
// a path (scripts/bench/RESULTS.md).
#define DIRECT_SAMPLES 2
// Chain samples per hit behind a chain (path/chain_samples.h).
#define CHAIN_SAMPLES 4

static int direct_samples( const RfEstimatorGroup* group, int tile_pixels, bool connections )
{
    int least = tile_pixels == 1 || connections || group->even_light_samples ? 1 : DIRECT_SAMPLES;
    return group->settings->light_samples > least ? group->settings->light_samples : least;
}

RfBatchShape rf_batch_shape( const RfEstimatorGroup* group )
{
    const RfRenderSettings* settings = group->settings;
    bool specular = rf_has_specular( group->traits.kinds );
    int tile_pixels = rf_tile_pixels( &settings->tile );
    bool chains = rf_wants_chains( &group->traits, settings, tile_pixels );
    bool connections = rf_wants_light_paths( &group->traits, settings );
    bool exact = settings->weights == RF_WEIGHTS_EXACT && !group->even_light_samples; // not in gradients
    bool caustics = group->traits.without_caustics && exact;
    bool samples = chains && group->traits.chain_triangles > 0 && !connections && !group->even_light_samples && !caustics;
    // at the ends of a path, groups of more frames are shorter, and have the memory of those
    int groups = exact ? group->traits.light_groups : 0;
    int frames = !group->traits.lamps_alone || !exact ? 1 : group->eye_count < RF_FRAMES_MOST ? group->eye_count : RF_FRAMES_MOST;
    RfLayerSet layers = {
        .base_parts = groups > 1 ? groups : 1,
        .by_kind = ( settings->aovs & RF_PASS_AOVS ) != 0 && exact,
        .removed = settings->clamp != 0.0 || caustics,
    };
    layers.parts = layers.base_parts;
    if ( group->eye_count > 1 && exact )
    {
        int alone = group->traits.lamps_alone < layers.base_parts ? group->traits.lamps_alone : layers.base_parts;
        layers.parts += group->traits.dimmable + ( frames > 1 ? alone * frames : 0 );
    }
    layers.parts = layers.parts < RF_PARTS_MOST + 1 ? layers.parts : RF_PARTS_MOST + 1;
    return ( RfBatchShape ){
        .eyes = group->eye_count,
        .light_samples = direct_samples( group, tile_pixels, connections ),
        .tile_pixels = tile_pixels,
        .params = rf_glossy_params( group->traits.kinds ),
        .blurred = rf_is_blurred( &group->traits ),
        .moments = rf_calls_for( group->traits.moves && group->traits.blur_steps > 0, RF_EFFECT_MOTION_BLUR ),
        .moving_lights = group->traits.moving_lights ? group->traits.most_lights : 0,
        .blended = group->traits.blended,
        .panes = group->traits.panes,
        .own_frame_light = specular || chains || group->traits.sky,
        .filtered = !rf_is_plain_filter( settings ),
        .chains = chains,
        .own_light = ( group->traits.moves && group->eye_count > 1 && exact ) || caustics,
        .caustics = caustics,
        .surfaces = ( group->traits.moves && rf_follows_motion( settings ) ) || rf_wants_covering( settings ),
        .features = rf_finds_features( settings ),
        .covering = rf_surface_kinds( settings ),
        .chain_samples = rf_calls_for( samples, RF_EFFECT_CHAINS ) ? CHAIN_SAMPLES : 0,
        .connections = connections,
        .clamped = settings->clamp != 0.0,
        .light_frames = frames,
        .groups = groups,
        .layers = layers,
    };
}

RfHarvest rf_make_harvest( const RfEstimatorGroup* group )
{
    const RfRenderSettings* settings = group->settings;
    return ( RfHarvest ){
        .path = { .tracer = group->tracer,
                  .max_depth = group->max_depth,
                  .light_samples = settings->light_samples,
                  .light_sampling = settings->light_sampling },
        .tracers = group->tracers,
        .shape = rf_batch_shape( group ),
        .patches = rf_lay_out_patches( &settings->tile, group->traits.scattered, group->width, group->height ),
        .alpha = ( settings->aovs & RF_AOV_BIT( RF_AOV_ALPHA ) ) != 0,
        .seed = settings->seed,
        .drawn_by = group->need != NULL ? group->filter : NULL,
        .eyes = group->eyes,
        .first_frame = group->first_frame,
        .group = group->number,
        .passes_before = group->passes_before,
        .pieces = settings->pieces,
        .need = group->need,
        .round = group->round,
        .packed = group->packed,
        .single = group->single,
        .first_hits_only = group->first_hits_only,
        .light_paths = rf_drawn_light_paths( group->shared ),
        .kernel_normalization = settings->kernel_normalization,
        .clamps = group->clamp,
        .clamp_watch = group->clamp_watch,
    };
}
