// How fast an error changes: its temporal spectrum, in two bands.
//
// The values that a pixel has in T consecutive frames, followed back from the
// last along the motion where that is compensated (follow.h), are split by the
// discrete cosine transform, type II (Ahmed, Natarajan, Rao 1974), orthonormal:
//   X_k = s_k Σ_t e_t cos( π (2t + 1) k / 2T ),  s_0² = 1/T, else 2/T,
// of frequency k / 2T cycles a frame. Σ_k X_k² = Σ_t e_t², so the bands add up
// to the mean square. It goes on over the ends of the window as in a mirror: a
// slow drift, whose ends differ, stays slow, which it would not in a Fourier
// transform without a taper.
//   frozen   k = 0: what stands still; without a reference the picture itself
//   drift    to 1/8 cycle a frame, that is periods of 8 frames or more (3 Hz at
//            24 frames per second): slow drift
//   boiling  above: what changes from frame to frame
// Noise that is independent in each frame is flat: of its mean square frozen has
// 1/16, drift 4/16, boiling 11/16 with the window of 16 frames, of which one
// begins every 8 and one ends with the last frame; a shorter sequence is one
// window. One of less than four frames does not tell drift (NaN).
#ifndef REFRAME_MEASURE_SPECTRUM_H
#define REFRAME_MEASURE_SPECTRUM_H

#include "measure/follow.h"

#define RF_SPECTRUM_FRAMES 16
#define RF_SPECTRUM_STEP 8
#define RF_SPECTRUM_SPLIT 0.125 // cycles a frame, of the slow band

// Sums over windows.
typedef struct RfSpectrumSums
{
    int windows;
    double pixels; // seen in all frames of the window
    double all_pixels;
    double frozen, drift, boiling; // of X_k² / T, over pixels and channels
} RfSpectrumSums;

// Root mean squares, in the unit of F1; NaN where nothing was seen or one of the
// frames is no number.
typedef struct RfSpectrum
{
    double frozen, drift, boiling;
    double coverage;
} RfSpectrum;

// Does a window end with the frame of this index (from 0), of `count`?
bool rf_ends_group( int index, int count );

// Adds a window of 2 to RF_SPECTRUM_FRAMES frames of one size, in order.
RfResult rf_add_window( RfSpectrumSums* sums, const RfFlickerFrame* const* frames, int count, bool compensate, RfError* error );

RfSpectrum rf_spectrum( const RfSpectrumSums* sums );

#endif
