// The surfaces that cover the pixels of a frame, by the samples that land in it (film/covering.h).
#ifndef REFRAME_REUSE_ACCUMULATE_COVERING_WEIGHTS_H
#define REFRAME_REUSE_ACCUMULATE_COVERING_WEIGHTS_H

#include "reuse/accumulate/splat.h"

// Adds the hits of a batch that landed, and in its `own` frame its misses.
void rf_cover_rows( const RfSplat* splat, const RfHitBatch* batch, bool own, const RfLandedHits* landing );

#endif
