// From a scene's cameras and animation channels to eyes, one per frame.
#ifndef REFRAME_SCENE_CAMERA_H
#define REFRAME_SCENE_CAMERA_H

#include "scene/eye.h"
#include "scene/scene.h"

// Index of the camera called `name`; with NULL the first animated one, else
// the first. Fails with RF_ERROR_USAGE, naming the cameras there are.
RfResult rf_find_camera( const RfScene* scene, const char* name, int* index, RfError* error );

// Frames of a camera's animation sampled at `fps`: one at its first key, then
// one every 1/fps s up to and with the last (to within 1e-3 of a frame); 1 for
// a camera that stands still. Fails (RF_ERROR_USAGE) above 1,000,000 frames.
RfResult rf_camera_frame_count( const RfCamera* camera, double fps, int* count, RfError* error );

// The eye of `camera` at `time` seconds on a film of width × height pixels.
// Animated ancestors and mirroring or scaling parents are honoured; the axes
// are orthonormalised, the camera looks along −Z of its node with +Y up.
// Fails (RF_ERROR_SCENE) where the transform collapses or is not finite.
RfResult rf_scene_eye( const RfScene* scene, int camera, double time, int width, int height, RfEye* eye,
                       RfError* error );

// World matrix of a node at `time` seconds.
void rf_node_world_matrix( const RfScene* scene, int node, double time, RfMat4* matrix );

#endif
