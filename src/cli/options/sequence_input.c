#include "cli/options/sequence_input.h"

#include "cli/options/frame_list.h"
#include "cli/report/report_folder.h"
#include "image/sequence.h"

#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>

bool rf_is_folder( const char* path )
{
    struct stat status;
    return stat( path, &status ) == 0 && S_ISDIR( status.st_mode );
}

bool rf_is_file( const char* path )
{
    struct stat status;
    return stat( path, &status ) == 0 && !S_ISDIR( status.st_mode );
}

// Replaces the frames by those that --frames names, all of which must be there.
static RfResult choose_frames( const char* list, RfSequenceInput* input, RfError* error )
{
    int *wanted, count, last = input->frames[input->count - 1];
    RfResult result = rf_parse_frames( list, last > 0 ? last : 1, &wanted, &count, error );
    if ( result != RF_OK )
        return result;
    for ( int i = 0, next = 0; i < count && result == RF_OK; ++i )
    {
        wanted[i] += 1; // rf_parse_frames counts from 0
        while ( next < input->count && input->frames[next] < wanted[i] )
            ++next;
        if ( next == input->count || input->frames[next] != wanted[i] )
            result = rf_fail( error, RF_ERROR_IO, "%s: frame %d is missing", input->pattern, wanted[i] );
    }
    free( input->frames );
    input->frames = wanted;
    input->count = count;
    return result;
}

RfResult rf_warn_of_missing( const RfSequenceInput* input, RfLog* log, RfError* error )
{
    int *missing, count;
    char text[256];
    RfResult result = rf_missing_frames( input->frames, input->count, &missing, &count, error );
    if ( result != RF_OK )
        return result;
    rf_format_frames( missing, count, text, sizeof text );
    if ( count > 0 )
        rf_warn( log, "%s: lacks frame%s %s", input->pattern, count == 1 ? "" : "s", text );
    free( missing );
    return RF_OK;
}

RfResult rf_find_sequence_input( const char* from, const char* list, RfSequenceInput* input, RfError* error )
{
    RfResult result = RF_OK;
    *input = ( RfSequenceInput ){ .count = 0 };
    if ( rf_is_folder( from ) )
        result = rf_find_folder_sequence( from, input->pattern, sizeof input->pattern, error );
    else if ( snprintf( input->pattern, sizeof input->pattern, "%s", from ) >= (int)sizeof input->pattern )
        result = rf_fail( error, RF_ERROR_USAGE, "%s: the name is too long", from );
    input->is_sequence = rf_is_sequence( input->pattern ) && !rf_is_file( input->pattern );
    if ( result != RF_OK )
        return result;
    if ( !input->is_sequence )
        return list == NULL ? RF_OK : rf_fail( error, RF_ERROR_USAGE, "--frames: is of sequences, and %s is a file", from );
    result = rf_sequence_frames( input->pattern, &input->frames, &input->count, error );
    if ( result != RF_OK )
        return result;
    return list != NULL ? choose_frames( list, input, error ) : RF_OK;
}

void rf_free_sequence_input( RfSequenceInput* input )
{
    free( input->frames );
    *input = ( RfSequenceInput ){ .count = 0 };
}
