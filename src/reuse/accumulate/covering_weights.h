// The surfaces that cover the pixels of a frame, by the samples that land in it (film/covering.h).
#ifndef REFRAME_REUSE_ACCUMULATE_COVERING_WEIGHTS_H
#define REFRAME_REUSE_ACCUMULATE_COVERING_WEIGHTS_H

#include "reuse/accumulate/accumulate.h"

// Adds a batch's hits, by the pixels, ratios and offsets of the scratch, and in their own frame its misses, to the rows of the job.
void rf_cover_rows( const RfAccumulation* a, RfAccumulateJob job, const RfHitBatch* batch, const RfAccumulateScratch* scratch );

#endif
