// Which group and tile pay here: each is tried on this path, on this machine,
// within a time budget (trial.h), by successive halving. The first round tries
// all of them on small pictures at few places of the path; each later one keeps
// the better part, and tries these on larger pictures, at other places.
//
// All settings of a round are tried at the same places, weighed by the same
// pictures, and with the same seeds; the errors are summed up over all of them
// before they are compared, for relMSE is carried by few pixels, and a mean of
// quotients would have a bias that depends on the noise. What the trials of other
// rows say of a row is made use of too (tune_smooth.c).
//
// Trials run side by side, one thread each: so their times are those of the work
// alone, however small the pictures are.
#ifndef REFRAME_MEASURE_TUNE_H
#define REFRAME_MEASURE_TUNE_H

#include "measure/trial.h"

#define RF_TUNE_GROUPS 9
#define RF_TUNE_TILES 5
#define RF_TUNE_ROWS ( RF_TUNE_GROUPS * RF_TUNE_TILES )
#define RF_TUNE_ROUNDS 4

// What a round tries, and how.
typedef struct RfTuneRound
{
    int width, height; // of the pictures
    int sites;         // places of the path
    int passes;        // of a window
    double seconds;    // expected, of the clock on the wall
} RfTuneRound;

typedef struct RfTuneRow
{
    int group; // half-width n, cut to the path
    int eyes;  // in a full group
    RfTile tile;
    int spp;                    // as rendered
    RfMemoryFit fit;            // of the render as asked for; `least` alone where it does not fit
    double samples;             // native ones of the frames asked for, all sweeps
    double predicted_gain;      // by fixed costs, as of plan.h, against the same tile without frame reuse
    double cost;                // of a native sample, by fixed costs
    const char* excluded;       // why it is not tried; NULL: it is
    int rounds;                 // that it was tried in
    RfTrial trial;              // sums of all of them
    double log_error, log_time; // what other rows say: to be added to the logarithms of the trial's
    // of the render as asked for; NaN where not tried
    double cpu_seconds, seconds; // of all frames
    double relmse, f1, phi;      // of a frame with `spp` samples
    double efficiency;           // 1 / (relMSE · CPU seconds of a frame)
    double gain;                 // efficiency over that of path tracing, group 0 and tile 1; NaN without that
    bool chosen;
} RfTuneRow;

typedef struct RfTune
{
    RfTuneRow rows[RF_TUNE_ROWS]; // by tile, then by group
    int count;
    int chosen; // −1: none yet
    RfTuneRound rounds[RF_TUNE_ROUNDS];
    int round_count; // that are complete
    double seconds;  // that it took
} RfTune;

typedef struct RfTuneJob
{
    const RfTracer* tracer;
    const RfEye* eyes; // of the whole path
    int eye_count;
    const int* frames; // asked for
    int frame_count;
    const RfRenderSettings* settings; // group and tile do not matter
    double budget;                    // seconds; the first round is always made
    const RfTrialWatch* watch;        // may be NULL; called from several threads
    void ( *say )( void* user, const RfTune* tune, const RfTuneRound* round, int candidates ); // before each round; may be NULL
    void* user;
} RfTuneJob;

// Fails with RF_ERROR_MEMORY where nothing fits the budget, RF_ERROR_INTERRUPTED
// where it was stopped: then what complete rounds found is there all the same.
RfResult rf_tune( const RfTuneJob* job, RfTune* tune, RfError* error );

#endif
