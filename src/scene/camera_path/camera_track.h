// A camera path: the camera at any time, from keys or by one of the built-in movements. The
// format is described by anim/camera-path.schema.json.
#ifndef REFRAME_SCENE_CAMERA_PATH_CAMERA_TRACK_H
#define REFRAME_SCENE_CAMERA_PATH_CAMERA_TRACK_H

#include "base/json.h"
#include "reframe/camera.h"
#include "scene/camera_path/curve.h"

#include <stdbool.h>
#include <stdint.h>

// The lens and the shutter of a camera, as files have them.

#define RF_DEFAULT_SENSOR 0.024 // height of the film, m: that of 35 mm film

typedef struct RfOptics
{
    double fstop;      // 0: by the radius
    double radius;     // of the lens, m; 0: a pinhole
    double sensor;     // height of the film, m: with the angle of view it gives the focal length that f-numbers divide
    double focus;      // m along the view; 0: none given
    char* focus_node;  // the node that is in focus, owned; NULL: by distance
    int blades;        // 0, or 3 and more
    double rotation;   // of the blades, rad
    double shutter[2]; // when it opens and closes, frames from the frame's own time
} RfOptics;

// Reads the member "lens" of a camera path or of a glTF node's extras; without it `optics` is a pinhole whose shutter is open for
// no time.
RfResult rf_read_optics( const RfField* object, RfOptics* optics );

void rf_destroy_optics( RfOptics* optics );

static inline bool rf_has_shutter( const RfOptics* optics ) { return optics->shutter[1] > optics->shutter[0]; }
static inline bool rf_has_lens( const RfOptics* optics ) { return optics->fstop > 0.0 || optics->radius > 0.0; }

// The radius of the lens for a camera of this angle of view, m. An orthographic camera has no focal length: 1 m, as in Cycles.
double rf_optics_radius( const RfOptics* optics, const RfEye* eye );

// Camera paths.

typedef enum RfTrackKind
{
    RF_TRACK_KEYED,
    RF_TRACK_ORBIT,
    RF_TRACK_DOLLY,
    RF_TRACK_ZOOM,
    RF_TRACK_WALK,
    RF_TRACK_KIND_COUNT
} RfTrackKind;

// A circle about the vertical axis: angle 0 is towards +z, and angles increase
// counter-clockwise seen from above.
typedef struct RfOrbit
{
    double center[3];
    double radius, height;
    double start, turn; // radians
} RfOrbit;

typedef struct RfCameraTrack
{
    RfTrackKind kind;
    char* name;     // of the file, followed by the JSON path if it is inside another file
    uint64_t hash;  // of the bytes of the file; 0 if it is inside another file
    bool in_frames; // times are frames, the one called 1 is at 0, independent of the frame rate; else seconds
    int step;       // frames from one of the picture to the next; 1 unless in_frames
    char* clock;    // where the duration is given: "move.json: duration", "scene.json:
                    // camera.keys[7].time"
    double start, end;
    RfCurve position;   // empty for orbits and walks
    RfCurve target, up; // empty with a rotation; walks may look ahead without a target
    RfCurve rotation;
    RfProjectionKind projection;
    RfCurve fov;      // vertical, degrees; of an orthographic camera ymag, half the height of the picture in m
    RfCurve shift[2]; // right and up, heights of the picture; empty: none
    double aspect;    // of the pixels, width over height
    RfOptics optics;
    RfCurve focus, fstop; // by keys, before those of the optics; empty: none
    RfOrbit orbit;
    RfWaypoints walk;
    double look_ahead; // m ahead along the curve of a walk
    int cut_count;     // of a keyed path
    int* cuts;         // ascending: keys with which another shot begins
} RfCameraTrack;

// Position and unit axes of a camera.
typedef struct RfView
{
    double position[3], forward[3], up[3];
    RfProjectionKind projection;
    double fov; // vertical, radians; orthographic: ymag
    double shift[2], aspect;
    double focus, fstop; // m; 0: no keys have them
} RfView;

// Reads a camera path file. Errors give the file and the JSON path. On failure the track is
// empty; free with rf_destroy_camera_track.
RfResult rf_load_camera_track( const char* path, RfCameraTrack* track, RfError* error );

// Reads a camera path from a JSON object inside another file.
RfResult rf_read_camera_track( const RfField* object, RfCameraTrack* track );

// Frees the curves and names of a track and clears it.
void rf_destroy_camera_track( RfCameraTrack* track );

// False where all keys of a keyed path are the same: the camera stands still in all its frames.
bool rf_camera_track_moves( const RfCameraTrack* track );

// The shot at a time, from 0: a path has one more than cuts.
int rf_track_shot( const RfCameraTrack* track, double time );

// Gives the curves of the shots the shape that they have as paths of their own.
void rf_part_track( RfCameraTrack* track );

// A shot as a path of its own, which borrows all from `track`.
RfCameraTrack rf_shot_of_track( const RfCameraTrack* track, int shot );

// The view at a time (in seconds or frames, as the track has it). Fails with RF_ERROR_SCENE if
// the view has no direction: the camera is on its target, or up is parallel to the view.
RfResult rf_sample_camera_track( const RfCameraTrack* track, double time, RfView* view, RfError* error );

#define RF_MAX_TRACK_SECONDS 1e6
#define RF_MAX_TRACK_FRAMES 1e6
#define RF_DEFAULT_FOV 40.0 // degrees
#define RF_MAX_SHIFT 1000.0 // heights of the picture

// Reads a rotation, which is required.
RfResult rf_read_rotation( const RfField* field, double q[4] ); // required

// Reads whether keys are joined linearly, rather than smoothly; false where nothing is said.
RfResult rf_read_interpolation( const RfField* object, bool* linear );

// Reads when key `index` is, in seconds or as the number of a frame, which must be later than the key before it.
RfResult rf_read_key_time( const RfField* key, bool in_frames, int index, double* times );

#endif
