// A scene as it is at a moment: what moves at its place, and in its shape.
#ifndef REFRAME_SCENE_POSE_H
#define REFRAME_SCENE_POSE_H

#include "base/layout.h"
#include "scene/scene.h"

// Starts as zeros.
typedef struct RfPosedScene
{
    double time;
    // Placements and meshes are the pose's own, punctual lights and materials where some change; all else is shared: to be read like
    // any scene, never destroyed. A lamp that is hidden has intensity 0. What deforms has meshes after those of the scene; they
    // stand in the world, relative to its origin, or, where only morph targets deform them, in the space of the mesh. Triangles
    // have the same numbers at all times; the bounds are those of the scene.
    RfScene scene;
    uint64_t hash; // of what moves: as rf_moment_hash
    void* memory;  // of rf_pose_bytes, aligned to 64 bytes; NULL: rf_pose_scene allocates it, and rf_destroy_pose frees it
    bool owned;
    // Before it is posed. It is a moment of a shutter (scene/moments.h): all that deforms, and all that may flatten, stands in the
    // world. Of places and shapes alone: images are not read; else lamps, materials, the sky, images and what is shown are as at
    // `middle` seconds of the shutter, where no moment may lie.
    bool in_shutter, places_alone;
    double middle;
} RfPosedScene;

// What a pose of the scene needs: all that it has while it lives, and what posing takes meanwhile.
size_t rf_pose_bytes( const RfScene* scene );

// What a pose has of its own where much deforms at once: meshes, and their triangles.
typedef struct RfPoseParts
{
    int meshes;
    uint64_t triangles;
    uint32_t most_triangles; // of one mesh
    size_t image_bytes;      // that reading one image takes meanwhile
} RfPoseParts;
RfPoseParts rf_pose_parts( const RfScene* scene );

// Poses what moves and changes as it is at `time` seconds, which counts as the first or last key outside of the keys. A pose may be
// posed again. Fails with RF_ERROR_SCENE, naming the object and the time, where something lies further out than floats
// compute with, or has a value that the file may not have. What shrinks to a point is not shown.
RfResult rf_pose_scene( const RfScene* scene, double time, RfPosedScene* pose, RfError* error );

void rf_destroy_pose( RfPosedScene* pose );

// Whether anything differs between two times: visibility, place, shape, light or material. True if there is no memory to find out.
bool rf_scene_moves( const RfScene* scene, double t0, double t1 );
// Whether the visibility, place or shape of a surface differs.
bool rf_surfaces_move( const RfScene* scene, double t0, double t1 );

// A hash of how all that moves and changes is at a time: that of a pose, at a fraction of its cost. Fails with RF_ERROR_MEMORY.
RfResult rf_moment_hash( const RfScene* scene, double time, uint64_t* hash, RfError* error );

// Decodes the images of a time for `posed` into the layout; without memory they are only measured. Errors name the file.
RfResult rf_pose_images( const RfScene* scene, double time, RfLayout* layout, RfScene* posed, RfError* error );

#endif
