// Reads and validates an image sequence.
#include "scene/json/sequence_json.h"

#include "reframe/image.h"
#include "scene/camera_path/camera_track_read.h"
#include "scene/scene.h"

#include <limits.h>

#define MAX_NUMBER 1e6
#define MAX_IMAGES 100000

static RfResult read_number( const RfField* object, const char* key, int* number )
{
    RfField field = rf_field_member( object, key );
    double value = (double)*number;
    RfResult result = rf_field_number( &field, rf_range( 0.0, MAX_NUMBER ), &value );
    if ( result == RF_OK && floor( value ) != value )
        return rf_field_must_be( &field, "a whole number" );
    *number = (int)value;
    return result;
}

RfResult rf_read_sequence( const RfField* object, RfImageSequence* s, const char** frames )
{
    static const char* const s_keys[] = { "frames", "first", "last", "start", "fps", "repeat", NULL };
    static const char* const s_repeats[] = { "hold", "loop", NULL };
    char name[PATH_MAX];
    RfError error;
    int repeat = 0;
    *s = ( RfImageSequence ){ .first = 1, .most = (double)INFINITY };
    *frames = "";
    RfField pattern = rf_field_member( object, "frames" ), start = rf_field_member( object, "start" ),
            fps = rf_field_member( object, "fps" ), loops = rf_field_member( object, "repeat" ),
            last = rf_field_member( object, "last" );
    RfResult result = rf_field_keys( object, s_keys );
    if ( result == RF_OK )
        result = rf_field_require( object, "frames", "the name of a sequence, such as \"film.####.png\"" );
    if ( result == RF_OK )
        result = rf_field_text( &pattern, frames );
    if ( result == RF_OK && !rf_is_sequence( *frames ) )
        return rf_field_must_be( &pattern, "the name of a sequence, such as \"film.####.png\"" );
    if ( result == RF_OK && rf_sequence_name( *frames, 1, name, sizeof name, &error ) != RF_OK )
        return rf_field_fail( &pattern, "%.560s", error.text );
    if ( result == RF_OK )
        result = rf_field_require( object, "last", "the number of the last image" );
    if ( result == RF_OK )
        result = read_number( object, "first", &s->first );
    if ( result == RF_OK )
        result = read_number( object, "last", &s->last );
    if ( result == RF_OK && ( s->last < s->first || s->last - s->first >= MAX_IMAGES ) )
        return rf_field_fail( &last, "must be from %d, the first image, to %d", s->first, s->first + MAX_IMAGES - 1 );
    if ( result == RF_OK )
        result = rf_field_number( &start, rf_range( -RF_MAX_TRACK_SECONDS, RF_MAX_TRACK_SECONDS ), &s->start );
    if ( result == RF_OK )
        result = rf_field_number( &fps, rf_range( 1e-6, 1e6 ), &s->fps );
    if ( result == RF_OK )
        result = rf_field_choice( &loops, s_repeats, &repeat );
    RfFps exact;
    if ( rf_broadcast_fps( s->fps, &exact ) )
        s->fps = (double)exact.numerator / exact.denominator;
    s->loops = repeat == 1;
    return result;
}
