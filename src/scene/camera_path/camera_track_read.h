// Internal to the reader of camera paths; users include scene/camera_path/camera_track.h.
#ifndef REFRAME_SCENE_CAMERA_PATH_CAMERA_TRACK_READ_H
#define REFRAME_SCENE_CAMERA_PATH_CAMERA_TRACK_READ_H

#include "scene/camera_path/camera_track.h"
#include "scene/json/json_document.h"

#define RF_MAX_TRACK_SECONDS 1e6
#define RF_MAX_TRACK_FRAMES 1e6
#define RF_DEFAULT_FOV 40.0 // degrees
#define RF_MAX_SHIFT 1000.0 // heights of the picture

// The range of valid coordinates.
RfRange rf_coordinates( void );

// Reads a member that is a point, which is required.
RfResult rf_read_point( const RfField* object, const char* key, double point[3] );

// Compares values, not bits: zero has two signs.
bool rf_is_same_point( const double a[3], const double b[3] );

// Reads an up direction; without one `up` is unchanged.
RfResult rf_read_up( const RfField* field, double up[3] );

// Reads a rotation, which is required.
RfResult rf_read_rotation( const RfField* field, double q[4] ); // required

// Reads "projection" into the track.
RfResult rf_read_projection( const RfField* top, RfCameraTrack* track );

// What says how much a camera sees: "fov", or "ymag" if it is orthographic.
const char* rf_extent_name( RfProjectionKind projection );

// Fails if an object has what a camera of this projection has not.
RfResult rf_check_projection( const RfField* object, RfProjectionKind projection );

// Reads a field of view in degrees, or ymag in metres, which is required; without a field of view `value` is unchanged.
RfResult rf_read_extent( const RfField* field, RfProjectionKind projection, double* value );

// Reads whether to interpolate linearly; without it `linear` is unchanged.
RfResult rf_read_interpolation( const RfField* top, bool* linear );

// Checks that a path uses either targets and up, or rotations; the two cannot be mixed.
RfResult rf_check_look( const RfField* object, bool rotates );

// A curve over the fraction of the duration, 0 to 1: constant, or from a first value to a
// second.
RfResult rf_constant_curve( RfCurveKind kind, const double* value, RfCurve* curve, RfError* error );

// A curve from the first of two values to the second.
RfResult rf_lead_curve( RfCurveKind kind, const double* both, RfCurve* curve, RfError* error );

// Reads a constant field of view, or {"from": …, "to": …}.
RfResult rf_read_lens( const RfField* top, bool must_change, RfCameraTrack* track );

// Reads target and up, or a rotation; `fallback` is the default target, or NULL.
RfResult rf_read_look( const RfField* top, const double* fallback, RfCameraTrack* track );

// Names the value that determines the duration.
RfResult rf_name_clock( const RfField* field, RfCameraTrack* track );

// Reads the duration of a movement: exactly one of `names`, which are "duration", "frames"
// and, for walks, "speed".
RfResult rf_read_span( const RfField* top, const char* const* names, RfCameraTrack* track );

// Reads a path of keys (camera_track_keys.c).
RfResult rf_read_keyed( const RfField* top, RfCameraTrack* track );

// Reads a movement (camera_track_moves.c).
RfResult rf_read_orbit( const RfField* top, RfCameraTrack* track );

// Reads a dolly.
RfResult rf_read_dolly( const RfField* top, RfCameraTrack* track );

// Reads a zoom.
RfResult rf_read_zoom( const RfField* top, RfCameraTrack* track );

// Reads a walk along waypoints.
RfResult rf_read_walk( const RfField* top, RfCameraTrack* track );

#endif
