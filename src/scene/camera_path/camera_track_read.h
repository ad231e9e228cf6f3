// Inside of the reader of camera paths: what its parts share. Users have
// scene/camera_track.h.
#ifndef REFRAME_SCENE_CAMERA_PATH_CAMERA_TRACK_READ_H
#define REFRAME_SCENE_CAMERA_PATH_CAMERA_TRACK_READ_H

#include "scene/camera_path/camera_track.h"
#include "scene/json/json_document.h"

#define RF_MAX_TRACK_SECONDS 1e6
#define RF_MAX_TRACK_FRAMES 1e6
#define RF_DEFAULT_FOV 40.0 // degrees

// camera_track_look.c. Members of objects; points are required, the others are
// left as they are where they are not given.
RfRange rf_coordinates( void );
RfResult rf_read_point( const RfField* object, const char* key, double point[3] );
RfResult rf_read_up( const RfField* field, double up[3] );
RfResult rf_read_rotation( const RfField* field, double q[4] ); // required
RfResult rf_read_fov( const RfField* field, double* fov );
RfResult rf_read_interpolation( const RfField* top, bool* linear );

// A path looks at targets, with an up, or is turned by rotations: the two do
// not mix, neither in one key nor from key to key.
RfResult rf_check_look( const RfField* object, bool rotates );

// Curves of the ready-made movements, over the share of the time, 0 to 1: one
// value all the time, or leading from the first of two to the second.
RfResult rf_constant_curve( RfCurveKind kind, const double* value, RfCurve* curve, RfError* error );
RfResult rf_lead_curve( RfCurveKind kind, const double* both, RfCurve* curve, RfError* error );

// One field of view, or {"from": …, "to": …}.
RfResult rf_read_lens( const RfField* top, bool must_change, RfCameraTrack* track );
// Target and up, or a rotation; `fallback` (or NULL) is a target that need not be given.
RfResult rf_read_look( const RfField* top, const double* fallback, RfCameraTrack* track );
// The time that a movement takes: exactly one of `names`, which are "duration",
// "frames" and, for walks, "speed".
RfResult rf_name_clock( const RfField* field, RfCameraTrack* track ); // the value that says how long it takes
RfResult rf_read_span( const RfField* top, const char* const* names, RfCameraTrack* track );

// camera_track_keys.c
RfResult rf_read_keyed( const RfField* top, RfCameraTrack* track );

// camera_track_moves.c
RfResult rf_read_orbit( const RfField* top, RfCameraTrack* track );
RfResult rf_read_dolly( const RfField* top, RfCameraTrack* track );
RfResult rf_read_zoom( const RfField* top, RfCameraTrack* track );
RfResult rf_read_walk( const RfField* top, RfCameraTrack* track );

#endif
