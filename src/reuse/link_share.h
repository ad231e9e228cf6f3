// How many light paths and links pay: a few batches traced ahead tell their variance and cost, and those of all other light.
#ifndef REFRAME_REUSE_LINK_SHARE_H
#define REFRAME_REUSE_LINK_SHARE_H

#include "kernel/light_paths.h"

// The bytes that rf_choose_link_share works in, aligned to 64.
size_t rf_link_share_bytes( const RfEstimatorGroup* group );

// Sets the share of light paths and links in all passes of a group, and counts the rays traced for that. It depends on
// scene, settings and group alone.
void rf_choose_link_share( const RfEstimatorGroup* group, RfLightPaths* paths, void* memory, RfRayCounts* rays );

#endif
