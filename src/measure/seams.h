// Which pairs of frames lie at the borders of groups, where a seam would be.
//
// Reframe's groups slide by one frame (reuse/group.h): each frame leaves one
// group behind and enters another, so that no border lies in the middle of a
// path, where every frame is the mean over the same number of full groups. What
// differs are the frames at both ends of it, within 2n of them for the half-width
// n, which lie in fewer groups or cut ones. A pair is inside where both its frames
// lie in full groups only and in as many as those in the middle; else it is at the
// border. A path of one group has no border, nor has one without reuse.
//
// Other programs' groups follow each other: a pair is at the border where one
// ends with its first frame and the next begins with the other.
#ifndef REFRAME_MEASURE_SEAMS_H
#define REFRAME_MEASURE_SEAMS_H

#include "render/groups.h"

#include <stdbool.h>

typedef struct RfSeams
{
    int period;  // > 0: groups of so many frames, the first begins with `first`
    int first;   // number of the frame that is the first of the path
    bool slides; // else by the plan
    RfGroupPlan plan;
} RfSeams;

// Are there any groups to be told apart?
static inline bool rf_has_seams( const RfSeams* seams ) { return seams->period > 0 || seams->slides; }

// Is the pair of this frame and the one before at a border?
bool rf_is_seam( const RfSeams* seams, int frame );

#endif
