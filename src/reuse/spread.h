// Adds the records of a batch to pixels of a film by a pixel filter: each in all pixels around it
// (src/reuse/estimators.md, section 14). splat.h is the plain case.
#ifndef REFRAME_REUSE_SPREAD_H
#define REFRAME_REUSE_SPREAD_H

#include "reuse/splat.h"

typedef struct RfSpread
{
    const RfPixelFilter* filter;
    RfPixelRange range;
    int width, height; // of the film
} RfSpread;

// Hits, by the pixels, offsets, ratios and filters of the scratch; glossy ones with its sums. Returns how many landed in
// the range itself.
uint64_t rf_spread_hits( const RfHitBatch* batch, const RfAccumulateScratch* scratch, RfSpread spread );

// Misses and specular hits, with weight 1 in their own frame, and glints. Returns how many but glints landed in the range.
uint64_t rf_spread_own_frame( const RfHitBatch* batch, bool black, float weight, RfSpread spread );

#endif
