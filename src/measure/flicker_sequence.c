// The flicker of a whole sequence (reframe/measure.h).
#include "image/exr.h"
#include "measure/error.h"
#include "measure/flicker.h"
#include "measure/flicker_read.h"
#include "measure/sequences.h"

#include <stdlib.h>

#define MAX_NAME 4096

typedef struct Run
{
    const char* pattern;
    const char* reference; // or NULL
    char first_path[MAX_NAME];
    RfExrHeader first;
    RfFlickerLayers layers; // their names lie in `first`
    RfFlickerSums sums;
} Run;

static RfResult check_numbers( const Run* run, const int* numbers, int count, RfError* error )
{
    if ( count < 2 )
        return rf_fail( error, RF_ERROR_IO, "%s: is frame %d alone: flicker wants two neighbouring ones at least", run->pattern,
                        numbers[0] );
    int step = rf_sequence_step( run->pattern, numbers[0] );
    for ( int i = 1; i < count; ++i )
    {
        if ( numbers[i] != numbers[i - 1] + step )
            return rf_fail( error, RF_ERROR_IO, "%s: after frame %d comes %d: flicker wants every frame", run->pattern,
                            numbers[i - 1], numbers[i] );
    }
    return RF_OK;
}

// Against a reference pixels are compared where they are, else along the motion.
static RfResult open_first( Run* run, int number, RfError* error )
{
    RfResult result = rf_sequence_name( run->pattern, number, run->first_path, sizeof run->first_path, error );
    if ( result == RF_OK )
        result = rf_read_exr_header( run->first_path, NULL, &run->first, error );
    if ( result != RF_OK || run->reference != NULL )
        return result;
    result = rf_find_flicker_layers( run->first_path, &run->first, NULL, NULL, &run->layers, error );
    if ( run->layers.motion[0] == NULL )
        run->layers.depth = NULL;
    return result == RF_OK ? rf_find_variance_layers( run->first_path, &run->first, &run->layers, error ) : result;
}

static RfResult read_reference( const Run* run, int number, RfImage* image, RfError* error )
{
    char path[MAX_NAME];
    RfResult result = rf_sequence_name( run->reference, number, path, sizeof path, error );
    return result == RF_OK ? rf_read_aligned( path, NULL, &run->first, run->first_path, image, error ) : result;
}

// The signal becomes the error where there is a reference.
static RfResult read_frame( const Run* run, int number, RfFlickerFrame* frame, RfError* error )
{
    char path[MAX_NAME];
    RfImage reference = { 0 };
    RfErrorMetrics metrics;
    RfResult result = rf_sequence_name( run->pattern, number, path, sizeof path, error );
    if ( result == RF_OK )
        result = rf_read_flicker_frame( path, &run->layers, &run->first, run->first_path, frame, error );
    if ( result == RF_OK && run->reference != NULL )
        result = read_reference( run, number, &reference, error );
    const RfImage* to = reference.rgb != NULL ? &reference : &frame->signal;
    if ( result == RF_OK )
        result = rf_measure_error( &frame->signal, to, &metrics, error );
    if ( result == RF_OK )
        frame->is_finite = !rf_has_no_error( &metrics );
    size_t values = 3 * (size_t)frame->signal.width * (size_t)frame->signal.height;
    for ( size_t i = 0; result == RF_OK && reference.rgb != NULL && i < values; ++i )
        frame->signal.rgb[i] -= reference.rgb[i];
    rf_destroy_image( &reference );
    return result;
}

static RfResult add_frames( Run* run, const int* numbers, int count, RfError* error )
{
    RfFlickerFrame frames[2] = { { 0 }, { 0 } };
    RfResult result = RF_OK;
    for ( int i = 0; i < count && result == RF_OK; ++i )
    {
        RfFlickerFrame *now = frames + i % 2, *before = frames + ( i + 1 ) % 2;
        RfFlickerSums pair;
        rf_destroy_flicker_frame( now );
        result = read_frame( run, numbers[i], now, error );
        if ( result == RF_OK && i > 0 )
        {
            result = rf_measure_flicker( now, before, run->layers.motion[0] != NULL, run->reference != NULL, &pair, error );
            if ( result == RF_OK )
                rf_add_flicker( &run->sums, &pair );
        }
    }
    rf_destroy_flicker_frame( frames );
    rf_destroy_flicker_frame( frames + 1 );
    return result;
}

RfResult rf_measure_sequence_flicker( const char* pattern, const char* reference, RfFlickerMetrics* metrics, RfError* error )
{
    Run run = { .pattern = pattern, .reference = reference };
    int* numbers = NULL;
    int count = 0;
    RfResult result = rf_sequence_frames( pattern, &numbers, &count, error );
    if ( result == RF_OK )
        result = check_numbers( &run, numbers, count, error );
    if ( result == RF_OK )
        result = open_first( &run, numbers[0], error );
    if ( result == RF_OK )
        result = add_frames( &run, numbers, count, error );
    if ( result == RF_OK )
        *metrics = rf_flicker_metrics( &run.sums );
    rf_destroy_exr_header( &run.first );
    free( numbers );
    return result;
}
