// The light of hit records.
#ifndef REFRAME_REUSE_HARVEST_RECORD_WEIGHTS_H
#define REFRAME_REUSE_HARVEST_RECORD_WEIGHTS_H

#include "reuse/harvest/harvest_scratch.h"

// The light of the records, in all layers. Misses and glints have none yet.
void rf_weight_batch( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch );

#endif
