// Second phase, accumulate: hit records that land in a frame are weighted (E1, E3) and added to
// the halves of its film.
#ifndef REFRAME_REUSE_ACCUMULATE_ACCUMULATE_H
#define REFRAME_REUSE_ACCUMULATE_ACCUMULATE_H

#include "render/estimator.h"
#include "reuse/harvest/records.h"

#include <stddef.h>

typedef struct RfAccumulateScratch
{
    RF_ALIGN int32_t pixel[RF_LANES];
    RF_ALIGN float ratio[RF_LANES];     // r_t, 0 where the hit does not land
    RF_ALIGN float filter[3][RF_LANES]; // of the way to the eye; only for batches with views
    RF_ALIGN float wo[3][RF_LANES];
    RF_ALIGN float f[3][RF_LANES];
    RF_ALIGN float sum[3][RF_LANES];
    RF_ALIGN float pdf[RF_LANES];
    RF_ALIGN float mixture[RF_LANES];
    RF_ALIGN float offset[2][RF_LANES]; // place in the pixel; only with a pixel filter, else not allocated
} RfAccumulateScratch;

// Bytes of a workspace.
static inline size_t rf_accumulate_scratch_bytes( const RfBatchShape* shape )
{
    return shape->filtered ? sizeof( RfAccumulateScratch ) : offsetof( RfAccumulateScratch, offset );
}

// Adds batches to some rows of a film; returns how many samples landed there. Jobs on
// different rows or films may run at the same time. RF_WEIGHTS_EQ15 wants job.pass_state:
// rf_seen_words per pixel of the film, all zero at first, and batches of the whole pass.
uint64_t rf_accumulate_rows( const RfEstimatorGroup* group, RfAccumulateJob job, void* const* batches, int batch_count,
                             RfAccumulateScratch* scratch );

#endif
