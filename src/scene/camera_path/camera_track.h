// A camera path of our own: where a camera is at any time, by keys or by one of
// the ready-made movements. anim/camera-path.schema.json tells the format.
#ifndef REFRAME_SCENE_CAMERA_PATH_CAMERA_TRACK_H
#define REFRAME_SCENE_CAMERA_PATH_CAMERA_TRACK_H

#include "reframe/error.h"
#include "scene/camera_path/curve.h"
#include "scene/camera_path/waypoints.h"

#include <stdbool.h>
#include <stdint.h>

typedef enum RfTrackKind
{
    RF_TRACK_KEYED,
    RF_TRACK_ORBIT,
    RF_TRACK_DOLLY,
    RF_TRACK_ZOOM,
    RF_TRACK_WALK,
    RF_TRACK_KIND_COUNT
} RfTrackKind;

// A circle about the vertical: angle 0 is on the side of +z, growing angles go
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
    char* name;     // of the file, with the JSON path where it stands inside another
    uint64_t hash;  // of the file's bytes; 0 where it stands inside another
    bool in_frames; // times count frames, whatever the frames per second; else seconds
    char* clock;    // what says how long it takes: "move.json: duration", "scene.json: camera.keys[7].time"
    double start, end;
    RfCurve position;   // none for orbits and walks
    RfCurve target, up; // none where there is a rotation; walks may look ahead without a target
    RfCurve rotation;
    RfCurve fov; // vertical, degrees
    RfOrbit orbit;
    RfWaypoints walk;
    double look_ahead; // m along a walk's curve
} RfCameraTrack;

// What an eye needs, unit axes.
typedef struct RfView
{
    double position[3], forward[3], up[3];
    double fov; // vertical, radians
} RfView;

// Reads a camera-path file. Faults name file and JSON path. On failure the
// track is empty; free with rf_destroy_camera_track.
RfResult rf_load_camera_track( const char* path, RfCameraTrack* track, RfError* error );
// The same from an object inside another file.
struct RfField;
RfResult rf_read_camera_track( const struct RfField* object, RfCameraTrack* track, RfError* error );
void rf_destroy_camera_track( RfCameraTrack* track );

// The view at a time (seconds or frames as the track counts). Fails with
// RF_ERROR_SCENE where it has no direction: the camera on its target, or up
// along the view.
RfResult rf_sample_camera_track( const RfCameraTrack* track, double time, RfView* view, RfError* error );

#endif
