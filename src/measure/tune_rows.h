// Internal to tune: its rows and its rounds.
#ifndef REFRAME_MEASURE_TUNE_ROWS_H
#define REFRAME_MEASURE_TUNE_ROWS_H

#include "measure/tune.h"

// Is the row path tracing, with which all are compared?
bool rf_is_plain_row( const RfTrialRow* row );

// The settings of a row, based on the job's.
RfRenderSettings rf_tune_settings( const RfTrialRow* row, const RfRenderSettings* common );

// Lists all rows for the path with their memory and costs. `common` receives the job's
// settings, resolved except for the group. Fails if no row can be tried.
RfResult rf_list_tune_rows( const RfTuneJob* job, RfTune* tune, RfRenderSettings* common, RfError* error );

// Sets log_error and log_time of each row from a fit over all rows.
void rf_smooth_tune_rows( RfTune* tune );

// Extrapolates the trials to the requested render.
void rf_predict_tune_rows( RfTune* tune, double pixels, int frames );

// How many trials may run in parallel so that half of the memory of each is left for films.
int rf_tune_workers( const RfTuneJob* job, const RfTune* tune, const RfRenderSettings* common );

// Passes of a trial with groups of `eyes` frames in a round of so many: more in small groups, so that frames get about as many
// samples in all trials. Errors fall faster than the samples grow while these are few (src/reuse/estimators.md, section 24).
int rf_tune_passes( int eyes, int passes );

// Frames that a test region has: it holds the groups of all candidates.
int rf_tune_region_frames( const RfTune* tune, const bool* candidate );

// Own-frame samples per pixel traced that a trial of the row takes.
double rf_tune_row_samples( const RfTrialRow* row, int passes );

// What is known before a round.
typedef struct RfTuneOutlook
{
    int number;         // of the round, from 0
    int width, height;  // of the requested render
    double left;        // wall-clock seconds
    double rate;        // CPU seconds per wall-clock second
    double cost_second; // seconds per unit of RfTrialRow.cost, for rows without a trial
    size_t memory;      // bytes, for all trials that run in parallel
    int workers;
    int passes; // at the least, of each trial
    bool must;  // the round is planned even where the time is too short
} RfTuneOutlook;

// Plans the next round: its share of the remaining time goes to larger and more pieces and, once they
// make up the whole picture, to more positions. Returns false if too little time is left for
// pieces large enough to be meaningful.
bool rf_plan_tune_round( const RfTune* tune, const bool* candidate, const RfTuneOutlook* outlook, RfTuneRound* round );

// Expected CPU seconds of a round.
double rf_tune_round_cost( const RfTune* tune, const bool* candidate, const RfTuneRound* round, double cost_second );

// Keeps the best `kept` ≥ 0 candidates that still have a chance to win, path tracing and the usual row; drops candidates without
// an efficiency.
void rf_cut_tune_candidates( const RfTune* tune, int kept, bool* candidate );

// The `index`-th position on the path, 0 to 1, of an evenly spread sequence.
double rf_tune_position( int index );

#endif
