// What the traits of a scene and the settings of a render call for in batches of hit records.
#include "reuse/reuse_plan.h"

#include "light_paths/light_paths.h"

// Light samples per first hit with tiles, at least. Tiles share all other light, and these samples are cheap beside the rest of
// a path (scripts/bench/RESULTS.md).
#define DIRECT_SAMPLES 2
// Chain samples per hit behind a chain (path/chain_samples.h).
#define CHAIN_SAMPLES 4

static int direct_samples( const RfRenderSettings* settings, int tile_pixels, bool even )
{
    int least = tile_pixels == 1 || even ? 1 : DIRECT_SAMPLES;
    return settings->light_samples > least ? settings->light_samples : least;
}

// Which layers light has: with biased weights, and in gradients, it is not told apart.
static RfLayerSet find_layers( const RfEstimatorGroup* group, bool exact, bool caustics, int light_frames )
{
    const RfRenderSettings* settings = group->settings;
    int groups = exact ? group->traits.light_groups : 0;
    RfLayerSet layers = {
        .base_parts = groups > 1 ? groups : 1,
        .by_kind = ( settings->aovs & RF_PASS_AOVS ) != 0 && exact,
        .removed = settings->clamp != 0.0 || caustics,
    };
    layers.parts = layers.base_parts;
    if ( group->eye_count > 1 && exact )
    {
        int alone = group->traits.lamps_alone < layers.base_parts ? group->traits.lamps_alone : layers.base_parts;
        layers.parts += group->traits.dimmable + ( light_frames > 1 ? alone * light_frames : 0 );
    }
    layers.parts = layers.parts < RF_PARTS_MOST + 1 ? layers.parts : RF_PARTS_MOST + 1;
    return layers;
}

// Whether frames share what is seen in rough glass. Light paths and caustics that are left out have chains of it.
static bool shares_frosted( const RfEstimatorGroup* group, bool exact )
{
    return rf_calls_for( ( group->traits.kinds >> RF_BSDF_FROSTED & 1u ) != 0, RF_EFFECT_TRANSMISSION ) && exact &&
           ( group->eye_count > 1 || group->probe ) && !group->traits.without_caustics &&
           !rf_wants_light_paths( &group->traits, group->settings );
}

static RfBatchShape find_shape( const RfEstimatorGroup* group, bool even )
{
    const RfRenderSettings* settings = group->settings;
    bool specular = rf_has_specular( group->traits.kinds );
    int tile_pixels = rf_tile_pixels( &settings->tile );
    bool chains = rf_wants_chains( &group->traits, settings, tile_pixels );
    bool connections = rf_wants_light_paths( &group->traits, settings );
    bool exact = settings->weights == RF_WEIGHTS_EXACT && !even;
    bool caustics = group->traits.without_caustics && exact;
    bool samples = chains && group->traits.chain_triangles > 0 && !connections && !even && !caustics;
    // at the ends of a path, groups of more frames are shorter, and have the memory of those
    int frames = !group->traits.lamps_alone || !exact ? 1 : group->eye_count < RF_FRAMES_MOST ? group->eye_count : RF_FRAMES_MOST;
    bool frosted = shares_frosted( group, exact );
    unsigned frosted_kind = 1u << RF_BSDF_FROSTED;
    return ( RfBatchShape ){
        .eyes = group->eye_count,
        .light_samples = direct_samples( settings, tile_pixels, connections || even ),
        .tile_pixels = tile_pixels,
        .params = rf_glossy_params( frosted ? group->traits.kinds : group->traits.kinds & ~frosted_kind ),
        .frosted = frosted,
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
        .groups = exact ? group->traits.light_groups : 0,
        .layers = find_layers( group, exact, caustics, frames ),
    };
}

static int list_films( const RfBatchShape* shape, unsigned aovs, RfFilmLayers* out )
{
    int count = 0;
    out[count++] = ( RfFilmLayers ){ RF_ALL, RF_ALL, false };
    for ( int base = 0; base < shape->groups; ++base )
        out[count++] = ( RfFilmLayers ){ base, RF_ALL, false };
    for ( int kind = 0; kind < RF_KINDS && shape->layers.by_kind; ++kind )
    {
        if ( ( aovs & RF_AOV_BIT( RF_AOV_EMISSION + kind ) ) != 0 )
            out[count++] = ( RfFilmLayers ){ RF_ALL, kind, false };
    }
    if ( shape->layers.removed )
        out[count++] = ( RfFilmLayers ){ RF_ALL, RF_ALL, true };
    return count;
}

void rf_compile_reuse( const RfEstimatorGroup* group, bool even_light_samples, RfReusePlan* out )
{
    const RfRenderSettings* settings = group->settings;
    out->shape = find_shape( group, even_light_samples );
    out->patches = rf_lay_out_patches( &settings->tile, group->traits.scattered, group->width, group->height );
    out->alpha = ( settings->aovs & RF_AOV_BIT( RF_AOV_ALPHA ) ) != 0;
    out->film_count = list_films( &out->shape, settings->aovs, out->films );
}
