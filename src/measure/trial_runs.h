// Runs trials (trial.h) of several settings at several places of the path, for `tune` and `cost`: in parallel with a thread
// each, so that their times are those of the work alone, however small the images are. All settings share the regions, and
// with them the pilot images for relMSE, and the seeds.
#ifndef REFRAME_MEASURE_TRIAL_RUNS_H
#define REFRAME_MEASURE_TRIAL_RUNS_H

#include "measure/trial.h"

#include <stdatomic.h>

// A setting that is tried.
typedef struct RfTrialRow
{
    RfRenderSettings settings; // threads and memory are those of a worker
    int groups, passes;        // as in rf_run_trial
} RfTrialRow;

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
    RfTrial* trials; // by region, then row; NULL: not run yet
    bool* done;      // in the same order
    int row_count;
    // while it runs
    const RfTestSite* sites;
    const RfTrialRow* rows;
    RfTrialWatch stopper; // of the trials: the watch and the deadline
    atomic_bool stop;
} RfTrialRuns;

// Creates regions at `sites` in the place of those of before. The runs must not move until rf_end_trial_runs. Fails with
// RF_ERROR_INTERRUPTED at the deadline.
RfResult rf_make_trial_regions( RfTrialRuns* runs, const RfTestSite* sites, int count, RfError* error );

// Tries all rows at all regions, region by region. Fails with RF_ERROR_INTERRUPTED at the deadline: `done` says which are valid.
RfResult rf_run_trials( RfTrialRuns* runs, const RfTrialRow* rows, int count, RfError* error );

// Was that the deadline, and nobody's wish?
bool rf_is_late( const RfTrialRuns* runs, RfResult result );

// CPU seconds that the regions and trials took.
double rf_trial_runs_seconds( const RfTrialRuns* runs );

// How many trials, `most` at the most, have room for films and records of so many bytes in half of the memory.
int rf_trial_workers( size_t memory, const RfMemoryFit* fit, int most );

// Frees regions and trials.
void rf_end_trial_runs( RfTrialRuns* runs );

#endif
