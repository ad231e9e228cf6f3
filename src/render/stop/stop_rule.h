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
// For a flicker F: F1² of a pair of frames falls as 1 / W as well, so v = F1² · W with F² in the place of E. It must be
// the F1 of the finished pair (pair_rule.h): the earlier frame is finished before the later one, and passes that the later
// one alone gets do not help. Passes are spread more evenly then: due_to_be_even in
// stop_rule.c. With both, a frame gets what the harder of the two needs.
//
// For a time: r is the time left over the cost of the remaining shares at the pace so far.
//
// There are no rays, films or clocks in here: what is known of them comes as numbers.
#ifndef REFRAME_RENDER_STOP_STOP_RULE_H
#define REFRAME_RENDER_STOP_STOP_RULE_H

#include "render/stop/pair_rule.h"

#include <stdbool.h>

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

// The group begun last, once more.
RfGroup rf_group_in_work( const RfStop* stop );

// Total passes that the group should have, by the latest estimates and the time now
// (seconds since the start), after `done` passes. With a time it may change
// after every pass, without it only with new estimates.
int rf_passes_due( RfStop* stop, const RfNoiseEstimates* look, int done, double now );

// A pass of the group is done.
void rf_note_pass( RfStop* stop, int eyes, double now );

// The group is done, with so many passes.
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
