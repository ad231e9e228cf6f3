#include "cli/compare/compare_frames.h"

#include "cli/options/frame_list.h"
#include "cli/report/report_folder.h"
#include "image/sequence.h"
#include "measure/sequences.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>

static bool has_frame( const int* frames, int count, int frame )
{
    for ( int i = 0; i < count; ++i )
    {
        if ( frames[i] == frame )
            return true;
    }
    return false;
}

// Replaces the list by the frames that --frames names, all of which must exist.
static RfResult choose_frames( RfCompareFrames* frames, const int* b, int b_count, RfError* error )
{
    int *wanted, count, last = frames->frames[frames->count - 1];
    RfResult result = rf_parse_frames( frames->list, last > 0 ? last : 1, &wanted, &count, error );
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        wanted[i] += 1;
        bool in_a = has_frame( frames->frames, frames->count, wanted[i] );
        if ( !in_a || !has_frame( b, b_count, wanted[i] ) )
            result = rf_fail( error, RF_ERROR_IO, "%s: frame %d is missing", frames->patterns[in_a ? 1 : 0], wanted[i] );
    }
    if ( result != RF_OK )
    {
        free( wanted );
        return result;
    }
    free( frames->frames );
    frames->frames = wanted;
    frames->count = count;
    return RF_OK;
}

static RfResult find_chosen( RfCompareFrames* frames, RfError* error )
{
    int* b = NULL;
    int b_count = 0;
    RfResult result = rf_sequence_frames( frames->patterns[0], &frames->frames, &frames->count, error );
    if ( result == RF_OK )
        result = rf_sequence_frames( frames->patterns[1], &b, &b_count, error );
    if ( result == RF_OK )
        result = choose_frames( frames, b, b_count, error );
    free( b );
    return result;
}

static RfResult find_all( RfCompareFrames* frames, RfError* error )
{
    RfResult result = rf_match_sequences( frames->patterns[0], frames->patterns[1], &frames->frames, &frames->count, error );
    if ( result != RF_OK )
        return result;
    return rf_missing_frames( frames->frames, frames->count, &frames->missing, &frames->missing_count, error );
}

// Sorts the frames of both into those that they share, and those that one lacks; *all gets them all.
static RfResult pair_frames( RfCompareFrames* frames, int* const numbers[2], const int counts[2], int** all, int* all_count,
                             RfError* error )
{
    size_t most = (size_t)counts[0] + (size_t)counts[1];
    int at[2] = { 0, 0 };
    *all_count = frames->count = 0;
    *all = malloc( most * sizeof( int ) );
    frames->frames = malloc( most * sizeof( int ) );
    for ( int i = 0; i < 2; ++i )
        frames->lacking[i] = malloc( most * sizeof( int ) );
    if ( *all == NULL || frames->frames == NULL || frames->lacking[0] == NULL || frames->lacking[1] == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for the numbers of %zu frames", most );
    while ( at[0] < counts[0] || at[1] < counts[1] )
    {
        bool first = at[0] < counts[0] && ( at[1] == counts[1] || numbers[0][at[0]] <= numbers[1][at[1]] );
        int number = first ? numbers[0][at[0]] : numbers[1][at[1]];
        bool both = first && at[1] < counts[1] && numbers[1][at[1]] == number;
        ( *all )[( *all_count )++] = number;
        if ( both )
            frames->frames[frames->count++] = number;
        else // A lacks what is B's alone
            frames->lacking[first][frames->lacking_count[first]++] = number;
        at[0] += first;
        at[1] += both || !first;
    }
    if ( frames->count == 0 )
        return rf_fail( error, RF_ERROR_IO, "%.400s and %.400s have no frame in common", frames->patterns[0],
                        frames->patterns[1] );
    return RF_OK;
}

static RfResult find_common( RfCompareFrames* frames, RfError* error )
{
    int *numbers[2] = { NULL, NULL }, counts[2], *all = NULL, all_count;
    RfResult result = rf_sequence_frames( frames->patterns[0], numbers, counts, error );
    if ( result == RF_OK )
        result = rf_sequence_frames( frames->patterns[1], numbers + 1, counts + 1, error );
    if ( result == RF_OK )
        result = pair_frames( frames, numbers, counts, &all, &all_count, error );
    if ( result == RF_OK )
        result = rf_missing_frames( all, all_count, &frames->missing, &frames->missing_count, error );
    free( numbers[0] );
    free( numbers[1] );
    free( all );
    return result;
}

static RfResult open_folders( RfCompareFrames* frames, RfError* error )
{
    struct stat status;
    RfResult result = RF_OK;
    for ( int i = 0; i < 2 && result == RF_OK; ++i )
    {
        if ( stat( frames->patterns[i], &status ) != 0 || !S_ISDIR( status.st_mode ) )
            continue;
        result = rf_find_folder_sequence( frames->patterns[i], frames->found[i], RF_COMPARE_NAME_SIZE, error );
        frames->patterns[i] = frames->found[i];
        frames->by_number = true;
    }
    return result;
}

RfResult rf_find_compare_frames( RfCompareFrames* frames, RfError* error )
{
    bool are_sequences;
    frames->count = 1;
    RfResult result = open_folders( frames, error );
    if ( result == RF_OK )
        result = rf_check_patterns( frames->patterns[0], frames->patterns[1], &are_sequences, error );
    if ( result != RF_OK )
        return result;
    if ( !are_sequences && frames->list != NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--frames: is of sequences, and these are two files" );
    if ( !are_sequences )
        return RF_OK;
    if ( frames->by_number && frames->list == NULL )
        return find_common( frames, error );
    return frames->list != NULL ? find_chosen( frames, error ) : find_all( frames, error );
}

void rf_free_compare_frames( RfCompareFrames* frames )
{
    free( frames->frames );
    free( frames->missing );
    for ( int i = 0; i < 2; ++i )
    {
        free( frames->lacking[i] );
        frames->lacking[i] = NULL;
    }
    frames->frames = frames->missing = NULL;
}

RfResult rf_compare_name( const RfCompareFrames* frames, const char* pattern, int frame, char name[RF_COMPARE_NAME_SIZE],
                          RfError* error )
{
    if ( frames->frames != NULL || rf_is_sequence( pattern ) )
        return rf_sequence_name( pattern, frame, name, RF_COMPARE_NAME_SIZE, error );
    if ( snprintf( name, RF_COMPARE_NAME_SIZE, "%s", pattern ) >= RF_COMPARE_NAME_SIZE )
        return rf_fail( error, RF_ERROR_USAGE, "%s: the name is too long", pattern );
    return RF_OK;
}

static int at_least( int a, int b ) { return a > b ? a : b; }
static int at_most( int a, int b ) { return a < b ? a : b; }

// Crops an image in place.
static void crop( RfImage* image, const RfExrWindow* from, const RfExrWindow* to )
{
    for ( int y = 0; y < to->height; ++y )
    {
        size_t row = (size_t)( to->y - from->y + y ) * (size_t)from->width + (size_t)( to->x - from->x );
        memmove( image->rgb + 3 * (size_t)y * (size_t)to->width, image->rgb + 3 * row, 3 * (size_t)to->width * sizeof( float ) );
    }
    image->width = to->width;
    image->height = to->height;
}

// Aligns two images by their data windows.
static RfResult align( bool overlap, RfComparePair* pair, const RfExrWindow windows[2], RfError* error )
{
    const RfExrWindow *a = windows, *b = windows + 1;
    pair->window = *a;
    if ( memcmp( a, b, sizeof *a ) == 0 )
        return RF_OK;
    if ( !overlap && a->x == b->x && a->y == b->y )
        return rf_fail( error, RF_ERROR_FORMAT, "%.300s has %dx%d pixels, %.300s %dx%d: --overlap measures what both have",
                        pair->names[0], a->width, a->height, pair->names[1], b->width, b->height );
    if ( !overlap )
        return rf_fail( error, RF_ERROR_FORMAT,
                        "the data windows differ: %.300s has %dx%d pixels from (%d, %d) on, %.300s %dx%d from (%d, %d) on: "
                        "--overlap measures what both have",
                        pair->names[0], a->width, a->height, a->x, a->y, pair->names[1], b->width, b->height, b->x, b->y );
    RfExrWindow both = { .x = at_least( a->x, b->x ), .y = at_least( a->y, b->y ) };
    int64_t right = at_most( a->x + ( a->width - 1 ), b->x + ( b->width - 1 ) );
    int64_t bottom = at_most( a->y + ( a->height - 1 ), b->y + ( b->height - 1 ) );
    if ( right < both.x || bottom < both.y )
        return rf_fail( error, RF_ERROR_FORMAT, "%.400s and %.400s have no pixel in common: their data windows lie apart",
                        pair->names[0], pair->names[1] );
    both.width = (int)( right - both.x + 1 );
    both.height = (int)( bottom - both.y + 1 );
    for ( int i = 0; i < 2; ++i )
        crop( pair->images + i, windows + i, &both );
    pair->window = both;
    return RF_OK;
}

RfResult rf_read_compare_pair( const RfCompareFrames* frames, int frame, RfComparePair* pair, RfError* error )
{
    RfExrWindow windows[2] = { { 0 }, { 0 } };
    RfResult result = RF_OK;
    pair->images[0] = pair->images[1] = ( RfImage ){ 0 };
    for ( int i = 0; i < 2 && result == RF_OK; ++i )
    {
        result = rf_compare_name( frames, frames->patterns[i], frame, pair->names[i], error );
        if ( result == RF_OK )
            result = rf_read_exr_layer( pair->names[i], frames->layers[i], pair->images + i, windows + i, error );
    }
    return result == RF_OK ? align( frames->overlap, pair, windows, error ) : result;
}

void rf_destroy_compare_pair( RfComparePair* pair )
{
    rf_destroy_image( pair->images );
    rf_destroy_image( pair->images + 1 );
}
