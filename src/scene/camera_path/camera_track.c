// The view and the optics of a camera path at a time.
#include "scene/camera_path/camera_track.h"

#include "base/try.h"
#include "math/quat.h"
#include "scene/eye.h"
#include "scene/projection.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define DEGREE ( 3.14159265358979323846 / 180.0 )
#define MAX_RADIUS 1e6 // m
#define MAX_BLADES 64.0

// A number of frames, in the middle of which the frame's own time is, or when the shutter opens and closes.
static RfResult read_shutter( const RfField* field, double shutter[2] )
{
    if ( json_is_array( field->json ) )
    {
        RfResult result = rf_field_numbers( field, rf_range( -RF_MAX_SHUTTER, RF_MAX_SHUTTER ), 2, shutter );
        if ( result == RF_OK && shutter[0] > shutter[1] )
            return rf_field_fail( field, "closes before it opens: it must be [open, close]" );
        return result;
    }
    double length = 0.0;
    rf_field_number( field, rf_range( 0.0, RF_MAX_SHUTTER ), &length );
    shutter[0] = -0.5 * length;
    shutter[1] = 0.5 * length;
    return rf_json_result( field );
}

// Metres, or the name of a node.
static RfResult read_focus( const RfField* field, RfOptics* optics )
{
    if ( !json_is_string( field->json ) )
        return rf_field_number( field, rf_above( 0.0, RF_MAX_FOCUS ), &optics->focus );
    const char* name = "";
    RF_TRY( rf_field_text( field, &name ) );
    optics->focus_node = strdup( name );
    return optics->focus_node != NULL ? RF_OK : rf_field_no_memory( field );
}

static RfResult read_blades( const RfField* field, int* blades )
{
    double number = 0.0;
    RfResult result = rf_field_number( field, rf_range( 0.0, MAX_BLADES ), &number );
    if ( result == RF_OK && ( floor( number ) != number || ( number > 0.0 && number < 3.0 ) ) )
        return rf_field_must_be( field, "0 for a round aperture, or a whole number from 3" );
    *blades = (int)number;
    return result;
}

RfResult rf_read_optics( const RfField* object, RfOptics* optics )
{
    static const char* const s_keys[] = { "fstop", "radius", "sensor", "focus", "blades", "rotation", "shutter", NULL };
    *optics = ( RfOptics ){ .sensor = RF_DEFAULT_SENSOR };
    RfField lens = rf_field_member( object, "lens" );
    if ( lens.json == NULL )
        return rf_json_result( object );
    RfField radius = rf_field_member( &lens, "radius" ), blades = rf_field_member( &lens, "blades" ),
            shutter = rf_field_member( &lens, "shutter" ), focus = rf_field_member( &lens, "focus" );
    double millimetres = 1e3 * RF_DEFAULT_SENSOR, degrees = 0.0;
    rf_field_keys( &lens, s_keys );
    if ( rf_has_member( &lens, "fstop" ) && radius.json != NULL )
        return rf_field_fail( &radius, "not together with fstop: leave one of the two out" );
    rf_get_number( &lens, "fstop", rf_above( 0.0, RF_MAX_FSTOP ), &optics->fstop );
    rf_field_number( &radius, rf_range( 0.0, MAX_RADIUS ), &optics->radius );
    rf_get_number( &lens, "sensor", rf_above( 0.0, 1e6 ), &millimetres );
    read_blades( &blades, &optics->blades );
    rf_get_number( &lens, "rotation", rf_range( -1e6, 1e6 ), &degrees );
    optics->sensor = 1e-3 * millimetres;
    optics->rotation = degrees * DEGREE;
    if ( shutter.json != NULL )
        read_shutter( &shutter, optics->shutter );
    return read_focus( &focus, optics );
}

void rf_destroy_optics( RfOptics* optics )
{
    free( optics->focus_node );
    *optics = ( RfOptics ){ 0 };
}

double rf_optics_radius( const RfOptics* optics, const RfEye* eye )
{
    if ( !( optics->fstop > 0.0 ) )
        return optics->radius;
    switch ( (RfProjectionKind)eye->projection )
    {
        case RF_ORTHOGRAPHIC: return 0.5 / optics->fstop;
        case RF_PERSPECTIVE:
        case RF_PANORAMIC: break; // takes no lens
    }
    double focal_length = optics->sensor * (double)eye->focal / (double)eye->height;
    return focal_length / ( 2.0 * optics->fstop );
}

// All curves of keys; the first so many say what the camera sees.
#define CURVES( track )                                                                                                          \
    {                                                                                                                            \
        &( track )->position, &( track )->target, &( track )->up, &( track )->rotation, &( track )->fov, ( track )->shift,       \
            ( track )->shift + 1, &( track )->focus, &( track )->fstop                                                           \
    }
#define VIEW_CURVES 7

void rf_destroy_camera_track( RfCameraTrack* track )
{
    RfCurve* const curves[] = CURVES( track );
    for ( size_t i = 0; i < sizeof curves / sizeof curves[0]; ++i )
        rf_destroy_curve( curves[i] );
    rf_destroy_optics( &track->optics );
    rf_destroy_waypoints( &track->walk );
    free( track->cuts );
    free( track->name );
    free( track->clock );
    *track = ( RfCameraTrack ){ 0 };
}

static bool curve_varies( const RfCurve* curve )
{
    size_t kind = (size_t)curve->kind;
    for ( size_t i = kind; i < kind * (size_t)curve->count; ++i )
    {
        if ( curve->values[i] != curve->values[i % kind] )
            return true;
    }
    return false;
}

bool rf_camera_track_moves( const RfCameraTrack* track )
{
    const RfCurve* curves[] = CURVES( track );
    bool moves = track->kind != RF_TRACK_KEYED;
    for ( size_t i = 0; i < VIEW_CURVES; ++i )
        moves = moves || curve_varies( curves[i] );
    return moves;
}

int rf_track_shot( const RfCameraTrack* track, double time )
{
    int low = 0, end = track->cut_count;
    while ( low < end )
    {
        int middle = low + ( end - low ) / 2;
        if ( track->position.times[track->cuts[middle]] <= time )
            low = middle + 1;
        else
            end = middle;
    }
    return low;
}

static int first_key( const RfCameraTrack* track, int shot ) { return shot > 0 ? track->cuts[shot - 1] : 0; }

static int end_key( const RfCameraTrack* track, int shot )
{
    return shot < track->cut_count ? track->cuts[shot] : track->position.count;
}

void rf_part_track( RfCameraTrack* track )
{
    RfCurve* const curves[] = CURVES( track );
    for ( int shot = 0; shot <= track->cut_count && track->cut_count > 0; ++shot )
    {
        int first = first_key( track, shot ), end = end_key( track, shot );
        for ( size_t i = 0; i < sizeof curves / sizeof curves[0]; ++i )
            rf_part_curve( curves[i], first, end - first );
    }
}

RfCameraTrack rf_shot_of_track( const RfCameraTrack* track, int shot )
{
    RfCameraTrack part = *track;
    if ( track->cut_count == 0 )
        return part;
    RfCurve* const curves[] = CURVES( &part );
    int first = first_key( track, shot ), end = end_key( track, shot );
    for ( size_t i = 0; i < sizeof curves / sizeof curves[0]; ++i )
        *curves[i] = rf_part_of_curve( curves[i], first, end - first );
    part.cut_count = 0;
    part.start = part.position.times[0];
    part.end = part.position.times[end - first - 1];
    return part;
}

static void orbit_at( const RfOrbit* orbit, double progress, double position[3] )
{
    double angle = orbit->start + progress * orbit->turn;
    position[0] = orbit->center[0] + orbit->radius * sin( angle );
    position[1] = orbit->center[1] + orbit->height;
    position[2] = orbit->center[2] + orbit->radius * cos( angle );
}

// The position of the camera, and its target if it looks ahead along the path.
static void sample_position( const RfCameraTrack* track, double at, RfView* view, double target[3] )
{
    double length = at * track->walk.length;
    if ( track->kind == RF_TRACK_ORBIT )
        orbit_at( &track->orbit, at, view->position );
    else if ( track->kind == RF_TRACK_WALK )
        rf_waypoint_position( &track->walk, length, view->position );
    else
        rf_sample_curve( &track->position, at, view->position );
    if ( track->target.count > 0 )
        rf_sample_curve( &track->target, at, target );
    else if ( track->kind == RF_TRACK_WALK )
        rf_waypoint_position( &track->walk, length + track->look_ahead, target );
}

static RfResult fail_at( const RfCameraTrack* track, double time, const char* what, RfError* error )
{
    if ( track->in_frames )
        return rf_fail( error, RF_ERROR_SCENE, "%s: at frame %g %s", track->name, time + 1.0, what );
    return rf_fail( error, RF_ERROR_SCENE, "%s: at %g s %s", track->name, time, what );
}

// Direction and distance to the target; false if they have no direction.
static bool look_at( const double position[3], const double target[3], RfView* view )
{
    double largest = 0.0, length = 0.0;
    for ( int i = 0; i < 3; ++i )
    {
        largest = fmax( largest, fmax( fabs( position[i] ), fabs( target[i] ) ) );
        view->forward[i] = target[i] - position[i];
        length += view->forward[i] * view->forward[i];
    }
    length = sqrt( length );
    rf_unit3( view->forward );
    return length > 1e-9 * largest && length > 1e-30;
}

RfResult rf_sample_camera_track( const RfCameraTrack* track, double time, RfView* view, RfError* error )
{
    if ( track->cut_count > 0 )
    {
        RfCameraTrack shot = rf_shot_of_track( track, rf_track_shot( track, time ) );
        return rf_sample_camera_track( &shot, time, view, error );
    }
    // times of keys are absolute; movements use the fraction of their duration
    double at = time;
    if ( track->kind != RF_TRACK_KEYED )
        at = track->end > 0.0 ? fmin( fmax( time / track->end, 0.0 ), 1.0 ) : 0.0;
    double target[3] = { 0 }, rotation[4], axes[9];
    sample_position( track, at, view, target );
    rf_sample_curve( &track->fov, at, &view->fov );
    view->projection = track->projection;
    if ( rf_projection_traits( track->projection )->extent == RF_EXTENT_FOV )
        view->fov *= 3.14159265358979323846 / 180.0;
    view->aspect = track->aspect;
    view->focus = view->fstop = 0.0;
    if ( track->focus.count > 0 )
        rf_sample_curve( &track->focus, at, &view->focus );
    if ( track->fstop.count > 0 )
        rf_sample_curve( &track->fstop, at, &view->fstop );
    for ( int i = 0; i < 2; ++i )
    {
        view->shift[i] = 0.0;
        if ( track->shift[i].count > 0 )
            rf_sample_curve( track->shift + i, at, view->shift + i );
    }
    if ( track->rotation.count > 0 )
    {
        rf_sample_curve( &track->rotation, at, rotation );
        rf_quat_axes( rotation, axes );
        for ( int i = 0; i < 3; ++i )
        {
            view->up[i] = axes[3 + i];
            view->forward[i] = -axes[6 + i];
        }
        return RF_OK;
    }
    if ( !look_at( view->position, target, view ) )
        return fail_at( track, time, "the camera stands on its target: move one of them", error );
    rf_sample_curve( &track->up, at, view->up );
    rf_unit3( view->up );
    double cosine = 0.0, length = 0.0;
    for ( int i = 0; i < 3; ++i )
    {
        cosine += view->forward[i] * view->up[i];
        length += view->up[i] * view->up[i]; // 0 if opposite up vectors cancel in the interpolation
    }
    // written so that NaN fails
    if ( !( fabs( cosine ) < 1.0 - 1e-9 ) || !( length > 0.5 ) )
        return fail_at( track, time, "the camera looks along its up, or has none: give it another \"up\"", error );
    return RF_OK;
}
