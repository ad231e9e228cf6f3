#include "cli/report/report_frames.h"

#include "cli/report/report_blocks.h"
#include "cli/messages.h"
#include "measure/flicker_read.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct Work
{
    RfPage* page;
    RfPageTrack* track;
    RfFlickerLayers layers;
    RfFlickerFrame ring[2]; // this frame and the one before, at their places modulo 2
    bool has_frame[2];      // and their signals are what flicker wants
    RfErrorSummary errors;
    bool has_summary;
} Work;

// Chooses motion and depth and, without a reference, the variance of the colour, where the
// files have them; what `flicker` would refuse is left out.
static void find_layers( Work* work )
{
    RfPageTrack* track = work->track;
    const RfPageSequence* sequence = track->sequence;
    RfFlickerLayers* layers = &work->layers;
    *layers = ( RfFlickerLayers ){ 0 };
    if ( !sequence->is_reference &&
         ( rf_find_flicker_layers( sequence->first, &sequence->header, NULL, NULL, layers, NULL ) != RF_OK ||
           layers->motion[0] == NULL ) )
        *layers = ( RfFlickerLayers ){ 0 };
    bool alone = track->reference == NULL && !sequence->is_reference;
    if ( alone && sequence->layer == NULL )
        rf_find_variance_layers( sequence->first, &sequence->header, layers, NULL );
    layers->colour = sequence->layer;
    layers->may_lack = true;
    track->compensated = alone && layers->motion[0] != NULL;
    track->follows = !alone && layers->motion[0] != NULL;
    track->has_variance = layers->variance[0] != NULL;
}

static size_t count_bad( const RfImage* image )
{
    size_t bad = 0, pixels = (size_t)image->width * (size_t)image->height;
    for ( size_t i = 0; i < pixels; ++i )
        bad += !isfinite( image->rgb[3 * i] ) || !isfinite( image->rgb[3 * i + 1] ) || !isfinite( image->rgb[3 * i + 2] );
    return bad;
}

static RfResult measure_error( Work* work, RfPageFrame* told, RfFlickerFrame* frame, RfImage* reference, RfError* error )
{
    RfErrorMetrics metrics;
    RfResult result = rf_measure_error( &frame->signal, reference, &metrics, error );
    if ( result == RF_OK && !work->has_summary )
    {
        result = rf_create_summary( frame->signal.width, frame->signal.height, work->track->count, &work->errors, error );
        work->has_summary = result == RF_OK;
    }
    if ( result == RF_OK )
        result = rf_summary_add( &work->errors, &frame->signal, reference, error );
    if ( result != RF_OK )
        return result;
    told->relmse = metrics.relmse;
    size_t count = 3 * (size_t)reference->width * (size_t)reference->height;
    for ( size_t i = 0; i < count; ++i )
        frame->signal.rgb[i] -= reference->rgb[i];
    frame->is_finite = !rf_has_no_error( &metrics );
    return RF_OK;
}

// Takes what `render` recorded of the frame, in its JSON or in the file. Times are in no
// image file, so that equal renders give equal files.
static void take_said( const RfPageSequence* sequence, int number, const char* path, RfPageFrame* told )
{
    size_t i;
    const json_t* row;
    json_array_foreach( json_object_get( sequence->render, "frames" ), i, row )
    {
        if ( rf_json_number_of( row, "frame" ) != number )
            continue;
        told->relmse = rf_json_number_of( row, "relmse_estimate" );
        told->seconds = rf_json_number_of( row, "seconds" );
        told->samples = rf_json_number_of( row, "native_spp" );
        told->at_least = json_is_true( json_object_get( row, "relmse_is_lower_bound" ) );
        told->worst_ten_share = rf_json_number_of( row, "worst_ten_share" );
    }
    if ( isnan( told->relmse ) )
        told->relmse = rf_read_exr_number( path, "reframe/relmse-estimate" );
    char text[8];
    if ( !told->at_least )
        told->at_least =
            rf_read_exr_string( path, "reframe/relmse-is-lower-bound", text, sizeof text, NULL ) == RF_OK && text[0] == 'y';
    if ( isnan( told->worst_ten_share ) )
        told->worst_ten_share = rf_read_exr_number( path, "reframe/worst-ten-share" );
    if ( isnan( told->samples ) )
        told->samples = rf_read_exr_number( path, "reframe/native-spp" );
}

// The pair of this frame and the one before, if both are there. Along the motion only
// where both have the layers.
static RfResult measure_flicker( Work* work, int i, RfError* error )
{
    RfPageTrack* track = work->track;
    RfFlickerSums sums, followed;
    const RfFlickerFrame *now = work->ring + i % 2, *before = work->ring + ( i + 1 ) % 2;
    bool pair = i > 0 && work->has_frame[0] && work->has_frame[1] && track->numbers[i] == track->numbers[i - 1] + 1;
    if ( !pair )
        return RF_OK;
    track->pair_count += 1;
    bool has_layers = rf_has_flicker_layers( &work->layers, now, before );
    if ( !track->follows && !has_layers )
        return RF_OK;
    RfResult result = rf_measure_flicker( now, before, track->compensated, track->reference != NULL, &sums, error );
    if ( result == RF_OK && track->follows && has_layers )
    {
        result = rf_measure_flicker( now, before, true, true, &followed, error );
        rf_add_flicker( &track->followed, &followed );
    }
    if ( result != RF_OK )
        return result;
    RfFlickerMetrics metrics = rf_flicker_metrics( &sums );
    track->frames[i].phi = metrics.phi;
    track->frames[i].f1 = metrics.f1;
    rf_add_flicker( &track->flicker, &sums );
    return RF_OK;
}

static RfResult add_frame( Work* work, int i, RfError* error )
{
    RfPageTrack* track = work->track;
    int number = track->numbers[i];
    RfPageFrame* told = track->frames + i;
    RfFlickerFrame* frame = work->ring + i % 2;
    char path[RF_PAGE_NAME_SIZE];
    rf_destroy_flicker_frame( frame );
    work->has_frame[i % 2] = false;
    if ( !rf_has_page_frame( track->sequence, number ) )
        return RF_OK;
    RfResult result = rf_page_frame_path( track->sequence, number, path, error );
    if ( result == RF_OK )
        result = rf_read_flicker_frame( path, &work->layers, &track->sequence->header, track->sequence->first, frame, error );
    if ( result == RF_OK )
        result = rf_add_page_blocks( work->page, track, i, &frame->signal, path, error );
    if ( result != RF_OK )
        return result;
    told->shown = true;
    told->bad = count_bad( &frame->signal );
    frame->number = number;
    frame->is_finite = told->bad == 0;
    bool has_reference = track->reference != NULL && rf_has_page_frame( track->reference, number );
    take_said( track->sequence, number, path, told );
    if ( track->reference != NULL || track->sequence->is_reference ) // an estimate would not belong there
    {
        told->relmse = told->worst_ten_share = NAN;
        told->at_least = false;
    }
    RfImage reference = { 0 };
    if ( has_reference )
        result = rf_page_frame_path( track->reference, number, path, error );
    if ( result == RF_OK && has_reference )
        result =
            rf_read_aligned( path, track->reference->layer, &track->sequence->header, track->sequence->first, &reference, error );
    if ( result == RF_OK && has_reference )
        result = measure_error( work, told, frame, &reference, error );
    rf_destroy_image( &reference );
    work->has_frame[i % 2] = !track->sequence->is_reference && ( has_reference || track->reference == NULL );
    return result == RF_OK ? measure_flicker( work, i, error ) : result;
}

static void sum_up( Work* work )
{
    RfPageTrack* track = work->track;
    double sum = 0.0;
    int count = 0;
    for ( int i = 0; i < track->count; ++i )
    {
        if ( isnan( track->frames[i].relmse ) )
            continue;
        sum += track->frames[i].relmse;
        ++count;
    }
    track->estimate = count > 0 && track->reference == NULL ? sum / count : NAN;
    track->has_error = work->has_summary;
    if ( work->has_summary )
        track->error = rf_summary_metrics( &work->errors );
}

RfResult rf_add_page_track( RfPage* page, RfPageTrack* track, RfPageProgressFn* progress, void* user, RfError* error )
{
    Work work = { .page = page, .track = track };
    track->frames = malloc( (size_t)track->count * sizeof( RfPageFrame ) );
    if ( track->frames == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for %d frames", track->sequence->pattern, track->count );
    for ( int i = 0; i < track->count; ++i )
        track->frames[i] =
            ( RfPageFrame ){ .relmse = NAN, .seconds = NAN, .samples = NAN, .phi = NAN, .f1 = NAN, .worst_ten_share = NAN };
    find_layers( &work );
    RfResult result = rf_find_page_aovs( track, error );
    for ( int i = 0; i < track->count && result == RF_OK; ++i )
    {
        result = add_frame( &work, i, error );
        if ( result == RF_OK && track->frames[i].shown && !progress( user ) )
            result = rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted: no page is written" );
    }
    if ( result == RF_OK )
        sum_up( &work );
    rf_destroy_flicker_frame( work.ring );
    rf_destroy_flicker_frame( work.ring + 1 );
    if ( work.has_summary )
        rf_destroy_summary( &work.errors );
    return result;
}

int* rf_page_missing_frames( const RfPageTrack* track, int* count )
{
    *count = 0;
    int* missing = malloc( (size_t)( track->count + track->hole_count + 1 ) * sizeof( int ) );
    for ( int i = 0, k = 0; missing != NULL && ( i < track->count || k < track->hole_count ); )
    {
        bool is_hole = i == track->count || ( k < track->hole_count && track->holes[k] < track->numbers[i] );
        int number = is_hole ? track->holes[k++] : track->numbers[i++];
        if ( !rf_has_page_frame( track->sequence, number ) )
            missing[( *count )++] = number;
    }
    return missing;
}

void rf_free_page_track( RfPageTrack* track )
{
    free( track->frames );
    track->frames = NULL;
}
