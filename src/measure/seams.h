// Finds the pairs of frames at group borders, where a seam would be visible.
//
// Reframe's groups slide by one frame: each frame leaves one group behind and enters another,
// so there is no border in the middle of a path, where every frame is the mean over the same
// number of full groups. Only the frames within 2n of the ends differ, n being the half-width:
// they are in fewer groups, or in clipped ones. A pair is interior if both its frames are in
// full groups only and in as many as the frames in the middle; otherwise it is at a border. A
// path of a single group has no border, nor has a render without reuse.
//
// Other programs use consecutive groups: a pair is at a border if it straddles two of them.
#ifndef REFRAME_MEASURE_SEAMS_H
#define REFRAME_MEASURE_SEAMS_H

#include "render/groups.h"

#include <stdbool.h>

typedef struct RfSeams
{
    int period;  // > 0: consecutive groups of this many frames, one of which starts at `first`
    int first;   // number of the first frame of the path
    bool slides; // sliding groups, by the plan
    RfGroupPlan plan;
} RfSeams;

// True if there are any group borders.
static inline bool rf_has_seams( const RfSeams* seams ) { return seams->period > 0 || seams->slides; }

// True if the pair of this frame and the previous one is at a border.
bool rf_is_seam( const RfSeams* seams, int frame );

#endif
