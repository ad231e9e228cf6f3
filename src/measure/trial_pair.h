// The inside of a trial: a render with its clocks, and the comparison of two.
#ifndef REFRAME_MEASURE_TRIAL_PAIR_H
#define REFRAME_MEASURE_TRIAL_PAIR_H

#include "measure/trial.h"

// Clocks of one render. Set-up ends with the first chunk of records, so `cpu`
// and `wall` are those of the `samples` after it (of all where there is one only).
typedef struct RfTrialMeter
{
    double samples, cpu, wall;
    double finish_cpu; // from the last chunk on, without the callbacks
    double all_samples, all_cpu;
} RfTrialMeter;

// Renders all frames of a piece of path; each goes to `frame`, whose time does not count.
RfResult rf_render_metered( const RfTracer* tracer, const RfEye* eyes, int eye_count, const RfRenderSettings* settings,
                            RfResult ( *frame )( void* user, const RfFrameResult* result, RfError* error ), void* user,
                            const RfTrialWatch* watch, RfTrialMeter* meter, RfError* error );

// Two renders of a window.
typedef struct RfTrialPair
{
    int eyes;
    bool whole; // they are all frames of the path
    size_t pixels;
    const float* weight; // of each frame's pixels
    float* rgb;          // frames of the first; then what the second differs by
    double relmse;       // sums over the frames: of weighted ½ d², over channels, mean over pixels,
    double square;       // of ½ d², mean over pixels and channels,
    double ends;         // half of what the first and the last have of it,
    double steps;        // of ½ (d_t − d_{t−1})²
} RfTrialPair;

void rf_begin_pair( RfTrialPair* pair, const float* weight );
RfResult rf_keep_first( void* user, const RfFrameResult* frame, RfError* error );
RfResult rf_compare_second( void* user, const RfFrameResult* frame, RfError* error );

// Adds what was found with so many passes.
void rf_end_pair( const RfTrialPair* pair, int passes, RfTrial* trial );

#endif
