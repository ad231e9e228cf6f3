#include "cli/report/report_warnings.h"

#include "cli/messages.h"
#include "image/sequence.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_LINES 100 // of a sequence
#define LONGEST 600    // characters of a line

typedef struct List
{
    json_t* json;
    int track;
} List;

static void add( const List* list, const char* text )
{
    char cut[LONGEST + 4];
    snprintf( cut, sizeof cut, "%.*s%s", LONGEST, text, strlen( text ) > LONGEST ? "..." : "" );
    json_array_append_new( list->json, json_pack( "{s:i, s:o}", "sequence", list->track, "text", rf_json_text( cut ) ) );
}

// What render --json repeats of the scene's loading and of the render.
static void add_told( const List* list, const json_t* render )
{
    size_t i;
    const json_t* line;
    json_array_foreach( json_object_get( render, "warnings" ), i, line )
    {
        if ( json_is_string( line ) && i < MOST_LINES )
            add( list, json_string_value( line ) );
    }
    double missed = rf_json_number_of( json_object_get( render, "noise" ), "missed" );
    char text[128];
    snprintf( text, sizeof text, "--noise was not reached in %.0f frame%s", missed, missed == 1.0 ? "" : "s" );
    if ( isgreater( missed, 0.0 ) && json_object_get( render, "warnings" ) == NULL )
        add( list, text );
    if ( json_is_true( json_object_get( render, "interrupted" ) ) )
        add( list, "the render was interrupted: --resume goes on" );
}

static void add_missing( const List* list, const RfPageTrack* track )
{
    char frames[240], text[300];
    int count;
    int* missing = rf_page_missing_frames( track, &count );
    rf_format_frames( missing, count, frames, sizeof frames );
    snprintf( text, sizeof text, "%s missing: %s", count == 1 ? "a frame is" : "frames are", frames );
    if ( count > 0 )
        add( list, text );
    free( missing );
}

static void add_bad( const List* list, const RfPageTrack* track )
{
    size_t bad = 0;
    int first = -1, count = 0;
    for ( int i = 0; i < track->count; ++i )
    {
        bad += track->frames[i].bad;
        count += track->frames[i].bad > 0;
        first = first < 0 && track->frames[i].bad > 0 ? i : first;
    }
    char text[160];
    if ( first < 0 )
        return;
    snprintf( text, sizeof text, "%zu pixel%s NaN or infinite, in %d frame%s from %d on; NaN is shown in magenta", bad,
              bad == 1 ? " is" : "s are", count, count == 1 ? "" : "s", track->numbers[first] );
    add( list, text );
}

// Estimates of heavy-tailed noise.
static void add_bounds( const List* list, const RfPageTrack* track )
{
    int count = 0;
    double most = 0.0;
    for ( int i = 0; i < track->count; ++i )
    {
        count += track->frames[i].at_least;
        most = fmax( most, track->frames[i].worst_ten_share ); // fmax passes over NaN
    }
    char text[240];
    if ( count == 0 )
        return;
    int used =
        snprintf( text, sizeof text, "the estimated relMSE is a lower bound in %d of %d frame%s: few pixels carry much of it",
                  count, track->count, track->count == 1 ? "" : "s" );
    if ( most > 0.0 )
        snprintf( text + used, sizeof text - (size_t)used, " (the ten worst up to %.0f %%)", 100.0 * most );
    add( list, text );
}

json_t* rf_page_warnings_json( const RfPageData* data )
{
    List list = { .json = json_array() };
    for ( list.track = 0; list.track < data->track_count; ++list.track )
    {
        const RfPageTrack* track = data->tracks + list.track;
        add_told( &list, track->sequence->render );
        add_missing( &list, track );
        add_bad( &list, track );
        add_bounds( &list, track );
    }
    return list.json;
}
