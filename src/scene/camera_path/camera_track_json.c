// Reads camera paths from JSON; every value is validated.

#include "scene/camera_path/camera_track_read.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char* const s_kinds[] = { "keyed", "orbit", "dolly", "zoom", "walk", NULL };

static RfResult read_kind( const RfField* top, RfCameraTrack* track )
{
    static RfResult ( *const s_read[RF_TRACK_KIND_COUNT] )( const RfField*, RfCameraTrack* ) = {
        rf_read_keyed, rf_read_orbit, rf_read_dolly, rf_read_zoom, rf_read_walk,
    };
    int kind = 0;
    RfField field = rf_field_member( top, "kind" );
    if ( !json_is_object( top->json ) )
        return rf_field_wants( top, "an object" );
    RfResult result = rf_field_require( top, "kind", "one of keyed, orbit, dolly, zoom, walk" );
    if ( result == RF_OK )
        result = rf_field_choice( &field, s_kinds, &kind );
    track->kind = (RfTrackKind)kind;
    return result == RF_OK ? s_read[kind]( top, track ) : result;
}

RfResult rf_read_camera_track( const RfField* object, RfCameraTrack* track, RfError* error )
{
    *track = ( RfCameraTrack ){ .step = 1, .aspect = 1.0 };
    char name[1024];
    snprintf( name, sizeof name, "%s%s%s", object->file, object->path[0] != 0 ? ": " : "", object->path );
    track->name = strdup( name );
    RfResult result = track->name != NULL ? RF_OK : rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left", object->file );
    RfField top = *object;
    top.error = error;
    top.notes = true;
    if ( result == RF_OK )
        result = read_kind( &top, track );
    if ( result != RF_OK )
        rf_destroy_camera_track( track );
    return result;
}

RfResult rf_load_camera_track( const char* path, RfCameraTrack* track, RfError* error )
{
    *track = ( RfCameraTrack ){ 0 };
    RfJsonDocument document;
    RfResult result = rf_open_json( path, &document, error );
    if ( result != RF_OK )
        return result;
    RfField root = rf_root_field( &document, error );
    result = rf_read_camera_track( &root, track, error );
    track->hash = result == RF_OK ? document.hash : 0;
    rf_close_json( &document );
    return result;
}
