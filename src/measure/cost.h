// Measures what accuracy costs in time: a few frames of the path are rendered with increasing sample counts, by path tracing and with
// reuse, and their errors are measured without a reference (trial.h). A line through their logarithms (RfErrorLine) predicts the
// seconds to any error; their spread gives the confidence interval. Path tracing is tried with about the samples that the least error
// wanted takes, on fewer frames, as far as the budget goes.
#ifndef REFRAME_MEASURE_COST_H
#define REFRAME_MEASURE_COST_H

#include "measure/trial_runs.h"
#include "reframe/denoise.h"

#define RF_COST_LEVELS 12
#define RF_COST_POSITIONS 3
#define RF_COST_CLAMPS 4

typedef struct RfCostCurve
{
    int group; // half-width n, clipped to the path
    int eyes;  // in a full group
    RfTile tile;
    RfTrialRow rows[RF_COST_LEVELS]; // by sample count: trials at all positions, of a frame of the requested size
    int count;
    RfErrorLine line;
    double f1_squared;     // of a pair of frames with line.samples each; NaN: no pixel was measured in two frames
    double sample_seconds; // CPU seconds of an own-frame sample, by the threads of the render
    double finish_seconds; // the same for finishing a frame
    double time_margin;    // 95 %, of the logarithm of sample_seconds
    double alone; // sample_seconds in the frames asked for, over those in the whole path: hits land in fewer frames; 0: as there
} RfCostCurve;

// A clamp with reuse: relMSE = that of the line + bias, at the seconds of the curve without one.
typedef struct RfCostClamp
{
    double threshold;
    RfErrorLine line; // of the variance, as relMSE; its exponent is that of the curve
    double bias;      // squared, as relMSE
    double missing;   // share of the light, 0 to 1
} RfCostClamp;

typedef struct RfCost
{
    RfCostCurve plain, reuse;
    RfCostClamp clamps[RF_COST_CLAMPS]; // that of job->relmse, and some beside it
    int clamp_count;                    // 0 where the estimator has none, or caustics are left out
    RfInterval gain;                    // of the errors of all samples tried: CPU seconds of path tracing over those with reuse
    double pixels;                      // traced of each test frame
    int positions;
    double seconds; // spent measuring
    double needed;  // seconds that the first round takes, about
} RfCost;

typedef struct RfCostJob
{
    RfShot shot;
    const RfRenderSettings* settings; // with reuse; spp is ignored
    double budget;                    // seconds; the first round is completed, but for a deadline
    double deadline;                  // rf_wall_seconds() at which all is stopped; 0: none
    double relmse;                    // for which --clamp auto looks for a threshold; 0: no clamps are tried
    double least;                     // relMSE wanted: path tracing is tried with about as many samples; 0: none
    const RfTrialWatch* watch;        // may be NULL
    void ( *report )( void* user, const RfCost* cost, int spp ); // called before each round; may be NULL
    void* user;
} RfCostJob;

// Measures both curves. Of the settings the clamp is not looked at. Fails with RF_ERROR_INTERRUPTED if stopped, RF_ERROR_USAGE if the
// settings do not reuse anything, RF_ERROR_SCENE if the deadline came before the first result.
RfResult rf_measure_cost( const RfCostJob* job, RfCost* cost, RfError* error );

// What reaching an error takes: samples per pixel as rendered (at least two), seconds for a
// frame in the middle of the path, and seconds for all requested frames including the ends of
// the path, in sweeps of `per_sweep` frames.
typedef struct RfCostPrediction
{
    int spp; // 0: more than a render can have
    double frame_seconds, seconds;
    double low, high; // frame_seconds, 95 %; NaN where samples were asked for
    int tried;        // the most samples that were tried, where spp is over four times as many; else 0
} RfCostPrediction;

// Predicts the cost of reaching `relmse` from a measured curve, that of so many samples, and that of F1 = `flicker`.
RfCostPrediction rf_predict_cost( const RfCostJob* job, const RfCostCurve* curve, double relmse, int per_sweep );
RfCostPrediction rf_predict_samples( const RfCostJob* job, const RfCostCurve* curve, double wanted, int per_sweep );
RfCostPrediction rf_predict_flicker_cost( const RfCostJob* job, const RfCostCurve* curve, double flicker, int per_sweep );

// Denoised pictures, by one sample count of a curve: three windows of frames spread over the path, as many pixels as the budget allows.
typedef struct RfDenoisedCost
{
    int spp;               // 0: not measured
    RfErrorEstimate error; // of the denoised windows, bias included
    double exponent;       // it falls as the samples to the power of -exponent, by the denoised halves
    double seconds;        // of the denoiser, for a frame, by the threads of the render
    double pixels;         // of all windows
    double needed;         // seconds that it takes at least, where it is not measured
} RfDenoisedCost;

// Fails with RF_ERROR_INTERRUPTED if stopped, and as rf_render and rf_denoise do. Windows that do not fit into the budget are not
// measured.
RfResult rf_measure_denoised_cost( const RfCostJob* job, const RfCostCurve* curve, RfDenoiser* denoiser, double budget,
                                   RfDenoisedCost* cost, RfError* error );

// As rf_predict_cost, with the time of the denoiser.
RfCostPrediction rf_predict_denoised_cost( const RfCostJob* job, const RfCostCurve* curve, const RfDenoisedCost* cost,
                                           double relmse, int per_sweep );

// The same with that clamp which needs the fewest samples for `relmse`; *clamp is NULL where none reaches it with fewer than
// the exact picture.
RfCostPrediction rf_predict_clamped_cost( const RfCostJob* job, const RfCost* cost, double relmse, int per_sweep,
                                          const RfCostClamp** clamp );

// CPU seconds of path tracing over those with reuse, of the frames asked for, with as many samples as this relMSE takes, and parts
// of them.
RfInterval rf_cost_speedup( const RfCostJob* job, const RfCost* cost, double relmse, const int per_sweep[2] );

// The clamp with the least relMSE for so many samples, which is set; NULL: there is none that takes out light.
const RfCostClamp* rf_best_clamp( const RfCost* cost, double spp, double* relmse );

#endif
