#include "reuse/tile_lanes.h"

#include <string.h>

void rf_gather_lanes( const int32_t* from, int count, float* lanes )
{
    float old[RF_LANES];
    memcpy( old, lanes, sizeof old );
    for ( int b = 0; b < count; ++b )
        lanes[b] = old[from[b]];
}

void rf_gather_vectors( const int32_t* from, int count, float lanes[3][RF_LANES] )
{
    for ( int c = 0; c < 3; ++c )
        rf_gather_lanes( from, count, lanes[c] );
}

void rf_take_vertices( const int32_t* from, const int32_t* slot, int count, RfVertexLanes* spare, RfVertexLanes* second )
{
    for ( int b = 0, kind = 0; b < count; ++b )
    {
        while ( from[b] >= second->first[kind + 1] )
            ++kind;
        rf_copy_vertices( second, from[b], 1, rf_bsdf_model( (RfBsdfKind)kind )->params, spare, b );
        spare->slot[b] = slot[b];
    }
    for ( int kind = 0, b = 0; kind <= RF_BSDF_KIND_COUNT; ++kind )
    {
        while ( b < count && from[b] < second->first[kind] )
            ++b;
        spare->first[kind] = b;
    }
    spare->count = count;
    *second = *spare;
}
