// Internal to the stop rule: what a look ahead tells of frames that are not rendered yet.
#ifndef REFRAME_RENDER_STOP_AHEAD_H
#define REFRAME_RENDER_STOP_AHEAD_H

#include "render/stop_rule.h"

// How many times as noisy as frame `from` is frame `to`? 1 where nothing is known.
double rf_noise_ahead( const RfStop* stop, int from, int to );

// What samples bring to the pair of frame `to`, by that of frame `from`.
RfPairNoise rf_pair_ahead( const RfStop* stop, RfPairNoise pair, int from, int to );

#endif
