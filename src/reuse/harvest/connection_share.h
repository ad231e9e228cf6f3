// Chooses how many light paths and connections pay, by the variance and cost of a few batches traced ahead.
#ifndef REFRAME_REUSE_HARVEST_CONNECTION_SHARE_H
#define REFRAME_REUSE_HARVEST_CONNECTION_SHARE_H

#include "light_paths/light_paths.h"
#include "reuse/record.h"

// What rf_choose_connection_share works in, for a group.
typedef struct RfPilot RfPilot;
RfPilot* rf_place_pilot( const RfEstimatorGroup* group, const RfBatchShape* shape, RfLayout* layout );

// Sets the share of light paths and connections for all passes of a group, by scene, settings and group alone, and
// counts the rays traced for it.
void rf_choose_connection_share( const RfEstimatorGroup* group, RfLightPaths* paths, RfPilot* pilot, RfRayCounts* rays );

#endif
