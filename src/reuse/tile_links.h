// Links at second vertices of a tile (src/kernel): each receiver gives them a weight of its own.
#ifndef REFRAME_REUSE_TILE_LINKS_H
#define REFRAME_REUSE_TILE_LINKS_H

#include "reuse/tile_reuse.h"

// The weight of the link at second vertex `a` in the light that hit i receives from there: a link at the hit may find it as
// well. i < 0: none does.
float rf_link_weight( const RfPathSettings* settings, const RfTileReuse* reuse, int i, int a );

// The same for the receivers of a pairing, 0 without one; all 1 for light that is no link's.
void rf_find_link_weights( const RfPathSettings* settings, const RfTileReuse* reuse, int pairing, bool links, float* weight );

// Adds the light of links, as it was gathered, that diffuse vertices scatter to each receiver. All other light was added before.
void rf_add_diffuse_links( const RfPathSettings* settings, const float* const wi[3], int tile_pixels, RfTileReuse* reuse,
                           RfLaneScratch* scratch );

#endif
