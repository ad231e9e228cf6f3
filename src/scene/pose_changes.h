// Internal to scene/pose.c: lamps, materials and the sky as they are at a time.
#ifndef REFRAME_SCENE_POSE_CHANGES_H
#define REFRAME_SCENE_POSE_CHANGES_H

#include "base/layout.h"
#include "scene/pose.h"

// Where the moving nodes are at a time, and whether they are shown.
typedef struct RfNodesAt
{
    double time;
    const RfMat4* worlds;
    const bool* shown;
} RfNodesAt;

// Poses what changes of `scene` into `posed`, in the layout; without memory it is only measured. Fails with RF_ERROR_SCENE.
RfResult rf_pose_changes( const RfScene* scene, const RfNodesAt* nodes, RfLayout* layout, RfScene* posed, RfError* error );

// Extends a hash by all of it, without memory.
uint64_t rf_hash_changes( const RfScene* scene, const RfNodesAt* nodes, uint64_t hash );

#endif
