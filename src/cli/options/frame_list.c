#include "cli/options/frame_list.h"

#include "cli/options/file_options.h"

#include <ctype.h>
#include <errno.h>
#include <stdbool.h>
#include <stdlib.h>
#include <string.h>

typedef struct Range
{
    long first, last, step; // 1-based, negative from the end, as written
} Range;

// Parses a whole number with an optional minus sign and advances *text past it.
static bool take_number( const char** text, long* number )
{
    const char* start = *text;
    if ( !isdigit( (unsigned char)start[start[0] == '-'] ) )
        return false;
    char* end;
    errno = 0;
    *number = strtol( start, &end, 10 );
    *text = end;
    return errno == 0;
}

// Parses "A", "A-B" or either with "xSTEP", up to a comma or the end.
static bool take_range( const char** text, Range* range )
{
    if ( !take_number( text, &range->first ) )
        return false;
    range->last = range->first;
    range->step = 1;
    if ( **text == '-' )
    {
        ++*text;
        if ( !take_number( text, &range->last ) )
            return false;
    }
    if ( **text == 'x' )
    {
        ++*text;
        if ( !take_number( text, &range->step ) || range->step < 1 )
            return false;
    }
    return **text == ',' || **text == '\0';
}

// Converts a number as written to an index; fails where there is no such frame.
static RfResult resolve( long number, int frame_count, long* index, RfError* error )
{
    *index = number < 0 ? number + frame_count : number - 1;
    if ( number == 0 || *index < 0 || *index >= frame_count )
        return rf_fail( error, RF_ERROR_USAGE, "--frames: there is no frame %ld, the camera's path has %d frame%s", number,
                        frame_count, frame_count == 1 ? "" : "s" );
    return RF_OK;
}

static RfResult mark_range( Range range, int frame_count, bool* wanted, RfError* error )
{
    long first, last;
    RfResult result = resolve( range.first, frame_count, &first, error );
    if ( result == RF_OK )
        result = resolve( range.last, frame_count, &last, error );
    if ( result != RF_OK )
        return result;
    if ( first > last )
        return rf_fail( error, RF_ERROR_USAGE, "--frames: %ld-%ld runs backwards, frame %ld comes after frame %ld", range.first,
                        range.last, first + 1, last + 1 );
    for ( long i = first; i <= last; i += range.step )
    {
        wanted[i] = true;
        if ( range.step > last ) // no overflow for absurd steps
            break;
    }
    return RF_OK;
}

static RfResult mark_all( const char* text, int frame_count, bool* wanted, RfError* error )
{
    if ( text == NULL )
    {
        memset( wanted, true, (size_t)frame_count * sizeof *wanted );
        return RF_OK;
    }
    for ( const char* next = text;; ++next )
    {
        Range range;
        if ( !take_range( &next, &range ) )
            return rf_fail( error, RF_ERROR_USAGE,
                            "--frames: wants frames such as 7, 1-48, 1-48x2, -5--1 with commas between them, got '%s'", text );
        RfResult result = mark_range( range, frame_count, wanted, error );
        if ( result != RF_OK || *next == '\0' )
            return result;
    }
}

RfResult rf_parse_frames( const char* text, int frame_count, int** frames, int* count, RfError* error )
{
    *frames = NULL;
    *count = 0;
    bool* wanted = calloc( (size_t)frame_count, sizeof *wanted );
    int* list = malloc( (size_t)frame_count * sizeof *list );
    RfResult result = RF_OK;
    if ( wanted == NULL || list == NULL )
        result = rf_fail( error, RF_ERROR_MEMORY, "--frames: no memory left for %d frames", frame_count );
    if ( result == RF_OK )
        result = mark_all( text, frame_count, wanted, error );
    if ( result == RF_OK )
    {
        for ( int i = 0; i < frame_count; ++i )
        {
            if ( wanted[i] )
                list[( *count )++] = i;
        }
        *frames = list;
        list = NULL;
    }
    free( wanted );
    free( list );
    return result;
}

RfResult rf_choose_frames( const char* text, const RfSceneFile* file, int frame_count, int** frames, int* count, RfError* error )
{
    RfResult result = rf_parse_frames( text, frame_count, frames, count, error );
    RfField defaults = rf_scene_file_defaults( file, error );
    RfField field = rf_field_member( &defaults, "frames" );
    if ( result != RF_ERROR_USAGE || field.json == NULL || json_string_value( field.json ) != text )
        return result;
    RfError fault = *error;
    return rf_fail_file_option( &field, &fault );
}
