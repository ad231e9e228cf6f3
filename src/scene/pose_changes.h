// Internal to scene/pose.c: lamps, materials and the sky as they are at a time.
#ifndef REFRAME_SCENE_POSE_CHANGES_H
#define REFRAME_SCENE_POSE_CHANGES_H

#include "scene/pose.h"

// What a pose has of its own for them, a multiple of 64.
size_t rf_changes_bytes( const RfScene* scene );

// Where the moving nodes are at a time, and whether they are shown.
typedef struct RfNodesAt
{
    double time;
    const RfMat4* worlds;
    const bool* shown;
} RfNodesAt;

// Poses what changes of `scene` into `posed`, in memory of rf_changes_bytes. Fails with RF_ERROR_SCENE.
RfResult rf_pose_changes( const RfScene* scene, const RfNodesAt* nodes, char* memory, RfScene* posed, RfError* error );

// Extends a hash by all of it, without memory.
uint64_t rf_hash_changes( const RfScene* scene, const RfNodesAt* nodes, uint64_t hash );

#endif
