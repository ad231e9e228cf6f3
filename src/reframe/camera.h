// Cameras. RfEye is the camera of one frame: its position, orientation, lens and moment. A camera path holds those
// of all frames of an animation, from a scene or from a camera-path file.
//
//     RfCameraPath path;
//     RfPathOptions options = { .fps = { 24, 1 }, .width = 960, .height = 540 };
//     if ( rf_create_camera_path( scene, &options, &path, &error ) == RF_OK )
//         printf( "%s has %d frames\n", path.name, path.count );
//     rf_destroy_camera_path( &path );
//
// Any array of cameras can be rendered, one of the caller's own too: rf_make_eye.
#ifndef REFRAME_CAMERA_H
#define REFRAME_CAMERA_H

#include "reframe/error.h"
#include "reframe/scene.h"
#include "reframe/types.h"

#include <stdbool.h>
#include <stdint.h>

RF_API_BEGIN

// Position, orientation, focal length and shift of a camera at a moment of the shutter.
typedef struct RfPose
{
    RfVec3 origin;
    RfVec3 forward, up;          // unit vectors
    float focal, axis_x, axis_y; // as those of RfEye
} RfPose;

typedef enum RfProjectionKind
{
    RF_PERSPECTIVE,
    RF_ORTHOGRAPHIC, // parallel rays along `forward`, from the plane through the origin
    RF_PANORAMIC,    // equirectangular: all directions, longitude across and latitude down, `forward` in the middle
} RfProjectionKind;

// A camera in world space (less the scene's origin: RfSceneInfo), with its film in pixels. Film coordinates: x to the right,
// y down, pixel (i, j) is the unit square [i, i+1) × [j, j+1). It is a pinhole that stands still, unless it has a thin lens
// (rf_set_lens) or moves while the shutter is open (rf_set_shutter): then this is the middle of both.
typedef struct RfEye
{
    RfVec3 origin;
    RfVec3 right, up, forward; // orthonormal
    float focal;               // focal length in heights of a pixel; orthographic: pixels per m; panoramic: per radian
    float focal_x;             // the same in widths of a pixel, which need not be square
    float axis_x, axis_y;      // where `forward` meets the film: its middle, unless the lens is shifted
    int width, height;         // film size in pixels
    int projection;            // RfProjectionKind
    float shear_x, shear_y;    // orthographic: parts of the rays' direction along right and up, per m along forward

    // the thin lens
    float lens_radius; // m; 0: a pinhole, all of the picture is sharp
    float focus;       // m along `forward`: what lies there is sharp
    int blades;        // sides of the aperture, 3 or more; 0: a disc
    float blade_angle; // rad: turns the polygon from a corner at the right, counter-clockwise

    int moves;          // 1 if the poses below count
    RfPose open, close; // where the camera is when the shutter opens and closes

    double time; // moment of the scene that it sees, s; 0 where nothing moves

    // What moves in the scene while the shutter is open is blurred as well.
    double opens, closes; // moments of the scene; 0 unless blur_steps is above
    int64_t blur_steps;   // straight steps from the one to the other, up to RF_MAX_BLUR_STEPS; 0: all is as at `time`

    // Number of its shot. Along a path it never falls, and rises at a cut: frames of different shots share no samples, and none
    // has motion towards another.
    int64_t shot;
} RfEye;

// A right-handed camera at `origin` that looks along `forward`, with `up` orthogonalised against it;
// `yfov` is the vertical field of view in radians. `forward` and `up` need not be unit vectors but must not be zero or parallel.
// Here and below, what cannot be a camera (such vectors, a field of view that is not between 0 and pi, numbers that are not finite)
// gives one that whatever renders refuses with RF_ERROR_USAGE.
// Pixels are square and the lens is centred.
RfEye rf_make_eye( RfVec3 origin, RfVec3 forward, RfVec3 up, double yfov, int width, int height );

// An orthographic camera whose picture is 2 ymag metres high.
RfEye rf_make_orthographic_eye( RfVec3 origin, RfVec3 forward, RfVec3 up, double ymag, int width, int height );

// A panoramic camera. Its pixels are square in the middle of a picture twice as wide as high; it takes no shift and no lens.
RfEye rf_make_panoramic_eye( RfVec3 origin, RfVec3 forward, RfVec3 up, int width, int height );

// Gives the pixels of a new camera an aspect, width over height, and moves its picture to the right
// and up by shifts in heights of the picture.
void rf_shift_eye( RfEye* eye, double pixel_aspect, double shift_x, double shift_y );

// Gives a new camera a thin lens of this radius (m; of the circle around the blades) that is focused at a distance (m along
// `forward`; infinity is a valid one). `blades`: 0 or 3 and more; their rotation in radians.
void rf_set_lens( RfEye* eye, double radius, double focus, int blades, double rotation );

// Lets the camera move while the shutter is open: through the places, directions, angles of view and shifts of three new
// cameras, of which `eye` itself is the middle, on a curve of second order.
void rf_set_shutter( RfEye* eye, const RfEye* open, const RfEye* close );

// The path of a camera: its state in each frame.
typedef struct RfCameraPath
{
    char* name;       // of the camera, or of the file
    int count;        // frames
    RfEye* eyes;      // count of them
    int first;        // number of the first frame, by which files and messages call it
    int step;         // from the number of a frame to that of the next
    RfFps fps;        // that it was sampled at
    double origin[3]; // of the scene (RfSceneInfo): the cameras are relative to it
    int overscan[2];  // pixels that films have beyond the picture, on the left and the right, above and below
    // Aspect ratio that the camera was made for, where the picture has another one, which shows more or less at its sides: the height
    // is as the camera has it. 0: the picture has it, or the camera does not say.
    double unmet_aspect;
    uint64_t hash; // of all cameras: a frame is made of its neighbours' samples too

    // Frames in a row with the same camera are a run, which needs to be rendered only once.
    int run_count;
    RfEye* runs;       // run_count of them
    int* run_of_frame; // count of them, ascending
} RfCameraPath;

// The number of frame `frame`, which counts from 0: numbers are those of the camera path, or from 1.
int rf_frame_number( const RfCameraPath* path, int frame );

// A path without frames, which rf_destroy_camera_path accepts.
RfCameraPath rf_empty_camera_path( void );

// Limits, of the program's options and of scene and camera-path files too.
#define RF_MAX_FSTOP 1e6     // beyond that a pinhole would do
#define RF_MAX_FOCUS 1e6     // m
#define RF_MAX_SHUTTER 100.0 // frames before and after the frame's own time
#define RF_MAX_BLUR_STEPS 32
#define RF_BLUR_STEPS 4 // unless asked for others

// A lens and a shutter in the place of a camera's own.
typedef struct RfLens
{
    bool has_shutter;
    double shutter[2]; // when it opens and closes, frames from the frame's own time; equal: no motion blur
    bool has_fstop;
    double fstop;           // 0: a pinhole
    double focus;           // m along the view; 0: the camera's own
    const char* focus_node; // the node of the scene that is in focus; NULL: none
    int blur_steps;         // straight steps that what moves in the scene takes while the shutter is open; 0: RF_BLUR_STEPS
} RfLens;

// A margin around the picture, which the same camera sees, for what a compositor shakes, warps or blurs.
typedef struct RfOverscan
{
    double size;   // pixels on each side, or of 1: of the width on the left and the right, of the height above and below
    bool relative; // the latter; pixels are rounded up
} RfOverscan;

// Which camera's path is sampled, and how; all zero: as the scene has it.
typedef struct RfPathOptions
{
    const char* camera;  // of the scene; a name that ends in ".json" is a camera-path file; NULL: the camera that a scene file
                         // asks for, else the first animated one, else the first
    const RfLens* lens;  // NULL: the camera's own
    RfFps fps;           // 0/0: the scene's own (RfSceneInfo), else 24
    int width, height;   // of the picture, pixels; 0 × 0: likewise, else as many as 960 × 540 in the camera's aspect ratio
    RfOverscan overscan; // makes films larger than the picture
} RfPathOptions;

// Samples the path of a camera. On failure the path is empty: RF_ERROR_USAGE where there is no such camera (the line names
// those there are), for a lens beyond the limits and for a panorama with overscan, RF_ERROR_SCENE for a path that cannot be
// followed, RF_ERROR_MEMORY, or as reading the file fails.
RfResult rf_create_camera_path( const RfScene* scene, const RfPathOptions* options, RfCameraPath* path, RfError* error );

// Frees what a path holds and empties it.
void rf_destroy_camera_path( RfCameraPath* path );

// The matrices of a camera as OpenEXR's worldToCamera and worldToNDC have them: row vectors
// (p' = p · M), 16 floats row by row. Camera space: metres, the camera at the origin, +x right, +y up,
// looking along −z. NDC: after the division by w the film is x and y in [−1, 1], +y up; z is −1 at
// 1 cm in front of the camera and 1 infinitely far away, of orthographic cameras 1 at 1 km. A panorama has no NDC: zeros.
// Of a film with overscan it is that of the whole film.
void rf_eye_matrices( const RfEye* eye, float world_to_camera[16], float world_to_ndc[16] );

RF_API_END

#endif
