// Reads and validates camera-path files (anim/camera-path.schema.json).
#include "base/try.h"
#include "scene/camera_path/camera_track.h"

#include "math/quat.h"
#include "scene/projection.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static RfResult check_projection( const RfField* object, RfProjectionKind projection );

// Projections, and how much of the scene they show: a field of view, the height of the picture, or all.

#define MAX_YMAG 1e12 // m

// Reads "projection" into the track.
static RfResult read_projection( const RfField* top, RfCameraTrack* track )
{
    int index = 0;
    rf_get_choice( top, "projection", g_rf_projection_names, &index );
    track->projection = (RfProjectionKind)index;
    return check_projection( top, track->projection );
}

static RfExtent extent_of( RfProjectionKind projection ) { return rf_projection_traits( projection )->extent; }

// The member that says how much a camera sees; that of one that sees all is missing.
static const char* extent_name( RfProjectionKind projection )
{
    return extent_of( projection ) == RF_EXTENT_YMAG ? "ymag" : "fov";
}

// Fails if an object has what a camera of this projection has not.
static RfResult check_projection( const RfField* object, RfProjectionKind projection )
{
    RfField fov = rf_field_member( object, "fov" ), ymag = rf_field_member( object, "ymag" ),
            shift = rf_field_member( object, "shift" ), aspect = rf_field_member( object, "pixelAspect" );
    const RfProjectionTraits* traits = rf_projection_traits( projection );
    if ( traits->extent != RF_EXTENT_FOV && fov.json != NULL )
        return rf_field_fail( &fov, "is that of a perspective camera: %s", traits->instead_of_fov );
    if ( traits->extent != RF_EXTENT_YMAG && ymag.json != NULL )
        return rf_field_fail( &ymag, "is that of an orthographic camera: set \"projection\": \"orthographic\", or leave it out" );
    if ( !traits->takes_shift && shift.json != NULL )
        return rf_field_fail( &shift, "a panorama cannot be shifted: turn the camera" );
    if ( !traits->takes_shift && aspect.json != NULL )
        return rf_field_fail( &aspect, "a panorama fills its picture, whatever the shape of that: leave it out" );
    return rf_json_result( object );
}

// Reads a field of view in degrees, or ymag in metres, which is required; without a field of view `value` is unchanged.
static RfResult read_extent( const RfField* field, RfProjectionKind projection, double* value )
{
    if ( extent_of( projection ) != RF_EXTENT_YMAG )
        return rf_field_number( field, rf_range( 0.1, 179.0 ), value );
    if ( field->json == NULL )
        return rf_field_fail( field, "is missing: half the height of the picture, in metres" );
    return rf_field_number( field, rf_above( 0.0, MAX_YMAG ), value );
}

// Shared by all kinds of camera paths: points, directions, field of view, duration.

#define MAX_COORDINATE 1e15
#define DEGREE ( 3.14159265358979323846 / 180.0 )

// The range of valid coordinates.
static RfRange coordinates( void ) { return rf_range( -MAX_COORDINATE, MAX_COORDINATE ); }

// Reads a member that is a point, which is required.
static RfResult read_point( const RfField* object, const char* key, double point[3] )
{
    rf_field_require( object, key, "an array of 3 numbers" );
    return rf_get_numbers( object, key, coordinates(), 3, point );
}

// Compares values, not bits: zero has two signs.
static bool is_same_point( const double a[3], const double b[3] ) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }

// Reads an up direction; without one `up` is unchanged.
static RfResult read_up( const RfField* field, double up[3] )
{
    RfResult result = rf_field_numbers( field, coordinates(), 3, up );
    if ( result == RF_OK && up[0] == 0.0 && up[1] == 0.0 && up[2] == 0.0 )
        return rf_field_fail( field, "must be a direction, got three zeros" );
    return result;
}

// A rotation about +y (yaw), then about the camera's own x (pitch) and z (roll).
static RfResult read_angles( const RfField* field, double q[4] )
{
    static const char* const s_keys[] = { "yaw", "pitch", "roll", NULL };
    static const int s_axis[] = { 1, 0, 2 };
    rf_field_keys( field, s_keys );
    q[0] = q[1] = q[2] = 0.0;
    q[3] = 1.0;
    for ( int i = 0; i < 3; ++i )
    {
        double degrees = 0.0, turn[4] = { 0 }, before[4];
        rf_get_number( field, s_keys[i], rf_range( -1e6, 1e6 ), &degrees );
        turn[s_axis[i]] = sin( 0.5 * degrees * DEGREE );
        turn[3] = cos( 0.5 * degrees * DEGREE );
        memcpy( before, q, sizeof before );
        rf_quat_mul( before, turn, q );
    }
    return rf_json_result( field );
}

RfResult rf_read_rotation( const RfField* field, double q[4] )
{
    if ( json_is_object( field->json ) )
        return read_angles( field, q );
    if ( !json_is_array( field->json ) )
        return rf_field_must_be( field, "a quaternion [x, y, z, w] or an object of yaw, pitch, roll" );
    RfResult result = rf_field_numbers( field, rf_range( -2.0, 2.0 ), 4, q );
    double length = sqrt( q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] );
    // decimals written by hand are rounded
    if ( result == RF_OK && !( fabs( length - 1.0 ) < 0.1 ) )
        return rf_field_fail( field, "must be a quaternion of length 1, got length %g", length );
    rf_quat_normalize( q );
    return result;
}

// Checks that a path uses either targets and up, or rotations; the two cannot be mixed.
static RfResult check_look( const RfField* object, bool rotates )
{
    static const char* const s_look[] = { "target", "up" };
    for ( int i = 0; i < 2; ++i )
    {
        RfField field = rf_field_member( object, s_look[i] );
        if ( rotates && field.json != NULL )
            return rf_field_fail( &field, "not together with rotation: leave one of the two out" );
    }
    RfField rotation = rf_field_member( object, "rotation" );
    if ( !rotates && rotation.json != NULL )
        return rf_field_fail( &rotation, "the keys before it have none: give all of them one, or none" );
    return rf_json_result( object );
}

RfResult rf_read_interpolation( const RfField* top, bool* linear )
{
    static const char* const s_names[] = { "catmull-rom", "linear", NULL };
    int index = 0;
    rf_get_choice( top, "interpolation", s_names, &index );
    *linear = index == 1;
    return rf_json_result( top );
}

// Names the value that determines the duration.
static RfResult name_clock( const RfField* field, RfCameraTrack* track )
{
    char text[1024];
    snprintf( text, sizeof text, "%.800s: %s", field->file, field->path );
    track->clock = strdup( text );
    return track->clock != NULL ? rf_json_result( field ) : rf_field_no_memory( field );
}

// Reads the duration of a movement: exactly one of `names`, which are "duration", "frames"
// and, for walks, "speed".
static RfResult read_span( const RfField* top, const char* const* names, RfCameraTrack* track )
{
    const char* given = NULL;
    for ( int i = 0; names[i] != NULL; ++i )
    {
        RfField field = rf_field_member( top, names[i] );
        if ( field.json != NULL && given != NULL )
            return rf_field_fail( &field, "not together with %s: leave one of the two out", given );
        given = field.json != NULL ? names[i] : given;
    }
    if ( given == NULL )
        return rf_field_fail( top, "the duration is missing: give duration (seconds) or frames (their number)%s",
                              names[2] != NULL ? " or speed (metres per second)" : "" );
    RfField field = rf_field_member( top, given );
    double value = 0.0;
    int frames = 1;
    RF_TRY( name_clock( &field, track ) );
    if ( strcmp( given, "speed" ) == 0 )
    {
        RF_TRY( rf_field_number( &field, rf_above( 0.0, MAX_COORDINATE ), &value ) );
        track->end = value > 0.0 ? track->walk.length / value : 0.0;
        if ( !( track->end <= RF_MAX_TRACK_SECONDS ) )
            return rf_field_fail( &field, "%g m at %g m/s take longer than %g s", track->walk.length, value,
                                  RF_MAX_TRACK_SECONDS );
        return RF_OK;
    }
    track->in_frames = strcmp( given, "frames" ) == 0;
    if ( !track->in_frames )
        return rf_field_number( &field, rf_above( 0.0, RF_MAX_TRACK_SECONDS ), &track->end );
    rf_field_whole( &field, 1.0, RF_MAX_TRACK_FRAMES, &frames );
    track->end = (double)frames - 1.0;
    return rf_json_result( &field );
}

// A curve through values that have been read.
static RfResult join( const RfField* top, RfCurveKind kind, bool linear, int count, const double* times, const double* values,
                      RfCurve* curve )
{
    RfResult result = rf_json_result( top );
    return result == RF_OK ? rf_create_curve( kind, linear, count, times, values, curve, top->error ) : result;
}

// A curve over the fraction of the duration, 0 to 1: constant, or from a first value to a
// second.
static RfResult constant_curve( const RfField* top, RfCurveKind kind, const double* value, RfCurve* curve )
{
    static const double s_start[1] = { 0.0 };
    return join( top, kind, true, 1, s_start, value, curve );
}

// A curve from the first of two values to the second.
static RfResult lead_curve( const RfField* top, RfCurveKind kind, const double* both, RfCurve* curve )
{
    static const double s_ends[2] = { 0.0, 1.0 };
    return join( top, kind, true, 2, s_ends, both, curve );
}

// Reads a constant field of view, or {"from": …, "to": …}.
static RfResult read_lens( const RfField* top, bool must_change, RfCameraTrack* track )
{
    static const char* const s_keys[] = { "from", "to", NULL };
    read_projection( top, track );
    bool in_metres = extent_of( track->projection ) == RF_EXTENT_YMAG;
    RfField field = rf_field_member( top, extent_name( track->projection ) );
    double fov[2] = { RF_DEFAULT_FOV, RF_DEFAULT_FOV };
    if ( must_change && !json_is_object( field.json ) )
        return rf_field_must_be( &field,
                                 in_metres ? "an object of from and to, in metres" : "an object of from and to, in degrees" );
    if ( !json_is_object( field.json ) )
    {
        read_extent( &field, track->projection, fov );
        return constant_curve( top, RF_CURVE_NUMBER, fov, &track->fov );
    }
    rf_field_keys( &field, s_keys );
    for ( int i = 0; i < 2; ++i )
    {
        RfField end = rf_field_member( &field, s_keys[i] );
        rf_field_require( &field, s_keys[i], in_metres ? "metres" : "degrees" );
        read_extent( &end, track->projection, fov + i );
    }
    return lead_curve( top, RF_CURVE_NUMBER, fov, &track->fov );
}

// Reads target and up, or a rotation; `fallback` is the default target, or NULL.
static RfResult read_look( const RfField* top, const double* fallback, RfCameraTrack* track )
{
    RfField rotation = rf_field_member( top, "rotation" ), up_field = rf_field_member( top, "up" );
    double q[4], target[3], up[3] = { 0.0, 1.0, 0.0 };
    check_look( top, rotation.json != NULL );
    if ( rotation.json != NULL )
    {
        rf_read_rotation( &rotation, q );
        return constant_curve( top, RF_CURVE_ROTATION, q, &track->rotation );
    }
    read_up( &up_field, up );
    constant_curve( top, RF_CURVE_POINT, up, &track->up );
    if ( fallback != NULL && !rf_has_member( top, "target" ) )
        return constant_curve( top, RF_CURVE_POINT, fallback, &track->target );
    read_point( top, "target", target );
    return constant_curve( top, RF_CURVE_POINT, target, &track->target );
}

// Reads the built-in movements: orbit, dolly, zoom, walk.

#define MAX_WAYPOINTS 10000

// The members that movements share.
#define LOOK "target", "rotation", "up"
#define FILM "projection", "fov", "ymag"
#define SPAN "duration", "frames"

static const char* const s_span[] = { SPAN, NULL };

static RfResult read_orbit( const RfField* top, RfCameraTrack* track )
{
    static const char* const s_keys[] = { "kind", "center", "radius", "height", "start", "turn", LOOK, FILM, SPAN, "lens", NULL };
    RfOrbit* orbit = &track->orbit;
    double start = 0.0, turn = 360.0;
    rf_field_keys( top, s_keys );
    read_point( top, "center", orbit->center );
    rf_field_require( top, "radius", "a number > 0" );
    rf_get_number( top, "radius", rf_above( 0.0, MAX_COORDINATE ), &orbit->radius );
    rf_get_number( top, "height", coordinates(), &orbit->height );
    rf_get_number( top, "start", rf_range( -1e6, 1e6 ), &start );
    rf_get_number( top, "turn", rf_range( -1e6, 1e6 ), &turn );
    orbit->start = start * DEGREE;
    orbit->turn = turn * DEGREE;
    read_look( top, orbit->center, track );
    read_lens( top, false, track );
    return read_span( top, s_span, track );
}

static RfResult read_dolly( const RfField* top, RfCameraTrack* track )
{
    static const char* const s_keys[] = { "kind", "from", "to", LOOK, FILM, SPAN, "lens", NULL };
    double ends[6];
    rf_field_keys( top, s_keys );
    read_point( top, "from", ends );
    read_point( top, "to", ends + 3 );
    lead_curve( top, RF_CURVE_POINT, ends, &track->position );
    read_look( top, NULL, track );
    read_lens( top, false, track );
    return read_span( top, s_span, track );
}

static RfResult read_zoom( const RfField* top, RfCameraTrack* track )
{
    static const char* const s_keys[] = { "kind", "position", LOOK, FILM, SPAN, "lens", NULL };
    double position[3];
    rf_field_keys( top, s_keys );
    read_point( top, "position", position );
    constant_curve( top, RF_CURVE_POINT, position, &track->position );
    read_look( top, NULL, track );
    read_lens( top, true, track );
    return read_span( top, s_span, track );
}

static RfResult read_waypoints( const RfField* top, RfCameraTrack* track )
{
    bool linear;
    RfField list = rf_field_member( top, "waypoints" );
    rf_field_array( &list, "points", 2, MAX_WAYPOINTS );
    RfResult result = rf_read_interpolation( top, &linear );
    if ( result != RF_OK )
        return result;
    size_t count = json_array_size( list.json );
    double* points = malloc( 3 * count * sizeof *points );
    if ( points == NULL )
        return rf_field_no_memory( &list );
    for ( size_t i = 0; i < count && result == RF_OK; ++i )
    {
        RfField item = rf_field_item( &list, i );
        result = rf_field_numbers( &item, coordinates(), 3, points + 3 * i );
        if ( result == RF_OK && i > 0 && is_same_point( points + 3 * i, points + 3 * i - 3 ) )
            result = rf_field_fail( &item, "is the same point as the one before it: leave one of the two out" );
    }
    if ( result == RF_OK )
        result = rf_create_waypoints( linear, (int)count, points, &track->walk, top->error );
    free( points );
    if ( result == RF_OK && !( track->walk.length > 0.0 ) )
        return rf_field_fail( &list, "are too close together: the walk has no length" );
    return result;
}

static RfResult read_walk_look( const RfField* top, RfCameraTrack* track )
{
    RfField ahead = rf_field_member( top, "look_ahead" ), up_field = rf_field_member( top, "up" );
    bool fixed = rf_has_member( top, "target" ) || rf_has_member( top, "rotation" );
    if ( fixed && ahead.json != NULL )
        return rf_field_fail( &ahead, "not together with target or rotation: leave one of the two out" );
    if ( fixed )
        return read_look( top, NULL, track );
    double up[3] = { 0.0, 1.0, 0.0 };
    track->look_ahead = 0.1 * track->walk.length;
    read_up( &up_field, up );
    rf_field_number( &ahead, rf_above( 0.0, MAX_COORDINATE ), &track->look_ahead );
    return constant_curve( top, RF_CURVE_POINT, up, &track->up );
}

static RfResult read_walk( const RfField* top, RfCameraTrack* track )
{
    static const char* const s_keys[] = { "kind",  "waypoints", "interpolation", "look_ahead", LOOK, FILM,
                                          "speed", SPAN,        "lens",          NULL };
    static const char* const s_walk_span[] = { "duration", "frames", "speed", NULL };
    rf_field_keys( top, s_keys );
    RF_TRY( read_waypoints( top, track ) );
    read_walk_look( top, track );
    read_lens( top, false, track );
    return read_span( top, s_walk_span, track );
}

// Reads keyed camera paths.

#define MAX_KEYS 1000000

// Keys closer than this in time are an error: their speed would be infinite.
#define MIN_STEP 1e-6

// The value of the key, else the default of the whole path.
static RfField inherited( const RfField* key, const RfField* top, const char* name )
{
    return rf_field_member( rf_has_member( key, name ) ? key : top, name );
}

// The values of all keys, one array per property.
typedef struct Keys
{
    int count;
    double *times, *position, *target, *up, *rotation, *fov, *shift[2], *focus, *fstop;
    bool shifts; // any of them
    bool focuses, stops;
} Keys;

static RfResult read_cut( const RfField* key, int index, RfCameraTrack* track )
{
    bool cut = false;
    RfResult result = rf_get_bool( key, "cut", &cut );
    if ( result != RF_OK || !cut )
        return result;
    RfField field = rf_field_member( key, "cut" );
    if ( index == 0 )
        return rf_field_fail( &field, "the first key begins the path: a cut needs a key before it" );
    track->cuts[track->cut_count++] = index;
    return RF_OK;
}

RfResult rf_read_key_time( const RfField* key, bool in_frames, int index, double* times )
{
    const char* name = in_frames ? "frame" : "time";
    const char* want = in_frames ? "a frame number" : "a number of seconds";
    RfRange range = in_frames ? rf_range( -RF_MAX_TRACK_FRAMES, RF_MAX_TRACK_FRAMES ) : rf_range( 0.0, RF_MAX_TRACK_SECONDS );
    rf_field_require( key, name, want );
    RfResult result = rf_get_number( key, name, range, times + index );
    if ( result != RF_OK || index == 0 || times[index] - times[index - 1] >= MIN_STEP )
        return result;
    RfField field = rf_field_member( key, name );
    return rf_field_fail( &field, "%g is not later than the key before it, at %g", times[index], times[index - 1] );
}

static void read_shift( const RfField* field, Keys* keys, int i )
{
    double shift[2] = { 0.0, 0.0 };
    rf_field_numbers( field, rf_range( -RF_MAX_SHIFT, RF_MAX_SHIFT ), 2, shift );
    keys->shifts = keys->shifts || field->json != NULL;
    keys->shift[0][i] = shift[0];
    keys->shift[1][i] = shift[1];
}

// All keys have such a value, or none.
static RfResult read_lens_value( const RfField* key, const char* name, double high, int i, bool* any, double* values )
{
    RfField field = rf_field_member( key, name );
    if ( i > 0 && ( field.json != NULL ) != *any )
        return rf_field_fail( key, "%s: give all keys one, or none", name );
    *any = field.json != NULL;
    return rf_field_number( &field, rf_above( 0.0, high ), values + i );
}

static RfResult read_key( const RfField* top, const RfField* key, Keys* keys, int i, bool rotates, RfCameraTrack* track )
{
    static const char* const s_seconds[] = { "time", "cut",  "position", "target", "rotation", "up",
                                             "fov",  "ymag", "shift",    "focus",  "fstop",    NULL };
    static const char* const s_frames[] = { "frame", "cut",  "position", "target", "rotation", "up",
                                            "fov",   "ymag", "shift",    "focus",  "fstop",    NULL };
    bool in_frames = track->in_frames;
    rf_field_keys( key, in_frames ? s_frames : s_seconds );
    check_projection( key, track->projection );
    rf_read_key_time( key, in_frames, i, keys->times );
    read_cut( key, i, track );
    read_point( key, "position", keys->position + 3 * i );
    check_look( key, rotates );
    RfField fov = inherited( key, top, extent_name( track->projection ) ), up = inherited( key, top, "up" ),
            shift = inherited( key, top, "shift" );
    if ( fov.json == NULL )
        fov = rf_field_member( key, extent_name( track->projection ) );
    read_shift( &shift, keys, i );
    read_lens_value( key, "focus", RF_MAX_FOCUS, i, &keys->focuses, keys->focus );
    read_lens_value( key, "fstop", RF_MAX_FSTOP, i, &keys->stops, keys->fstop );
    read_extent( &fov, track->projection, keys->fov + i );
    read_up( &up, keys->up + 3 * i );
    if ( rotates )
    {
        RfField rotation = inherited( key, top, "rotation" );
        if ( rotation.json == NULL )
            rotation = rf_field_member( key, "rotation" );
        return rf_read_rotation( &rotation, keys->rotation + 4 * i );
    }
    RfField target = inherited( key, top, "target" );
    if ( target.json == NULL )
        return rf_field_fail( key, "has neither target nor rotation, and the path has none for all keys" );
    RfResult result = rf_field_numbers( &target, coordinates(), 3, keys->target + 3 * i );
    if ( result == RF_OK && is_same_point( keys->target + 3 * i, keys->position + 3 * i ) )
        return rf_field_fail( &target, "is at the position of the camera: move one of them" );
    return result;
}

static RfResult make_curves( const RfField* top, const Keys* keys, bool linear, bool rotates, RfCameraTrack* track )
{
    int n = keys->count;
    const double* t = keys->times;
    join( top, RF_CURVE_POINT, linear, n, t, keys->position, &track->position );
    join( top, RF_CURVE_NUMBER, linear, n, t, keys->fov, &track->fov );
    for ( int i = 0; i < 2 && keys->shifts; ++i )
        join( top, RF_CURVE_NUMBER, linear, n, t, keys->shift[i], track->shift + i );
    if ( keys->focuses )
        join( top, RF_CURVE_NUMBER, linear, n, t, keys->focus, &track->focus );
    if ( keys->stops )
        join( top, RF_CURVE_NUMBER, linear, n, t, keys->fstop, &track->fstop );
    if ( rotates )
        return join( top, RF_CURVE_ROTATION, linear, n, t, keys->rotation, &track->rotation );
    join( top, RF_CURVE_POINT, linear, n, t, keys->target, &track->target );
    return join( top, RF_CURVE_POINT, linear, n, t, keys->up, &track->up );
}

#define NUMBERS 19 // per key

static Keys split_memory( double* memory, int count )
{
    size_t n = (size_t)count;
    Keys keys = { .count = count,
                  .times = memory,
                  .position = memory + n,
                  .target = memory + 4 * n,
                  .up = memory + 7 * n,
                  .rotation = memory + 10 * n,
                  .fov = memory + 14 * n,
                  .shift = { memory + 15 * n, memory + 16 * n },
                  .focus = memory + 17 * n,
                  .fstop = memory + 18 * n };
    for ( size_t i = 0; i < n; ++i )
    {
        keys.up[3 * i + 1] = 1.0;
        keys.fov[i] = RF_DEFAULT_FOV;
    }
    return keys;
}

// What holds for all keys: the numbers of frames and the shape of a pixel.
static RfResult read_film( const RfField* top, RfCameraTrack* track )
{
    rf_get_number( top, "pixelAspect", rf_range( 0.01, 100.0 ), &track->aspect );
    rf_get_whole( top, "step", 1.0, RF_MAX_TRACK_FRAMES, &track->step );
    RfField field = rf_field_member( top, "step" );
    if ( field.json != NULL && !track->in_frames )
        return rf_field_fail( &field, "must have keys with frames, not times" );
    return rf_json_result( top );
}

static RfResult read_keys( const RfField* top, const RfField* list, RfCameraTrack* track )
{
    int count = (int)json_array_size( list->json );
    RfField first = rf_field_item( list, 0 );
    bool rotates = rf_has_member( top, "rotation" ) || rf_has_member( &first, "rotation" ), linear;
    track->in_frames = rf_has_member( &first, "frame" );
    rf_read_interpolation( top, &linear );
    read_projection( top, track );
    check_look( top, rotates );
    RfResult result = read_film( top, track );
    if ( result != RF_OK )
        return result;
    double* memory = calloc( (size_t)count * NUMBERS, sizeof *memory );
    track->cuts = malloc( (size_t)count * sizeof *track->cuts );
    if ( memory == NULL || track->cuts == NULL )
    {
        free( memory );
        return rf_field_no_memory( list );
    }
    Keys keys = split_memory( memory, count );
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        RfField key = rf_field_item( list, (size_t)i );
        result = read_key( top, &key, &keys, i, rotates, track );
    }
    for ( int i = 0; i < count && track->in_frames; ++i )
        keys.times[i] -= 1.0; // frame 1 is at time 0
    if ( result == RF_OK )
        result = make_curves( top, &keys, linear, rotates, track );
    if ( result == RF_OK )
        rf_part_track( track );
    track->start = keys.times[0];
    track->end = keys.times[count - 1];
    free( memory );
    RfField last = rf_field_item( list, (size_t)count - 1 ),
            field = rf_field_member( &last, track->in_frames ? "frame" : "time" );
    return result == RF_OK ? name_clock( &field, track ) : result;
}

// Reads a path of keys.
static RfResult read_keyed( const RfField* top, RfCameraTrack* track )
{
    static const char* const s_keys[] = { "kind", "interpolation", "keys",  "target", "rotation",    "up",   "projection",
                                          "fov",  "ymag",          "shift", "step",   "pixelAspect", "lens", NULL };
    RfField list = rf_field_member( top, "keys" );
    rf_field_keys( top, s_keys );
    RfResult result = rf_field_array( &list, "keys", 1, MAX_KEYS );
    return result == RF_OK ? read_keys( top, &list, track ) : result;
}

// Reads camera paths from JSON; every value is validated.

static const char* const s_kinds[] = { "keyed", "orbit", "dolly", "zoom", "walk", NULL };

static RfResult read_kind( const RfField* top, RfCameraTrack* track )
{
    static RfResult ( *const s_read[RF_TRACK_KIND_COUNT] )( const RfField*, RfCameraTrack* ) = {
        read_keyed, read_orbit, read_dolly, read_zoom, read_walk,
    };
    int kind = 0;
    if ( !json_is_object( top->json ) )
        return rf_field_must_be( top, "an object" );
    rf_field_require( top, "kind", "one of keyed, orbit, dolly, zoom, walk" );
    RfResult result = rf_get_choice( top, "kind", s_kinds, &kind );
    track->kind = (RfTrackKind)kind;
    return result == RF_OK ? s_read[kind]( top, track ) : result;
}

RfResult rf_read_camera_track( const RfField* object, RfCameraTrack* track )
{
    *track = ( RfCameraTrack ){ .step = 1, .aspect = 1.0 };
    char name[1024];
    snprintf( name, sizeof name, "%s%s%s", object->file, object->path[0] != 0 ? ": " : "", object->path );
    track->name = strdup( name );
    RfResult result = track->name != NULL ? RF_OK : rf_field_no_memory( object );
    RfField top = *object;
    top.notes = true;
    if ( result == RF_OK )
        result = read_kind( &top, track );
    if ( result == RF_OK )
        result = rf_read_optics( &top, &track->optics );
    if ( result != RF_OK )
        rf_destroy_camera_track( track );
    return result;
}

RfResult rf_load_camera_track( const char* path, RfCameraTrack* track, RfError* error )
{
    *track = ( RfCameraTrack ){ 0 };
    RfJsonDocument document;
    RF_TRY( rf_open_json( path, &document, error ) );
    RfField root = rf_root_field( &document, error );
    RfResult result = rf_read_camera_track( &root, track );
    track->hash = result == RF_OK ? document.hash : 0;
    rf_close_json( &document );
    return result;
}
