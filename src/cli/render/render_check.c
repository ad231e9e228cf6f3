#include "cli/render/render_check.h"

#include "cli/ranges.h"
#include "image/sequence.h"
#include "reframe/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MAX_NAME 4096
#define MOST_TEXT 160 // characters of a list of frames in a message

typedef enum Kind
{
    MISSING,
    OTHER,
    UNREADABLE,
    FINISHED,
    KINDS
} Kind;

typedef struct Check
{
    int* lists[KINDS]; // numbers of the frames
    int counts[KINDS];
    int *left, *left_eyes; // all but the finished: their numbers and their runs
    int left_count;
} Check;

static bool create( int count, Check* check )
{
    bool good = true;
    *check = ( Check ){ .left = malloc( (size_t)count * sizeof( int ) ), .left_eyes = malloc( (size_t)count * sizeof( int ) ) };
    for ( int k = 0; k < KINDS; ++k )
    {
        check->lists[k] = malloc( (size_t)count * sizeof( int ) );
        good = good && check->lists[k] != NULL;
    }
    return good && check->left != NULL && check->left_eyes != NULL;
}

static void destroy( Check* check )
{
    for ( int k = 0; k < KINDS; ++k )
        free( check->lists[k] );
    free( check->left );
    free( check->left_eyes );
}

// A frame of this render is there under its name only once it is whole; whether it still is, reading it tells.
static RfResult look_at( const RfRenderJob* job, int frame, Kind* kind, RfError* error )
{
    char name[MAX_NAME];
    RfFrameFileState state;
    RfImage image = { 0 };
    RfResult result = rf_sequence_name( job->options.output, rf_frame_number( &job->path, frame ), name, sizeof name, error );
    if ( result == RF_OK )
        result = rf_check_frame_file( &job->output, frame, &state, error );
    if ( result != RF_OK )
        return result;
    static const Kind kinds[] = { [RF_FRAME_FILE_MISSING] = MISSING,
                                  [RF_FRAME_FILE_SAME] = FINISHED,
                                  [RF_FRAME_FILE_OTHER] = OTHER,
                                  [RF_FRAME_FILE_UNREADABLE] = UNREADABLE };
    *kind = kinds[state];
    if ( *kind == FINISHED )
    {
        result = rf_read_exr( name, &image, error );
        *kind = result == RF_OK ? FINISHED : UNREADABLE;
        rf_destroy_image( &image );
    }
    return result == RF_ERROR_MEMORY ? result : RF_OK;
}

static RfResult look_at_all( const RfRenderJob* job, Check* check, RfError* error )
{
    RfResult result = RF_OK;
    for ( int i = 0; i < job->frame_count && result == RF_OK; ++i )
    {
        int frame = job->frames[i], number = rf_frame_number( &job->path, frame );
        Kind kind;
        result = look_at( job, frame, &kind, error );
        if ( result != RF_OK )
            break;
        check->lists[kind][check->counts[kind]++] = number;
        if ( kind == FINISHED )
            continue;
        check->left[check->left_count] = number;
        check->left_eyes[check->left_count++] = job->path.run_of_frame[frame];
    }
    return result;
}

static json_t* check_json( const RfRenderJob* job, const Check* check, const RfRanges* ranges )
{
    const RfRenderSettings* settings = &job->options.settings;
    json_t* json =
        json_pack( "{s:s, s:o, s:b, s:i, s:i, s:o, s:o, s:o, s:i, s:i, s:s}", "version", rf_version(), "scene",
                   rf_json_text( job->options.scene ), "complete", check->left_count == 0, "asked", job->frame_count, "finished",
                   check->counts[FINISHED], "missing", rf_json_frames( check->lists[MISSING], check->counts[MISSING] ), "other",
                   rf_json_frames( check->lists[OTHER], check->counts[OTHER] ), "unreadable",
                   rf_json_frames( check->lists[UNREADABLE], check->counts[UNREADABLE] ), "group", settings->group, "spp",
                   settings->spp, "adaptive_mode", rf_adaptive_name( settings->adaptive ) );
    if ( ranges->list != NULL )
        json_object_set_new( json, "nodes", rf_ranges_json( ranges ) );
    return json;
}

static void add_list( const Check* check, Kind kind, const char* words, char* text, size_t size )
{
    char frames[MOST_TEXT];
    size_t used = strlen( text );
    rf_format_frames( check->lists[kind], check->counts[kind], frames, sizeof frames );
    if ( check->counts[kind] > 0 )
        snprintf( text + used, size - used, "; %s: %s", words, frames );
}

static RfResult fail_incomplete( const RfRenderJob* job, const Check* check, RfError* error )
{
    char text[4 * MOST_TEXT] = "";
    bool in_the_way = check->counts[OTHER] + check->counts[UNREADABLE] > 0;
    add_list( check, MISSING, "not there", text, sizeof text );
    add_list( check, OTHER, "of another render", text, sizeof text );
    add_list( check, UNREADABLE, "no whole frame", text, sizeof text );
    return rf_fail( error, RF_ERROR_IO, "%.300s: %d of %d frames are finished%s: %s", job->options.output,
                    check->counts[FINISHED], job->frame_count, text,
                    in_the_way ? "--resume --overwrite replaces the rest" : "--resume goes on" );
}

static RfResult tell( const RfRenderJob* job, const Check* check, const RfRanges* ranges, RfError* error )
{
    const char* json = job->options.json;
    bool tells = json == NULL || strcmp( json, "-" ) != 0;
    if ( tells && check->left_count == 0 )
        rf_print( "%d frame%s in %s: all there, whole and of this render\n", job->frame_count, job->frame_count == 1 ? "" : "s",
                  job->options.output );
    if ( tells && ranges->list != NULL )
        rf_print_ranges( ranges );
    RfResult result = json != NULL ? rf_write_json( json, check_json( job, check, ranges ), error ) : rf_flush_output( error );
    return result == RF_OK && check->left_count > 0 ? fail_incomplete( job, check, error ) : result;
}

RfResult rf_check_render( RfRenderJob* job, RfError* error )
{
    Check check;
    RfRanges ranges = { 0 };
    RfResult result = RF_OK;
    if ( !create( job->frame_count, &check ) )
        result = rf_fail( error, RF_ERROR_MEMORY, "no memory left for the numbers of %d frames", job->frame_count );
    if ( result == RF_OK )
        result = look_at_all( job, &check, error );
    if ( result == RF_OK && job->options.nodes > 0 && check.left_count > 0 )
        result = rf_cut_ranges( job->options.nodes, check.left, job->path.step, job->path.run_count, check.left_eyes,
                                check.left_count, &job->options.settings, &ranges, error );
    if ( result == RF_OK )
        result = tell( job, &check, &ranges, error );
    rf_free_ranges( &ranges );
    destroy( &check );
    return result;
}
