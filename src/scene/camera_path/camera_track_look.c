// Shared by all kinds of camera paths: points, directions, field of view, duration.

#include "scene/camera_path/camera_track_read.h"

#include "math/quat.h"

#include <stdio.h>
#include <string.h>

#define MAX_COORDINATE 1e15
#define DEGREE ( 3.14159265358979323846 / 180.0 )

RfRange rf_coordinates( void ) { return rf_range( -MAX_COORDINATE, MAX_COORDINATE ); }

RfResult rf_read_point( const RfField* object, const char* key, double point[3] )
{
    RfField field = rf_field_member( object, key );
    RfResult result = rf_field_require( object, key, "an array of 3 numbers" );
    return result == RF_OK ? rf_field_numbers( &field, rf_coordinates(), 3, point ) : result;
}

bool rf_is_same_point( const double a[3], const double b[3] ) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }

RfResult rf_read_up( const RfField* field, double up[3] )
{
    RfResult result = rf_field_numbers( field, rf_coordinates(), 3, up );
    if ( result == RF_OK && up[0] == 0.0 && up[1] == 0.0 && up[2] == 0.0 )
        return rf_field_fail( field, "wants a direction, got three zeros" );
    return result;
}

// A rotation about +y (yaw), then about the camera's own x (pitch) and z (roll).
static RfResult read_angles( const RfField* field, double q[4] )
{
    static const char* const s_keys[] = { "yaw", "pitch", "roll", NULL };
    static const int s_axis[] = { 1, 0, 2 };
    RfResult result = rf_field_keys( field, s_keys );
    q[0] = q[1] = q[2] = 0.0;
    q[3] = 1.0;
    for ( int i = 0; i < 3 && result == RF_OK; ++i )
    {
        double degrees = 0.0, turn[4] = { 0 }, before[4];
        RfField angle = rf_field_member( field, s_keys[i] );
        result = rf_field_number( &angle, rf_range( -1e6, 1e6 ), &degrees );
        turn[s_axis[i]] = sin( 0.5 * degrees * DEGREE );
        turn[3] = cos( 0.5 * degrees * DEGREE );
        memcpy( before, q, sizeof before );
        rf_quat_mul( before, turn, q );
    }
    return result;
}

RfResult rf_read_rotation( const RfField* field, double q[4] )
{
    if ( json_is_object( field->json ) )
        return read_angles( field, q );
    if ( !json_is_array( field->json ) )
        return rf_field_wants( field, "a quaternion [x, y, z, w] or an object of yaw, pitch, roll" );
    RfResult result = rf_field_numbers( field, rf_range( -2.0, 2.0 ), 4, q );
    double length = sqrt( q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3] );
    // decimals written by hand are rounded
    if ( result == RF_OK && !( fabs( length - 1.0 ) < 0.1 ) )
        return rf_field_fail( field, "wants a quaternion of length 1, got length %g", length );
    rf_quat_normalize( q );
    return result;
}

// A path uses either targets and up, or rotations; the two cannot be mixed.
RfResult rf_check_look( const RfField* object, bool rotates )
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
    return RF_OK;
}

RfResult rf_read_interpolation( const RfField* top, bool* linear )
{
    static const char* const s_names[] = { "catmull-rom", "linear", NULL };
    int index = 0;
    RfField field = rf_field_member( top, "interpolation" );
    RfResult result = rf_field_choice( &field, s_names, &index );
    *linear = index == 1;
    return result;
}

RfResult rf_name_clock( const RfField* field, RfCameraTrack* track )
{
    char text[1024];
    snprintf( text, sizeof text, "%.800s: %s", field->file, field->path );
    track->clock = strdup( text );
    return track->clock != NULL ? RF_OK : rf_fail( field->error, RF_ERROR_MEMORY, "%s: no memory left", field->file );
}

// The duration of a movement: exactly one of `names`.
RfResult rf_read_span( const RfField* top, const char* const* names, RfCameraTrack* track )
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
    RfResult result = rf_name_clock( &field, track );
    if ( result != RF_OK )
        return result;
    if ( strcmp( given, "speed" ) == 0 )
    {
        result = rf_field_number( &field, rf_above( 0.0, MAX_COORDINATE ), &value );
        track->end = value > 0.0 ? track->walk.length / value : 0.0;
        if ( result == RF_OK && !( track->end <= RF_MAX_TRACK_SECONDS ) )
            return rf_field_fail( &field, "%g m at %g m/s take longer than %g s", track->walk.length, value,
                                  RF_MAX_TRACK_SECONDS );
        return result;
    }
    track->in_frames = strcmp( given, "frames" ) == 0;
    if ( !track->in_frames )
        return rf_field_number( &field, rf_above( 0.0, RF_MAX_TRACK_SECONDS ), &track->end );
    result = rf_field_number( &field, rf_range( 1.0, RF_MAX_TRACK_FRAMES ), &value );
    track->end = value - 1.0;
    return result == RF_OK && floor( value ) != value ? rf_field_wants( &field, "a whole number" ) : result;
}

// A constant curve, or one from a first value to a second.
RfResult rf_constant_curve( RfCurveKind kind, const double* value, RfCurve* curve, RfError* error )
{
    static const double s_start[1] = { 0.0 };
    return rf_create_curve( kind, true, 1, s_start, value, curve, error );
}

RfResult rf_lead_curve( RfCurveKind kind, const double* both, RfCurve* curve, RfError* error )
{
    static const double s_ends[2] = { 0.0, 1.0 };
    return rf_create_curve( kind, true, 2, s_ends, both, curve, error );
}

// A constant extent, or {"from": …, "to": …}.
RfResult rf_read_lens( const RfField* top, bool must_change, RfCameraTrack* track )
{
    static const char* const s_keys[] = { "from", "to", NULL };
    RfResult known = rf_read_projection( top, track );
    if ( known != RF_OK )
        return known;
    bool orthographic = track->projection == RF_ORTHOGRAPHIC;
    RfField field = rf_field_member( top, rf_extent_name( track->projection ) );
    double fov[2] = { RF_DEFAULT_FOV, RF_DEFAULT_FOV };
    if ( must_change && !json_is_object( field.json ) )
        return rf_field_wants( &field,
                               orthographic ? "an object of from and to, in metres" : "an object of from and to, in degrees" );
    if ( !json_is_object( field.json ) )
    {
        RfResult result = rf_read_extent( &field, track->projection, fov );
        return result == RF_OK ? rf_constant_curve( RF_CURVE_NUMBER, fov, &track->fov, top->error ) : result;
    }
    RfResult result = rf_field_keys( &field, s_keys );
    for ( int i = 0; i < 2 && result == RF_OK; ++i )
    {
        RfField end = rf_field_member( &field, s_keys[i] );
        result = rf_field_require( &field, s_keys[i], orthographic ? "metres" : "degrees" );
        if ( result == RF_OK )
            result = rf_read_extent( &end, track->projection, fov + i );
    }
    return result == RF_OK ? rf_lead_curve( RF_CURVE_NUMBER, fov, &track->fov, top->error ) : result;
}

// Target and up, or a rotation; `fallback` is the default target.
RfResult rf_read_look( const RfField* top, const double* fallback, RfCameraTrack* track )
{
    RfField rotation = rf_field_member( top, "rotation" ), up_field = rf_field_member( top, "up" );
    double q[4], target[3], up[3] = { 0.0, 1.0, 0.0 };
    RfResult result = rf_check_look( top, rotation.json != NULL );
    if ( result == RF_OK && rotation.json != NULL )
    {
        result = rf_read_rotation( &rotation, q );
        return result == RF_OK ? rf_constant_curve( RF_CURVE_ROTATION, q, &track->rotation, top->error ) : result;
    }
    if ( result == RF_OK )
        result = rf_read_up( &up_field, up );
    if ( result == RF_OK )
        result = rf_constant_curve( RF_CURVE_POINT, up, &track->up, top->error );
    if ( result != RF_OK )
        return result;
    if ( fallback != NULL && !rf_has_member( top, "target" ) )
        return rf_constant_curve( RF_CURVE_POINT, fallback, &track->target, top->error );
    result = rf_read_point( top, "target", target );
    return result == RF_OK ? rf_constant_curve( RF_CURVE_POINT, target, &track->target, top->error ) : result;
}
