// How many light paths and connections pay: a few batches traced ahead tell their variance and cost, and those of all other
// light.
#ifndef REFRAME_REUSE_HARVEST_CONNECTION_SHARE_H
#define REFRAME_REUSE_HARVEST_CONNECTION_SHARE_H

#include "light_paths/light_paths.h"

// The bytes that rf_choose_connection_share works in, aligned to 64.
size_t rf_connection_share_bytes( const RfEstimatorGroup* group );

// Sets the share of light paths and connections in all passes of a group, and counts the rays traced for that. It depends on
// scene, settings and group alone.
void rf_choose_connection_share( const RfEstimatorGroup* group, RfLightPaths* paths, void* memory, RfRayCounts* rays );

#endif
