// Reads aperture, focus and shutter of a camera from JSON.
#include "scene/camera_path/optics.h"

#include "base/json.h"
#include "base/try.h"

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
