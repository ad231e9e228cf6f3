// Projections, and how much of the scene they show: a field of view, the height of the picture, or all.

#include "scene/camera_path/camera_track_read.h"

#define MAX_YMAG 1e12 // m

RfResult rf_read_projection( const RfField* top, RfCameraTrack* track )
{
    static const char* const s_names[] = { "perspective", "orthographic", "panoramic", NULL };
    int index = 0;
    RfField field = rf_field_member( top, "projection" );
    RfResult result = rf_field_choice( &field, s_names, &index );
    track->projection = (RfProjectionKind)index;
    return result == RF_OK ? rf_check_projection( top, track->projection ) : result;
}

const char* rf_extent_name( RfProjectionKind projection ) { return projection == RF_ORTHOGRAPHIC ? "ymag" : "fov"; }

RfResult rf_check_projection( const RfField* object, RfProjectionKind projection )
{
    RfField fov = rf_field_member( object, "fov" ), ymag = rf_field_member( object, "ymag" ),
            shift = rf_field_member( object, "shift" ), aspect = rf_field_member( object, "pixelAspect" );
    if ( projection != RF_PERSPECTIVE && fov.json != NULL )
        return rf_field_fail( &fov, projection == RF_ORTHOGRAPHIC
                                        ? "is that of a perspective camera: an orthographic one has ymag"
                                        : "is that of a perspective camera: a panorama shows all directions" );
    if ( projection != RF_ORTHOGRAPHIC && ymag.json != NULL )
        return rf_field_fail( &ymag, "is that of an orthographic camera: set \"projection\": \"orthographic\", or leave it out" );
    if ( projection == RF_PANORAMIC && shift.json != NULL )
        return rf_field_fail( &shift, "a panorama cannot be shifted: turn the camera" );
    if ( projection == RF_PANORAMIC && aspect.json != NULL )
        return rf_field_fail( &aspect, "a panorama fills its picture, whatever the shape of that: leave it out" );
    return RF_OK;
}

RfResult rf_read_extent( const RfField* field, RfProjectionKind projection, double* value )
{
    if ( projection != RF_ORTHOGRAPHIC )
        return rf_field_number( field, rf_range( 0.1, 179.0 ), value );
    if ( field->json == NULL )
        return rf_field_fail( field, "is missing: half the height of the picture, in metres" );
    return rf_field_number( field, rf_above( 0.0, MAX_YMAG ), value );
}
