// A trial measures the cost and error of a group and a tile from a few passes of a few frames, without a reference, on pieces of the
// picture (trial_pieces.h) in the resolution of the render: on a smaller picture reuse is worth another amount.
//
// A segment of 2n+1 frames of the path is rendered as a single group. A frame of a long path is the mean over the 2n+1 groups that
// contain it, in each of which it has a different position. So the error averaged over the positions within one group, v with P passes,
// predicts the frame in the middle of a long path: v·P/S with S own-frame samples per pixel, at the same cost per sample. Errors fall a
// little faster than that, by (E28) of src/reuse/estimators.md (RfErrorLine). RfPlanRow.samples has the extra
// cost of the ends of the path, of several sweeps and of a selection of frames.
//
// The group is rendered twice with independent seeds. The variance of the difference d is twice that of the error, whatever tiles and
// frames share (the two halves of one film share c of (E2)). F1 and φ come from d as well: the signal cancels, so no motion compensation
// is needed. Bias is not measured: exact weights have none.
//
// relMSE divides by the image. Dividing by each noisy render itself would overweight dark pixels and underweight fireflies. All settings
// therefore use the brightness (E23) of the same pilot image of the test region, which is independent of them.
//
// With a clamp (src/reuse/estimators.md, E15) one render has both pictures: the clamped one, and with what was removed the
// exact one. All figures are of the exact picture, but those that say otherwise. The error of the clamped one is its variance,
// from the difference of the two renders, and its squared bias, of which the product of what both have lost is an unbiased
// estimate.
#ifndef REFRAME_MEASURE_TRIAL_H
#define REFRAME_MEASURE_TRIAL_H

#include "measure/image_error.h"
#include "measure/trial_pieces.h"
#include "scene/eye.h"

// Return false to stop with RF_ERROR_INTERRUPTED.
typedef bool RfTrialContinueFn( void* user );

typedef struct RfTrialWatch
{
    RfTrialContinueFn* should_continue; // may be NULL; called often, from the thread that runs the trial
    void* user;
} RfTrialWatch;

// A segment of the path with the pieces of its frames in which settings are tried.
typedef struct RfTestRegion
{
    RfShot shot;               // its frames are not looked at
    const RfTrialWatch* watch; // or NULL
    const RfEye* eyes;         // `frames` of them, of the path
    int first;                 // first frame on the path, from 0
    int frames;
    bool whole;   // the region is the whole path
    RfEye* crops; // of an estimator that renders no pieces: the cameras are these windows (rf_choose_crops); NULL: the path's
    RfTestPieces pieces;
    float* weight;  // relMSE weight 1 / (b² + 0.001) of each pixel of the pilot image, b its brightness, slot after slot
    double seconds; // CPU seconds spent on the pilot image
    double samples; // own-frame samples traced for it
} RfTestRegion;

// Where on the path a region is, and how large.
typedef struct RfTestSite
{
    int centre, frames; // up to so many frames around the frame `centre`
    double pixels;      // traced of each, about
} RfTestSite;

// Creates a test region and renders its pilot image with the threads, memory, seed, depth and light samples of `settings`. Of
// the shot its frames are not looked at; `watch` may be NULL. Free with rf_destroy_test_region, also after a failure; what shot
// and watch point to must live as long.
RfResult rf_create_test_region( const RfShot* shot, const RfTrialWatch* watch, const RfTestSite* site,
                                const RfRenderSettings* settings, RfTestRegion* region, RfError* error );

// Pixels traced in a region of one frame, all windows together.
static inline double rf_region_pixels( const RfTestRegion* region )
{
    return region->pieces.pixels * ( region->crops != NULL ? region->frames : 1 );
}

void rf_destroy_test_region( RfTestRegion* region );

#define RF_TRIAL_PIECES 512
#define RF_WORST_CELLS 10

// The error found in a piece, over all frames.
typedef struct RfPieceError
{
    double weight;  // pixels
    double relmse;  // summed, as in RfTrial
    double clamped; // likewise
} RfPieceError;

// What a clamp does, as sums over the pixels.
typedef struct RfClampSums
{
    double relmse;         // of a single pass of the clamped picture, without its bias
    double bias;           // squared, weighted as relMSE, which does not fall with the passes
    double removed, light; // of both renders, all channels
    double threshold;      // of the clamp, times `frames`
    double frames;
} RfClampSums;

// The result of trials, as sums that rf_add_trial can combine. Errors are those of a single
// pass (P times the error of P passes), multiplied by `weight`.
typedef struct RfTrial
{
    int groups;                           // rendered, each twice
    double weight;                        // number of pixels measured
    double log_passes;                    // logarithm of the passes, times weight
    double samples;                       // own-frame samples traced
    double timed_samples;                 // those within the next time, which excludes set-up
    double cpu_seconds;                   // of all threads
    double finish_seconds, finish_pixels; // CPU seconds for finishing frames, and their pixels
    double relmse;                        // from the two renders
    double change_weight;                 // like weight, of trials that have pixels measured in consecutive frames
    double change;                        // ½ F1² (relative) of consecutive frames of a long path
    double time_noise;                    // squared differences of the logarithms of the two renders' seconds per sample
    int time_count;                       // of these
    double worst[RF_WORST_CELLS];         // of relmse: what the cells of 4×4 pixels with the most hold, in falling order
    RfClampSums clamp;                    // zero without one
    int piece_count;                      // the first RF_TRIAL_PIECES are listed
    RfPieceError pieces[RF_TRIAL_PIECES];
} RfTrial;

// Tries `settings` (group, tile) with `passes` ≥ 2 passes per group on up to `groups`
// adjacent groups in the middle of the region; fails with RF_ERROR_USAGE if not even one fits.
// With settings->threads 1, CPU seconds are those of the calling thread, so trials may run in
// parallel; otherwise those of the process, which may include threads that wait for others.
// The seeds of both renders of a group derive from settings->seed.
RfResult rf_run_trial( const RfTestRegion* region, int groups, int passes, const RfRenderSettings* settings, RfTrial* trial,
                       RfError* error );

// Adds the error of a cell to the list of the worst ones, if it is among them.
void rf_keep_worst_cell( double worst[RF_WORST_CELLS], double relmse );

// Adds the sums of another trial, and lists its pieces behind those of `sum`.
void rf_add_trial( RfTrial* sum, const RfTrial* trial );

// Adds a trial whose errors count `weight` times; its pieces are those of `sum` from number `first` on.
void rf_add_weighed_trial( RfTrial* sum, const RfTrial* trial, double weight, int first );

// How many times less CPU time `reuse` takes than `plain` for the same error, with a 95 % interval from the scatter
// between pieces (a jackknife) and of the times, and from how much of the errors the worst cells hold. Both were tried in the same regions, one of them perhaps in more: what
// they have in common counts. NaN if they have nothing.
RfInterval rf_trial_gain( const RfTrial* plain, const RfTrial* reuse );

// relMSE of a single sample with such an interval, in which the times have no part.
RfInterval rf_trial_error( const RfTrial* trial );

// The same of the clamped picture, without its bias.
RfInterval rf_trial_clamped_error( const RfTrial* trial );

// relMSE of a frame in the middle of a long path with `spp` own-frame samples per pixel.
double rf_trial_relmse( const RfTrial* trial, double spp );

// Passes with which the errors were found: the geometric mean.
double rf_trial_passes( const RfTrial* trial );

// Relative F1 of such a frame.
double rf_trial_f1( const RfTrial* trial, double spp );

// φ, which does not depend on the samples.
double rf_trial_phi( const RfTrial* trial );

// CPU seconds per own-frame sample.
double rf_trial_sample_seconds( const RfTrial* trial );

// Half the 95 % interval of its logarithm, from what the two renders of each group differ by.
double rf_trial_time_margin( const RfTrial* trial );

// Bytes held by a test region of `frames` frames of `pixels` pixels each, and by a trial with groups of `eyes` frames, of
// each of which `pixels` pixels are measured. The memory of rf_render is not included.
size_t rf_test_region_bytes( int frames, size_t pixels );
size_t rf_trial_bytes( int eyes, size_t pixels );

#endif
