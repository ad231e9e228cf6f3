// Frame by frame through the sequences of reframe flicker: reads, compares neighbours, adds up.
#include "cli/compare/flicker_run.h"
#include "cli/messages.h"
#include "cli/render/progress.h"
#include "reframe/image.h"

#include <stdlib.h>

RfResult rf_prepare_flicker( RfFlickerRun* flicker, RfError* error )
{
    int last = flicker->frames[flicker->frame_count - 1], width = flicker->header.width;
    flicker->seams = flicker->period > 0 ? rf_fixed_seams( flicker->period, flicker->first_frame )
                                         : rf_read_seams( flicker->first_path, flicker->frames[0], last );
    flicker->report.has_seams = rf_has_seams( &flicker->seams );
    flicker->report.has_spectrum = flicker->spectrum;
    flicker->report.window = flicker->frame_count < RF_SPECTRUM_FRAMES ? flicker->frame_count : RF_SPECTRUM_FRAMES;
    flicker->ring_size = flicker->spectrum ? flicker->report.window : 2;
    if ( flicker->column > width )
        return rf_fail( error, RF_ERROR_USAGE, "--column: there is no column %d in frames of %d", flicker->column, width );
    RfResult result = rf_create_summary( width, flicker->header.height, flicker->frame_count, &flicker->errors, error );
    if ( result == RF_OK && flicker->png != NULL )
        result = rf_create_slit_scan( flicker->frame_count, flicker->header.height, flicker->reference != NULL ? 2 : 1,
                                      &flicker->slit, error );
    return result;
}

static void subtract( RfImage* image, const RfImage* reference )
{
    size_t count = 3 * (size_t)image->width * (size_t)image->height;
    for ( size_t i = 0; i < count; ++i )
        image->rgb[i] -= reference->rgb[i];
}

// Counts values that are not finite, adds the slit, and computes the signal.
static RfResult take_images( RfFlickerRun* flicker, int i, RfFlickerFrame* frame, const RfImage* reference, RfError* error )
{
    bool has_reference = reference->rgb != NULL;
    const RfImage* to = has_reference ? reference : &frame->signal;
    RfErrorMetrics metrics;
    RfResult result = rf_measure_error( &frame->signal, to, &metrics, error );
    if ( result == RF_OK )
        result = rf_summary_add( &flicker->errors, &frame->signal, to, error );
    if ( result != RF_OK )
        return result;
    frame->number = flicker->frames[i];
    frame->is_finite = !rf_has_no_error( &metrics );
    int column = flicker->column > 0 ? flicker->column - 1 : frame->signal.width / 2;
    if ( flicker->png != NULL )
        rf_add_slit( &flicker->slit, i, 0, &frame->signal, column );
    if ( flicker->png != NULL && has_reference )
        rf_add_slit( &flicker->slit, i, 1, reference, column );
    if ( has_reference )
        subtract( &frame->signal, reference );
    return RF_OK;
}

static RfResult read_frame( RfFlickerRun* flicker, int i, RfError* error )
{
    char path[RF_FLICKER_NAME_SIZE];
    RfFlickerFrame* frame = flicker->ring + i % flicker->ring_size;
    RfImage reference = { 0 };
    rf_destroy_flicker_frame( frame );
    RfResult result = rf_flicker_path( flicker->pattern, flicker->frames[i], path, error );
    if ( result == RF_OK )
        result = rf_read_flicker_frame( path, &flicker->layers, &flicker->header, flicker->first_path, frame, error );
    if ( result == RF_OK && flicker->reference != NULL )
    {
        result = rf_flicker_path( flicker->reference, flicker->frames[i], path, error );
        if ( result == RF_OK )
            result = rf_read_aligned( path, flicker->reference_layer, &flicker->header, flicker->first_path, &reference, error );
    }
    if ( result == RF_OK )
        result = take_images( flicker, i, frame, &reference, error );
    rf_destroy_image( &reference );
    return result;
}

// The same pair along the motion, where its frames have the layers.
static RfResult follow_pair( RfFlickerRun* flicker, const RfFlickerFrame* now, const RfFlickerFrame* before, bool border,
                             json_t* row, RfError* error )
{
    RfFlickerSums sums;
    bool has_layers = rf_has_flicker_layers( &flicker->layers, now, before );
    if ( has_layers )
    {
        RfResult result = rf_measure_flicker( now, before, true, true, &sums, error );
        if ( result != RF_OK )
            return result;
        rf_add_flicker_pair( &flicker->report.followed, border, &sums );
    }
    json_object_set_new( row, "followed", rf_followed_pair_json( has_layers ? &sums : NULL ) );
    return RF_OK;
}

// Frees what the spectrum, which keeps the frame, does not need.
static void forget_layers( const RfFlickerReport* report, RfFlickerFrame* frame )
{
    rf_destroy_image( &frame->variance );
    if ( report->compensated )
        return;
    free( frame->motion );
    free( frame->depth );
    frame->motion = frame->depth = NULL;
}

static RfResult measure_pair( RfFlickerRun* flicker, int i, RfError* error )
{
    RfFlickerReport* report = &flicker->report;
    const RfFlickerFrame* now = flicker->ring + i % flicker->ring_size;
    RfFlickerFrame* before = flicker->ring + ( i - 1 ) % flicker->ring_size;
    RfFlickerSums sums;
    RfResult result = rf_measure_flicker( now, before, report->compensated, flicker->reference != NULL, &sums, error );
    if ( result != RF_OK )
        return result;
    bool border = report->has_seams && rf_is_seam( &flicker->seams, now->number );
    rf_add_flicker_pair( &report->plain, border, &sums );
    json_t* row = rf_flicker_pair_json( now->number, border, &sums );
    json_array_append_new( report->pairs, row );
    if ( report->follows )
        result = follow_pair( flicker, now, before, border, row, error );
    forget_layers( report, before );
    return result;
}

static RfResult measure_window( RfFlickerRun* flicker, int i, RfError* error )
{
    int count = flicker->report.window;
    if ( !flicker->spectrum || !rf_ends_group( i, flicker->frame_count ) )
        return RF_OK;
    const RfFlickerFrame* frames[RF_SPECTRUM_FRAMES];
    for ( int t = 0; t < count; ++t )
        frames[t] = flicker->ring + ( i - count + 1 + t ) % flicker->ring_size;
    return rf_add_spectrum_group( &flicker->report.spectrum, frames, count, flicker->report.compensated, error );
}

static RfResult check_finite( const RfFlickerRun* flicker, RfError* error )
{
    const RfErrorMetrics* m = &flicker->report.errors;
    if ( m->nan > 0 || m->inf > 0 )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: %zu pixels with NaN, %zu with infinity: no flicker can be reported",
                        flicker->pattern, m->nan, m->inf );
    if ( flicker->reference != NULL && rf_has_no_error( m ) )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: %zu pixels with NaN, %zu with infinity: no flicker can be reported",
                        flicker->reference, m->reference_nan, m->reference_inf );
    return RF_OK;
}

static RfResult finish( RfFlickerRun* flicker, RfError* error )
{
    RfFlickerReport* report = &flicker->report;
    report->errors = rf_summary_metrics( &flicker->errors );
    if ( flicker->table )
        rf_print_flicker( report );
    RfResult result = rf_flush_output( error );
    if ( result == RF_OK && flicker->png != NULL )
        result = rf_write_png( flicker->png, &flicker->slit.image, (float)flicker->exposure, error );
    if ( result == RF_OK && flicker->json != NULL )
        result = rf_write_json( flicker->json, rf_flicker_json( report ), error );
    return result == RF_OK ? check_finite( flicker, error ) : result;
}

RfResult rf_go_through_frames( RfFlickerRun* flicker, RfError* error )
{
    RfResult result = RF_OK;
    for ( int i = 0; i < flicker->frame_count && result == RF_OK; ++i )
    {
        result = read_frame( flicker, i, error );
        if ( result == RF_OK && i > 0 )
            result = measure_pair( flicker, i, error );
        if ( result == RF_OK )
            result = measure_window( flicker, i, error );
        rf_show_frame_count( flicker->quiet, i + 1, flicker->frame_count );
    }
    return result == RF_OK ? finish( flicker, error ) : result;
}
