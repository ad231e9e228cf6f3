// Collects the sequences of a report and the JSON beside them; tasks of one render are summed.
#include "cli/report/report_input.h"

#include "base/file.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "image/exr.h"
#include "image/sequence.h"

#include <errno.h>
#include <jansson.h>
#include <math.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

#define MOST_FRAMES 1000000 // of all ranges; a path has no more
#define MOST_TASKS 100      // in a page's table

// Does this JSON have ranges: that of `tune --nodes`, of `render --check --nodes` or of scripts/slurm-render?
static bool is_plan_json( const json_t* json )
{
    const json_t* range = json_array_get( json_object_get( json_object_get( json, "nodes" ), "ranges" ), 0 );
    return json_is_string( json_object_get( range, "frames" ) );
}

static void add_up( json_t* all, const json_t* task, const char* key )
{
    double sum = rf_json_number_of( all, key ) + rf_json_number_of( task, key );
    const json_t *a = json_object_get( all, key ), *b = json_object_get( task, key );
    if ( json_is_integer( a ) && json_is_integer( b ) )
        json_object_set_new( all, key, json_integer( json_integer_value( a ) + json_integer_value( b ) ) );
    else
        json_object_set_new( all, key, rf_json_number( sum ) );
}

static void join_rays( json_t* all, const json_t* task )
{
    const char* key;
    json_t* value;
    json_object_foreach( json_object_get( all, "rays" ), key, value )
        add_up( json_object_get( all, "rays" ), json_object_get( task, "rays" ), key );
}

// Joins the render JSON of a task to those before, into *all (NULL at first): frames, seconds, rays and warnings are added up.
static void join_task_json( json_t** all, const json_t* task )
{
    if ( *all == NULL )
    {
        *all = json_deep_copy( task );
        json_object_set_new( *all, "tasks", json_integer( 1 ) );
        json_object_del( *all, "interrupted" ); // of a task: it may have gone on since
        return;
    }
    json_array_extend( json_object_get( *all, "frames" ), json_object_get( task, "frames" ) );
    json_array_extend( json_object_get( *all, "warnings" ), json_object_get( task, "warnings" ) );
    join_rays( *all, task );
    add_up( *all, task, "seconds" );
    add_up( *all, task, "seconds_scene" );
    json_object_set_new( *all, "tasks", json_integer( json_integer_value( json_object_get( *all, "tasks" ) ) + 1 ) );
    if ( isgreater( rf_json_number_of( task, "peak_bytes" ), rf_json_number_of( *all, "peak_bytes" ) ) )
        json_object_set( *all, "peak_bytes", json_object_get( task, "peak_bytes" ) );
    if ( !json_equal( json_object_get( *all, "threads" ), json_object_get( task, "threads" ) ) )
        json_object_del( *all, "threads" );
}

// Numbers of the frames that are there, ascending.
typedef struct RfTaskFrames
{
    const int* numbers;
    int count;
} RfTaskFrames;

static bool is_among( const RfTaskFrames* there, int number )
{
    return there->count > 0 && bsearch( &number, there->numbers, (size_t)there->count, sizeof( int ), rf_compare_frames ) != NULL;
}

static bool take_number( const char** text, long* number )
{
    char* end;
    *number = strtol( *text, &end, 10 );
    bool good = end != *text && labs( *number ) <= MOST_FRAMES * 100L;
    *text = end;
    return good;
}

// Frames of "1-9,12,20-30x2" or "@-3-3" and how many of them are there; the others are appended to `left`. -1: it is no such text.
static int count_frames( const char* text, long step, const RfTaskFrames* there, int* finished, json_t* left )
{
    int count = 0;
    while ( *text != '\0' )
    {
        long first, last, apart = step;
        text += *text == '@';
        if ( !take_number( &text, &first ) )
            return -1;
        last = first;
        if ( *text == '-' && ( ++text, !take_number( &text, &last ) ) )
            return -1;
        if ( *text == 'x' && ( ++text, !take_number( &text, &apart ) ) )
            return -1;
        if ( apart < 1 || last < first || ( last - first ) / apart > MOST_FRAMES - count || ( *text != '\0' && *text++ != ',' ) )
            return -1;
        for ( long frame = first; frame <= last; frame += apart, ++count )
        {
            bool is_there = is_among( there, (int)frame );
            *finished += is_there;
            if ( !is_there )
                json_array_append_new( left, json_integer( frame ) );
        }
    }
    return count;
}

// {"asked", "finished", "left": [numbers], "tasks": [{"frames", "count", "finished"}]} of a plan for a sequence whose frames
// of these numbers, ascending, are there; NULL: its ranges are not what we write.
static json_t* task_progress_json( const json_t* plan, const int* numbers, int number_count )
{
    const RfTaskFrames there = { numbers, number_count };
    const json_t* nodes = json_object_get( plan, "nodes" );
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
        count = frames != NULL ? count_frames( frames, step, &there, &here, left ) : -1;
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

void rf_format_left( const json_t* left, char* text, size_t size )
{
    size_t count = json_array_size( left );
    int* numbers = malloc( ( count + 1 ) * sizeof( int ) );
    text[0] = '\0';
    for ( size_t i = 0; i < count && numbers != NULL; ++i )
        numbers[i] = (int)json_integer_value( json_array_get( left, i ) );
    if ( numbers != NULL )
        rf_format_frames( numbers, (int)count, text, size );
    free( numbers );
}

void rf_tell_unfinished( const char* name, const json_t* progress )
{
    char frames[240];
    const json_t* left = json_object_get( progress, "left" );
    rf_format_left( left, frames, sizeof frames );
    if ( json_array_size( left ) > 0 )
        rf_print( "%s: %.0f of %.0f frames are finished, missing %s\n", name, rf_json_number_of( progress, "finished" ),
                  rf_json_number_of( progress, "asked" ), frames );
}

static void add_fact( json_t* facts, const char* label, const char* value )
{
    json_array_append_new( facts, json_pack( "[s, o, o]", "Progress", rf_json_text( label ), rf_json_text( value ) ) );
}

void rf_add_progress_facts( json_t* facts, const json_t* progress )
{
    char text[240], label[240];
    size_t i;
    const json_t *task, *left = json_object_get( progress, "left" );
    snprintf( text, sizeof text, "%.0f of %.0f", rf_json_number_of( progress, "finished" ),
              rf_json_number_of( progress, "asked" ) );
    add_fact( facts, "Finished frames", text );
    rf_format_left( left, text, sizeof text );
    if ( json_array_size( left ) > 0 )
        add_fact( facts, "Not yet", text );
    json_array_foreach( json_object_get( progress, "tasks" ), i, task )
    {
        if ( i == MOST_TASKS )
            break;
        snprintf( label, sizeof label, "Task %zu: %.200s", i, json_string_value( json_object_get( task, "frames" ) ) );
        snprintf( text, sizeof text, "%.0f of %.0f", rf_json_number_of( task, "finished" ), rf_json_number_of( task, "count" ) );
        add_fact( facts, label, text );
    }
}

#define MOST_JSON_BYTES ( (uint64_t)64 << 20 )

static bool is_render_json( const json_t* json )
{
    return json_is_array( json_object_get( json, "frames" ) ) && json_is_object( json_object_get( json, "rays" ) ) &&
           json_is_number( json_object_get( json, "seconds" ) );
}

static bool is_cost_json( const json_t* json )
{
    const json_t* row = json_array_get( json_object_get( json, "rows" ), 0 );
    return json_object_get( row, "reuse" ) != NULL && json_is_number( json_object_get( row, "seconds" ) ) &&
           json_object_get( row, "relmse" ) != NULL;
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
        rf_fail( error, RF_ERROR_MEMORY, "%s: the system has no memory left: close other programs", path );
    else if ( json == NULL )
        rf_fail( error, RF_ERROR_FORMAT, "%s: line %d: %s", path, reason.line, reason.text );
    return json;
}

static RfResult load_json( const char* path, const char* option, bool ( *is_kind )( const json_t* ), const char* command,
                           json_t** json, RfError* error )
{
    RfError reason = { 0 };
    json_t* loaded = parse_json( path, &reason );
    if ( loaded == NULL )
        return rf_fail( error, reason.code, "%s: %.900s", option, reason.text );
    if ( !is_kind( loaded ) )
    {
        json_decref( loaded );
        return rf_fail( error, RF_ERROR_FORMAT, "%s: %s: is not what reframe %s --json writes", option, path, command );
    }
    json_decref( *json );
    *json = loaded;
    return RF_OK;
}

RfResult rf_load_render_json( const char* path, const char* option, json_t** json, RfError* error )
{
    return load_json( path, option, is_render_json, "render", json, error );
}

RfResult rf_load_cost_json( const char* path, const char* option, json_t** json, RfError* error )
{
    return load_json( path, option, is_cost_json, "cost", json, error );
}

bool rf_is_same_scene( const char* a, const char* b )
{
    const char *slash_a = strrchr( a, '/' ), *slash_b = strrchr( b, '/' );
    return a[0] == '\0' || b[0] == '\0' || strcmp( slash_a != NULL ? slash_a + 1 : a, slash_b != NULL ? slash_b + 1 : b ) == 0;
}

const char* rf_scene_of_json( const json_t* json )
{
    const char* scene = json_string_value( json_object_get( json, "scene" ) );
    return scene != NULL ? scene : "";
}

// The first by name is taken, of cost the first of this scene; one of another scene only where there
// is no other, so that it can be refused.
static void take_cost( RfPageSequence* sequence, const char* path, json_t* json )
{
    bool fits = rf_is_same_scene( rf_scene_of_json( json ), sequence->scene );
    if ( sequence->cost != NULL && ( !fits || rf_is_same_scene( rf_scene_of_json( sequence->cost ), sequence->scene ) ) )
        return;
    json_decref( sequence->cost );
    sequence->cost = json_incref( json );
    snprintf( sequence->cost_file, sizeof sequence->cost_file, "%s", path );
}

// Other files are ignored.
static void take_json( RfPageSequence* sequence, const char* path )
{
    json_t* json = parse_json( path, NULL );
    if ( json != NULL && sequence->render == NULL && is_render_json( json ) )
        sequence->render = json_incref( json );
    else if ( json != NULL && is_cost_json( json ) )
        take_cost( sequence, path, json );
    else if ( json != NULL && sequence->plan == NULL && is_plan_json( json ) )
        sequence->plan = json_incref( json );
    json_decref( json );
}

// In the folder of a render's tasks: all of them count.
static void take_task( RfPageSequence* sequence, const char* path, json_t** tasks )
{
    json_t* json = parse_json( path, NULL );
    if ( json != NULL && is_render_json( json ) )
        join_task_json( tasks, json );
    else if ( json != NULL && sequence->plan == NULL && is_plan_json( json ) )
        sequence->plan = json_incref( json );
    json_decref( json );
}

// What scripts/slurm-render keeps beside the frames, if it is there.
static void look_for_tasks( RfPageSequence* sequence, const char* frames )
{
    char folder[RF_PAGE_NAME_SIZE], path[RF_PAGE_NAME_SIZE];
    RfFolderList list;
    json_t* tasks = NULL;
    if ( snprintf( folder, sizeof folder, "%.4000s/slurm", frames ) >= (int)sizeof folder ||
         rf_list_folder( folder, ".json", &list, NULL ) != RF_OK )
        return;
    for ( int i = 0; i < list.count; ++i )
    {
        if ( snprintf( path, sizeof path, "%.3500s/%.500s", folder, list.names[i] ) < (int)sizeof path )
            take_task( sequence, path, &tasks );
    }
    rf_free_folder_list( &list );
    if ( sequence->render == NULL )
        sequence->render = tasks;
    else
        json_decref( tasks );
}

static RfResult look_for_json( RfPageSequence* sequence, const char* folder, RfError* error )
{
    RfFolderList list;
    RfResult result = rf_list_folder( folder, ".json", &list, error );
    for ( int i = 0; i < list.count && result == RF_OK; ++i )
    {
        char path[RF_PAGE_NAME_SIZE];
        if ( snprintf( path, sizeof path, "%s/%s", folder, list.names[i] ) < (int)sizeof path )
            take_json( sequence, path );
    }
    rf_free_folder_list( &list );
    look_for_tasks( sequence, folder );
    return result;
}

// Everything before the last component; "." where there is nothing.
static void folder_of( const char* path, char folder[RF_PAGE_NAME_SIZE] )
{
    const char* slash = strrchr( path, '/' );
    snprintf( folder, RF_PAGE_NAME_SIZE, "%.*s",
              slash == NULL   ? 1
              : slash == path ? 1
                              : (int)( slash - path ),
              slash == NULL ? "." : path );
}

// The last component of a folder's name, or of the file's.
static void name_sequence( const char* place, RfPageSequence* sequence )
{
    size_t length = strlen( place );
    while ( length > 1 && place[length - 1] == '/' )
        --length;
    size_t begin = length;
    while ( begin > 0 && place[begin - 1] != '/' )
        --begin;
    snprintf( sequence->name, sizeof sequence->name, "%.*s", (int)( length - begin ), place + begin );
}

static RfResult take_file( const char* place, RfPageSequence* sequence, RfError* error )
{
    sequence->frames = malloc( sizeof( int ) );
    if ( sequence->frames == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left", place );
    sequence->frames[0] = 1;
    sequence->frame_count = 1;
    return RF_OK;
}

static RfResult find_frames( const char* place, RfPageSequence* sequence, RfError* error )
{
    struct stat status;
    bool is_there = stat( place, &status ) == 0;
    if ( strlen( place ) >= RF_PAGE_NAME_SIZE )
        return rf_fail( error, RF_ERROR_USAGE, "%s: the name is too long", place );
    snprintf( sequence->pattern, sizeof sequence->pattern, "%s", place );
    if ( is_there && S_ISDIR( status.st_mode ) )
    {
        RfResult result = rf_find_folder_sequence( place, sequence->pattern, sizeof sequence->pattern, error );
        if ( result != RF_OK )
            return result;
    }
    if ( rf_is_sequence( sequence->pattern ) && !( is_there && S_ISREG( status.st_mode ) ) )
        return rf_sequence_frames( sequence->pattern, &sequence->frames, &sequence->frame_count, error );
    if ( !is_there )
        return rf_fail( error, RF_ERROR_IO, "%s: is not there: give a folder, or the name of a sequence with #### for the number",
                        place );
    return take_file( place, sequence, error );
}

// A folder without frames that tasks are rendering to.
static bool waits_for_frames( const char* place, RfPageSequence* sequence )
{
    struct stat status;
    if ( stat( place, &status ) != 0 || !S_ISDIR( status.st_mode ) || look_for_json( sequence, place, NULL ) != RF_OK )
        return false;
    return sequence->plan != NULL;
}

RfResult rf_open_page_sequence( const char* place, const char* layer, RfPageSequence* sequence, RfError* error )
{
    *sequence = ( RfPageSequence ){ .layer = layer };
    name_sequence( place, sequence );
    RfResult result = find_frames( place, sequence, error );
    if ( result == RF_ERROR_IO && waits_for_frames( place, sequence ) )
        return rf_fail( error, result, "%s: none of its frames is finished yet: try again later", place );
    if ( result == RF_OK )
        result = rf_page_frame_path( sequence, sequence->frames[0], sequence->first, error );
    if ( result == RF_OK )
        sequence->layer = rf_layer_of_file( sequence->first, layer, sequence->layer_text );
    if ( result == RF_OK )
        result = rf_read_exr_header( sequence->first, sequence->layer, &sequence->header, error );
    if ( result == RF_OK &&
         rf_read_exr_string( sequence->first, "reframe/scene", sequence->scene, sizeof sequence->scene, NULL ) != RF_OK )
        sequence->scene[0] = '\0';
    char folder[RF_PAGE_NAME_SIZE];
    folder_of( sequence->pattern, folder );
    if ( result == RF_OK )
        result = look_for_json( sequence, folder, error );
    if ( result == RF_OK && sequence->plan != NULL )
        sequence->progress = task_progress_json( sequence->plan, sequence->frames, sequence->frame_count );
    return result;
}

void rf_close_page_sequence( RfPageSequence* sequence )
{
    free( sequence->frames );
    rf_destroy_exr_header( &sequence->header );
    json_decref( sequence->render );
    json_decref( sequence->plan );
    json_decref( sequence->progress );
    json_decref( sequence->cost );
    *sequence = ( RfPageSequence ){ 0 };
}

bool rf_has_page_frame( const RfPageSequence* sequence, int frame )
{
    for ( int i = 0; i < sequence->frame_count; ++i )
    {
        if ( sequence->frames[i] == frame )
            return true;
    }
    return false;
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

RfResult rf_page_frame_path( const RfPageSequence* sequence, int frame, char path[RF_PAGE_NAME_SIZE], RfError* error )
{
    if ( sequence->frame_count == 1 && !rf_is_sequence( sequence->pattern ) )
    {
        snprintf( path, RF_PAGE_NAME_SIZE, "%s", sequence->pattern );
        return RF_OK;
    }
    return rf_sequence_name( sequence->pattern, frame, path, RF_PAGE_NAME_SIZE, error );
}
