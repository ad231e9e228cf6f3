// What the camera rays of a batch have found.
#ifndef REFRAME_REUSE_HARVEST_HIT_LIST_H
#define REFRAME_REUSE_HARVEST_HIT_LIST_H

#include "reuse/harvest/harvest_scratch.h"

// Fills the batch with the hits, misses and glints of `count` camera rays, without their light.
void rf_list_hits( const RfHarvest* harvest, int count, RfHarvestScratch* scratch, RfHitBatch* batch );

// Notes which surfaces the camera rays of the batch's hits and misses hit first: batch->surface. And what another camera sees
// first on its way to hits that it sees, of density > 0: batch->surface_seen.
void rf_note_surfaces( const RfHarvest* harvest, int count, const RfHarvestScratch* scratch, RfHitBatch* batch );
void rf_note_surfaces_seen( const RfHarvest* harvest, int eye, const float* density, const RfHarvestScratch* scratch,
                            RfHitBatch* batch );

#endif
