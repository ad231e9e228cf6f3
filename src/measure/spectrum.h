// The temporal spectrum of the error, in bands: how fast the error changes.
//
// The values of a pixel over T consecutive frames, reprojected from the last frame backwards
// if motion compensation is on (follow.h), are transformed by the orthonormal discrete cosine
// transform of type II (Ahmed, Natarajan, Rao 1974):
//   X_k = s_k Σ_t e_t cos( π (2t + 1) k / 2T ),  s_0² = 1/T, else 2/T,
// with frequency k / 2T cycles per frame. Σ_k X_k² = Σ_t e_t², so the bands sum to the mean
// square. The transform extends the signal by reflection at both ends, so that a slow drift,
// whose ends differ, stays in the low band; in a Fourier transform without a window function
// it would leak.
//   frozen   k = 0: static error; without a reference the image itself
//   drift    up to 1/8 cycle per frame: periods of 8 frames or more (3 Hz at 24 frames per
//            second)
//   boiling  above: changes from frame to frame
// White noise, independent in each frame, has a flat spectrum: with 16 frames, frozen has 1/16
// of its mean square, drift 4/16, boiling 11/16. A group of 16 frames starts every 8 frames,
// and one ends with the last frame; a shorter sequence is a single group. Groups of fewer than
// four frames cannot resolve drift (NaN).
#ifndef REFRAME_MEASURE_SPECTRUM_H
#define REFRAME_MEASURE_SPECTRUM_H

#include "measure/follow.h"

#define RF_SPECTRUM_FRAMES 16
#define RF_SPECTRUM_STEP 8
#define RF_SPECTRUM_SPLIT 0.125 // cycles per frame, upper end of the slow band

// Sums over groups.
typedef struct RfSpectrumSums
{
    int groups;
    double pixels; // visible in all frames of the group
    double all_pixels;
    double frozen, drift, boiling; // of X_k² / T, over pixels and channels
} RfSpectrumSums;

// Root mean squares, in the unit of F1; NaN if nothing was visible or a frame has NaN or
// infinite pixels.
typedef struct RfSpectrum
{
    double frozen, drift, boiling;
    double coverage;
} RfSpectrum;

// True if a group ends with the frame of this index (from 0) out of `count`.
bool rf_ends_group( int index, int count );

// Adds a group of 2 to RF_SPECTRUM_FRAMES frames of equal size, in order.
RfResult rf_add_spectrum_group( RfSpectrumSums* sums, const RfFlickerFrame* const* frames, int count, bool compensate,
                                RfError* error );

// The bands from the sums.
RfSpectrum rf_spectrum( const RfSpectrumSums* sums );

#endif
