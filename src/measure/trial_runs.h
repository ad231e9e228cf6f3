// What `tune` and `cost` share: a row of their tables, and trials (trial.h) of several settings at several places of the path, in
// parallel with a thread each, so that their times are those of the work alone, however small the images are. All settings share
// the regions, and with them the pilot images for relMSE, and the seeds.
#ifndef REFRAME_MEASURE_TRIAL_RUNS_H
#define REFRAME_MEASURE_TRIAL_RUNS_H

#include "measure/trial.h"

#include <stdatomic.h>

// How errors fall with the samples (estimators.md, E28): what trials with several sample counts say of any other.
typedef struct RfErrorLine
{
    double samples;      // with which the error is known best
    RfInterval error;    // relMSE with so many
    RfInterval exponent; // it falls as the samples to the power of -exponent
} RfErrorLine;

typedef struct RfErrorPoint
{
    double samples, error;
    double weight; // 1: a trial of the fewest samples
} RfErrorPoint;

// The line through points, whose exponent is drawn towards that of most scenes. `margin` is that of the logarithm of all errors
// alike, by the places that were tried. Points without an error are left out; NaN where there is no other.
RfErrorLine rf_fit_error_line( const RfErrorPoint* points, int count, double margin );

// The line through one error, with the exponent of most scenes.
RfErrorLine rf_usual_line( double samples, RfInterval error );

// The error with so many samples, and the samples that an error takes, with 95 % intervals.
RfInterval rf_line_error( const RfErrorLine* line, double samples );
RfInterval rf_line_samples( const RfErrorLine* line, double error );

// A row: a setting, what a render with it takes, and what its trials say. NaN: not known.
typedef struct RfTrialRow
{
    int group; // half-width n, clipped to the path
    int eyes;  // in a full group
    RfTile tile;
    int spp;                    // as rendered
    RfMemoryFit fit;            // of the render; only `least` is set if it does not fit. Of cost only `threads`
    double samples;             // own-frame samples of the frames predicted for, over all sweeps
    double predicted_gain;      // as in plan.h, relative to the same tile without frame reuse
    double cost;                // of an own-frame sample, with fixed costs
    const char* excluded;       // why it is not tried; NULL: it is, as far as the time goes
    bool usual;                 // what a render takes by itself: of the job's tile the group of RF_GROUP_AUTO
    int rounds;                 // in which it was tried
    RfTrial trial;              // sum over those rounds
    double log_error, log_time; // corrections by the other rows, added to the logarithms of the trial's error and time
    // predictions
    double cpu_seconds, seconds; // of all frames predicted for: all of a render in tune, one in cost
    double relmse, f1, phi;      // of a frame with `spp` samples
    double efficiency;           // 1 / (relMSE · CPU seconds of a frame), or with F1 squared in the place of relMSE; before
                                 // the first round a guess
    RfInterval error;            // relMSE with its 95 % interval
    RfInterval gain;             // efficiency relative to path tracing (group 0, tile 1), measured on the same pieces
    bool chosen;
} RfTrialRow;

// Predicts time and error of `frames` frames of `pixels` pixels from the trials of a row, whose errors count `factor` times, by
// rf_usual_line; NaN where there are none.
void rf_predict_trial_row( RfTrialRow* row, double pixels, int frames, double factor );

// What is tried for a row.
typedef struct RfTrialTask
{
    RfRenderSettings settings; // threads and memory are those of a worker
    int groups, passes;        // as in rf_run_trial
} RfTrialTask;

// The settings without what ends a render early and without a clamp.
RfRenderSettings rf_trial_settings( const RfRenderSettings* settings );

typedef struct RfTrialRuns
{
    RfShot shot;
    const RfTrialWatch* watch; // the caller's, or NULL
    double deadline;           // rf_wall_seconds(); 0: none
    int workers;
    RfRenderSettings pilot; // of the regions, for a worker
    int first;              // the first region is the so many-th of all: other ones have other pieces and seeds
    // what is held
    RfTestRegion* regions;
    int region_count;
    RfTrial* trials; // by region, then task; NULL: not run yet
    bool* done;      // in the same order
    int task_count;
    // while it runs
    const RfTestSite* sites;
    const RfTrialTask* tasks;
    RfTrialWatch stopper; // of the trials: the watch and the deadline
    atomic_bool stop;
} RfTrialRuns;

// Creates regions at `sites` in the place of those of before. The runs must not move until rf_end_trial_runs. Fails with
// RF_ERROR_INTERRUPTED at the deadline.
RfResult rf_make_trial_regions( RfTrialRuns* runs, const RfTestSite* sites, int count, RfError* error );

// Does all tasks at all regions, region by region. Fails with RF_ERROR_INTERRUPTED at the deadline: `done` says which are valid.
RfResult rf_run_trials( RfTrialRuns* runs, const RfTrialTask* tasks, int count, RfError* error );

// Was that the deadline, and nobody's wish?
bool rf_is_late( const RfTrialRuns* runs, RfResult result );

// CPU seconds that the regions and trials took.
double rf_trial_runs_seconds( const RfTrialRuns* runs );

// How many trials, `most` at the most, have room for films and records of so many bytes in half of the memory.
int rf_trial_workers( size_t memory, const RfMemoryFit* fit, int most );

// Frees regions and trials.
void rf_end_trial_runs( RfTrialRuns* runs );

#endif
