// What all batches of a window share.
#include "render/render_internal.h"

// A scene without lights has nothing to sample, walk or combine.
static int useful_depth( const RfRenderer* r ) { return rf_tracer_lights( r->tracer )->count > 0 ? r->settings.max_depth : 1; }

RfHarvest rf_group_harvest( const RfRenderer* r, int number )
{
    RfGroup window = rf_group( &r->plan, number );
    RfHarvest harvest = {
        .walk = { r->tracer, useful_depth( r ), r->settings.light_samples, r->settings.light_sampling },
        .shape = r->sizes.shape,
        .patches = r->sizes.patches,
        .tile_roulette = r->settings.tile_roulette,
        .weights = r->settings.weights,
        .seed = r->settings.seed,
        .eyes = r->eyes + window.first,
        .first_frame = window.first,
        .window = number,
    };
    harvest.shape.eyes = window.eyes;
    return harvest;
}
