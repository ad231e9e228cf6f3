// Evaluates cameras and their animation: one RfEye per frame.
#ifndef REFRAME_SCENE_CAMERA_H
#define REFRAME_SCENE_CAMERA_H

#include "scene/eye.h"
#include "scene/scene.h"

// Index of the camera called `name`. NULL selects the scene file's choice, else the
// first animated camera, else the first. Fails with RF_ERROR_USAGE, listing the cameras.
RfResult rf_find_camera( const RfScene* scene, const char* name, int* index, RfError* error );

// Frames of a camera: frame i has the number first + i · step, and the frame that is called 1 is at 0 s.
typedef struct RfCameraFrames
{
    int first, step, count;
} RfCameraFrames;

// They begin at 0 s, number 1, and go on to the last key of the camera and of all that moves (to within 1e-3 of a frame); the camera
// is held before its first key and after its last. A path that says how long it is, by frame numbers of two keys or more, by a
// duration or a count of frames, ends there, and one by frame numbers begins with its first. Without movement, a camera that stands
// still has one frame. Fails above 1,000,000 frames (RF_ERROR_SCENE; the message gives the file and the position in it, or the
// camera's name if it belongs to the scene) and unless fps > 0 (RF_ERROR_USAGE).
RfResult rf_camera_frames( const RfScene* scene, const RfCamera* camera, double fps, RfCameraFrames* frames, RfError* error );

// Reads a camera path from a file (scene/camera_path/camera_track.h); the camera is named after
// the file. Free with rf_destroy_camera.
RfResult rf_load_camera( const char* path, RfCamera* camera, RfError* error );

// Reads a camera path from a JSON object inside another file. `name` is copied.
struct RfField;
RfResult rf_read_camera( const struct RfField* object, const char* name, RfCamera* camera );

// How the path of a camera is sampled.
typedef struct RfCameraSampling
{
    const RfScene* scene;
    const RfCamera* camera; // of the scene or from rf_load_camera
    const RfLens* lens;     // in the place of the camera's own; NULL: that
    RfFps fps;
    int width, height; // of the film, pixels
} RfCameraSampling;

// The camera at frame `frame` of its path, counted from 0, in the shot that the frame is in. It follows animated ancestors,
// also mirrored or scaled ones; the axes are orthonormalised. The camera looks along −Z of its node with +Y up.
// Fails (RF_ERROR_SCENE) if the transform is degenerate or not finite.
// Lens and shutter end where the shot does: beyond, the path is extrapolated, and what moves is
// blurred up to there. Fails with RF_ERROR_SCENE for a lens without a focus, and where the node in focus does not
// exist or is not before the camera; with RF_ERROR_USAGE where a focus is asked for but there is no aperture.
RfResult rf_camera_eye( const RfCameraSampling* sampling, double frame, RfEye* eye, RfError* error );

// Finds the cuts of a camera that moves with its node: keys of STEP interpolation at which it, an ancestor or its zoom jumps, if no key of the
// same channel is nearer than 0.25 s. Fails with RF_ERROR_MEMORY.
RfResult rf_find_step_cuts( const RfScene* scene, RfCamera* camera, RfError* error );

// Shots of its path: one more than cuts.
int rf_camera_shots( const RfCamera* camera );

// World matrix of a node at `time` seconds.
void rf_node_world_matrix( const RfScene* scene, int node, double time, RfMat4* matrix );

#endif
