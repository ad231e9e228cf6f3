// A round at work: its sites, then each candidate at each of them, shared out to threads.
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
    RfTestRegion* sites;
    int rows[RF_TUNE_ROWS], row_count; // candidates
    int site_frames;
    int first_place; // number of the first site's place, over all rounds
    int threads, task_count;
    RfRenderSettings settings; // of a trial
    RfTrial* trials;           // by site, then row
    bool* done;                // likewise
    double deadline;           // +inf: none
    RfTrialWatch watch;
    atomic_int next;
    atomic_bool stop;
    pthread_mutex_t mutex; // of the rest
    RfResult result;       // the first failure
    RfError error;
} RfTuneWork;

// `common`: the job's settings, resolved. To be ended.
void rf_begin_tune_work( const RfTuneJob* job, const RfTune* tune, const RfRenderSettings* common, const bool* candidate,
                         const RfTuneRound* round, int first_place, double deadline, RfTuneWork* work );
void rf_end_tune_work( RfTuneWork* work );

// One after the other. Both fail with RF_ERROR_INTERRUPTED at the deadline as well.
RfResult rf_make_tune_regions( RfTuneWork* work, RfError* error );
RfResult rf_run_tune_trials( RfTuneWork* work, RfError* error );

// Adds the trials of the sites at which all rows were tried; returns how many.
int rf_take_tune_trials( const RfTuneWork* work, RfTune* tune );

// CPU seconds that were spent.
double rf_tune_work_seconds( const RfTuneWork* work );

#endif
