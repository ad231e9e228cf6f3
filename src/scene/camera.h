// From a scene's cameras and animation channels to eyes, one per frame.
#ifndef REFRAME_SCENE_CAMERA_H
#define REFRAME_SCENE_CAMERA_H

#include "scene/eye.h"
#include "scene/scene.h"

// Index of the camera called `name`; with NULL the one that the scene file asks
// for, else the first animated one, else the first. Fails with RF_ERROR_USAGE, naming the cameras there are.
RfResult rf_find_camera( const RfScene* scene, const char* name, int* index, RfError* error );

// Frames of a camera's animation sampled at `fps`: one at its first key, then
// one every 1/fps s up to and with the last (to within 1e-3 of a frame); 1 for
// a camera that stands still. Paths of our own that count frames have as many
// whatever the fps. Fails above 1,000,000 frames (RF_ERROR_SCENE, naming the file
// and where in it, of a camera of the scene its name only) and for an fps that is
// not above 0 (RF_ERROR_USAGE).
RfResult rf_camera_frame_count( const RfCamera* camera, double fps, int* count, RfError* error );
// The same; the line names the file of any camera.
RfResult rf_scene_frame_count( const RfScene* scene, const RfCamera* camera, double fps, int* count, RfError* error );

// The eye of `camera` at `time` seconds on a film of width × height pixels.
// Animated ancestors and mirroring or scaling parents are honoured; the axes
// are orthonormalised, the camera looks along −Z of its node with +Y up.
// Fails (RF_ERROR_SCENE) where the transform collapses or is not finite, and
// where the camera's path counts frames instead of seconds: rf_camera_eye then.
RfResult rf_scene_eye( const RfScene* scene, int camera, double time, int width, int height, RfEye* eye, RfError* error );

// A camera whose path is read from a file (scene/camera_track.h), called by the
// file's name. Free with rf_destroy_camera.
RfResult rf_load_camera( const char* path, RfCamera* camera, RfError* error );

// The same from an object inside another file. `name` is copied.
struct RfField;
RfResult rf_read_camera( const struct RfField* object, const char* name, RfCamera* camera, RfError* error );

// The eye of a camera (of the scene, or one from rf_load_camera) at a frame of
// its path, from 0, at numerator / denominator frames per second.
RfResult rf_camera_eye( const RfScene* scene, const RfCamera* camera, double frame, int numerator, int denominator, int width,
                        int height, RfEye* eye, RfError* error );

// World matrix of a node at `time` seconds.
void rf_node_world_matrix( const RfScene* scene, int node, double time, RfMat4* matrix );

#endif
