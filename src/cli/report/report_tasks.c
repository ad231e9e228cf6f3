#include "cli/report/report_tasks.h"

#include "cli/messages.h"
#include "image/sequence.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_FRAMES 1000000 // of all ranges; a path has no more
#define MOST_TASKS 100      // in a page's table

bool rf_is_plan_json( const json_t* json )
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

void rf_join_task_json( json_t** all, const json_t* task )
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

static int compare_ints( const void* a, const void* b )
{
    int x = *(const int*)a, y = *(const int*)b;
    return ( x > y ) - ( x < y );
}

static bool is_among( const RfTaskFrames* there, int number )
{
    return there->count > 0 && bsearch( &number, there->numbers, (size_t)there->count, sizeof( int ), compare_ints ) != NULL;
}

static bool take_number( const char** text, long* number )
{
    char* end;
    *number = strtol( *text, &end, 10 );
    bool good = end != *text && labs( *number ) <= MOST_FRAMES * 100L;
    *text = end;
    return good;
}

// Frames of "1-9,12,20-30x2" and how many of them are there; the others are appended to `left`. -1: it is no such text.
static int count_frames( const char* text, long step, const RfTaskFrames* there, int* finished, json_t* left )
{
    int count = 0;
    while ( *text != '\0' )
    {
        long first, last, apart = step;
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

json_t* rf_task_progress_json( const json_t* plan, const int* numbers, int number_count )
{
    const RfTaskFrames there = { numbers, number_count };
    const json_t* nodes = json_object_get( plan, "nodes" );
    double told = rf_json_number_of( nodes, "step" );
    long step = isgreaterequal( told, 1.0 ) && islessequal( told, MOST_FRAMES ) ? (long)told : 1;
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
        rf_print( "%s: %.0f of %.0f frames are finished, not yet %s\n", name, rf_json_number_of( progress, "finished" ),
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
