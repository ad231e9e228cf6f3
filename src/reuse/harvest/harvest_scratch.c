// The layout of the workspace in which a batch is traced.
#include "reuse/harvest/harvest_scratch.h"

// What depends on the base parts of the light.
static void place_groups( const RfBatchShape* shape, RfLayout* layout, RfHarvestScratch* scratch )
{
    const RfLayerSet* layers = &shape->layers;
    int base_parts = layers->base_parts, events = layers->by_kind ? RF_EVENTS : 1;
    int finds = shape->chains ? base_parts * events : 0;
    RF_PLACE( layout, scratch->dimmed, ( layers->parts > finds ? layers->parts : finds ) - 1 );
    if ( shape->chains )
        RF_PLACE( layout, scratch->chains->finds, finds );
    if ( shape->chains && scratch != NULL )
        scratch->chains->events = events;
    if ( shape->own_light )
    {
        RF_PLACE( layout, scratch->own->layers, base_parts * rf_hit_kinds( layers ) );
        RF_PLACE( layout, scratch->own->removed, layers->removed ? base_parts : 0 );
        RF_PLACE( layout, scratch->own->paths.of_groups, base_parts - 1 );
        if ( scratch != NULL )
            scratch->own->by_kind = layers->by_kind;
    }
    uint8_t* part = rf_take( layout, base_parts > 1 ? RF_LANES : 0, sizeof *part );
    if ( scratch != NULL && scratch->tiles != NULL )
        scratch->tiles->slots.chain_light.part = part;
    if ( shape->chain_samples == 0 )
        return;
    RF_PLACE( layout, scratch->chain_samples->of_groups, base_parts - 1 );
    RF_PLACE( layout, scratch->chain_samples->part, base_parts > 1 ? RF_LANES : 0 );
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
                                              shape->own_light, &shape->layers, layout );
    RF_PLACE( layout, scratch->chains, shape->chains );
    RF_PLACE( layout, scratch->connections, shape->connections );
    RF_PLACE( layout, scratch->chain_samples, shape->chain_samples > 0 );
    RF_PLACE( layout, scratch->chain_light, shape->chain_samples > 0 );
    RF_PLACE( layout, scratch->own, shape->own_light );
    RF_PLACE( layout, scratch->clamp, shape->clamped );
    RF_PLACE( layout, scratch->surfaces, shape->surfaces );
    RF_PLACE( layout, scratch->features, shape->features );
    for ( int c = 0; c < 2; ++c )
        RF_PLACE( layout, scratch->place[c], shape->filtered ? RF_LANES : 0 );
    RF_PLACE( layout, scratch->first_seen, covering ? RF_LANES : 0 );
    if ( shape->chains )
        RF_PLACE( layout, scratch->chains->triangle, covering ? RF_LANES : 0 );
    if ( scratch != NULL )
    {
        scratch->tiles = tiles;
        scratch->occluders = ( RfOccluders ){ .of = NULL };
    }
    place_groups( shape, layout, scratch );
    return scratch;
}
