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
    bool whole;                   // the frames are the whole path
    const RfTestPieces* pieces;   // of the region
    int first;                    // frame of the region
    const float* weight;          // of the region
    float* rgb;                   // of the group's slots: the first render, then the differences to the second
    double relmse[RF_MAX_PIECES]; // sums over the pixels of a piece: of weighted ½ d², summed over channels
    double pixels[RF_MAX_PIECES];
    double worst[RF_WORST_CELLS]; // of relmse
    double square;                // sum of ½ d² over pixels, mean over channels
    double first_mean, last_mean; // of ½ d² in the first and the last frame
    double steps;                 // sum of the means of ½ (d_t − d_{t−1})² over the pixels that both frames measure
    int step_count;
} RfTrialPair;

// Prepares for the first render of the group that begins with frame `first` of the region.
void rf_begin_pair( RfTrialPair* pair, int first );

// Frame callback of the first render: keeps the frame.
RfResult rf_keep_first( void* user, const RfFrameResult* frame, RfError* error );

// Frame callback of the second render: subtracts the frame and accumulates the sums.
RfResult rf_compare_second( void* user, const RfFrameResult* frame, RfError* error );

// Adds the result, measured with `passes` passes, to a trial; its pieces are the first of the trial.
void rf_end_pair( const RfTrialPair* pair, int passes, RfTrial* trial );

#endif
