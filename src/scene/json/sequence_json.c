// Reads and validates an image sequence.
#include "scene/json/sequence_json.h"

#include "reframe/image.h"
#include "scene/camera_path/camera_track_read.h"
#include "scene/scene.h"

#include <limits.h>

#define MAX_NUMBER 1e6
#define MAX_IMAGES 100000
#define NAME "the name of a sequence, such as \"film.####.png\""

RfResult rf_read_sequence( const RfField* object, RfImageSequence* s, const char** frames )
{
    static const char* const s_keys[] = { "frames", "first", "last", "start", "fps", "repeat", NULL };
    static const char* const s_repeats[] = { "hold", "loop", NULL };
    char name[PATH_MAX];
    RfError error;
    int repeat = 0;
    *s = ( RfImageSequence ){ .first = 1, .most = (double)INFINITY };
    *frames = "";
    RfField pattern = rf_field_member( object, "frames" ), last = rf_field_member( object, "last" );
    rf_field_keys( object, s_keys );
    rf_field_require( object, "frames", NAME );
    RfResult result = rf_field_text( &pattern, frames );
    if ( result == RF_OK && !rf_is_sequence( *frames ) )
        return rf_field_must_be( &pattern, NAME );
    if ( result == RF_OK && rf_sequence_name( *frames, 1, name, sizeof name, &error ) != RF_OK )
        return rf_field_fail( &pattern, "%.560s", error.text );
    rf_field_require( object, "last", "the number of the last image" );
    rf_get_whole( object, "first", 0.0, MAX_NUMBER, &s->first );
    result = rf_field_whole( &last, 0.0, MAX_NUMBER, &s->last );
    if ( result == RF_OK && ( s->last < s->first || s->last - s->first >= MAX_IMAGES ) )
        return rf_field_fail( &last, "must be from %d, the first image, to %d", s->first, s->first + MAX_IMAGES - 1 );
    rf_get_number( object, "start", rf_range( -RF_MAX_TRACK_SECONDS, RF_MAX_TRACK_SECONDS ), &s->start );
    rf_get_number( object, "fps", rf_range( 1e-6, 1e6 ), &s->fps );
    rf_get_choice( object, "repeat", s_repeats, &repeat );
    RfFps exact;
    if ( rf_broadcast_fps( s->fps, &exact ) )
        s->fps = (double)exact.numerator / exact.denominator;
    s->loops = repeat == 1;
    return rf_json_result( object );
}
