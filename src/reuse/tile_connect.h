// Directions from hits to the second vertices that a pairing connects them to.
#ifndef REFRAME_REUSE_TILE_CONNECT_H
#define REFRAME_REUSE_TILE_CONNECT_H

#include "reuse/tile_reuse.h"

// Sets the directions and ρ, without density and visibility, where the weight of the pairing is above 0.
void rf_connect_neighbours( const RfVertexLanes* restrict hits, const RfTileReuse* restrict reuse,
                            RfPairingLanes* restrict pairing );

// The same for pairing s where the roulette has left few second vertices.
void rf_connect_few( const RfVertexLanes* hits, RfTileReuse* reuse, int s );

#endif
