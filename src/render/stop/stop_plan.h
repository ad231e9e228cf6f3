// What a render is to reach, and the plan of shares by which the stop rule gets there (stop_rule.h).
#ifndef REFRAME_RENDER_STOP_STOP_PLAN_H
#define REFRAME_RENDER_STOP_STOP_PLAN_H

#include "render/groups.h"

#include <stdbool.h>

// What a render is to reach; 0: does not matter.
typedef struct RfStopGoals
{
    double noise;   // relMSE that every frame is to come below
    double flicker; // F1² that every pair is to come below
    double seconds; // for all frames
} RfStopGoals;

typedef struct RfStopRule
{
    RfStopGoals goals;
    RfGroupPlan plan;   // of the shares
    double scale;       // passes of a share in it
    double most, least; // passes for each share
} RfStopRule;

// Shares of a group.
double rf_shares_of( const RfStopRule* rule, int group );

// Weight of a frame's groups from number `from` on for one pass a share.
double rf_planned_weight( const RfStopRule* rule, int frame, int from );

#endif
