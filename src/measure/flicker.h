// Flicker: of pairs of frames, along the motion, as a spectrum, at the borders of groups, as a picture.
#ifndef REFRAME_MEASURE_FLICKER_H
#define REFRAME_MEASURE_FLICKER_H

#include "reframe/image.h"
#include "reframe/measure.h"
#include "render/groups.h"

#include <string.h>

// Backward reprojection: where the surface seen in a pixel was in the previous frame, and whether it was visible there.
//
// A point at (x, y), in pixels from the centre of the first pixel of the data window with +y down, was at (x + motion.X,
// y − motion.Y) in the previous frame (the layer has +y up). Motion, depth and colour are interpolated bilinearly. It was visible if
// the depth found there is within 2 % of its expected depth, or if both show no surface. With the attribute worldToNDC in both
// frames the expected depth is that of a point of a static scene seen by both cameras; otherwise the depth is taken as unchanged.
// Points outside the frame, or with undefined motion or depth, were not visible.

// A frame as input to the flicker measures.
typedef struct RfFlickerFrame
{
    int number;
    char shot[32];    // of its path; empty where that has no cuts, or another program wrote it
    RfImage signal;   // e = v − r with a reference, else the image v
    RfImage variance; // of v; rgb NULL: unknown
    double* below;    // brightness² + ε of r, or of v (E23), 1 per pixel; NULL: 1
    float* motion;    // 2 per pixel, or NULL
    float* depth;     // 1 per pixel, or NULL
    bool has_camera;
    double camera[3][4]; // maps a world point (P, 1) to x·z, y·z and the depth z
    bool is_finite;      // no NaN or infinity in v and r
} RfFlickerFrame;

void rf_destroy_flicker_frame( RfFlickerFrame* frame );

// What the errors of a frame are relative to: the brightness of this picture; nothing where the frame is not finite. Fails with
// RF_ERROR_MEMORY.
RfResult rf_take_brightness( RfFlickerFrame* frame, const RfImage* picture, RfError* error );

// The reprojection from a frame to the previous one.
typedef struct RfFollow
{
    const RfFlickerFrame* now;
    const RfFlickerFrame* before;
    bool compensate;  // else pixels are compared in place
    double expect[4]; // depth before = z (expect[0] x + expect[1] y + expect[2]) + expect[3]
} RfFollow;

RfFollow rf_follow( const RfFlickerFrame* now, const RfFlickerFrame* before, bool compensate );

// Flicker: the change of the error from one frame to the next. measure/README.md defines F1 and φ: since (a − b)² = a² + b² − 2ab, φ
// is 1 minus the correlation of two errors of the same magnitude.
//
// With motion compensation e_{t−1} is taken at the reprojected position in the previous frame (RfFollow), in all three means, over the
// pixels that were visible there; their fraction is the coverage. Bilinear interpolation reduces noise between pixels, in the
// numerator and the denominator of φ alike.
//
// Without a reference e_t − e_{t−1} is v_t − v_{t−1}, with true changes of the image: moving objects if there is no motion layer,
// moving highlights if there is. The mean squares in φ come from the variance layer, if any: E e² is the variance of an unbiased
// estimate. Interpolated, it is Σ weight² · variance, which assumes independent pixels: too small in tiles, where φ comes out too large.
//
// The relative F1 divides (e_t − e_{t−1})² by the mean over both frames of brightness² + ε, the denominator of relMSE (E23): its unit
// is that of percent noise, and dark rooms count as much as bright ones.
//
// Over many pairs φ is the quotient of sums. Sums are accumulated in double over each row, then over rows and pairs in order.

// Sums over pairs of frames.
typedef struct RfFlickerSums
{
    int pairs;
    double pixels;     // visible in both frames
    double all_pixels; // of the later frame
    double motion;     // Σ lengths of the motion vectors, pixels; NaN: not compensated
    double difference; // Σ (e_t − e_{t−1})², over pixels and channels
    double relative;   // the same, over the mean of `below` of both frames
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

void rf_add_flicker( RfFlickerSums* sums, const RfFlickerSums* more );

// F1, φ and the rest from the sums.
RfFlickerMetrics rf_flicker_metrics( const RfFlickerSums* sums );

// The temporal spectrum of the error, in bands: how fast the error changes.
//
// The values of a pixel over T consecutive frames, reprojected from the last frame backwards if motion compensation is on (RfFollow),
// are transformed by the orthonormal discrete cosine transform of type II (Ahmed, Natarajan, Rao 1974):
//   X_k = s_k Σ_t e_t cos( π (2t + 1) k / 2T ),  s_0² = 1/T, else 2/T,
// with frequency k / 2T cycles per frame. Σ_k X_k² = Σ_t e_t², so the bands sum to the mean square. The transform extends the signal
// by reflection, so that a slow drift, whose ends differ, stays in the low band; in a Fourier transform without a window it would leak.
//   frozen   k = 0: static error; without a reference the image itself
//   drift    up to 2 Hz, by the frame rate: 1/12 cycle per frame at 24
//   boiling  above: changes from frame to frame
// White noise of 16 frames at 24 a second has 1/16 of its mean square in frozen, 2/16 in drift, 13/16 in boiling. A group of 16 frames
// starts every 8 frames, and one ends with the last frame; a shorter sequence is a single group. With less than a quarter of a second,
// drift cannot be told (NaN).

#define RF_SPECTRUM_FRAMES 16
#define RF_SPECTRUM_STEP 8
#define RF_DRIFT_HERTZ 2.0 // upper end of the slow band

// Sums over groups.
typedef struct RfSpectrumSums
{
    int groups;
    double pixels; // visible in all frames of the group
    double all_pixels;
    double frozen, drift, boiling; // of X_k² / T, over the mean of `below`, over pixels and channels
} RfSpectrumSums;

// Root mean squares, relative to the brightness; NaN if nothing was visible or a frame has NaN or
// infinite pixels.
typedef struct RfSpectrum
{
    double frozen, drift, boiling;
    double coverage;
} RfSpectrum;

// True if a group ends with the frame of this index (from 0) out of `count`.
bool rf_ends_group( int index, int count );

// Adds a group of 2 to RF_SPECTRUM_FRAMES frames of equal size, in order, unless there is a cut among them. `split`: upper end of the
// slow band, cycles per frame.
RfResult rf_add_spectrum_group( RfSpectrumSums* sums, const RfFlickerFrame* const* frames, int count, double split,
                                bool compensate, RfError* error );

// The bands from the sums.
RfSpectrum rf_spectrum( const RfSpectrumSums* sums );

// Finds the pairs of frames at group borders, where a seam would be visible.
//
// Reframe's groups slide by one frame: only the frames within 2n of the ends of a path, n being the half-width, are in fewer groups
// than the others, or in clipped ones. A pair is at a border if one of its frames is. A path of a single group has no border, nor has
// a render without reuse. Other programs use consecutive groups: a pair is at a border if it straddles two of them.

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

// A slit-scan: one column of every frame side by side, with time to the right.

typedef struct RfSlitScan
{
    RfImage image;
    int repeat; // columns per frame
    int height; // of a frame
} RfSlitScan;

// A scan of `frames` frames of `height` pixels, with `parts` of them stacked vertically.
RfResult rf_create_slit_scan( int frames, int height, int parts, RfSlitScan* scan, RfError* error );

void rf_destroy_slit_scan( RfSlitScan* scan );

// Copies a column of the image into a frame (from 0) and a part (from 0, at the top).
void rf_add_slit( RfSlitScan* scan, int frame, int part, const RfImage* image, int column );

#endif
