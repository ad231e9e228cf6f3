// How the light of a few batches varies, and what larger and smaller tiles would leave of that: for the choice of a tile.
#ifndef REFRAME_REUSE_TILE_PILOT_H
#define REFRAME_REUSE_TILE_PILOT_H

#include "reuse/harvest/harvest_scratch.h"
#include "reuse/reuse_plan.h"

// What batches are compared in.
typedef struct RfTilePilot RfTilePilot;
RfTilePilot* rf_place_tile_pilot( const RfReusePlan* plan, RfLayout* layout );

// Takes the first of two batches of about the same pixels, as they were traced for a group of one frame; the second one adds what
// both tell (src/reuse/estimators.md, E29).
void rf_begin_tile_pair( const RfEstimatorGroup* group, const RfHitBatch* batch, RfHarvestScratch* scratch, RfTilePilot* pilot );
void rf_end_tile_pair( const RfEstimatorGroup* group, const RfHitBatch* batch, RfHarvestScratch* scratch, RfTilePilot* pilot,
                       RfTileCount* count );

#endif
