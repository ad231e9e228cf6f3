// Sliding groups (src/reuse/estimators.md, section 7): groups of consecutive frames, each one frame
// further along the path, and the number of passes of each.
//
// A path longer than two groups has full groups only, so that each sample serves as many frames
// as possible. The first and the last frame lie in one group only; its number of
// passes is raised so that they get as many samples as a frame in the middle.
//
// In a path of one to two groups nearly all full groups hold the middle frames, which would get far
// more samples than the ends. There groups also extend over both ends of the path and are cut
// to it; the shorter a group, the more passes it gets. A path of one group or less is
// one group.
//
// Groups do not cross a cut: each shot, the frames between two cuts, is grouped as a path of its own.
#ifndef REFRAME_RENDER_GROUPS_H
#define REFRAME_RENDER_GROUPS_H

#include "reframe/camera.h"

#include <stdbool.h>
#include <stdint.h>

typedef struct RfGroupPlan
{
    int frames;     // in the whole path
    int eyes;       // in a full group: 2n+1, or all frames of a shorter path, with cuts of the longest shot
    int groups;     // numbered in the order in which they are rendered; with cuts some are of no frames
    int cut;        // groups at each end that are not full
    int passes;     // of a full group in the middle, one own-frame sample per pixel each; 0: unequal
    int end_passes; // of the first and the last group, where all groups are full
    int spp;        // own-frame samples per pixel that every frame gets at least

    const RfEye* cameras; // of all frames, where there are cuts, which cut and end_passes say nothing of; NULL: there are none
} RfGroupPlan;

// A group of frames [first, first + eyes) that is rendered as a whole.
typedef struct RfGroup
{
    int first, eyes;
    int passes;
    int weight;            // of a pass in the mean of a frame: shorter groups are noisier
    int64_t passes_before; // of all groups with a lower number
} RfGroup;

// For a path of `frames` frames, half-width n and at least `spp` own-frame
// samples per pixel.
RfGroupPlan rf_plan_groups( int frames, int half_width, int spp );

// The same with the cuts of the path (RfEye.shot), which `cameras` must outlive; NULL: it has none.
RfGroupPlan rf_plan_shots( const RfEye* cameras, int frames, int half_width, int spp );

static inline int rf_longest_shot( const RfEye* cameras, int frames )
{
    return rf_plan_shots( cameras, frames, frames / 2, 1 ).eyes;
}

// Frames [*first, *end) of the path are the shot that holds a frame.
void rf_shot_of_frame( const RfGroupPlan* plan, int frame, int* first, int* end );

// Frames [*first, *first + *count) are those of its shot around a frame: so many, as far as it goes.
void rf_frames_around( const RfGroupPlan* plan, int frame, int* first, int* count );

// Do two frames share a shot? No frame does with one beyond the path.
bool rf_share_shot( const RfGroupPlan* plan, int frame, int other );

// Group number 0 … plan->groups − 1.
RfGroup rf_group( const RfGroupPlan* plan, int number );

// Numbers of the first and last group that hold a frame; it is in all between.
void rf_groups_of_frame( const RfGroupPlan* plan, int frame, int* first, int* last );

// Own-frame samples per pixel of a frame, over all groups that hold it.
int rf_frame_passes( const RfGroupPlan* plan, int frame );

// Adds the own-frame samples per pixel in the groups that hold any of
// frames[first … end), in ascending order, and those times the other frames of the group.
void rf_add_group_samples( const RfGroupPlan* plan, const int* frames, int first, int end, double* samples, double* others );

// Which half of the film a pass goes to (E2): the passes of the whole render
// alternate, so that the halves of a frame, whose groups follow each other,
// differ by one pass at most and both see every group of two passes or more.
static inline int rf_half_of_pass( const RfGroup* group, int pass ) { return (int)( ( group->passes_before + pass ) & 1 ); }

// Cost of a pixel over all groups where a sample costs `own`, and `reuse` for every other camera of its group:
// Σ passes · eyes · (own + (eyes − 1) · reuse).
double rf_plan_work( const RfGroupPlan* plan, double own, double reuse );

#endif
