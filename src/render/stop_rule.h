// When a render stops that is to reach an error (--noise) or to take a time
// (--time): how many passes each group gets, decided while it is rendered.
//
// The plan of render/groups.h gives the groups their shares, so that the passes
// of a frame stay spread over all groups that hold it and no seams come up:
// a full group has share 1, an end group as many as it has eyes. With r passes
// for each share a frame gets r · eyes native samples per pixel, as by --spp.
//
// For an error: a frame's relMSE goes with 1 over the weight W of its passes, so
// v = relMSE · W says what it lacks, W' = v/E − W. A group gets what brings each
// of its frames its part of that: r = max over frames of W' over their shares to
// come. v is pooled over the frames around, which have much the same noise and
// each an estimate of its own; a newer frame has few passes yet. The last group
// of a frame is then topped up until the frame's own estimate and the pooled one
// are both below E: two looks at least seldom agree on a lucky draw, and each
// look is at more passes than the one before, by a thirtieth or more.
//
// For a time: r is the time that is left over what the shares to come cost at
// the pace so far.
//
// No rays, films or clocks in here: what is seen of them comes as numbers.
#ifndef REFRAME_RENDER_STOP_RULE_H
#define REFRAME_RENDER_STOP_RULE_H

#include "render/groups.h"

#include <stdbool.h>

#define RF_STOP_HISTORY 16 // finished frames that are remembered

// What is known of a frame's noise.
typedef struct RfFrameNoise
{
    int frame;
    int passes;    // so far
    double weight; // of them
    double noise;  // v, the relMSE times the weight it was estimated at
    double seen;   // that weight; 0: v is not known
} RfFrameNoise;

typedef struct RfStop
{
    double noise;                          // relMSE that every frame is to come below; 0: does not matter
    double seconds;                        // for all frames; 0: does not matter
    RfGroupPlan plan;                      // of the shares
    double scale;                          // passes of a share in it
    double most, least;                    // passes for each share
    double owed;                           // part of a pass, from one group to the next
    double due;                            // passes of this group, as last decided
    int64_t passes;                        // of all groups before this one
    double units_left;                     // shares × eyes of all groups after this one
    double units_all;                      // the same of all groups
    double group_units;                    // of this group
    double group_share;                    // of it that is done
    double seconds_done, units_done, last; // pace: seconds per eye and pass is their quotient
    RfFrameNoise finished[RF_STOP_HISTORY];
    int finished_count; // in all
    int missed;         // frames that were finished above the wanted error
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
// `most_spp` native samples per pixel. `units` is of all groups, see rf_group_units.
RfStop rf_create_stop( const RfGroupPlan* plan, int most_spp, double noise, double seconds );

// What a group costs: shares × eyes.
double rf_group_units( const RfStop* stop, int group );

// A group begins. Its `passes` say nothing; the others as in rf_group, with
// the passes that there really were before it.
RfGroup rf_begin_group( RfStop* stop, int group );

// Passes that the group should have in all, by the last look and the time now
// (seconds since the start), after `done` passes. With a time it may change
// after every pass, without only with a look.
int rf_passes_due( RfStop* stop, const RfNoiseEstimates* look, int done, double now );

// A pass of the group is done.
void rf_note_pass( RfStop* stop, int eyes, double now );

// The group is done, with so many passes.
void rf_end_group( RfStop* stop, int done );

// Of the whole render, 0 to 1, as far as can be told.
double rf_stop_share( const RfStop* stop, double now );

// A frame is finished. True where it is what was wanted.
bool rf_note_finished( RfStop* stop, RfFrameNoise frame );

// v of a frame, pooled over the looked-at and the finished frames around it; NaN where nothing is known.
double rf_pooled_noise( const RfStop* stop, const RfNoiseEstimates* look, int frame );

#endif
