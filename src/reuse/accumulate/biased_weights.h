// Research: the biased weightings of the literature, for comparison (--weights eq15 and unweighted). Both count a hit once in
// each frame in which it lands, instead of with the weight of (E1). `unweighted` divides the light of glossy hits by the
// density of their own camera, `eq15` by the mean density over the cameras whose hits landed in the pixel (Méndez Feliu,
// Sbert, Szirmay-Kalos, Reusing Frames in Camera Animation, WSCG 2006, equation 15): its records keep light and densities
// apart.
#ifndef REFRAME_REUSE_ACCUMULATE_BIASED_WEIGHTS_H
#define REFRAME_REUSE_ACCUMULATE_BIASED_WEIGHTS_H

#include "path/mis.h"
#include "reuse/accumulate/accumulate.h"

// The bytes of RfHitBatch.arrivals with so many directions; 0: the weights want none.
size_t rf_arrivals_bytes( RfWeights weights, int directions );

// Keeps what arrives from a direction in it.
void rf_keep_arrivals( const RfHitBatch* batch, int direction, const RfArrivalLanes* arrival );

// Gives hits that land the weight of the pass.
void rf_count_once( int count, float weight, float* ratio );

// Notes the batch's camera in the pixels [low, end) in which its hits landed: rf_seen_words words per pixel of the film.
void rf_note_landed_eyes( const RfAccumulation* a, const RfHitBatch* batch, const RfAccumulateScratch* scratch, int32_t low,
                          int32_t end, uint32_t* landed_eyes );

// Radiance of the glossy hits towards the camera, into scratch->sum.
void rf_light_glossy_eq15( const RfAccumulation* a, int eye, const RfHitBatch* batch, const uint32_t* landed_eyes,
                           RfAccumulateScratch* scratch );

#endif
