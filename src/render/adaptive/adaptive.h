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
// Glints, pixels in which few first hits bring most of the light, have a pilot and extra samples of their own (glint_pilot.c).
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

#include <stdbool.h>
#include <stddef.h>

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

// What a pilot found, per pixel.
typedef struct RfPilotSums
{
    float* share; // sums of ρ over the passes
    const float*
        noise; // four per pixel: sums of the two variances of its hits' classes, of the hits, and of costs; NULL: all alike
    const float* samples; // camera rays of the pixel; NULL: one in each pass
    size_t pixels;
    float passes;
    int eyes;     // of the group
    bool wary;    // extra samples must pay by a margin (RF_ADAPTIVE_AUTO), where materials differ in noise
    double worth; // of an extra sample beside one of a pass: 1 without a pixel filter (film/pixel_filter.h)
} RfPilotSums;

// Do enough pixels of a coarse look lack samples for a pilot to be worth it?
bool rf_extra_may_pay( const RfPilotSums* sums );

// Replaces sums->share by the extra samples of each pixel in a pass, and returns the most.
float rf_set_need( const RfPilotSums* sums );

// θ for pixels of which counts[b] have ρ = (b + 1) / bins. counts[] leaves out pixels
// that see nothing, `all` has them; `eyes`: cameras of the group. 1: no extra samples pay.
double rf_extra_threshold( const double* counts, int bins, double all, int eyes );

// Extra samples of a pixel in a pass, at most.
#define RF_MOST_GLINTS 64
// With fewer samples of a frame the pilot costs more than a hundredth of it; `auto` leaves it out.
#define RF_LEAST_GLINT_SPP 12

// Fills live->glints and live->most_glints of a frame whose film has just been cleared; `worth`: of an extra sample beside one of
// a pass.
void rf_find_glints( RfRenderer* renderer, RfLiveFilm* live, double worth );

// From the sums of the pilot (RfEstimator.add_glints), four for each of `pixels`, to extra samples per pixel in a pass. Returns the
// most; 0: none pay. `reach`: samples that a pass brings to a pixel.
float rf_set_glints( const float* sums, size_t pixels, double reach, double worth, float* extra );

#endif
