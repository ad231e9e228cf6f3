// Matches the frames of two sequences and measures the error of each pair.
#include "measure/sequences.h"

#include "base/remedy.h"
#include "measure/image_error.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define MAX_NAME 4096

static RfResult match( const char* const patterns[2], int* const numbers[2], const int counts[2], RfError* error )
{
    int count = counts[0] > counts[1] ? counts[0] : counts[1];
    for ( int i = 0; i < count; ++i )
    {
        if ( i < counts[0] && i < counts[1] && numbers[0][i] == numbers[1][i] )
            continue;
        bool in_a = i == counts[1] || ( i < counts[0] && numbers[0][i] < numbers[1][i] );
        return rf_advise( rf_fail( error, RF_ERROR_IO, "frame %d is in %.300s but not in %.300s", numbers[!in_a][i],
                                   patterns[!in_a], patterns[in_a] ),
                          RF_REMEDY_FRAMES, 0, error );
    }
    return RF_OK;
}

int rf_sequence_step( const char* pattern, int number )
{
    char name[MAX_NAME];
    if ( rf_sequence_name( pattern, number, name, sizeof name, NULL ) != RF_OK )
        return 1;
    double step = rf_read_exr_number( name, "reframe/step" );
    return isgreaterequal( step, 1.0 ) && step <= 1e6 ? (int)step : 1;
}

RfResult rf_match_sequences( const char* a, const char* b, int** numbers, int* count, RfError* error )
{
    const char* const patterns[2] = { a, b };
    int* found[2] = { NULL, NULL };
    int counts[2] = { 0, 0 };
    RfResult result = RF_OK;
    for ( int i = 0; i < 2 && result == RF_OK; ++i )
        result = rf_sequence_frames( patterns[i], found + i, counts + i, error );
    if ( result == RF_OK )
        result = match( patterns, found, counts, error );
    free( found[1] );
    if ( result != RF_OK )
        free( found[0] );
    *numbers = result == RF_OK ? found[0] : NULL;
    *count = result == RF_OK ? counts[0] : 0;
    return result;
}

RfResult rf_check_patterns( const char* a, const char* b, bool* are_sequences, RfError* error )
{
    *are_sequences = rf_is_sequence( a );
    if ( *are_sequences == rf_is_sequence( b ) )
        return RF_OK;
    return rf_fail( error, RF_ERROR_USAGE, "%s is a sequence and %s a single file: give two of a kind", *are_sequences ? a : b,
                    *are_sequences ? b : a );
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
    int* numbers = NULL;
    int count = 1;
    bool are_sequences;
    RfResult result = rf_check_patterns( pattern, reference, &are_sequences, error );
    if ( result == RF_OK && are_sequences )
        result = rf_match_sequences( pattern, reference, &numbers, &count, error );
    for ( int i = 0; i < count && result == RF_OK; ++i )
        result = add_pair( patterns, numbers != NULL ? numbers[i] : 1, count, &sum, error );
    if ( result == RF_OK )
        *metrics = rf_summary_metrics( &sum );
    rf_destroy_summary( &sum );
    free( numbers );
    return result;
}
