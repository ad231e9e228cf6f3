// From hits that are projected and lit to the pixels of a film.
#ifndef REFRAME_REUSE_ACCUMULATE_SPLAT_H
#define REFRAME_REUSE_ACCUMULATE_SPLAT_H

#include "reuse/accumulate/accumulate.h"

// Only pixels [low, end) belong to this job.
typedef struct RfPixelRange
{
    float* film;    // 4 per pixel, as in the next two
    float* glints;  // what glints are added to: the film, or its sums of own-frame light
    float* counted; // whose weights count the samples of the frame itself; NULL: none
    int32_t low, end;
    float* sky; // weight of the camera rays that missed, 1 per pixel; NULL: not asked for
} RfPixelRange;

#define RF_LANDING_BINS 128

// The hits of a batch that landed in a frame: those of a pixel in their order, and without a pixel filter sorted into bins of
// pixels; with one all in their order, since a hit then counts in pixels of several bins.
typedef struct RfLandedHits
{
    int count;
    int32_t low, high;                  // the first and the last pixel of them
    int shift;                          // bin b holds pixels from low + (b << shift) on
    int16_t first[RF_LANDING_BINS + 1]; // hits [first[b], first[b+1]) are in bin b
    float* value;                       // 4 each: r g b 1, times r_t
    int32_t* pixel;
    float* offset[2]; // in the pixel; NULL without a pixel filter
} RfLandedHits;

// An empty landing.
RfLandedHits* rf_place_landing( bool filtered, RfLayout* layout );

// Keeps the hits that landed, by the pixels, ratios, filters and sums of the scratch.
void rf_keep_landing( const RfHitBatch* batch, const RfAccumulateScratch* scratch, RfLandedHits* landing );

// Adds a batch to the pixels of the range: its hits by the pixels, offsets, ratios and filters of the scratch, glossy ones with its
// sums, and in its own frame misses and glints. Returns how many samples landed in the range.
uint64_t rf_splat( const RfAccumulation* a, int eye, const RfHitBatch* batch, RfPixelRange range,
                   const RfAccumulateScratch* scratch );

// The same with hits that were kept.
uint64_t rf_splat_landing( const RfAccumulation* a, int eye, const RfHitBatch* batch, const RfLandedHits* landing,
                           RfPixelRange range );

// Count the samples that land in each pixel of the range.
void rf_count_landed( const RfHitBatch* batch, const RfAccumulateScratch* scratch, RfPixelRange range, uint32_t* landed );
void rf_count_landing( const RfLandedHits* landing, RfPixelRange range, uint32_t* landed );
void rf_count_misses( const RfHitBatch* batch, RfPixelRange range, uint32_t* landed );

#endif
