// The work of a round: creates its test regions, then runs each candidate at each of them,
// distributed over threads.
#ifndef REFRAME_MEASURE_TUNE_WORK_H
#define REFRAME_MEASURE_TUNE_WORK_H

#include "measure/tune.h"

#include <pthread.h>
#include <stdatomic.h>

typedef struct RfTuneWork
{
    const RfTuneJob* job;
    const RfTune* tune;
    const RfTuneRound* round;
    RfTestRegion* regions;
    int rows[RF_TUNE_ROWS], row_count; // candidates
    int region_frames;
    int first_position; // index of the first region's position, over all rounds
    int threads, task_count;
    RfRenderSettings settings; // for a trial
    RfTrial* trials;           // by region, then row
    bool* done;                // same order
    double deadline;           // +inf: none
    RfTrialWatch watch;
    atomic_int next;
    atomic_bool stop;
    pthread_mutex_t mutex; // protects the fields below
    RfResult result;       // the first failure
    RfError error;
} RfTuneWork;

// Starts a round. `common` is the job's settings, resolved. Call rf_end_tune_work afterwards.
void rf_begin_tune_work( const RfTuneJob* job, const RfTune* tune, const RfRenderSettings* common, const bool* candidate,
                         const RfTuneRound* round, int first_position, double deadline, RfTuneWork* work );

// Frees what the round holds.
void rf_end_tune_work( RfTuneWork* work );

// Creates the test regions. Fails with RF_ERROR_INTERRUPTED at the deadline.
RfResult rf_make_tune_regions( RfTuneWork* work, RfError* error );

// Runs the trials. Fails with RF_ERROR_INTERRUPTED at the deadline.
RfResult rf_run_tune_trials( RfTuneWork* work, RfError* error );

// Adds the trials of the regions at which all rows were tried; returns the number of these
// regions.
int rf_take_tune_trials( const RfTuneWork* work, RfTune* tune );

// CPU seconds spent so far.
double rf_tune_work_seconds( const RfTuneWork* work );

#endif
