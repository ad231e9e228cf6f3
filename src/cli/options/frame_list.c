#include "cli/options/frame_list.h"

#include "cli/options/file_options.h"

#include <ctype.h>
#include <errno.h>
#include <stdbool.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Range
{
    long first, last, step; // as written: negative from the end
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

// The numbers that a path's frames have.
typedef struct Numbers
{
    long first, step, count;
} Numbers;

static long last_number( const Numbers* numbers ) { return numbers->first + ( numbers->count - 1 ) * numbers->step; }

static RfResult fail_missing( long number, const Numbers* numbers, RfError* error )
{
    if ( numbers->first == 1 && numbers->step == 1 )
        return rf_fail( error, RF_ERROR_USAGE, "--frames: there is no frame %ld, the camera's path has %ld frame%s", number,
                        numbers->count, numbers->count == 1 ? "" : "s" );
    char steps[48] = "";
    if ( numbers->step > 1 )
        snprintf( steps, sizeof steps, " in steps of %ld", numbers->step );
    return rf_fail( error, RF_ERROR_USAGE, "--frames: there is no frame %ld, the camera's path has frames %ld to %ld%s", number,
                    numbers->first, last_number( numbers ), steps );
}

// Makes a negative number one of the path; fails beyond its ends.
static RfResult resolve( long written, const Numbers* numbers, long* number, RfError* error )
{
    *number = written < 0 ? numbers->first + ( written + numbers->count ) * numbers->step : written;
    bool inside = *number >= numbers->first && *number < last_number( numbers ) + numbers->step;
    bool counted = written >= 0 || written >= -numbers->count;
    return inside && counted ? RF_OK : fail_missing( written, numbers, error );
}

static RfResult mark_range( Range range, const Numbers* numbers, bool* wanted, RfError* error )
{
    long first, last;
    RfResult result = resolve( range.first, numbers, &first, error );
    if ( result == RF_OK )
        result = resolve( range.last, numbers, &last, error );
    if ( result != RF_OK )
        return result;
    if ( first > last )
        return rf_fail( error, RF_ERROR_USAGE, "--frames: %ld-%ld runs backwards, frame %ld comes after frame %ld", range.first,
                        range.last, first, last );
    bool any = false;
    for ( long i = ( first - numbers->first ) / numbers->step; i < numbers->count; ++i )
    {
        long number = numbers->first + i * numbers->step;
        bool here = number >= first && number <= last && ( number - first ) % range.step == 0;
        wanted[i] = wanted[i] || here;
        any = any || here;
        if ( number >= last )
            break;
    }
    return any ? RF_OK : fail_missing( first, numbers, error );
}

static RfResult mark_all( const char* text, const Numbers* numbers, bool* wanted, RfError* error )
{
    if ( text == NULL )
    {
        memset( wanted, true, (size_t)numbers->count * sizeof *wanted );
        return RF_OK;
    }
    for ( const char* next = text;; ++next )
    {
        Range range;
        if ( !take_range( &next, &range ) )
            return rf_fail( error, RF_ERROR_USAGE,
                            "--frames: wants frames such as 7, 1-48, 1-48x2, -5--1 with commas between them, got '%s'", text );
        RfResult result = mark_range( range, numbers, wanted, error );
        if ( result != RF_OK || *next == '\0' )
            return result;
    }
}

static RfResult parse( const char* text, const Numbers* numbers, int** frames, int* count, RfError* error )
{
    *frames = NULL;
    *count = 0;
    int frame_count = (int)numbers->count;
    bool* wanted = calloc( (size_t)frame_count, sizeof *wanted );
    int* list = malloc( (size_t)frame_count * sizeof *list );
    RfResult result = RF_OK;
    if ( wanted == NULL || list == NULL )
        result = rf_fail( error, RF_ERROR_MEMORY, "--frames: no memory left for %d frames", frame_count );
    if ( result == RF_OK )
        result = mark_all( text, numbers, wanted, error );
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

RfResult rf_parse_frames( const char* text, int frame_count, int** frames, int* count, RfError* error )
{
    Numbers numbers = { 1, 1, frame_count };
    return parse( text, &numbers, frames, count, error );
}

RfResult rf_choose_frames( const char* text, const RfSceneFile* file, const RfCameraPath* path, int** frames, int* count,
                           RfError* error )
{
    Numbers numbers = { path->first, path->step, path->count };
    RfResult result = parse( text, &numbers, frames, count, error );
    RfField defaults = rf_scene_file_defaults( file, error );
    RfField field = rf_field_member( &defaults, "frames" );
    if ( result != RF_ERROR_USAGE || field.json == NULL || json_string_value( field.json ) != text )
        return result;
    RfError fault = *error;
    return rf_fail_file_option( &field, &fault );
}
