// Evaluates animation channels, and the local matrices of animated nodes.
#ifndef REFRAME_SCENE_ANIMATION_H
#define REFRAME_SCENE_ANIMATION_H

#include "scene/scene.h"

// The value of a channel at `time` seconds of the scene, clamped to its first and last key: as many numbers as it has components, a
// unit quaternion for rotations.
void rf_sample_channel( const RfChannel* channel, double time, double* value );

// From when to when a channel moves, in seconds of the scene, which begins at 0: of what loops, the first round.
void rf_channel_span( const RfChannel* channel, double* start, double* end );

// Whether its value is not the same at all times.
bool rf_channel_varies( const RfChannel* channel );

// Copies a channel with its keys, which are to be freed also where that fails.
RfResult rf_copy_channel( const RfChannel* from, RfChannel* to, RfError* error );

// The channels of one node, contiguous in `scene->channels`, which are sorted by node, then path. Returns
// the first, and their number in `count` (0 to 5).
const RfChannel* rf_node_channels( const RfScene* scene, int node, int* count );

// The matrix of a node relative to its parent at `time` seconds.
void rf_node_local_matrix( const RfScene* scene, int node, double time, RfMat4* matrix );

#endif
