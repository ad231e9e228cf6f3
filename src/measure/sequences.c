// Matches the frames of two sequences and measures the error of each pair.
#include "measure/sequences.h"

#include "base/remedy.h"
#include "measure/image_error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_NAME 4096

RfResult rf_pair_frames( const int* const numbers[2], const int counts[2], RfFramePairs* pairs, RfError* error )
{
    size_t most = (size_t)counts[0] + (size_t)counts[1];
    int at[2] = { 0, 0 };
    *pairs = ( RfFramePairs ){ .all = malloc( ( 4 * most + 1 ) * sizeof( int ) ) };
    if ( pairs->all == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for the numbers of %zu frames", most );
    pairs->both = pairs->all + most;
    pairs->lacking[0] = pairs->both + most;
    pairs->lacking[1] = pairs->lacking[0] + most;
    while ( at[0] < counts[0] || at[1] < counts[1] )
    {
        bool first = at[0] < counts[0] && ( at[1] == counts[1] || numbers[0][at[0]] <= numbers[1][at[1]] );
        int number = first ? numbers[0][at[0]] : numbers[1][at[1]];
        bool both = first && at[1] < counts[1] && numbers[1][at[1]] == number;
        pairs->all[pairs->all_count++] = number;
        if ( both )
            pairs->both[pairs->count++] = number;
        else // the first lacks what is the second's alone
            pairs->lacking[first][pairs->lacking_count[first]++] = number;
        at[0] += first;
        at[1] += both || !first;
    }
    return RF_OK;
}

void rf_free_frame_pairs( RfFramePairs* pairs )
{
    free( pairs->all );
    *pairs = ( RfFramePairs ){ 0 };
}

RfResult rf_check_all_paired( const RfFramePairs* pairs, const char* const patterns[2], RfError* error )
{
    const int* counts = pairs->lacking_count;
    if ( counts[0] + counts[1] == 0 )
        return RF_OK;
    bool by = counts[0] == 0 || ( counts[1] > 0 && pairs->lacking[1][0] < pairs->lacking[0][0] ); // which lacks the first one
    return rf_advise( rf_fail( error, RF_ERROR_IO, "frame %d is in %.300s but not in %.300s", pairs->lacking[by][0],
                               patterns[!by], patterns[by] ),
                      RF_REMEDY_FRAMES, 0, error );
}

int rf_sequence_step( const char* pattern, int number )
{
    char name[MAX_NAME];
    if ( rf_sequence_name( pattern, number, name, sizeof name, NULL ) != RF_OK )
        return 1;
    double step = rf_read_exr_number( name, "reframe/step" );
    return isgreaterequal( step, 1.0 ) && step <= 1e6 ? (int)step : 1;
}

static RfResult pair_sequences( const char* const patterns[2], RfFramePairs* pairs, RfError* error )
{
    int *numbers[2] = { NULL, NULL }, counts[2] = { 0, 0 };
    RfResult result = RF_OK;
    for ( int i = 0; i < 2 && result == RF_OK; ++i )
        result = rf_sequence_frames( patterns[i], numbers + i, counts + i, error );
    if ( result == RF_OK )
        result = rf_pair_frames( (const int* const*)numbers, counts, pairs, error );
    free( numbers[0] );
    free( numbers[1] );
    return result == RF_OK ? rf_check_all_paired( pairs, patterns, error ) : result;
}

// The same pixels in both files.
static RfResult read_pair( const char* const patterns[2], int number, RfImage images[2], RfError* error )
{
    char names[2][MAX_NAME];
    RfExrWindow windows[2];
    RfResult result = RF_OK;
    for ( int i = 0; i < 2 && result == RF_OK; ++i )
    {
        result = rf_sequence_name( patterns[i], number, names[i], sizeof names[i], error );
        if ( result == RF_OK )
            result = rf_read_exr_layer( names[i], NULL, images + i, windows + i, error );
    }
    if ( result == RF_OK && memcmp( windows, windows + 1, sizeof *windows ) != 0 )
        result = rf_fail( error, RF_ERROR_FORMAT, "%.400s and %.400s have different data windows", names[0], names[1] );
    return result;
}

static RfResult add_pair( const char* const patterns[2], int number, int count, RfErrorSummary* sum, RfError* error )
{
    RfImage images[2] = { { 0 }, { 0 } };
    RfResult result = read_pair( patterns, number, images, error );
    if ( result == RF_OK && sum->frames == 0 )
        result = rf_create_summary( images[0].width, images[0].height, count, sum, error );
    if ( result == RF_OK )
        result = rf_summary_add( sum, images, images + 1, error );
    rf_destroy_image( images );
    rf_destroy_image( images + 1 );
    return result;
}

RfResult rf_measure_sequences( const char* pattern, const char* reference, RfErrorMetrics* metrics, RfError* error )
{
    const char* const patterns[2] = { pattern, reference };
    RfErrorSummary sum = { 0 };
    RfFramePairs pairs = { .count = 1 };
    bool are_sequences = rf_is_sequence( pattern );
    RfResult result = RF_OK;
    if ( are_sequences != rf_is_sequence( reference ) )
        result = rf_fail( error, RF_ERROR_USAGE, "%s is a sequence and %s a single file: give two of a kind",
                          patterns[!are_sequences], patterns[are_sequences] );
    else if ( are_sequences )
        result = pair_sequences( patterns, &pairs, error );
    for ( int i = 0; i < pairs.count && result == RF_OK; ++i )
        result = add_pair( patterns, are_sequences ? pairs.both[i] : 1, pairs.count, &sum, error );
    if ( result == RF_OK )
        *metrics = rf_summary_metrics( &sum );
    rf_destroy_summary( &sum );
    rf_free_frame_pairs( &pairs );
    return result;
}
