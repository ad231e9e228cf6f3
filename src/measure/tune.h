// Finds the best group and tile for a path within a time budget, by successive halving over trials (trial.h). The first round tries all
// settings on small pieces of the picture at few positions on the path; each later round keeps the best, and path tracing to compare
// them with, and tries them on larger and more pieces at other positions.
//
// Errors are summed over all positions before they are compared: relMSE is dominated by few pixels, and a mean of ratios would have a
// bias that depends on the noise. A row also borrows strength from the trials of the other rows (rf_smooth_tune_rows).
#ifndef REFRAME_MEASURE_TUNE_H
#define REFRAME_MEASURE_TUNE_H

#include "measure/trial_runs.h"

#define RF_TUNE_GROUPS 9
#define RF_TUNE_TILES 7
#define RF_TUNE_ROWS ( RF_TUNE_GROUPS * RF_TUNE_TILES )
#define RF_TUNE_ROUNDS 4

// What a round tries.
typedef struct RfTuneRound
{
    double pixels;  // traced of each frame, in pieces all over the picture
    int regions;    // test regions
    int passes;     // per group
    double seconds; // expected, wall-clock
} RfTuneRound;

// What settings are compared by, at equal CPU time.
typedef enum RfTuneGoal
{
    RF_TUNE_NOISE,   // relMSE
    RF_TUNE_FLICKER, // F1 squared, which falls as relMSE does
} RfTuneGoal;

typedef struct RfTune
{
    RfTrialRow rows[RF_TUNE_ROWS]; // sorted by tile, then by group
    int count;
    RfTuneGoal goal;
    int chosen; // −1: none yet
    RfTuneRound rounds[RF_TUNE_ROUNDS];
    int round_count; // completed
    double seconds;  // spent
    double needed;   // where the deadline came before the first result: seconds that this takes, about
} RfTune;

typedef struct RfTuneJob
{
    RfShot shot;
    const RfRenderSettings* settings; // group and tile are those of the usual row
    double budget;                    // seconds; the first round is completed, but for a deadline
    double deadline;                  // rf_wall_seconds() at which all is stopped, for which settings may be left out; 0: none
    RfTuneGoal goal;
    const RfTrialWatch* watch; // may be NULL; called from several threads
    void ( *report )( void* user, const RfTune* tune, const RfTuneRound* round,
                      int candidates ); // called before each round; may be NULL
    void* user;
} RfTuneJob;

// Tunes. Fails with RF_ERROR_MEMORY if no row fits the memory budget, and with
// RF_ERROR_INTERRUPTED if stopped; the results of completed rounds are valid even then.
RfResult rf_tune( const RfTuneJob* job, RfTune* tune, RfError* error );

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

// Passes of a trial with groups of `eyes` frames in a round of so many: more in small groups, so that frames get about as many
// samples in all trials. Errors fall faster than the samples grow while these are few (src/reuse/estimators.md, section 24).
int rf_tune_passes( int eyes, int passes );

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
