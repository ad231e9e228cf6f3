// What the cameras of a group see of the hits of a batch.
#ifndef REFRAME_REUSE_HARVEST_VISIBILITY_H
#define REFRAME_REUSE_HARVEST_VISIBILITY_H

#include "reuse/harvest/harvest_scratch.h"

// Visibility and densities from every camera: batch->seen, rows and density_sum,
// and scratch->density.
void rf_test_batch_visibility( const RfHarvest* harvest, RfHitBatch* batch, RfHarvestScratch* scratch, RfRayCounts* rays );

#endif
