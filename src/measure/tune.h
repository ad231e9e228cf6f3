// Finds the best group and tile for a path on this machine, within a time budget, by
// successive halving over trials (trial.h). The first round tries all settings on small pieces of the picture
// at few positions on the path; each later round keeps the best, and path tracing to compare them with, and tries them on
// larger and more pieces at other positions.
//
// All settings of a round use the same positions, the same pilot images for relMSE and the
// same seeds. Errors are summed over all positions before they are compared: relMSE is
// dominated by few pixels, and a mean of ratios would have a bias that depends on the noise. A
// row also borrows strength from the trials of the other rows (rf_smooth_tune_rows).
#ifndef REFRAME_MEASURE_TUNE_H
#define REFRAME_MEASURE_TUNE_H

#include "measure/trial_runs.h"

#define RF_TUNE_GROUPS 9
#define RF_TUNE_TILES 5
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
    RF_TUNE_FLICKER, // F1 squared, which falls as 1 / samples, too
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
    const RfRenderSettings* settings; // the group is ignored, the tile is that of the usual row
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

#endif
