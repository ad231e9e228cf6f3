// Sliding groups (src/reuse/estimators.md, section 7): windows of consecutive frames that
// move by one frame, and how many passes each is given.
//
// A path of more than two groups has full windows only: a sample then always
// serves as many frames as it can. The first and the last frame lie in one
// window only; its passes are raised so that they get as many samples as a
// frame in the middle.
//
// In a path of one to two groups nearly all full windows hold the middle, which
// would outdo the ends by far. There the windows go on over both ends of the
// path, cut to what is left of them, and the shorter they are the more passes
// they get. A path of one group or less is one window.
#ifndef REFRAME_RENDER_GROUPS_H
#define REFRAME_RENDER_GROUPS_H

#include <stdint.h>

typedef struct RfGroupPlan
{
    int frames;     // in the whole path
    int eyes;       // in a full window: 2n+1, or all frames of a shorter path
    int windows;    // numbered in the order in which they are rendered
    int cut;        // windows at each end that are not full
    int passes;     // of a full window in the middle, one native sample per pixel each; 0: unequal
    int end_passes; // of the first and the last window, where all windows are full
    int spp;        // native samples per pixel that every frame gets at least
} RfGroupPlan;

// A group of frames [first, first + eyes) that is harvested and computed as a whole.
typedef struct RfGroup
{
    int first, eyes;
    int passes;
    int weight;            // of a pass in the mean of a frame: shorter windows are noisier
    int64_t passes_before; // of all windows with a lower number
} RfGroup;

// For a path of `frames` frames, half-width n and at least `spp` native
// samples per pixel and frame.
RfGroupPlan rf_plan_groups( int frames, int half_width, int spp );

// Window number 0 … windows−1.
RfGroup rf_group( const RfGroupPlan* plan, int number );

// Numbers of the first and last window that hold a frame; it is in all between.
void rf_groups_of_frame( const RfGroupPlan* plan, int frame, int* first, int* last );

// Native samples per pixel of a frame, over all windows that hold it.
int rf_frame_passes( const RfGroupPlan* plan, int frame );

// A bound on that for all frames.
int64_t rf_most_passes( const RfGroupPlan* plan );

// Adds the native samples per pixel in the windows that hold any of
// frames[first … end), in ascending order, and those times the other eyes of the window.
void rf_add_group_samples( const RfGroupPlan* plan, const int* frames, int first, int end, double* samples, double* others );

// Which half of the film a pass goes to (E2): the passes of the whole render
// alternate, so that the halves of a frame, whose windows follow each other,
// differ by one pass at most and both see every window of two passes or more.
static inline int rf_half_of_pass( const RfGroup* window, int pass ) { return (int)( ( window->passes_before + pass ) & 1 ); }

#endif
