// The noise of samples by class of first hit, for adaptive sampling.
//
// A path that leaves a camera through glass or a mirror often has a variance orders of magnitude above that of the
// others. Each material that may start a chain (src/reuse/estimators.md, section 10) is a class of its own, all others
// are one. A pre-pass measures the classes once per render: in some frames of the path it renders some blocks of pixels
// twice, with random numbers of its own. Half the squared difference is the variance of a sample; over the squared
// mean around it (plus 1e-3) it is in the units of relMSE. In scenes without such materials nothing is measured.
#ifndef REFRAME_RENDER_ADAPTIVE_NOISE_H
#define REFRAME_RENDER_ADAPTIVE_NOISE_H

#include "render/renderer.h"

// One class: a material, or in the last place all that are alike.
typedef struct RfMaterialNoise
{
    // of a sample, relative to that of the materials that are alike: by every other frame that was looked at, and by the others
    float variance[2];
    float cost; // of a sample: rays from vertex to vertex, with the one from the eye
    bool special;
    // while it is measured: pixels and squares in a block, then over all blocks
    uint64_t samples, rays; // path rays of its samples
    double part_pixels, part_square;
    double pixels[2], sum[2], most[2]; // most: of any block
} RfMaterialNoise;

// Does the scene have materials whose noise is to be measured?
static inline bool rf_noise_differs( const RfSceneTraits* traits )
{
    return traits->smooth || ( traits->kinds & 1u << RF_BSDF_GLASS ) != 0;
}

// Measures the classes, if there are any and it has not been done. Borrows a film that has just been cleared.
void rf_measure_noise( RfRenderer* renderer, RfLiveFilm* live );

// Adds to each pixel of `sums` (four floats) the two variances of its hit's class, 1, and its cost.
void rf_add_noise( const RfMaterialNoise* noise, RfFirstHits first, float* sums );

#endif
