// The layout of the workspace in which a batch is traced.
#include "reuse/harvest/harvest_steps.h"

// What light groups need for the base parts from 1 on, and the base parts of light by chains.
static void place_groups( const RfBatchShape* shape, RfLayout* layout, RfHarvestScratch* scratch )
{
    int count = shape->groups > 1 ? shape->groups - 1 : 0;
    if ( shape->chains )
        RF_PLACE( layout, scratch->chains->groups, count );
    if ( shape->own_light )
    {
        RF_PLACE( layout, scratch->own->groups, count );
        RF_PLACE( layout, scratch->own->paths.of_groups, count );
    }
    uint8_t* part = rf_take( layout, count > 0 ? RF_LANES : 0, sizeof *part );
    if ( scratch != NULL && scratch->tiles != NULL )
        scratch->tiles->slots.chain_light.part = part;
    if ( shape->chain_samples == 0 )
        return;
    RF_PLACE( layout, scratch->chain_samples->of_groups, count );
    RF_PLACE( layout, scratch->chain_samples->part, count > 0 ? RF_LANES : 0 );
    if ( scratch != NULL )
        scratch->chain_light->part = part;
}

RfHarvestScratch* rf_place_harvest_scratch( const RfBatchShape* shape, RfLayout* layout )
{
    RfHarvestScratch* scratch = rf_take( layout, 1, sizeof *scratch );
    bool moments = shape->moments, covering = rf_has_covering( shape ) && shape->chains;
    RF_PLACE( layout, scratch->eyes, rf_is_blurred_shape( shape ) ? shape->eyes : 0 );
    RF_PLACE( layout, scratch->tracers, moments ? shape->eyes : 0 );
    RF_PLACE( layout, scratch->at_moment, moments ? (size_t)shape->eyes * rf_tracer_at_bytes( shape->moving_lights ) : 0 );
    RF_PLACE( layout, scratch->direct, rf_light_directions( shape ) );
    RF_PLACE( layout, scratch->density, shape->eyes * RF_LANES );
    RF_PLACE( layout, scratch->mixture, rf_direction_count( shape ) * RF_LANES );
    RfTileReuse* tiles = rf_place_tile_reuse( rf_light_directions( shape ) + shape->connections, shape->tile_pixels, shape->panes,
                                              shape->own_light, shape->dimmed, shape->groups, layout );
    RF_PLACE( layout, scratch->chains, shape->chains );
    RF_PLACE( layout, scratch->connections, shape->connections );
    RF_PLACE( layout, scratch->chain_samples, shape->chain_samples > 0 );
    RF_PLACE( layout, scratch->chain_light, shape->chain_samples > 0 );
    RF_PLACE( layout, scratch->own, shape->own_light );
    RF_PLACE( layout, scratch->own_passes, shape->own_light && shape->passes );
    RF_PLACE( layout, scratch->dimmed, shape->dimmed );
    RF_PLACE( layout, scratch->clamp, shape->clamped );
    RF_PLACE( layout, scratch->surfaces, shape->surfaces );
    RF_PLACE( layout, scratch->features, shape->features );
    for ( int c = 0; c < 2; ++c )
        RF_PLACE( layout, scratch->place[c], shape->filtered ? RF_LANES : 0 );
    RF_PLACE( layout, scratch->first_seen, covering ? RF_LANES : 0 );
    if ( shape->chains )
    {
        RF_PLACE( layout, scratch->chains->triangle, covering ? RF_LANES : 0 );
        RF_PLACE( layout, scratch->chains->by_event, shape->passes );
    }
    if ( scratch != NULL )
    {
        scratch->tiles = tiles;
        scratch->occluders = ( RfOccluders ){ .of = NULL };
        scratch->part = 0;
    }
    place_groups( shape, layout, scratch );
    return scratch;
}
