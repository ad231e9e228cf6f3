// What the flicker of a pair of frames will be when both are finished (src/reuse/estimators.md, section 17). The earlier
// frame is finished first: after its last group the later one gets further passes, which the earlier one does not share.
//
// Like the stop rule, numbers alone.
#ifndef REFRAME_RENDER_PAIR_RULE_H
#define REFRAME_RENDER_PAIR_RULE_H

#include "film/film_error.h"
#include "render/stop_rule.h"

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
// is the larger one of those with and without.
double rf_final_flicker( const RfStop* stop, const RfPairNow* pair );

// The same to stop by, with doubts and the passes that the later frame may get beyond what is planned (pair->spare is set).
double rf_flicker_ahead( const RfStop* stop, RfPairNow* pair );

// The later frame is in its last group and the earlier one is finished. The same as a bound for the weight of the later
// one; 0 where passes of that one alone do not bring F1² down to what is wanted.
double rf_late_flicker( const RfStop* stop, const RfFrameNoise* now, const RfFlicker* flicker );

// v of F1² of a frame and the next (of the one before and the last) by the plan of groups.
double rf_planned_flicker( const RfStop* stop, int frame, RfPairNoise pair );

// What a sample brings to the pair, from its flicker.
RfPairNoise rf_pair_noise( const RfPairNow* pair );

#endif
