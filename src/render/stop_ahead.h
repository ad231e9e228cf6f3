// Internal to the stop rule: what a look ahead tells of frames that are not rendered yet.
#ifndef REFRAME_RENDER_STOP_AHEAD_H
#define REFRAME_RENDER_STOP_AHEAD_H

#include "render/stop_rule.h"

// How many times as noisy as frame `from` is frame `to`? 1 where nothing is known.
double rf_noise_ahead( const RfStop* stop, int from, int to );

// The same of the mean square of their errors.
double rf_variance_ahead( const RfStop* stop, int from, int to );

// The part of that which a frame and the next do not share although they have all samples in common, 0 to 1; and its mean
// over the path. 0 where nothing is known.
double rf_apart_ahead( const RfStop* stop, int frame );
double rf_usual_apart_ahead( const RfStop* stop );

#endif
