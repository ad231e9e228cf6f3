// What the flicker of a pair of frames will be when both are finished (src/reuse/estimators.md, section 17). The earlier
// frame is finished first: after its last group the later one gets further passes, which the earlier one does not share.
//
// Like the stop rule, numbers alone.
#ifndef REFRAME_RENDER_STOP_PAIR_RULE_H
#define REFRAME_RENDER_STOP_PAIR_RULE_H

#include "film/film_error.h"
#include "render/stop/stop_plan.h"

// What a sample brings to a pair of frames: the mean variance of its errors, and the covariance where both have it.
typedef struct RfPairNoise
{
    double variance, covariance; // NaN: not known
} RfPairNoise;

// What is known of a frame's noise.
typedef struct RfFrameNoise
{
    int frame;
    int passes;       // so far
    double weight;    // of them
    double noise;     // v, the relMSE times the weight it was estimated at
    double flicker;   // the same of F1² of a pair that the frame is in, as rf_final_flicker has it; NaN: not known
    RfPairNoise pair; // of this frame and the next, from which that of others is guessed
    double seen;      // that weight; 0: neither is known
} RfFrameNoise;

// A pair of frames after some passes of a group that holds both, or neither shares any with the other.
typedef struct RfPairNow
{
    int group;                  // in which it was estimated
    const RfFrameNoise* before; // the earlier frame: number and weight
    const RfFrameNoise* now;
    RfFlicker flicker;
    double spare; // weight that the later frame may get beyond what is planned
} RfPairNow;

// The likely F1² of the finished pair, times the weight of the earlier frame: falls as 1 over that weight. With `spare` it
// is the larger one of those with and without. NaN: the flicker is not known.
double rf_final_flicker( const RfStopRule* rule, const RfPairNow* pair );

// The same to stop by, with doubts and the passes that the later frame may get beyond what is planned (pair->spare is set).
double rf_flicker_ahead( const RfStopRule* rule, RfPairNow* pair );

// The later frame is in its last group and the earlier one is finished. The same as a bound for the weight of the later
// one; 0 where passes of that one alone do not bring F1² down to what is wanted.
double rf_late_flicker( const RfStopRule* rule, const RfFrameNoise* now, const RfFlicker* flicker );

// v of F1² of a frame and the next (of the one before and the last) by the plan of groups.
double rf_planned_flicker( const RfStopRule* rule, int frame, RfPairNoise pair );

// What a sample brings to the pair, from its flicker.
RfPairNoise rf_pair_noise( const RfPairNow* pair );

#endif
