// Frame lists, file patterns of sequences, and the cut of a render into ranges for several machines.
#include "cli/options/frame_lists.h"

#include "base/try.h"
#include "base/words.h"
#include "cli/options/render_options.h"
#include "image/atomic_file.h"
#include "image/sequence.h"

#include <ctype.h>
#include <dirent.h>
#include <errno.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

RfResult rf_cut_ranges( int nodes, const RfDividedFrames* frames, const RfRenderSettings* settings, RfRanges* ranges,
                        RfError* error )
{
    int most = nodes < frames->count ? nodes : frames->count;
    *ranges = ( RfRanges ){
        .list = malloc( (size_t)most * sizeof( RfPlanRange ) ), .nodes = nodes, .group = settings->group, .frames = *frames
    };
    if ( ranges->list == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for %d ranges", most );
    RfShot shot = {
        .eyes = frames->cameras, .eye_count = frames->run_count, .frames = frames->runs, .frame_count = frames->count
    };
    return rf_plan_ranges( &shot, settings, nodes, ranges->list, &ranges->count, error );
}

void rf_free_ranges( RfRanges* ranges )
{
    free( ranges->list );
    *ranges = ( RfRanges ){ 0 };
}

// Numbers from the first on that are evenly spaced; two are no series unless they are neighbours in the path.
static int series( const int* numbers, int count, int step )
{
    int length = count > 1 ? 2 : 1;
    while ( length > 1 && length < count && numbers[length] - numbers[length - 1] == numbers[1] - numbers[0] )
        ++length;
    return length == 2 && numbers[1] - numbers[0] != step ? 1 : length;
}

// Frames as --frames takes them: "1-24", "1,7,9-15x2", "@-3-24". The caller frees the text; NULL where memory ran out.
static char* frame_list( const int* numbers, int count, int step )
{
    char* text = NULL;
    size_t size;
    FILE* file = open_memstream( &text, &size );
    for ( int i = 0, length; i < count && file != NULL; i += length )
    {
        length = series( numbers + i, count - i, step );
        int apart = length > 1 ? numbers[i + 1] - numbers[i] : step;
        fprintf( file, "%s%s%d", i > 0 ? "," : "", numbers[i] < 0 ? "@" : "", numbers[i] );
        if ( length > 1 )
            fprintf( file, "-%d", numbers[i + length - 1] );
        if ( apart != step )
            fprintf( file, "x%d", apart );
    }
    if ( file == NULL || fclose( file ) == 0 )
        return text;
    free( text );
    return NULL;
}

static void sum_up( const RfRanges* r, double* all, double* longest )
{
    *all = *longest = 0.0;
    for ( int i = 0; i < r->count; ++i )
    {
        *all += r->list[i].work;
        *longest = r->list[i].work > *longest ? r->list[i].work : *longest;
    }
}

void rf_print_ranges( const RfRanges* r )
{
    double all, longest;
    sum_up( r, &all, &longest );
    printf( "\n%d range%s for --nodes %d, group %d, with the share of the work:\n", r->count, r->count == 1 ? "" : "s", r->nodes,
            r->group );
    for ( int i = 0; i < r->count; ++i )
    {
        const RfPlanRange* range = r->list + i;
        char* frames = frame_list( r->frames.numbers + range->first, range->end - range->first, r->frames.step );
        printf( "  --frames %-16s %5d frame%s %6.1f %%\n", frames != NULL ? frames : "?", range->end - range->first,
                range->end - range->first == 1 ? " " : "s", 100.0 * range->work );
        free( frames );
    }
    printf( "overhead of the halos at the cuts: %.1f %% more samples in total; at best %.1f %% of the time of one machine\n",
            100.0 * ( all - 1.0 ), 100.0 * longest );
}

json_t* rf_ranges_json( const RfRanges* r )
{
    double all, longest;
    sum_up( r, &all, &longest );
    json_t* list = json_array();
    for ( int i = 0; i < r->count; ++i )
    {
        const RfPlanRange* range = r->list + i;
        char* frames = frame_list( r->frames.numbers + range->first, range->end - range->first, r->frames.step );
        json_array_append_new( list, json_pack( "{s:s, s:i, s:f}", "frames", frames != NULL ? frames : "", "count",
                                                range->end - range->first, "work", range->work ) );
        free( frames );
    }
    return json_pack( "{s:i, s:i, s:i, s:o, s:f, s:f}", "wanted", r->nodes, "group", r->group, "step", r->frames.step, "ranges",
                      list, "overhead", all - 1.0, "longest", longest );
}

#define NAME_SIZE 512

static int compare_names( const struct dirent** a, const struct dirent** b ) { return strcmp( ( *a )->d_name, ( *b )->d_name ); }

static int is_shown( const struct dirent* entry ) { return entry->d_name[0] != '.'; }

RfResult rf_list_folder( const char* folder, const char* suffix, RfFolderList* list, RfError* error )
{
    struct dirent** entries;
    *list = ( RfFolderList ){ 0 };
    int count = scandir( folder, &entries, is_shown, compare_names );
    if ( count < 0 )
        return rf_fail_io( folder, "this folder cannot be read", errno, error );
    RfResult result = RF_OK;
    list->names = malloc( ( (size_t)count + 1 ) * sizeof( char* ) );
    for ( int i = 0; i < count; ++i )
    {
        bool is_wanted = rf_ends_with( entries[i]->d_name, suffix ), has_room = is_wanted && list->names != NULL;
        if ( has_room && ( list->names[list->count] = strdup( entries[i]->d_name ) ) != NULL )
            list->count += 1;
        else if ( is_wanted )
            result = rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for the names of its files", folder );
        free( entries[i] );
    }
    free( entries );
    return result;
}

void rf_free_folder_list( RfFolderList* list )
{
    for ( int i = 0; i < list->count; ++i )
        free( list->names[i] );
    free( list->names );
    *list = ( RfFolderList ){ 0 };
}

// Where the last number of a name before ".exr" is; false where it has none. A minus belongs to it where no word is before that.
static bool find_number( const char* name, size_t* begin, size_t* length )
{
    size_t end = strlen( name ) - strlen( ".exr" );
    while ( end > 0 && !isdigit( (unsigned char)name[end - 1] ) )
        --end;
    *begin = end;
    while ( *begin > 0 && isdigit( (unsigned char)name[*begin - 1] ) )
        --*begin;
    if ( *begin<end&& * begin> 0 && name[*begin - 1] == '-' && ( *begin == 1 || !isalnum( (unsigned char)name[*begin - 2] ) ) )
        --*begin;
    *length = end - *begin;
    return *length > 0;
}

static size_t count_digits( const char* name, size_t begin, size_t length ) { return length - ( name[begin] == '-' ); }

// Of one sequence: the same but for the number.
static bool is_alike( const char* a, const char* b )
{
    size_t a_begin, a_length, b_begin, b_length;
    if ( !find_number( a, &a_begin, &a_length ) || !find_number( b, &b_begin, &b_length ) )
        return false;
    return a_begin == b_begin && memcmp( a, b, a_begin ) == 0 && strcmp( a + a_begin + a_length, b + b_begin + b_length ) == 0;
}

// The pattern of the sequence that `name` is of: '#' for the digits of its shortest number.
static void make_pattern( const RfFolderList* list, const char* name, char pattern[NAME_SIZE] )
{
    size_t begin, length, shortest, used;
    snprintf( pattern, NAME_SIZE, "%s", name );
    if ( !find_number( name, &begin, &length ) )
        return;
    shortest = count_digits( name, begin, length );
    for ( int i = 0; i < list->count; ++i )
    {
        size_t other_begin, other_length;
        if ( is_alike( name, list->names[i] ) && find_number( list->names[i], &other_begin, &other_length ) &&
             count_digits( list->names[i], other_begin, other_length ) < shortest )
            shortest = count_digits( list->names[i], other_begin, other_length );
    }
    used = (size_t)snprintf( pattern, NAME_SIZE, "%.*s", (int)begin, name );
    for ( size_t i = 0; i < shortest && used + 1 < NAME_SIZE; ++i )
        pattern[used++] = '#';
    snprintf( pattern + used, NAME_SIZE - used, "%s", name + begin + length );
}

// The pattern of the folder's frames: the last number of their names is the frame's. Fails where there is no EXR, or more than one
// sequence, which the error names; a folder of one file without a number gives that file.
static RfResult find_folder_sequence( const char* folder, char* pattern, size_t size, RfError* error )
{
    RfFolderList list;
    char first[NAME_SIZE], other[NAME_SIZE];
    RfResult result = rf_list_folder( folder, ".exr", &list, error );
    if ( result == RF_OK && list.count == 0 )
        result = rf_fail( error, RF_ERROR_IO, "%s: no EXR file in this folder", folder );
    for ( int i = 1; i < list.count && result == RF_OK; ++i )
    {
        if ( is_alike( list.names[0], list.names[i] ) )
            continue;
        make_pattern( &list, list.names[0], first );
        make_pattern( &list, list.names[i], other );
        result =
            rf_fail( error, RF_ERROR_USAGE, "%.300s: has more than one sequence, %.200s and %.200s: name one, as %.100s/%.150s",
                     folder, first, other, folder, first );
    }
    if ( result == RF_OK )
    {
        make_pattern( &list, list.names[0], first );
        bool slash = folder[strlen( folder ) - 1] == '/';
        if ( snprintf( pattern, size, "%s%s%s", folder, slash ? "" : "/", first ) >= (int)size )
            result = rf_fail( error, RF_ERROR_USAGE, "%s: the names in this folder are too long", folder );
    }
    rf_free_folder_list( &list );
    return result;
}

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

// "A" or "A-B", with '@' before it or "xSTEP" behind it.
typedef struct Range
{
    bool is_own;            // written with '@': numbers as the path has them
    long first, last, step; // as written: else negative from the end
} Range;

// Parses a range up to a comma or the end, and advances *text to there. False: it is none.
static bool take_range( const char** text, Range* range )
{
    range->is_own = **text == '@';
    *text += range->is_own;
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

static RfResult fail_missing( long number, bool is_own, const Numbers* numbers, RfError* error )
{
    if ( numbers->first == 1 && numbers->step == 1 )
        return rf_fail( error, RF_ERROR_USAGE, "--frames: there is no frame %ld, the camera's path has %ld frame%s", number,
                        numbers->count, numbers->count == 1 ? "" : "s" );
    char steps[48] = "";
    if ( numbers->step > 1 )
        snprintf( steps, sizeof steps, " in steps of %ld", numbers->step );
    return rf_fail( error, RF_ERROR_USAGE, "--frames: there is no frame %ld, the camera's path has frames %ld to %ld%s%s", number,
                    numbers->first, last_number( numbers ), steps,
                    number < 0 && !is_own && numbers->first < 0 ? "; negative numbers count from the end, those of the path are "
                                                                  "written as @-3-3"
                                                                : "" );
}

// Makes a number that counts from the end one of the path; fails beyond its ends.
static RfResult resolve( long written, bool is_own, const Numbers* numbers, long* number, RfError* error )
{
    bool from_end = written < 0 && !is_own;
    *number = from_end ? numbers->first + ( written + numbers->count ) * numbers->step : written;
    bool inside = *number >= numbers->first && *number < last_number( numbers ) + numbers->step;
    bool counted = !from_end || written >= -numbers->count;
    return inside && counted ? RF_OK : fail_missing( written, is_own, numbers, error );
}

static RfResult mark_range( Range range, const Numbers* numbers, bool* wanted, RfError* error )
{
    long first, last;
    RF_TRY( resolve( range.first, range.is_own, numbers, &first, error ) );
    RF_TRY( resolve( range.last, range.is_own, numbers, &last, error ) );
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
    return any ? RF_OK : fail_missing( first, true, numbers, error );
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
            return rf_fail(
                error, RF_ERROR_USAGE,
                "--frames: expected frames such as 7, 1-48, 1-48x2, -5--1 (the last five) or @-5--1 (by their numbers) "
                "with commas between them, got '%s'",
                text );
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
        result = rf_fail( error, RF_ERROR_MEMORY, "--frames: out of memory for %d frames", frame_count );
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

RfResult rf_parse_frames( const char* text, const int* there, int there_count, int** frames, int* count, RfError* error )
{
    long first = there[0] < 1 ? there[0] : 1, last = there[there_count - 1] > first ? there[there_count - 1] : first;
    Numbers numbers = { first, 1, last - first + 1 };
    RfResult result = parse( text, &numbers, frames, count, error );
    for ( int i = 0; i < *count; ++i )
        ( *frames )[i] += (int)first;
    return result;
}

RfResult rf_choose_frames( const char* text, const RfSceneFile* file, const RfCameraPath* path, int** frames, int* count,
                           RfError* error )
{
    Numbers numbers = { path->first, path->step, path->count };
    RfResult result = parse( text, &numbers, frames, count, error );
    RfError fault = *error;
    RfField defaults = rf_scene_file_defaults( file, &fault );
    RfField field = rf_field_member( &defaults, "frames" );
    if ( result != RF_ERROR_USAGE || field.json == NULL || json_string_value( field.json ) != text )
        return result;
    result = rf_fail_file_option( &field, error );
    *error = fault;
    return result;
}

bool rf_is_folder( const char* path )
{
    struct stat status;
    return stat( path, &status ) == 0 && S_ISDIR( status.st_mode );
}

static bool is_file( const char* path )
{
    struct stat status;
    return stat( path, &status ) == 0 && !S_ISDIR( status.st_mode );
}

// Replaces the frames by those that --frames names, all of which must be there.
static RfResult choose_frames( const char* list, RfSequenceInput* input, RfError* error )
{
    int *wanted, count;
    RF_TRY( rf_parse_frames( list, input->frames, input->count, &wanted, &count, error ) );
    RfResult result = RF_OK;
    for ( int i = 0, next = 0; i < count && result == RF_OK; ++i )
    {
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
    RF_TRY( rf_missing_frames( input->frames, input->count, &missing, &count, error ) );
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
        result = find_folder_sequence( from, input->pattern, sizeof input->pattern, error );
    else if ( snprintf( input->pattern, sizeof input->pattern, "%s", from ) >= (int)sizeof input->pattern )
        result = rf_fail( error, RF_ERROR_USAGE, "%s: the name is too long", from );
    input->is_sequence = rf_is_sequence( input->pattern ) && !is_file( input->pattern );
    if ( result != RF_OK )
        return result;
    if ( !input->is_sequence )
        return list == NULL ? RF_OK : rf_fail( error, RF_ERROR_USAGE, "--frames: needs a sequence, and %s is a file", from );
    RF_TRY( rf_sequence_frames( input->pattern, &input->frames, &input->count, error ) );
    input->first = input->frames[0];
    return list != NULL ? choose_frames( list, input, error ) : RF_OK;
}

RfResult rf_sequence_input_name( const RfSequenceInput* input, int frame, char name[RF_FILE_NAME_SIZE], RfError* error )
{
    if ( input->is_sequence )
        return rf_sequence_name( input->pattern, frame, name, RF_FILE_NAME_SIZE, error );
    snprintf( name, RF_FILE_NAME_SIZE, "%s", input->pattern );
    return RF_OK;
}

void rf_free_sequence_input( RfSequenceInput* input )
{
    free( input->frames );
    *input = ( RfSequenceInput ){ .count = 0 };
}
