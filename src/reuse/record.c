// The layout of a batch of hit records in one block of memory.
#include "reuse/record.h"

#define PLACE_LANES3( layout, lanes )                                                                                            \
    for ( int c_ = 0; c_ < 3; ++c_ )                                                                                             \
    RF_PLACE( layout, ( lanes )[c_], RF_LANES )

void rf_find_layer_directions( const RfBatchShape* shape, const RfLayerSet* set, int layer, int* first, int* end )
{
    RfDirections directions = rf_layer_directions( set, layer, shape->clamped );
    *first = directions == RF_DIRECTIONS_SCATTERING ? rf_light_directions( shape ) : 0;
    *end = directions == RF_DIRECTIONS_SAMPLING ? rf_first_pairing( shape ) + 1 : rf_direction_count( shape );
    if ( shape->params == 0 || directions == RF_DIRECTIONS_NONE )
        *end = *first;
}

// Whether a layer has light of hits, and of misses and glints: parts beyond base parts have no own-frame light.
static size_t find_listed( const RfBatchShape* shape, int layer, size_t listed )
{
    const RfLayerSet* set = &shape->layers;
    int kinds = set->parts * rf_kinds( set ), part = layer < kinds ? layer / rf_kinds( set ) : layer - kinds;
    bool of_hits = layer >= kinds || !set->by_kind || layer % RF_KINDS < RF_HIT_KINDS;
    return part < set->base_parts ? listed : of_hits ? RF_LANES : 0;
}

static RfLayerLight place_layer( RfLayout* layout, const RfBatchShape* shape, int layer, size_t listed )
{
    RfLayerLight light = { .radiance = rf_take( layout, 4 * find_listed( shape, layer, listed ), sizeof( float ) ) };
    rf_find_layer_directions( shape, &shape->layers, layer, &light.first_direction, &light.end_direction );
    light.by = rf_take( layout, (size_t)( light.end_direction - light.first_direction ), sizeof *light.by );
    for ( int d = light.first_direction; d < light.end_direction; ++d )
        PLACE_LANES3( layout, rf_weighted( &light, d )->q );
    return light;
}

static void place_glossy( RfLayout* layout, const RfBatchShape* shape, RfHitBatch* batch )
{
    int directions = rf_direction_count( shape );
    PLACE_LANES3( layout, batch->n );
    PLACE_LANES3( layout, batch->wo );
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
        RF_PLACE( layout, batch->param[p], rf_has_param( shape->params, (RfBsdfParam)p ) ? RF_LANES : 0 );
    RF_PLACE( layout, batch->directions, directions );
    for ( int d = 0; d < directions; ++d )
        PLACE_LANES3( layout, batch->directions[d].wi );
}

RfHitBatch* rf_place_batch( const RfBatchShape* shape, RfLayout* layout )
{
    RfHitBatch* batch = rf_take( layout, 1, sizeof *batch );
    size_t listed = shape->chains || shape->own_light ? 2 * RF_LANES : RF_LANES; // a hit may have a glint as well
    int by_eye = shape->eyes * RF_LANES;
    bool covering = rf_has_covering( shape );
    if ( batch != NULL )
        *batch = ( RfHitBatch ){ 0 };
    PLACE_LANES3( layout, batch->p );
    PLACE_LANES3( layout, batch->ng );
    RF_PLACE( layout, batch->density_sum, RF_LANES );
    RF_PLACE( layout, batch->seen, rf_seen_words( shape->eyes ) * RF_LANES );
    RF_PLACE( layout, batch->densities, rf_is_partial( shape ) ? by_eye : 0 );
    for ( int c = 0; c < 3; ++c )
        RF_PLACE( layout, batch->panes[c], shape->panes && shape->chains ? by_eye : 0 );
    RF_PLACE( layout, batch->pixel, listed );
    for ( int c = 0; c < 2; ++c )
        RF_PLACE( layout, batch->offset[c], shape->filtered ? listed : 0 );
    RF_PLACE( layout, batch->view, shape->chains ? RF_LANES : 0 );
    RF_PLACE( layout, batch->surface, covering ? RF_LANES : 0 );
    RF_PLACE( layout, batch->surface_seen, covering && shape->chains && shape->eyes > 1 ? by_eye : 0 );
    RF_PLACE( layout, batch->rows, 2 * shape->eyes );
    if ( shape->params != 0 )
        place_glossy( layout, shape, batch );
    RF_PLACE( layout, batch->event, shape->layers.by_kind ? RF_LANES : 0 );
    RF_PLACE( layout, batch->light, rf_layer_count( &shape->layers ) );
    for ( int layer = 0; layer < rf_layer_count( &shape->layers ); ++layer )
    {
        RfLayerLight light = place_layer( layout, shape, layer, listed );
        if ( batch != NULL )
            batch->light[layer] = light;
    }
    if ( batch != NULL )
        batch->layers = shape->layers;
    return batch;
}

RfBsdfParams rf_glossy_params( unsigned kinds )
{
    RfBsdfParams params = 0;
    for ( int kind = RF_BSDF_FIRST_GLOSSY; kind < RF_BSDF_FIRST_SPECULAR; ++kind )
    {
        if ( ( kinds >> kind & 1u ) != 0 && rf_is_model_built( (RfBsdfKind)kind ) )
            params |= rf_bsdf_model( (RfBsdfKind)kind )->params;
    }
    return params;
}
