// Shared by the files of the tuning.
#ifndef REFRAME_MEASURE_TUNE_INTERNAL_H
#define REFRAME_MEASURE_TUNE_INTERNAL_H

#include "measure/tune.h"

// The settings of a row, from those of the job.
RfRenderSettings rf_tune_settings( const RfTuneRow* row, const RfRenderSettings* common );

// All rows of the path, with memory and costs; `common` is the job's settings,
// resolved but for the group. Fails where none can be tried.
RfResult rf_list_tune_rows( const RfTuneJob* job, RfTune* tune, RfRenderSettings* common, RfError* error );

// Sets log_error and log_time from what the rows' trials have in common.
void rf_smooth_tune_rows( RfTune* tune );

// What the trials say of the render.
void rf_weight_tune_rows( RfTune* tune, double pixels, int frames );

// Threads that trials may run on beside each other, so that half of the memory of
// each is left for films.
int rf_tune_workers( const RfTuneJob* job, const RfTune* tune, const RfRenderSettings* common );

// Windows beside each other that a site tries with groups of so many frames: small
// groups would see too little else.
int rf_tune_groups( int eyes );

// Frames of a site that has room for all of the rows.
int rf_tune_region_frames( const RfTune* tune, const bool* candidate );

// Native samples that trying a row takes for each pixel of the film.
double rf_tune_row_samples( const RfTuneRow* row, int passes );

// What is known before a round.
typedef struct RfTuneOutlook
{
    int number;         // of the round, from 0
    int width, height;  // of the render
    double left;        // seconds on the wall
    double rate;        // CPU seconds done in each of them
    double cost_second; // RfTuneRow.cost units to seconds, for rows without a trial
    size_t memory;      // bytes for all trials that run at the same time
    int workers;
} RfTuneOutlook;

// The next round for the candidates: its share of the time left goes to larger
// pictures and, when they are as large as the render's, to more places. False:
// there is not time enough for pictures that tell anything; the first round is
// always made.
bool rf_plan_tune_round( const RfTune* tune, const bool* candidate, const RfTuneOutlook* outlook, RfTuneRound* round );

// CPU seconds of a round, expected.
double rf_tune_round_cost( const RfTune* tune, const bool* candidate, const RfTuneRound* round, double cost_second );

// Strikes out all but the best `kept`, and of them those without hope. What has no
// efficiency goes as well.
void rf_cut_tune_candidates( const RfTune* tune, int kept, bool* candidate );

// The `index`-th place, 0 to 1, spread ever more densely and evenly.
double rf_tune_place( int index );

#endif
