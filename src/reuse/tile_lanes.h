// Second vertices of a tile with some of their lanes left out, or repeated.
#ifndef REFRAME_REUSE_TILE_LANES_H
#define REFRAME_REUSE_TILE_LANES_H

#include "reuse/tile_reuse.h"

// Moves lane from[b] of an array to lane b.
void rf_gather_lanes( const int32_t* from, int count, float* lanes );
void rf_gather_vectors( const int32_t* from, int count, float lanes[3][RF_LANES] );

// Makes the listed lanes of the second vertices, in the order of their models, the second vertices.
void rf_take_vertices( const int32_t* from, const int32_t* slot, int count, RfVertexLanes* spare, RfVertexLanes* second );

#endif
