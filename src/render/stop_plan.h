// Internal to the stop rule: its plan of shares.
#ifndef REFRAME_RENDER_STOP_PLAN_H
#define REFRAME_RENDER_STOP_PLAN_H

#include "render/stop_rule.h"

// Shares of a group.
double rf_shares_of( const RfStop* stop, int group );

// Weight of a frame's groups from number `from` on for one pass a share.
double rf_planned_weight( const RfStop* stop, int frame, int from );

#endif
