// Which paths of a tile are reused: copies of one path in several tiles, and Russian roulette.
#ifndef REFRAME_REUSE_TILE_TILE_PATHS_H
#define REFRAME_REUSE_TILE_TILE_PATHS_H

#include "reuse/tile/tile_reuse.h"

// Copies, for gradient-domain path tracing (Kettunen et al., 2015). A tile has two hits that take turns: one of them has a
// path, which is traced once for all tiles that its hit is in. `source` has, by slot, the first slot with that hit, at most
// seven before it, or −1 for hits whose turn it is not. Only paths that can be reused are dropped.

// Keeps one second vertex of those that are reused and belong to the same hit, and none of hits whose turn it is not.
void rf_drop_copies( const int32_t* source, RfWavefront* wavefront, RfTileReuse* reuse );

// Copies what is left, with its light, to all tiles of its hit. The light is doubled, since a tile is traced once with each
// hit's path. Owners must be found anew.
void rf_restore_copies( const int32_t* source, int light_samples, RfWavefront* wavefront, RfTileReuse* reuse );

// Russian roulette on paths by the luminance that they bring (rf_reuse_survival): the light of survivors is scaled up, the
// others are dropped, and hits.second of their owner becomes −1. Paths that bring no light never survive.
void rf_thin_paths( const RfPathSettings* path, RfWavefront* wavefront, RfTileReuse* reuse );

#endif
