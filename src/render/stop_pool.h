// Internal to the stop rule: what frames need by their estimates and those around them.
#ifndef REFRAME_RENDER_STOP_POOL_H
#define REFRAME_RENDER_STOP_POOL_H

#include "render/stop_rule.h"

// Is all known that the frame is to reach? A frame whose neighbours are not rendered has no flicker of its own.
bool rf_is_known( const RfStop* stop, const RfFrameNoise* frame );

// Weight that the frame needs for the hardest goal, by the pooled estimates and with `own` by its own, too; NaN: not known.
double rf_needed_weight( const RfStop* stop, const RfNoiseEstimates* look, const RfFrameNoise* frame, bool own );

#endif
