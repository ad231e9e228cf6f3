// The stop rule of a render that is to reach an error (settings.noise), a flicker (settings.flicker) or to take a time
// (settings.time): how many passes each group gets, decided while it is rendered.
//
// The plan of groups.h gives each group a number of shares, so that the passes of a frame stay spread over all groups that hold
// it and no seams appear: a full group has one share, an end group as many as it has frames. With r passes per share and groups
// of m frames a frame gets r · m own-frame samples per pixel, as with settings.spp.
//
// For an error E: a frame's relMSE is inversely proportional to the weight W of its passes, so
// with v = relMSE · W it needs W' = v/E − W more. A group gets r = max over its frames of W' over
// their remaining shares. v is pooled over neighbouring frames, which have about the same noise
// and an independent estimate each; a newer frame has few passes yet. The last group of a
// frame is then topped up until the frame's own estimate and the pooled one are both below E. A
// lucky draw seldom deceives both, and each check comes after more passes than the one
// before, by a thirtieth or more.
//
// Where another error is stopped by that falls as W^−q, as that of a denoised picture, v = E W (error / E)^(1/q).
//
// For a flicker F: F1² of a pair of frames falls as 1 / W as well, so v = F1² · W with F² in the place of E. It must be
// the F1 of the finished pair (src/reuse/estimators.md, section 17): the earlier frame is finished before the later one, and passes that the later
// one alone gets do not help. Passes are spread more evenly then: due_to_be_even in
// stop_rule.c. With both, a frame gets what the harder of the two needs.
//
// For a time: r is the time left over the cost of the remaining shares at the pace so far.
//
// There are no rays, films or clocks in here: what is known of them comes as numbers.
#ifndef REFRAME_RENDER_STOP_STOP_RULE_H
#define REFRAME_RENDER_STOP_STOP_RULE_H

#include "film/film_error.h"
#include "render/groups.h"

#include <stdbool.h>

// What a render is to reach; 0: does not matter.
typedef struct RfStopGoals
{
    double noise;   // relMSE that every frame is to come below
    double flicker; // F1² that every pair is to come below
    double seconds; // for all frames
    int passes;     // that a frame needs for an estimate of its noise; 0: 2, one in each half
} RfStopGoals;

int rf_passes_for( const RfStopGoals* goals );

typedef struct RfStopRule
{
    RfStopGoals goals;
    RfGroupPlan plan;   // of the shares
    double scale;       // passes of a share in it
    double most, least; // passes for each share
} RfStopRule;

// Weight of a frame's groups from number `from` on for one pass a share.
double rf_planned_weight( const RfStopRule* rule, int frame, int from );

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

// What a sample brings to the pair, from its flicker.
RfPairNoise rf_pair_noise( const RfPairNow* pair );

#define RF_STOP_HISTORY 16 // finished frames that are kept for pooling

typedef struct RfStop
{
    RfStopRule rule;
    double owed;        // part of a pass, from one group to the next
    int group;          // that is rendered
    double due;         // passes of this group, as last decided
    int64_t passes;     // of all groups before this one
    double units_left;  // shares × frames of all groups after this one
    double units_all;   // the same of all groups
    double group_units; // of this group
    double group_share; // of it that is done
    int groups_done;
    double last_rate;                      // of the last group
    double seconds_done, units_done, last; // pace: seconds per frame and pass is their quotient
    RfFrameNoise finished[RF_STOP_HISTORY];
    int finished_count; // in all
    int missed;         // frames that were finished above the wanted error
    int flicker_missed; // and above the wanted flicker
    bool hurried;       // a group got the least passes for lack of time
} RfStop;

// Some frames of a group, as they were after so many passes of it.
typedef struct RfNoiseEstimates
{
    int group; // its number
    int done;
    const RfFrameNoise* frames; // ascending: those asked for
    int count;
} RfNoiseEstimates;

// For a path as of rf_plan_groups, of which no frame is to get more than about
// `most_spp` own-frame samples per pixel. `units` is of all groups, see rf_group_units.
RfStop rf_create_stop( const RfGroupPlan* plan, int most_spp, const RfStopGoals* goals );

// What a group costs: shares × frames.
double rf_group_units( const RfStop* stop, int group );

// A group begins. Its `passes` say nothing; the others as in rf_group, with
// the passes that there really were before it.
RfGroup rf_begin_group( RfStop* stop, int group );
RfGroup rf_group_in_work( const RfStop* stop );

// Total passes that the group should have, by the latest estimates and the time now
// (seconds since the start), after `done` passes. With a time it may change
// after every pass, without it only with new estimates.
int rf_passes_due( RfStop* stop, const RfNoiseEstimates* look, int done, double now );
void rf_note_pass( RfStop* stop, int eyes, double now );
void rf_end_group( RfStop* stop, int done );

// Estimated part of the whole render that is done, 0 to 1.
double rf_stop_share( const RfStop* stop, double now );

// Seconds to the end if the rest of the shares take as long as those that are done. NaN in the first group, which says too
// little of the passes to come; with a time never more than what is left of it.
double rf_stop_left( const RfStop* stop, double now );

// Notes a finished frame, with the flicker since the one before (NaN: not known). Reports which goals it has missed.
typedef struct RfMissed
{
    bool noise, flicker;
} RfMissed;
RfMissed rf_note_finished( RfStop* stop, RfFrameNoise frame );

#endif
