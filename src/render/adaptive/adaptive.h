// Adaptive sampling: more own-frame samples for pixels that few other frames help, such as borders,
// surfaces that come into view, mirrors and glass.
//
// A pilot decides. It has random numbers of its own and traces camera rays and
// visibility rays to the other cameras only: ρ of a pixel is the mean over its hits of J_t V_t / Σ_l J_l V_l in the
// group around frame t, the share of a sample's weight that its own frame keeps (1 where no
// other frame sees it). With samples of equal variance a pixel's error is proportional to ρ over
// the passes. Extra samples bring pixels with ρ > 1/θ to the error of those with ρ = 1/θ; θ
// minimises error times cost for the distribution of ρ in the frame, so a frame that would
// not gain gets none.
//
// A path that leaves a camera through glass or a mirror often has a variance orders of magnitude above that of the others.
// Each material that may start a chain (src/reuse/estimators.md, section 10) is a class of its own, all others are one. A
// pre-pass measures the variance v of the classes once per render: in some frames of the path it renders some blocks of pixels
// twice, with random numbers of its own. Half the squared difference is the variance of a sample; over the squared mean around
// it (plus 1e-3) it is in the units of relMSE. A pixel's error is v over its samples, and extra samples bring it to θ √v
// samples: the split that has the least error for its cost. In scenes without such materials nothing is measured.
//
// With RF_ADAPTIVE_AUTO a coarse look comes first, a ray for a sixteenth of the pixels: where few of them are without
// help the frame gets neither a pilot nor extra samples. The pilot's random numbers do not depend on it.
//
// Glints, pixels in which few first hits bring most of the light, have a pilot and extra samples of their own (glint_pilot.h).
//
// An extra sample belongs to a group of one frame: f |cos| L / p, plain or shared in its
// tile, with the weight of a pass. It adds 1 to B and 1 to the pixel's number of
// passes, so that E[B] stays 1 (src/reuse/estimators.md, section 2). Which tiles get one is
// drawn from the pilot's ρ and random numbers that no path uses: the choice is independent
// of the samples, so there is no bias.
//
// With a pixel filter other than the plain one, extra samples of a pixel are drawn by its filter and count in that pixel
// alone, while those of passes count in all pixels around them: so an extra sample is worth less, and both it and the
// pixel's number of passes are weighted by that.
#ifndef REFRAME_RENDER_ADAPTIVE_ADAPTIVE_H
#define REFRAME_RENDER_ADAPTIVE_ADAPTIVE_H

#include "render/renderer.h"

// One class: a material, or in the last place all that are alike.
typedef struct RfMaterialNoise
{
    // of a sample, relative to that of the materials that are alike: by every other frame that was looked at, and by the others
    float variance[2];
    float cost; // of a sample: rays from vertex to vertex, with the camera ray
    bool special;
    // while it is measured: pixels and squares in a block, then over all blocks
    uint64_t samples, rays; // path rays of its samples
    double part_pixels, part_square;
    double pixels[2], sum[2], most[2]; // most: of any block
} RfMaterialNoise;

// Does the scene have materials whose noise is to be measured?
static inline bool rf_noise_differs( const RfSceneTraits* traits ) { return traits->smooth || rf_has_specular( traits->kinds ); }

// Extra samples in a pass, per pixel, at most: where all materials are alike, and elsewhere.
#define RF_MOST_EXTRA 4
#define RF_MOST_EXTRA_NOISY 16

static inline int rf_most_extra( bool noisy ) { return noisy ? RF_MOST_EXTRA_NOISY : RF_MOST_EXTRA; }

// Runs the pilot of a frame whose film has just been cleared and fills live->need and live->most_need.
void rf_run_pilot( RfRenderer* renderer, RfLiveFilm* live );

// Traces the extra samples that go with a pass, into all films in use.
void rf_render_extra( RfRenderer* renderer, const RfPass* pass );

#endif
