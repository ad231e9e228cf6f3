// Phase 2, accumulation: weights the hit records that land in a frame (E1, E3), and adds them to the films of its half, each of
// which is a sum of layers (reuse/layer.h).
#ifndef REFRAME_REUSE_ACCUMULATE_ACCUMULATE_H
#define REFRAME_REUSE_ACCUMULATE_ACCUMULATE_H

#include "reuse/accumulate/splat.h"

// A thread's workspace, and an empty landing.
void rf_place_accumulation( const RfReusePlan* plan, RfLayout* layout );
RfLandedHits* rf_place_landing( const RfReusePlan* plan, RfLayout* layout );

// Adds batches to some rows of the films; returns how many samples landed there. Jobs on
// different rows or films may run at the same time.
uint64_t rf_accumulate_rows( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count,
                             void* scratch );

// Projects and lights the hits of a batch for a frame, whole, and keeps those that land (splat.h).
void rf_land_batch( const RfEstimatorGroup* group, RfAccumulateJob job, const RfHitBatch* batch, void* scratch, void* landing );

// rf_accumulate_rows with what rf_land_batch kept of each batch.
uint64_t rf_add_landings( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, void* const* landings,
                          int batch_count );

#endif
