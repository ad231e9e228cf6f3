// Tiles of two hits that take turns: one of them has the path, and its hit may be in several tiles. `source` has, by slot,
// the first slot with that hit, at most seven slots before it, or −1 for hits without a path. Paths are dropped only where they can be reused: the
// others go on by themselves.
#ifndef REFRAME_REUSE_TILE_TILE_PATHS_H
#define REFRAME_REUSE_TILE_TILE_PATHS_H

#include "reuse/tile/tile_reuse.h"

// Leaves one second vertex of those that are reused and belong to the same hit, and none of hits without a path.
void rf_drop_copies( const int32_t* source, RfWavefront* wavefront, RfTileReuse* reuse );

// Copies what is left, with its light, to all tiles of its hit. Twice the light: a tile is traced once with each of its
// hits as the one with the path. Owners must be found anew.
void rf_restore_copies( const int32_t* source, int light_samples, RfWavefront* wavefront, RfTileReuse* reuse );

// Russian roulette on the paths of the tiles by that luminance: survivors' light is scaled up. The others, and those without
// light, are dropped: hits.second of their owner becomes −1.
void rf_thin_paths( const RfPathSettings* path, RfWavefront* wavefront, RfTileReuse* reuse );

#endif
