// Internal to a trial: a timed render, and the comparison of two renders.
#ifndef REFRAME_MEASURE_TRIAL_PAIR_H
#define REFRAME_MEASURE_TRIAL_PAIR_H

#include "measure/trial.h"

// Timings of one render. Set-up ends with the first chunk of records; `cpu` and `wall` cover
// the `samples` after it, or everything if there is only one chunk.
typedef struct RfTrialMeter
{
    double samples, cpu, wall;
    double finish_cpu; // from the last chunk on, without the callbacks
    double all_samples, all_cpu;
} RfTrialMeter;

// Renders all frames of a segment of the path; each goes to the callback `frame`, whose time
// is not counted.
RfResult rf_render_metered( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                            RfResult ( *frame )( void* user, const RfFrameResult* result, RfError* error ), void* user,
                            const RfTrialWatch* watch, RfTrialMeter* meter, RfError* error );

// Two renders of a group.
typedef struct RfTrialPair
{
    int eyes;
    bool whole; // the frames are the whole path
    size_t pixels;
    const float* weight; // per pixel, frame after frame
    float* rgb;          // the frames of the first render, then the differences to the second
    double relmse;       // sums over the frames: of weighted ½ d², summed over channels, mean over
                         // pixels
    double square;       // of ½ d², mean over pixels and channels
    double ends;         // half of what the first and the last frame contribute to `square`
    double steps;        // of ½ (d_t − d_{t−1})²
} RfTrialPair;

// Prepares for the first render.
void rf_begin_pair( RfTrialPair* pair, const float* weight );

// Frame callback of the first render: keeps the frame.
RfResult rf_keep_first( void* user, const RfFrameResult* frame, RfError* error );

// Frame callback of the second render: subtracts the frame and accumulates the sums.
RfResult rf_compare_second( void* user, const RfFrameResult* frame, RfError* error );

// Adds the result, measured with `passes` passes, to a trial.
void rf_end_pair( const RfTrialPair* pair, int passes, RfTrial* trial );

#endif
