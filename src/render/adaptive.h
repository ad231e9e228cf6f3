// More native samples for pixels that few other frames help: borders, what comes
// into view, mirrors and glass.
//
// A pilot decides, that has random numbers of its own and traces camera rays and
// eye rays only: ρ of a pixel is the mean over its hits of J_t V_t / Σ_l J_l V_l
// in the group around frame t, the part that a sample of its own frame has in it
// (1 where no other frame sees it). With samples of equal variance its error goes
// with ρ over the passes. Extra samples bring the pixels with ρ > 1/θ to what
// those with ρ = 1/θ have; θ is where error times cost is least by the
// distribution of ρ in the frame, so a frame that would not gain gets none.
//
// An extra sample is of the group of one frame: f |cos| L / p, plain or shared in
// its tile, taken as often as a pass. It adds 1 to B and 1 to the pixel's
// number of passes, so that E[B] stays what it should be (src/reuse/estimators.md,
// section 2). Which tiles get one is drawn by the pilot's ρ and random numbers that no path uses:
// the choice knows nothing of the samples, and there is no bias.
#ifndef REFRAME_RENDER_ADAPTIVE_H
#define REFRAME_RENDER_ADAPTIVE_H

#include "render/render_internal.h"

// Extra samples in a pass, per pixel, at most.
#define RF_MOST_EXTRA 4

// Of a frame whose film has been cleared: runs its pilot and fills live->need.
void rf_run_pilot( RfRenderer* renderer, LiveFilm* live );

// The extra samples that go with a pass of a window, into half `half` of all films in use.
void rf_render_extra( RfRenderer* renderer, const RfHarvest* harvest, const RfGroup* window, int pass, int half );

// θ for pixels of which counts[b] have ρ = (b + 1) / bins; counts[] without those
// that see nothing, `all` with them; `eyes` in the group. 1: no extra samples pay.
double rf_extra_threshold( const double* counts, int bins, double all, int eyes );

#endif
