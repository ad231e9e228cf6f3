// What accuracy costs in time, here: a few frames of a path are rendered with
// ever more samples, by path tracing and with reuse, and their errors measured
// without a reference (trial.h). Errors of unbiased estimators fall as 1 / samples:
// so all of it together tells the seconds that any error takes, and the spread
// between places and sample counts how sure that is.
#ifndef REFRAME_MEASURE_COST_H
#define REFRAME_MEASURE_COST_H

#include "measure/cost_fit.h"
#include "measure/trial.h"

#define RF_COST_LEVELS 12
#define RF_COST_PLACES 3

// One curve's point: the mean over the places of the path.
typedef struct RfCostRow
{
    int spp;        // native samples per pixel
    double seconds; // of a frame of the size asked for, on the clock
    double cpu_seconds;
    double relmse;
} RfCostRow;

typedef struct RfCostCurve
{
    int group; // half-width n, cut to the path
    int eyes;  // in a full group
    RfTile tile;
    RfCostRow rows[RF_COST_LEVELS];
    int count;
    RfInterval slope;      // of log relMSE over log seconds
    double relmse;         // of a single sample
    double sample_seconds; // on the clock, of a native sample
    double finish_seconds; // of what a frame takes besides
} RfCostCurve;

typedef struct RfCost
{
    RfCostCurve plain, reuse;
    RfInterval speedup; // seconds of path tracing over those with reuse at equal error
    int width, height;  // of the pictures tried
    int places;
    double seconds; // that it took
} RfCost;

typedef struct RfCostJob
{
    const RfTracer* tracer;
    const RfEye* eyes; // of the whole path
    int eye_count;
    const int* frames; // asked for
    int frame_count;
    const RfRenderSettings* settings;                         // those with reuse; spp does not matter
    double budget;                                            // seconds; the first level is always made
    const RfTrialWatch* watch;                                // may be NULL
    void ( *say )( void* user, const RfCost* cost, int spp ); // before each level; may be NULL
    void* user;
} RfCostJob;

// Fails with RF_ERROR_INTERRUPTED where it was stopped, RF_ERROR_USAGE for
// settings that do not reuse anything.
RfResult rf_measure_cost( const RfCostJob* job, RfCost* cost, RfError* error );

// What an error takes: samples as a render will have them (two at least), seconds
// of a frame in the middle of the path, and of a render of all frames asked for
// with its ends, in sweeps of `per_sweep` frames.
typedef struct RfCostPrediction
{
    int spp; // 0: more than a render can have
    double frame_seconds, seconds;
} RfCostPrediction;

RfCostPrediction rf_predict_cost( const RfCostJob* job, const RfCostCurve* curve, double relmse, int per_sweep );

#endif
