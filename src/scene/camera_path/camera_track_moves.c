// Reads the built-in movements: orbit, dolly, zoom, walk.

#include "scene/camera_path/camera_track_read.h"

#include <stdlib.h>

#define MAX_WAYPOINTS 10000
#define DEGREE ( 3.14159265358979323846 / 180.0 )

static const char* const s_span[] = { "duration", "frames", NULL };

RfResult rf_read_orbit( const RfField* top, RfCameraTrack* track )
{
    static const char* const s_keys[] = { "kind", "center",     "radius", "height", "start",    "turn",   "target", "rotation",
                                          "up",   "projection", "fov",    "ymag",   "duration", "frames", "lens",   NULL };
    RfOrbit* orbit = &track->orbit;
    double start = 0.0, turn = 360.0;
    RfField radius = rf_field_member( top, "radius" ), height = rf_field_member( top, "height" ),
            start_field = rf_field_member( top, "start" ), turn_field = rf_field_member( top, "turn" );
    RfResult result = rf_field_keys( top, s_keys );
    if ( result == RF_OK )
        result = rf_read_point( top, "center", orbit->center );
    if ( result == RF_OK )
        result = rf_field_require( top, "radius", "a number > 0" );
    if ( result == RF_OK )
        result = rf_field_number( &radius, rf_above( 0.0, rf_coordinates().high ), &orbit->radius );
    if ( result == RF_OK )
        result = rf_field_number( &height, rf_coordinates(), &orbit->height );
    if ( result == RF_OK )
        result = rf_field_number( &start_field, rf_range( -1e6, 1e6 ), &start );
    if ( result == RF_OK )
        result = rf_field_number( &turn_field, rf_range( -1e6, 1e6 ), &turn );
    orbit->start = start * DEGREE;
    orbit->turn = turn * DEGREE;
    if ( result == RF_OK )
        result = rf_read_look( top, orbit->center, track );
    if ( result == RF_OK )
        result = rf_read_lens( top, false, track );
    return result == RF_OK ? rf_read_span( top, s_span, track ) : result;
}

RfResult rf_read_dolly( const RfField* top, RfCameraTrack* track )
{
    static const char* const s_keys[] = { "kind", "from", "to",       "target", "rotation", "up", "projection",
                                          "fov",  "ymag", "duration", "frames", "lens",     NULL };
    double ends[6];
    RfResult result = rf_field_keys( top, s_keys );
    if ( result == RF_OK )
        result = rf_read_point( top, "from", ends );
    if ( result == RF_OK )
        result = rf_read_point( top, "to", ends + 3 );
    if ( result == RF_OK )
        result = rf_lead_curve( RF_CURVE_POINT, ends, &track->position, top->error );
    if ( result == RF_OK )
        result = rf_read_look( top, NULL, track );
    if ( result == RF_OK )
        result = rf_read_lens( top, false, track );
    return result == RF_OK ? rf_read_span( top, s_span, track ) : result;
}

RfResult rf_read_zoom( const RfField* top, RfCameraTrack* track )
{
    static const char* const s_keys[] = { "kind", "position", "target",   "rotation", "up",   "projection",
                                          "fov",  "ymag",     "duration", "frames",   "lens", NULL };
    double position[3];
    RfResult result = rf_field_keys( top, s_keys );
    if ( result == RF_OK )
        result = rf_read_point( top, "position", position );
    if ( result == RF_OK )
        result = rf_constant_curve( RF_CURVE_POINT, position, &track->position, top->error );
    if ( result == RF_OK )
        result = rf_read_look( top, NULL, track );
    if ( result == RF_OK )
        result = rf_read_lens( top, true, track );
    return result == RF_OK ? rf_read_span( top, s_span, track ) : result;
}

static RfResult read_waypoints( const RfField* top, RfCameraTrack* track )
{
    bool linear;
    RfField list = rf_field_member( top, "waypoints" );
    RfResult result = rf_field_array( &list, "points", 2, MAX_WAYPOINTS );
    if ( result == RF_OK )
        result = rf_read_interpolation( top, &linear );
    if ( result != RF_OK )
        return result;
    size_t count = json_array_size( list.json );
    double* points = malloc( 3 * count * sizeof *points );
    if ( points == NULL )
        return rf_fail( top->error, RF_ERROR_MEMORY, "%s: no memory left for %zu waypoints", top->file, count );
    for ( size_t i = 0; i < count && result == RF_OK; ++i )
    {
        RfField item = rf_field_item( &list, i );
        result = rf_field_numbers( &item, rf_coordinates(), 3, points + 3 * i );
        if ( result == RF_OK && i > 0 && rf_is_same_point( points + 3 * i, points + 3 * i - 3 ) )
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
        return rf_read_look( top, NULL, track );
    double up[3] = { 0.0, 1.0, 0.0 };
    track->look_ahead = 0.1 * track->walk.length;
    RfResult result = rf_read_up( &up_field, up );
    if ( result == RF_OK )
        result = rf_field_number( &ahead, rf_above( 0.0, rf_coordinates().high ), &track->look_ahead );
    return result == RF_OK ? rf_constant_curve( RF_CURVE_POINT, up, &track->up, top->error ) : result;
}

RfResult rf_read_walk( const RfField* top, RfCameraTrack* track )
{
    static const char* const s_keys[] = { "kind",     "waypoints", "interpolation", "look_ahead", "target",
                                          "rotation", "up",        "projection",    "fov",        "ymag",
                                          "speed",    "duration",  "frames",        "lens",       NULL };
    static const char* const s_walk_span[] = { "duration", "frames", "speed", NULL };
    RfResult result = rf_field_keys( top, s_keys );
    if ( result == RF_OK )
        result = read_waypoints( top, track );
    if ( result == RF_OK )
        result = read_walk_look( top, track );
    if ( result == RF_OK )
        result = rf_read_lens( top, false, track );
    return result == RF_OK ? rf_read_span( top, s_walk_span, track ) : result;
}
