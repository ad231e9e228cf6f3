// The light of misses and specular hits.
#ifndef REFRAME_REUSE_HARVEST_OWN_FRAME_H
#define REFRAME_REUSE_HARVEST_OWN_FRAME_H

#include "reuse/harvest/harvest_scratch.h"

// Radiance of the own-frame samples: the sky, and specular hits, which are listed behind the misses.
void rf_light_own_frame( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch );

#endif
