// Internal to the measurement of cost.
#ifndef REFRAME_MEASURE_COST_INTERNAL_H
#define REFRAME_MEASURE_COST_INTERNAL_H

#include "measure/cost.h"

#define RF_COST_UNITS ( RF_COST_LEVELS * RF_COST_POSITIONS )
#define RF_COST_TASKS ( 2 * RF_COST_POSITIONS )

typedef struct RfCostStudy
{
    const RfCostJob* job;
    RfCost* cost;
    RfRenderSettings settings[2]; // resolved
    RfTestRegion regions[RF_COST_POSITIONS];
    double pixels;                    // to trace of each of their frames
    int workers;                      // trials at a time, with a thread each
    int threads;                      // of the render
    int level, first_passes;          // of the first level
    RfTrial trials[RF_COST_UNITS][2]; // per position and level: path tracing and reuse, with different seeds
    RfCostUnit units[RF_COST_UNITS];  // the measurements of these trials
    int unit_count;
    double start;
} RfCostStudy;

static inline double rf_cost_frame_pixels( const RfCostJob* job ) { return (double)job->eyes->width * job->eyes->height; }

// Seconds of a frame of a curve with so many samples per pixel.
static inline double rf_cost_frame_seconds( const RfCostJob* job, const RfCostCurve* c, double spp, double sample_seconds )
{
    return rf_cost_frame_pixels( job ) * spp * sample_seconds + c->finish_seconds;
}

// Settings of both curves, how many trials run at a time, and the threads and memory of each.
RfResult rf_resolve_cost_settings( RfCostStudy* study, RfError* error );

// What all trials say together: slopes, errors and times of both curves, and the gain.
void rf_fit_cost_curves( RfCostStudy* study );

#endif
