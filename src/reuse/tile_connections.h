// Connections at second vertices of a tile (src/light_paths): each receiver gives them a weight of its own.
#ifndef REFRAME_REUSE_TILE_CONNECTIONS_H
#define REFRAME_REUSE_TILE_CONNECTIONS_H

#include "reuse/tile_reuse.h"

// The weight of the connection at second vertex `a` in the light that hit i receives from there: a connection at the hit may find it as
// well. i < 0: none does.
float rf_connection_weight( const RfPathSettings* settings, const RfTileReuse* reuse, int i, int a );

// The same for the receivers of a pairing, 0 without one; all 1 for light that is no connection's.
void rf_find_connection_weights( const RfPathSettings* settings, const RfTileReuse* reuse, int pairing, bool connections,
                                 float* weight );

// Adds the light of connections, as it was gathered, that diffuse vertices scatter to each receiver. All other light was added before.
void rf_add_diffuse_connections( const RfPathSettings* settings, const float* const wi[3], int tile_pixels, RfTileReuse* reuse,
                                 RfLaneScratch* scratch );

#endif
