// The layout of a batch of hit records in one block of memory.
#include "reuse/harvest/records.h"

#define PLACE_LANES3( layout, lanes )                                                                                            \
    for ( int c_ = 0; c_ < 3; ++c_ )                                                                                             \
    RF_PLACE( layout, ( lanes )[c_], RF_LANES )

// `along`: directions whose wi these have as well, if they have no `own`.
static RfDirectionLanes* place_directions( RfLayout* layout, int count, bool own, const RfDirectionLanes* along )
{
    RfDirectionLanes* out = rf_take( layout, (size_t)count, sizeof *out );
    for ( int d = 0; d < count; ++d )
    {
        if ( out != NULL )
            out[d] = own ? ( RfDirectionLanes ){ .dark = false } : along[d];
        if ( own )
            PLACE_LANES3( layout, out[d].wi );
        PLACE_LANES3( layout, out[d].q );
    }
    return out;
}

static RfPassLight* place_pass_light( RfLayout* layout, const RfBatchShape* shape )
{
    RfPassLight* light = rf_take( layout, 1, sizeof *light );
    if ( light != NULL )
        *light = ( RfPassLight ){ 0 };
    PLACE_LANES3( layout, light->emission );
    PLACE_LANES3( layout, light->direct );
    if ( shape->params != 0 )
        PLACE_LANES3( layout, light->direct_q );
    return light;
}

// Part `part` of the light, from 1 on.
static void place_part( RfLayout* layout, const RfBatchShape* shape, int part, size_t listed, RfHitBatch* batch )
{
    int directions = shape->params != 0 ? rf_direction_count( shape ) : 0;
    bool base = part < shape->groups;
    RfDimmedLight light = { .radiance = rf_take( layout, 4 * ( base ? listed : RF_LANES ), sizeof( float ) ) };
    if ( shape->clamped )
        light.removed = rf_take( layout, 4 * ( base ? listed : RF_LANES ), sizeof( float ) );
    const RfDirectionLanes* along = batch != NULL ? batch->directions : NULL;
    light.directions = place_directions( layout, directions, false, along );
    light.removed_directions = place_directions( layout, shape->clamped ? directions : 0, false, along );
    if ( shape->passes && !base )
        light.passes = place_pass_light( layout, shape );
    if ( batch != NULL )
        batch->dimmed[part - 1] = light;
}

static void place_glossy( RfLayout* layout, const RfBatchShape* shape, RfHitBatch* batch )
{
    int directions = rf_direction_count( shape );
    PLACE_LANES3( layout, batch->n );
    PLACE_LANES3( layout, batch->wo );
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
        RF_PLACE( layout, batch->param[p], rf_has_param( shape->params, (RfBsdfParam)p ) ? RF_LANES : 0 );
    RfDirectionLanes* lanes = place_directions( layout, directions, true, NULL );
    RfDirectionLanes* removed = place_directions( layout, shape->clamped ? directions : 0, false, lanes );
    if ( batch != NULL )
    {
        batch->directions = lanes;
        batch->removed_directions = removed;
    }
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
    RF_PLACE( layout, batch->radiance, 4 * listed );
    RF_PLACE( layout, batch->removed, shape->clamped || shape->caustics ? 4 * listed : 0 );
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
    if ( shape->passes )
    {
        RfPassLight* light = place_pass_light( layout, shape );
        if ( batch != NULL )
            batch->passes = light;
        RF_PLACE( layout, batch->event, RF_LANES );
        RF_PLACE( layout, batch->others, RF_OTHER_PASSES * 4 * RF_MOST_LISTED );
    }
    RF_PLACE( layout, batch->dimmed, shape->dimmed );
    for ( int part = 1; part <= shape->dimmed; ++part )
        place_part( layout, shape, part, listed, batch );
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

RfHitBatch rf_batch_of_part( const RfHitBatch* batch, int part, bool others )
{
    RfHitBatch out = *batch;
    if ( part == 0 )
        return out;
    const RfDimmedLight* light = batch->dimmed + part - 1;
    out.radiance = light->radiance;
    out.directions = light->directions;
    out.removed = light->removed;
    out.removed_directions = light->removed_directions;
    out.any_removed = light->any_removed;
    out.passes = light->passes != NULL ? light->passes : batch->passes;
    out.miss_count = others ? out.miss_count : 0;
    out.glint_count = others ? out.glint_count : 0;
    return out;
}
