#include "cli/render/render_output.h"

#include "output/frame_difference.h"
#include "reframe/image.h"

#include <stdio.h>
#include <string.h>
#include <sys/stat.h>

#define MAX_NAME 4096

// "--spp 28 (here 56), --seed 1 (here 2)"; empty where no setting differs.
static void tell_differences( const RfOutput* output, int frame, char* text, size_t size )
{
    static const char* const facts[] = { "version", "frame", "frames" }; // no options, or not in this sense
    static const char* const words[] = { "version", "frame", "frames in the path" };
    RfFrameDifference list[RF_MAX_DIFFERENCES];
    int count = rf_list_frame_differences( output, frame, list );
    size_t used = 0;
    text[0] = '\0';
    for ( int i = 0; i < count && used < size; ++i )
    {
        char option[48];
        snprintf( option, sizeof option, "--%s", list[i].name );
        for ( size_t k = 0; k < sizeof facts / sizeof facts[0]; ++k )
        {
            if ( strcmp( list[i].name, facts[k] ) == 0 )
                snprintf( option, sizeof option, "%s", words[k] );
        }
        used += (size_t)snprintf( text + used, size - used, "%s%s %s (here %s)", i > 0 ? ", " : "", option, list[i].there,
                                  list[i].here );
    }
}

static RfResult refuse_other( const RfOutput* output, int frame, const char* name, RfError* error )
{
    char differences[512];
    tell_differences( output, frame, differences, sizeof differences );
    if ( differences[0] != '\0' )
        return rf_fail( error, RF_ERROR_IO,
                        "--resume: %.300s: is of another render, of %s: give the same, or add --overwrite to replace such frames",
                        name, differences );
    return rf_fail( error, RF_ERROR_IO,
                    "--resume: %s: was rendered with these settings, but from another scene or camera path, or one that has "
                    "changed since, or with another --fps: give those, or add --overwrite to replace such frames",
                    name );
}

static RfResult refuse( RfFrameFileState state, const RfRenderOptions* options, const RfOutput* output, int frame,
                        const char* name, const RfError* reason, RfError* error )
{
    if ( !options->resume )
        return rf_fail( error, RF_ERROR_IO, "%s: is there already: --resume goes on, --overwrite replaces", name );
    if ( state == RF_FRAME_FILE_UNREADABLE )
        return rf_fail( error, RF_ERROR_IO, "--resume: not a frame of this render, add --overwrite to replace it: %.900s",
                        reason->text );
    return refuse_other( output, frame, name, error );
}

static RfResult keep_or_refuse( const RfOutput* output, const RfRenderOptions* options, int frame, bool* keep, RfError* error )
{
    char name[MAX_NAME];
    RfError reason = { 0 };
    RfFrameFileState state;
    *keep = false;
    RfResult result = rf_sequence_name( output->pattern, rf_frame_number( output->path, frame ), name, sizeof name, error );
    if ( result != RF_OK )
        return result;
    result = rf_check_frame_file( output, frame, &state, &reason );
    if ( result != RF_OK )
        return rf_fail( error, result, "%s", reason.text );
    if ( state == RF_FRAME_FILE_MISSING )
        return RF_OK;
    *keep = options->resume && state == RF_FRAME_FILE_SAME;
    return *keep || options->overwrite ? RF_OK : refuse( state, options, output, frame, name, &reason, error );
}

static RfResult check_json( const char* name, RfError* error )
{
    struct stat status;
    if ( name != NULL && strcmp( name, "-" ) != 0 && stat( name, &status ) == 0 && S_ISDIR( status.st_mode ) )
        return rf_fail( error, RF_ERROR_IO, "--json: %s: is a folder: choose another name", name );
    return RF_OK;
}

// The folder is there, or is made, and files can be made in it.
static RfResult prepare_folder( const char* pattern, RfError* error )
{
    RfError reason = { 0 };
    RfResult result = rf_prepare_output_folder( pattern, &reason );
    if ( result == RF_ERROR_IO )
        return rf_fail( error, result, "%.900s: say with -o where the frames go", reason.text );
    return result == RF_OK ? RF_OK : rf_fail( error, result, "--output: %.1000s", reason.text );
}

RfResult rf_prepare_output( const RfOutput* output, const RfRenderOptions* options, int* frames, int* count, int* kept,
                            RfError* error )
{
    RfResult result = RF_OK;
    if ( *count > 1 && !rf_is_sequence( output->pattern ) )
        result = rf_fail( error, RF_ERROR_USAGE, "--output: '%s' has no #### for the number, but %d frames are asked for",
                          output->pattern, *count );
    if ( result == RF_OK )
        result = prepare_folder( output->pattern, error );
    if ( result == RF_OK )
        result = check_json( options->json, error );
    int left = 0;
    for ( int i = 0; i < *count && result == RF_OK; ++i )
    {
        bool keep;
        result = keep_or_refuse( output, options, frames[i], &keep, error );
        if ( result == RF_OK && keep )
            kept[i - left] = frames[i];
        else if ( result == RF_OK )
            frames[left++] = frames[i];
    }
    *count = result == RF_OK ? left : *count;
    return result;
}
