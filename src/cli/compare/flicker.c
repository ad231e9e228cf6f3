// reframe flicker SEQ: how much the error of a sequence changes from frame to
// frame, against a reference or along the motion layers.
#include "cli/commands.h"
#include "cli/compare/flicker_run.h"
#include "cli/options/options.h"
#include "cli/render/progress.h"
#include "cli/messages.h"
#include "reframe/image.h"

#include <stdlib.h>
#include <string.h>

#define COMMAND "flicker"

static RfResult prepare( RfFlickerRun* flicker, RfError* error )
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
        return rf_fail( error, RF_ERROR_FORMAT, "%s: %zu pixels with NaN, %zu with infinity: no flicker can be told",
                        flicker->pattern, m->nan, m->inf );
    if ( flicker->reference != NULL && rf_has_no_error( m ) )
        return rf_fail( error, RF_ERROR_FORMAT, "%s: %zu pixels with NaN, %zu with infinity: no flicker can be told",
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

static RfResult go_through( RfFlickerRun* flicker, RfError* error )
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

static RfResult check_options( const RfFlickerRun* flicker, RfError* error )
{
    const char* alone = flicker->motion != NULL ? "motion" : flicker->depth != NULL ? "depth" : NULL;
    if ( alone != NULL && flicker->compensate_given && !flicker->compensate )
        return rf_fail( error, RF_ERROR_USAGE, "--%s: is of no use with --no-compensate", alone );
    if ( flicker->reference_layer != NULL && flicker->reference == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--reference-layer: is of the sequence that --reference names" );
    if ( flicker->png == NULL && ( flicker->column_given || flicker->exposure_given ) )
        return rf_fail( error, RF_ERROR_USAGE, "--%s: is of the picture that --png names",
                        flicker->column_given ? "column" : "exposure" );
    return RF_OK;
}

static RfResult run( RfFlickerRun* flicker, RfError* error )
{
    flicker->table = flicker->json == NULL || strcmp( flicker->json, "-" ) != 0;
    flicker->report.pairs = json_array();
    RfResult result = check_options( flicker, error );
    if ( result == RF_OK )
        result = rf_find_flicker_frames( flicker, error );
    if ( result == RF_OK )
        result = rf_find_layers_to_read( flicker, error );
    if ( result == RF_OK )
        result = prepare( flicker, error );
    if ( result == RF_OK )
        result = go_through( flicker, error );
    for ( int i = 0; i < RF_SPECTRUM_FRAMES; ++i )
        rf_destroy_flicker_frame( flicker->ring + i );
    rf_destroy_exr_header( &flicker->header );
    rf_destroy_exr_header( &flicker->layered );
    rf_destroy_summary( &flicker->errors );
    rf_destroy_slit_scan( &flicker->slit );
    json_decref( flicker->report.pairs );
    free( flicker->frames );
    return result;
}

int rf_command_flicker( int argc, char** argv )
{
    static const char* const files[] = { "SEQ" };
    RfFlickerRun flicker = { .spectrum = true };
    const RfOption options[] = {
        { .name = "reference",
          .reads = true,
          .type = RF_OPTION_STRING,
          .value = &flicker.reference,
          .meta = "SEQ",
          .help = "what the frames should be: flicker of the error, not of the picture" },
        { .name = "frames",
          .type = RF_OPTION_STRING,
          .value = &flicker.frame_list,
          .meta = "A-B",
          .default_text = "all",
          .help = "only these, by their numbers; neighbouring ones" },
        { .name = "layer",
          .type = RF_OPTION_STRING,
          .value = &flicker.layer,
          .meta = "NAME",
          .default_text = "the colour",
          .help = "a layer, part or channel of the files, or three channels X,Y,Z" },
        { .name = "reference-layer",
          .type = RF_OPTION_STRING,
          .value = &flicker.reference_layer,
          .meta = "NAME",
          .default_text = "that of --layer",
          .help = "the same of the reference, where its name is another" },
        { .name = "compensate",
          .type = RF_OPTION_BOOL,
          .value = &flicker.compensate,
          .given = &flicker.compensate_given,
          .default_text = "where there are motion layers; with a reference beside the plain figures",
          .help = "follow the motion layers, masked by depth, in the main figures; --no-compensate: in none" },
        { .name = "motion",
          .type = RF_OPTION_STRING,
          .value = &flicker.motion,
          .meta = "X,Y",
          .default_text = "of the layer motion or Vector",
          .help = "channels with the way to the frame before, pixels, +x right, +y up; compensates" },
        { .name = "depth",
          .type = RF_OPTION_STRING,
          .value = &flicker.depth,
          .meta = "NAME",
          .default_text = "depth.Z, Depth.Z, Depth.V or Z",
          .help = "channel with the depth that tells what was seen before" },
        { .name = "border",
          .type = RF_OPTION_INT,
          .value = &flicker.period,
          .min = 2,
          .max = 1000000,
          .meta = "N",
          .default_text = "Reframe's own groups",
          .help = "groups of N frames begin with the sequence: their borders apart" },
        { .name = "spectrum",
          .type = RF_OPTION_BOOL,
          .value = &flicker.spectrum,
          .default_text = "on",
          .help = "slow drift and boiling; keeps 16 frames in memory" },
        { .name = "png",
          .writes = ".png",
          .type = RF_OPTION_STRING,
          .value = &flicker.png,
          .meta = "FILE",
          .help = "write a slit-scan: one column over time, the reference's below" },
        { .name = "column",
          .type = RF_OPTION_INT,
          .value = &flicker.column,
          .min = 1,
          .max = 1 << 20,
          .meta = "X",
          .default_text = "the middle",
          .given = &flicker.column_given,
          .help = "of the slit-scan, 1 is on the left" },
        { .name = "exposure",
          .type = RF_OPTION_REAL,
          .value = &flicker.exposure,
          .min = -32,
          .max = 32,
          .meta = "E",
          .default_text = "0",
          .given = &flicker.exposure_given,
          .help = "of the slit-scan: brighter by E stops" },
        { .name = "json",
          .writes = ".json",
          .type = RF_OPTION_STRING,
          .value = &flicker.json,
          .meta = "FILE",
          .help = "write the results as JSON, - for standard output instead of the table" },
        { .name = "quiet", .type = RF_OPTION_BOOL, .value = &flicker.quiet, .help = "no progress on standard error" },
    };
    const RfCommandTable table = {
        .command = COMMAND,
        .summary = "How much the error of a sequence changes from frame to frame: EXR files named with ####.",
        .files = files,
        .file_count = 1,
        .options = options,
        .option_count = sizeof options / sizeof options[0],
    };
    RfError error = { 0 };
    bool help = false;
    RfResult result = rf_parse_options( &table, argc, argv, &flicker.pattern, &help, &error );
    if ( result == RF_OK && help )
    {
        rf_print_help( &table, stdout );
        result = rf_flush_output( &error );
    }
    else if ( result == RF_OK )
        result = run( &flicker, &error );
    return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
}
