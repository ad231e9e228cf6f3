// Flicker: of pairs of frames, along the motion, as a spectrum, at the borders of groups, as a picture.
#ifndef REFRAME_MEASURE_FLICKER_H
#define REFRAME_MEASURE_FLICKER_H

#include "reframe/image.h"
#include "reframe/measure.h"
#include "render/groups.h"

#include <stdbool.h>
#include <string.h>

// Backward reprojection: where the surface seen in a pixel was in the previous frame, by the
// motion layer, and whether it was visible there, by depth.
//
// A point at (x, y), in pixels from the centre of the first pixel of the data window with +y
// down, was at (x + motion.X, y − motion.Y) in the previous frame (the layer has +y up).
// Motion, depth and colour are interpolated bilinearly.
//
// The point was visible if the depth found there is within 2 % of its expected depth, or if
// both show no surface. The expected depth differs from the current one because the camera
// moves: if both frames have the attribute worldToNDC (ours do), the point is reprojected
// through both cameras as part of a static scene; otherwise the depth is taken as unchanged.
// Points outside the frame, or with undefined motion or depth, were not visible. There is no
// layer of primitive ids yet to compare as well.

// A frame as input to the flicker measures.
typedef struct RfFlickerFrame
{
    int number;
    char shot[32];    // of its path; empty where that has no cuts, or another program wrote it
    size_t clipped;   // pixels of v (rf_read_exr_picture)
    RfImage signal;   // e = v − r with a reference, else the image v
    RfImage variance; // of v; rgb NULL: unknown
    float* motion;    // 2 per pixel, or NULL
    float* depth;     // 1 per pixel, or NULL
    bool has_camera;
    double camera[3][4]; // maps a world point (P, 1) to x·z, y·z and the depth z
    bool is_finite;      // no NaN or infinity in v and r
} RfFlickerFrame;

// Frees the arrays of a frame and clears it.
void rf_destroy_flicker_frame( RfFlickerFrame* frame );

// The reprojection from a frame to the previous one.
typedef struct RfFollow
{
    const RfFlickerFrame* now;
    const RfFlickerFrame* before;
    bool compensate;  // else pixels are compared in place
    double expect[4]; // depth before = z (expect[0] x + expect[1] y + expect[2]) + expect[3]
} RfFollow;

// Prepares the reprojection from `now` to `before`.
RfFollow rf_follow( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate );

// Flicker: the change of the error from one frame to the next.
//
// With e_t = v_t − r_t the error of frame t, over pixels and channels:
//   F1 = sqrt( mean (e_t − e_{t−1})² )
//   φ  = F1² / ( mean e_t² + mean e_{t−1}² )
// Since (a − b)² = a² + b² − 2ab, φ is 1 minus the correlation of the two errors if
// they have the same magnitude: 1 for noise independent in each frame, 0 for a static
// error, 2 for an error that changes sign every frame. Scaling the error scales F1
// and leaves φ unchanged.
//
// With motion compensation, e_{t−1} is the error at the reprojected position in the
// previous frame (RfFollow), in all three means. These are taken over the pixels that
// were visible there; their fraction is the coverage. Bilinear interpolation reduces
// noise between pixels, in the numerator and the denominator of φ alike.
//
// Without a reference, e_t − e_{t−1} is v_t − v_{t−1}. It then includes true changes of
// the image: moving objects if there is no motion layer, moving highlights if there
// is. The mean squares in φ come from the variance layer, if any: E e² is the variance
// of an unbiased estimate. Interpolated, the variance is Σ weight² · variance, which
// assumes independent pixels. Pixels of a tile are correlated, so φ comes out too
// large there.
//
// Over many pairs φ is the quotient of sums, not a mean of quotients. Sums are
// accumulated in double over each row, then over rows and pairs in order.

// Sums over pairs of frames.
typedef struct RfFlickerSums
{
    int pairs;
    double pixels;     // visible in both frames
    double all_pixels; // of the later frame
    double motion;     // Σ lengths of the motion vectors, pixels; NaN: not compensated
    double difference; // Σ (e_t − e_{t−1})², over pixels and channels
    double square;     // Σ e_t² + e_{t−1}²; NaN: unknown
} RfFlickerSums;

// Is there a cut between two frames?
static inline bool rf_is_cut( const RfFlickerFrame* now, const RfFlickerFrame* before )
{
    return strcmp( now->shot, before->shot ) != 0;
}

// The sums of a frame and the previous one, which has the same size; all 0 where there is a cut between them. `has_error`: the
// signals are errors against a reference; else they are the frames themselves, and
// mean squared errors come from the variance layer, if there is one.
RfResult rf_measure_flicker( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate, bool has_error,
                             RfFlickerSums* sums, RfError* error );

// Adds the sums of further pairs.
void rf_add_flicker( RfFlickerSums* sums, const RfFlickerSums* more );

// F1, φ and the rest from the sums.
RfFlickerMetrics rf_flicker_metrics( const RfFlickerSums* sums );

// The temporal spectrum of the error, in bands: how fast the error changes.
//
// The values of a pixel over T consecutive frames, reprojected from the last frame backwards
// if motion compensation is on (RfFollow), are transformed by the orthonormal discrete cosine
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

// Adds a group of 2 to RF_SPECTRUM_FRAMES frames of equal size, in order, unless there is a cut among them.
RfResult rf_add_spectrum_group( RfSpectrumSums* sums, const RfFlickerFrame* const* frames, int count, bool compensate,
                                RfError* error );

// The bands from the sums.
RfSpectrum rf_spectrum( const RfSpectrumSums* sums );

// Finds the pairs of frames at group borders, where a seam would be visible.
//
// Reframe's groups slide by one frame: each frame leaves one group behind and enters another,
// so there is no border in the middle of a path, where every frame is the mean over the same
// number of full groups. Only the frames within 2n of the ends differ, n being the half-width:
// they are in fewer groups, or in clipped ones. A pair is interior if both its frames are in
// full groups only and in as many as the frames in the middle; otherwise it is at a border. A
// path of a single group has no border, nor has a render without reuse.
//
// Other programs use consecutive groups: a pair is at a border if it straddles two of them.

typedef struct RfSeams
{
    int period;  // > 0: consecutive groups of this many frames, one of which starts at `first`
    int first;   // number of the first frame of the path
    bool slides; // sliding groups, by the plan
    RfGroupPlan plan;
} RfSeams;

// True if there are any group borders.
static inline bool rf_has_seams( const RfSeams* seams ) { return seams->period > 0 || seams->slides; }

// True if the pair of this frame and the previous one is at a border.
bool rf_is_seam( const RfSeams* seams, int frame );

// A slit-scan: one column of every frame side by side, with time to the right. A static image
// gives horizontal lines, flicker gives stripes and grain.

typedef struct RfSlitScan
{
    RfImage image;
    int repeat; // columns per frame
    int height; // of a frame
} RfSlitScan;

// Allocates a scan of `frames` frames of `height` pixels, with `parts` of them stacked
// vertically.
RfResult rf_create_slit_scan( int frames, int height, int parts, RfSlitScan* scan, RfError* error );

// Frees the image of a scan.
void rf_destroy_slit_scan( RfSlitScan* scan );

// Copies a column of the image into a frame (from 0) and a part (from 0, at the top).
void rf_add_slit( RfSlitScan* scan, int frame, int part, const RfImage* image, int column );

#endif
