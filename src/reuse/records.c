#include "reuse/records.h"

#include <string.h>

// Hands out pieces of a block and copies what `from` has there; with base NULL
// it only counts. The room is for so many hits, of them so many glossy, and pixels.
typedef struct Layout
{
    char* base;
    size_t used;
    size_t hits, glossy, pixels, radiances;
} Layout;

static void* take( Layout* layout, size_t bytes, const void* from )
{
    void* piece = layout->base != NULL ? layout->base + layout->used : NULL;
    layout->used += ( bytes + 63 ) / 64 * 64;
    if ( piece != NULL && from != NULL )
        memcpy( piece, from, bytes );
    return piece;
}

static float* take_lanes( Layout* layout, size_t count, const float* from ) { return take( layout, count * sizeof( float ), from ); }

static void take_lanes3( Layout* layout, size_t count, float* lanes[3] )
{
    for ( int c = 0; c < 3; ++c )
        lanes[c] = take_lanes( layout, count, lanes[c] );
}

static RfDirectionLanes take_direction( Layout* layout, RfDirectionLanes lanes, bool eq15 )
{
    take_lanes3( layout, layout->glossy, lanes.wi );
    take_lanes3( layout, layout->glossy, lanes.q );
    if ( eq15 )
    {
        take_lanes3( layout, layout->glossy, lanes.a );
        take_lanes3( layout, layout->glossy, lanes.b );
        lanes.light_pdf = take_lanes( layout, layout->glossy, lanes.light_pdf );
    }
    return lanes;
}

// From here on the batch's arrays are those to be copied, or NULL, and become pieces.
static void take_glossy( Layout* layout, const RfBatchShape* shape, RfHitBatch* batch )
{
    size_t count = layout->glossy;
    take_lanes3( layout, count, batch->n );
    take_lanes3( layout, count, batch->wo );
    take_lanes3( layout, count, batch->diffuse );
    take_lanes3( layout, count, batch->specular );
    batch->shape = take_lanes( layout, count, batch->shape );
    batch->f90 = take_lanes( layout, count, batch->f90 );
    batch->coat_f0 = take_lanes( layout, count, batch->coat_f0 );
    batch->coat_f90 = take_lanes( layout, count, batch->coat_f90 );
    if ( shape->coated )
    {
        batch->clearcoat = take_lanes( layout, count, batch->clearcoat );
        batch->clearcoat_alpha = take_lanes( layout, count, batch->clearcoat_alpha );
        take_lanes3( layout, count, batch->clearcoat_n );
    }
    int directions = rf_direction_count( shape );
    const RfDirectionLanes* from = batch->directions;
    batch->directions = take( layout, (size_t)directions * sizeof *batch->directions, NULL );
    for ( int d = 0; d < directions; ++d )
    {
        RfDirectionLanes lanes = take_direction( layout, from != NULL ? from[d] : ( RfDirectionLanes ){ 0 }, shape->eq15 );
        if ( layout->base != NULL )
            batch->directions[d] = lanes;
    }
}

static RfHitBatch lay_out( const RfBatchShape* shape, RfHitBatch batch, Layout* layout )
{
    size_t count = layout->hits;
    size_t words = (size_t)rf_seen_words( shape->eyes ) - 1; // before the last
    take_lanes3( layout, count, batch.p );
    take_lanes3( layout, count, batch.ng );
    batch.density_sum = take_lanes( layout, count, batch.density_sum );
    batch.radiance = take_lanes( layout, 4 * layout->radiances, batch.radiance );
    batch.seen = take( layout, ( words * RF_LANES + count ) * sizeof( uint32_t ), batch.seen );
    if ( shape->blended )
        batch.densities = take_lanes( layout, (size_t)( shape->eyes - 1 ) * RF_LANES + count, batch.densities );
    batch.pixel = take( layout, layout->pixels * sizeof( int32_t ), batch.pixel );
    batch.rows = take( layout, (size_t)shape->eyes * 2 * sizeof( int32_t ), batch.rows );
    if ( shape->glossy )
        take_glossy( layout, shape, &batch );
    return batch;
}

static Layout whole_layout( void* memory )
{
    return ( Layout ){ .base = memory, .hits = RF_LANES, .glossy = RF_LANES, .pixels = RF_LANES, .radiances = RF_LANES };
}

static Layout packed_layout( const RfBatchShape* shape, const RfHitBatch* batch, void* memory )
{
    size_t hits = (size_t)batch->count, misses = (size_t)batch->miss_count;
    return ( Layout ){ .base = memory,
                       .hits = hits,
                       .glossy = hits - (size_t)batch->first[RF_BSDF_PHONG],
                       .pixels = hits + misses,
                       .radiances = hits + ( shape->natives ? misses : 0 ) };
}

size_t rf_batch_bytes( const RfBatchShape* shape )
{
    Layout layout = whole_layout( NULL );
    lay_out( shape, ( RfHitBatch ){ 0 }, &layout );
    return layout.used;
}

RfHitBatch rf_lay_out_batch( const RfBatchShape* shape, void* memory )
{
    Layout layout = whole_layout( memory );
    return lay_out( shape, ( RfHitBatch ){ 0 }, &layout );
}

size_t rf_packed_batch_bytes( const RfBatchShape* shape, const RfHitBatch* batch )
{
    Layout layout = packed_layout( shape, batch, NULL );
    lay_out( shape, *batch, &layout );
    return layout.used;
}

RfHitBatch rf_pack_batch( const RfBatchShape* shape, const RfHitBatch* batch, void* memory )
{
    Layout layout = packed_layout( shape, batch, memory );
    return lay_out( shape, *batch, &layout );
}
