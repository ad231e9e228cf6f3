// Research: the biased weightings of the literature, for comparison (--weights eq15 and unweighted). Both count a hit once in
// each frame in which it lands, instead of with the weight of (E1). `unweighted` divides the light of glossy hits by the
// density of their own camera, `eq15` by the mean density over the cameras whose hits landed in the pixel (Méndez Feliu,
// Sbert, Szirmay-Kalos, Reusing Frames in Camera Animation, WSCG 2006, equation 15): its records keep light and densities
// apart.
#ifndef REFRAME_REUSE_ACCUMULATE_BIASED_WEIGHTS_H
#define REFRAME_REUSE_ACCUMULATE_BIASED_WEIGHTS_H

#include "path/mis.h"
#include "reuse/accumulate/accumulate.h"

// What arrives at the glossy hits from one direction (RfArrivalLanes).
typedef struct RfEq15Lanes
{
    float* a[3];
    float* b[3];
    float* light_pdf;
} RfEq15Lanes;

// The bytes of so many directions, and their layout in memory of that size.
size_t rf_eq15_bytes( int directions );
RfEq15Lanes* rf_lay_out_eq15( int directions, void* memory );

// Keeps what arrives from a direction.
void rf_keep_eq15( const RfHitBatch* batch, const RfArrivalLanes* arrival, RfEq15Lanes* direction );

// Sets all directions to zero.
void rf_clear_eq15( const RfHitBatch* batch, int directions );

// Gives hits that land the weight of the pass.
void rf_count_once( int count, float weight, float* ratio );

// Notes the batch's camera in the pixels [low, end) in which its hits landed: rf_seen_words words per pixel of the film.
void rf_note_landed_eyes( const RfAccumulation* a, const RfHitBatch* batch, const RfAccumulateScratch* scratch, int32_t low,
                          int32_t end, uint32_t* landed_eyes );

// Radiance of the glossy hits towards the camera, into scratch->sum.
void rf_light_glossy_eq15( const RfAccumulation* a, int eye, const RfHitBatch* batch, const uint32_t* landed_eyes,
                           RfAccumulateScratch* scratch );

#endif
