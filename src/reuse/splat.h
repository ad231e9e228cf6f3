// Adds the records of a batch to pixels of a film: the last step of accumulation.
#ifndef REFRAME_REUSE_SPLAT_H
#define REFRAME_REUSE_SPLAT_H

#include "reuse/accumulate.h"

// Only pixels [low, end) belong to this job.
typedef struct RfPixelRange
{
    float* film; // 4 per pixel
    int32_t low, end;
    float* sky; // weight of the camera rays that missed, 1 per pixel; NULL: not asked for
} RfPixelRange;

// Hits, by the pixels, ratios and filters of the scratch; glossy ones with its sums. Return how many landed.
uint64_t rf_splat_diffuse( const RfHitBatch* batch, const RfAccumulateScratch* scratch, RfPixelRange range );
uint64_t rf_splat_glossy( const RfHitBatch* batch, const RfAccumulateScratch* scratch, RfPixelRange range );

// Misses and specular hits: weight 1 in their own frame, 0 elsewhere. Returns how many landed.
uint64_t rf_splat_misses( const RfHitBatch* batch, bool black, float weight, RfPixelRange range );

// Light without a sample of its own.
void rf_splat_glints( const RfHitBatch* batch, float weight, RfPixelRange range );

// Count the samples that land in each pixel.
void rf_count_landed( const RfHitBatch* batch, const RfAccumulateScratch* scratch, RfPixelRange range, uint32_t* landed );
void rf_count_misses( const RfHitBatch* batch, RfPixelRange range, uint32_t* landed );

#endif
