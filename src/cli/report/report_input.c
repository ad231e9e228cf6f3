// Collects the sequences of a report and the JSON beside them; tasks of one render are summed.
#include "cli/report/report_input.h"

#include "base/file.h"
#include "cli/messages.h"
#include "image/sequence.h"

#include <errno.h>
#include <libgen.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#define MOST_FRAMES 1000000 // of all ranges; a path has no more
#define MOST_JSON_BYTES ( (uint64_t)64 << 20 )

// Does this JSON have ranges: that of `tune --nodes`, of `render --check --nodes` or of scripts/slurm-render?
static bool is_plan_json( const json_t* json )
{
    const json_t* range = json_array_get( json_object_get( json_object_get( json, "nodes" ), "ranges" ), 0 );
    return json_is_string( json_object_get( range, "frames" ) );
}

// Joins the render JSON of a task to those before, into *all (NULL at first): frames, seconds and warnings are added up.
static void join_task( json_t** all, json_t* task )
{
    if ( *all == NULL )
    {
        *all = json_deep_copy( task );
        json_object_set_new( *all, "tasks", json_integer( 1 ) );
        json_object_del( *all, "interrupted" ); // of a task: it may have gone on since
        json_object_del( *all, "rays" );
        return;
    }
    json_array_extend( json_object_get( *all, "frames" ), json_object_get( task, "frames" ) );
    json_array_extend( json_object_get( *all, "warnings" ), json_object_get( task, "warnings" ) );
    json_object_set_new( *all, "seconds",
                         rf_json_number( rf_json_number_of( *all, "seconds" ) + rf_json_number_of( task, "seconds" ) ) );
    json_object_set_new( *all, "tasks", json_integer( json_integer_value( json_object_get( *all, "tasks" ) ) + 1 ) );
    if ( isgreater( rf_json_number_of( task, "peak_bytes" ), rf_json_number_of( *all, "peak_bytes" ) ) )
        json_object_set( *all, "peak_bytes", json_object_get( task, "peak_bytes" ) );
    if ( !json_equal( json_object_get( *all, "threads" ), json_object_get( task, "threads" ) ) )
        json_object_del( *all, "threads" );
}

static void keep_first( json_t** first, json_t* json )
{
    if ( *first == NULL )
        *first = json_incref( json );
}

// Counts the frames of "1-9,12,20-30x2" or "@-3-3" and those of them that are there; the others are appended to `left`. -1: it is
// no such text.
static int count_frames( const char* text, long step, const RfPageSequence* there, int* finished, json_t* left )
{
    for ( int count = 0;; ++text )
    {
        RfFrameRange range;
        if ( !rf_take_frame_range( &text, step, &range ) || range.first != (int)range.first || range.last != (int)range.last ||
             range.last < range.first || ( range.last - range.first ) / range.step > MOST_FRAMES - count )
            return -1;
        for ( long frame = range.first; frame <= range.last; frame += range.step, ++count )
        {
            bool is_there = rf_has_page_frame( there, (int)frame );
            *finished += is_there;
            if ( !is_there )
                json_array_append_new( left, json_integer( frame ) );
        }
        if ( *text == '\0' )
            return count;
    }
}

// What the plan of a sequence has become; NULL: its ranges are not what we write.
static json_t* task_progress_json( const RfPageSequence* sequence )
{
    const json_t* nodes = json_object_get( sequence->plan, "nodes" );
    double reported = rf_json_number_of( nodes, "step" );
    long step = isgreaterequal( reported, 1.0 ) && islessequal( reported, MOST_FRAMES ) ? (long)reported : 1;
    json_t *tasks = json_array(), *left = json_array();
    int asked = 0, finished = 0, count = 0;
    size_t i;
    const json_t* range;
    json_array_foreach( json_object_get( nodes, "ranges" ), i, range )
    {
        const char* frames = json_string_value( json_object_get( range, "frames" ) );
        int here = 0;
        count = frames != NULL ? count_frames( frames, step, sequence, &here, left ) : -1;
        if ( count < 0 )
            break;
        asked += count;
        finished += here;
        json_array_append_new( tasks, json_pack( "{s:s, s:i, s:i}", "frames", frames, "count", count, "finished", here ) );
    }
    if ( asked > 0 && count >= 0 )
        return json_pack( "{s:i, s:i, s:o, s:o}", "asked", asked, "finished", finished, "left", left, "tasks", tasks );
    json_decref( tasks );
    json_decref( left );
    return NULL;
}

bool rf_format_numbers( const json_t* numbers, char* text, size_t size )
{
    size_t count = json_array_size( numbers );
    int* list = malloc( ( count + 1 ) * sizeof( int ) );
    text[0] = '\0';
    for ( size_t i = 0; i < count && list != NULL; ++i )
        list[i] = (int)json_integer_value( json_array_get( numbers, i ) );
    if ( list != NULL )
        rf_format_frames( list, (int)count, text, size );
    free( list );
    return count > 0;
}

bool rf_format_unfinished( const json_t* progress, char text[RF_UNFINISHED_SIZE] )
{
    char frames[240];
    bool lacks = rf_format_numbers( json_object_get( progress, "left" ), frames, sizeof frames );
    snprintf( text, RF_UNFINISHED_SIZE, "%.0f of %.0f frames are finished, missing %s", rf_json_number_of( progress, "finished" ),
              rf_json_number_of( progress, "asked" ), frames );
    return lacks;
}

static bool is_render_json( const json_t* json )
{
    return json_is_array( json_object_get( json, "frames" ) ) && json_is_object( json_object_get( json, "rays" ) ) &&
           json_is_number( json_object_get( json, "seconds" ) );
}

static json_t* parse_json( const char* path, RfError* error )
{
    uint8_t* bytes;
    size_t size;
    if ( rf_read_file( path, MOST_JSON_BYTES, &bytes, &size, error ) != RF_OK )
        return NULL;
    json_error_t reason;
    errno = 0;
    json_t* json = json_loadb( (const char*)bytes, size, 0, &reason );
    bool no_memory = errno == ENOMEM;
    free( bytes );
    if ( json == NULL && no_memory )
        rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory: close other programs", path );
    else if ( json == NULL )
        rf_fail( error, RF_ERROR_FORMAT, "%s: line %d: %s", path, reason.line, reason.text );
    return json;
}

RfResult rf_load_render_json( const char* path, const char* option, json_t** json, RfError* error )
{
    RfError reason = { 0 };
    json_t* loaded = parse_json( path, &reason );
    if ( loaded == NULL )
        return rf_fail( error, reason.code, "%s: %.900s", option, reason.text );
    if ( !is_render_json( loaded ) )
    {
        json_decref( loaded );
        return rf_fail( error, RF_ERROR_FORMAT, "%s: %s: is not what reframe render --json writes", option, path );
    }
    json_decref( *json );
    *json = loaded;
    return RF_OK;
}

// Passes the JSON of renders in a folder, by name, to `take`, and keeps the first plan; other files are ignored.
static RfResult look_for_json( RfPageSequence* sequence, const char* folder, void ( *take )( json_t** all, json_t* one ),
                               json_t** all, RfError* error )
{
    RfFolderList list;
    RfResult result = rf_list_folder( folder, ".json", &list, error );
    for ( int i = 0; i < list.count && result == RF_OK; ++i )
    {
        char path[RF_FILE_NAME_SIZE];
        bool fits = snprintf( path, sizeof path, "%s/%s", folder, list.names[i] ) < (int)sizeof path;
        json_t* json = fits ? parse_json( path, NULL ) : NULL;
        if ( json != NULL && is_render_json( json ) )
            take( all, json );
        else if ( json != NULL && is_plan_json( json ) )
            keep_first( &sequence->plan, json );
        json_decref( json );
    }
    rf_free_folder_list( &list );
    return result;
}

// In the folder of the frames, or what scripts/slurm-render keeps beside them.
static RfResult look_beside( RfPageSequence* sequence, const char* folder, RfError* error )
{
    char slurm[RF_FILE_NAME_SIZE];
    json_t* tasks = NULL;
    RfResult result = look_for_json( sequence, folder, keep_first, &sequence->render, error );
    if ( snprintf( slurm, sizeof slurm, "%.4000s/slurm", folder ) < (int)sizeof slurm )
        look_for_json( sequence, slurm, join_task, &tasks, NULL );
    if ( tasks != NULL )
        keep_first( &sequence->render, tasks );
    json_decref( tasks );
    return result;
}

static RfResult find_frames( const char* place, RfPageSequence* sequence, RfError* error )
{
    RfSequenceInput* input = &sequence->input;
    RfResult result = rf_find_sequence_input( place, NULL, input, error );
    if ( result == RF_ERROR_IO && rf_is_folder( place ) && look_beside( sequence, place, NULL ) == RF_OK &&
         sequence->plan != NULL )
        return rf_fail( error, result, "%s: none of its frames is finished yet: try again later", place );
    if ( result != RF_OK || input->is_sequence )
        return result;
    input->frames = malloc( sizeof( int ) );
    if ( input->frames == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory", place );
    input->frames[0] = input->count = 1;
    return RF_OK;
}

RfResult rf_open_page_sequence( const char* place, const char* layer, RfPageSequence* sequence, RfError* error )
{
    char copy[RF_FILE_NAME_SIZE]; // which basename and dirname may change
    *sequence = ( RfPageSequence ){ .layer = layer };
    snprintf( copy, sizeof copy, "%s", place );
    snprintf( sequence->name, sizeof sequence->name, "%.255s", basename( copy ) );
    RfResult result = find_frames( place, sequence, error );
    if ( result == RF_OK )
        result = rf_sequence_input_name( &sequence->input, sequence->input.frames[0], sequence->first, error );
    if ( result == RF_OK )
        sequence->layer = rf_layer_of_file( sequence->first, layer, sequence->layer_text );
    if ( result == RF_OK )
        result = rf_read_exr_header( sequence->first, sequence->layer, &sequence->header, error );
    snprintf( copy, sizeof copy, "%s", sequence->input.pattern );
    if ( result == RF_OK )
        result = look_beside( sequence, dirname( copy ), error );
    if ( result == RF_OK && sequence->plan != NULL )
        sequence->progress = task_progress_json( sequence );
    return result;
}

void rf_close_page_sequence( RfPageSequence* sequence )
{
    rf_free_sequence_input( &sequence->input );
    rf_destroy_exr_header( &sequence->header );
    json_decref( sequence->render );
    json_decref( sequence->plan );
    json_decref( sequence->progress );
    *sequence = ( RfPageSequence ){ 0 };
}

bool rf_has_page_frame( const RfPageSequence* sequence, int frame )
{
    const RfSequenceInput* input = &sequence->input;
    return bsearch( &frame, input->frames, (size_t)input->count, sizeof( int ), rf_compare_frames ) != NULL;
}

static int64_t at_least( int64_t a, int64_t b ) { return a > b ? a : b; }
static int64_t at_most( int64_t a, int64_t b ) { return a < b ? a : b; }

RfExrWindow rf_page_window( const RfExrHeader* header )
{
    int64_t left = at_least( header->x, header->display_x ), top = at_least( header->y, header->display_y );
    int64_t right = at_most( (int64_t)header->x + header->width, (int64_t)header->display_x + header->display_width );
    int64_t bottom = at_most( (int64_t)header->y + header->height, (int64_t)header->display_y + header->display_height );
    if ( left >= right || top >= bottom )
        return ( RfExrWindow ){ 0, 0, header->width, header->height };
    return ( RfExrWindow ){ (int)( left - header->x ), (int)( top - header->y ), (int)( right - left ), (int)( bottom - top ) };
}
