// The layout of a batch of hit records in one block of memory.
#include "reuse/harvest/records.h"

// Hands out pieces of a block of memory; with base NULL only counts bytes.
typedef struct Layout
{
    char* base;
    size_t used;
} Layout;

static void* take( Layout* layout, size_t bytes )
{
    void* piece = layout->base != NULL ? layout->base + layout->used : NULL;
    layout->used += ( bytes + 63 ) / 64 * 64;
    return piece;
}

static float* take_lanes( Layout* layout ) { return take( layout, RF_LANES * sizeof( float ) ); }

static void take_lanes3( Layout* layout, float* lanes[3] )
{
    for ( int c = 0; c < 3; ++c )
        lanes[c] = take_lanes( layout );
}

// Further light by the directions of a batch.
static RfDirectionLanes* take_along( Layout* layout, int directions, const RfHitBatch* batch )
{
    RfDirectionLanes* out = take( layout, (size_t)directions * sizeof *out );
    for ( int d = 0; d < directions; ++d )
    {
        RfDirectionLanes lanes = { 0 };
        take_lanes3( layout, lanes.q );
        if ( layout->base == NULL )
            continue;
        for ( int c = 0; c < 3; ++c )
            lanes.wi[c] = batch->directions[d].wi[c];
        out[d] = lanes;
    }
    return out;
}

static RfPassLight* take_pass_light( Layout* layout, const RfBatchShape* shape )
{
    RfPassLight light = { 0 }, *out = take( layout, sizeof *out );
    take_lanes3( layout, light.emission );
    take_lanes3( layout, light.direct );
    if ( shape->params != 0 )
        take_lanes3( layout, light.direct_q );
    if ( layout->base != NULL )
        *out = light;
    return out;
}

static void take_passes( Layout* layout, const RfBatchShape* shape, RfHitBatch* batch )
{
    batch->passes = take_pass_light( layout, shape );
    batch->event = take( layout, RF_LANES );
    batch->others = take( layout, RF_OTHER_PASSES * 4 * (size_t)RF_MOST_LISTED * sizeof( float ) );
    for ( int k = shape->groups > 1 ? shape->groups - 1 : 0; k < shape->dimmed; ++k )
    {
        RfPassLight* light = take_pass_light( layout, shape );
        if ( layout->base != NULL )
            batch->dimmed[k].passes = light;
    }
}

static void take_glossy( Layout* layout, const RfBatchShape* shape, RfHitBatch* batch )
{
    take_lanes3( layout, batch->n );
    take_lanes3( layout, batch->wo );
    for ( int p = 0; p < RF_PARAM_COUNT; ++p )
    {
        if ( rf_has_param( shape->params, (RfBsdfParam)p ) )
            batch->param[p] = take_lanes( layout );
    }
    int directions = rf_direction_count( shape );
    batch->directions = take( layout, (size_t)directions * sizeof *batch->directions );
    for ( int d = 0; d < directions; ++d )
    {
        RfDirectionLanes lanes = { 0 };
        take_lanes3( layout, lanes.wi );
        take_lanes3( layout, lanes.q );
        if ( layout->base != NULL )
            batch->directions[d] = lanes;
    }
    if ( shape->clamped )
        batch->removed_directions = take_along( layout, directions, batch );
    for ( int k = 0; k < shape->dimmed; ++k )
    {
        RfDirectionLanes *light = take_along( layout, directions, batch ), *removed = NULL;
        if ( shape->clamped )
            removed = take_along( layout, directions, batch );
        if ( layout->base == NULL )
            continue;
        batch->dimmed[k].directions = light;
        batch->dimmed[k].removed_directions = removed;
    }
    if ( shape->arrivals > 0 )
        batch->arrivals = take( layout, shape->arrivals );
}

static RfHitBatch lay_out( const RfBatchShape* shape, Layout* layout )
{
    RfHitBatch batch = { 0 };
    take_lanes3( layout, batch.p );
    take_lanes3( layout, batch.ng );
    batch.density_sum = take_lanes( layout );
    size_t listed = shape->chains || shape->own_light ? 2 * RF_LANES : RF_LANES; // a hit may have a glint as well
    batch.radiance = take( layout, 4 * listed * sizeof( float ) );
    if ( shape->clamped || shape->caustics )
        batch.removed = take( layout, 4 * listed * sizeof( float ) );
    batch.dimmed = shape->dimmed > 0 ? take( layout, (size_t)shape->dimmed * sizeof *batch.dimmed ) : NULL;
    for ( int k = 0; k < shape->dimmed; ++k )
    {
        size_t lanes = k + 1 < shape->groups ? listed : RF_LANES;
        RfDimmedLight light = { .radiance = take( layout, 4 * lanes * sizeof( float ) ) };
        if ( shape->clamped )
            light.removed = take( layout, 4 * lanes * sizeof( float ) );
        if ( layout->base != NULL )
            batch.dimmed[k] = light;
    }
    batch.seen = take( layout, (size_t)rf_seen_words( shape->eyes ) * RF_LANES * sizeof( uint32_t ) );
    if ( rf_is_partial( shape ) )
        batch.densities = take( layout, (size_t)shape->eyes * RF_LANES * sizeof( float ) );
    for ( int c = 0; c < 3 && shape->panes && shape->chains; ++c )
        batch.panes[c] = take( layout, (size_t)shape->eyes * RF_LANES * sizeof( float ) );
    batch.pixel = take( layout, listed * sizeof( int32_t ) );
    for ( int c = 0; c < 2 && shape->filtered; ++c )
        batch.offset[c] = take( layout, listed * sizeof( float ) );
    if ( shape->chains )
        batch.view = take( layout, RF_LANES );
    if ( rf_has_covering( shape ) )
        batch.surface = take( layout, RF_LANES * sizeof( uint32_t ) );
    if ( rf_has_covering( shape ) && shape->chains && shape->eyes > 1 )
        batch.surface_seen = take( layout, (size_t)shape->eyes * RF_LANES * sizeof( uint32_t ) );
    batch.rows = take( layout, (size_t)shape->eyes * 2 * sizeof( int32_t ) );
    if ( shape->params != 0 )
        take_glossy( layout, shape, &batch );
    if ( shape->passes )
        take_passes( layout, shape, &batch );
    return batch;
}

uint32_t rf_glossy_params( unsigned kinds )
{
    uint32_t params = 0;
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
    out.arrivals = NULL;
    out.miss_count = others ? out.miss_count : 0;
    out.glint_count = others ? out.glint_count : 0;
    return out;
}

size_t rf_batch_bytes( const RfBatchShape* shape )
{
    Layout layout = { NULL, 0 };
    lay_out( shape, &layout );
    return layout.used;
}

RfHitBatch rf_lay_out_batch( const RfBatchShape* shape, void* memory )
{
    Layout layout = { memory, 0 };
    return lay_out( shape, &layout );
}
