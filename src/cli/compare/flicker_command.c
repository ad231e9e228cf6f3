// reframe flicker SEQ: how much the error of a sequence changes from frame to
// frame, against a reference or along the motion layers.
#include "cli/commands.h"
#include "cli/compare/flicker_report.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "cli/options/options.h"
#include "cli/render/progress.h"
#include "measure/flicker.h"
#include "measure/flicker_sequence.h"
#include "measure/sequences.h"
#include "page/pass_groups.h"
#include "reframe/image.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define FLICKER_NAME_SIZE 4096

typedef struct FlickerRun
{
    const char* pattern;
    const char* reference; // this and the next five may be NULL
    const char* layer;     // as named for the first file; NULL: the colour
    const char* reference_layer;
    char texts[2][RF_PASS_LAYER_SIZE]; // of both
    const char* frame_list;
    const char* motion;
    const char* depth;
    bool compensate, compensate_given;
    int period; // of --border; 0: from the files
    bool spectrum;
    const char* png; // or NULL
    int column;      // 0: the middle
    bool column_given;
    double exposure;
    bool exposure_given;
    const char* json; // or NULL
    bool quiet;
    bool table; // standard output is free for the table

    int* frames;
    int frame_count;
    int first_frame; // of the whole sequence
    char first_path[FLICKER_NAME_SIZE];
    RfExrHeader header;     // of the first frame
    RfExrHeader layered;    // of the first that has motion layers, or of the first; the layers' names lie there
    RfFlickerLayers layers; // that are read
    RfSeams seams;
    RfFlickerFrame ring[RF_SPECTRUM_FRAMES]; // frame i at i modulo the number of them
    int ring_size;
    RfErrorSummary errors;
    RfSlitScan slit;
    RfFlickerReport report;
} FlickerRun;

// The file of a frame.
static RfResult flicker_path( const char* pattern, int frame, char path[FLICKER_NAME_SIZE], RfError* error )
{
    return rf_sequence_name( pattern, frame, path, FLICKER_NAME_SIZE, error );
}

// Keeps the frames that --frames names, all of which must exist.
static RfResult choose_frames( FlickerRun* flicker, RfError* error )
{
    int *wanted, count;
    RfResult result = rf_parse_frames( flicker->frame_list, flicker->frames, flicker->frame_count, &wanted, &count, error );
    for ( int i = 0, from = 0; i < count && result == RF_OK; ++i )
    {
        int number = wanted[i];
        while ( from < flicker->frame_count && flicker->frames[from] < number )
            ++from;
        if ( from == flicker->frame_count || flicker->frames[from] != number )
            result = rf_fail( error, RF_ERROR_IO, "%s: frame %d is missing", flicker->pattern, number );
    }
    if ( result != RF_OK )
    {
        free( wanted );
        return result;
    }
    free( flicker->frames );
    flicker->frames = wanted;
    flicker->frame_count = count;
    return RF_OK;
}

static RfResult check_frames( const FlickerRun* flicker, RfError* error )
{
    if ( flicker->frame_count < 2 )
        return rf_fail( error, RF_ERROR_IO, "%s: has only frame %d: flicker needs at least two neighbouring frames",
                        flicker->pattern, flicker->frames[0] );
    int step = rf_sequence_step( flicker->pattern, flicker->frames[0] );
    for ( int i = 1; i < flicker->frame_count; ++i )
    {
        int before = flicker->frames[i - 1], now = flicker->frames[i];
        if ( now != before + step )
            return rf_fail( error, RF_ERROR_IO,
                            "%s: frame %d is followed by %d: flicker needs consecutive frames: choose them by --frames",
                            flicker->pattern, before, now );
    }
    return RF_OK;
}

// Checks before the work that the reference has all frames.
static RfResult check_reference( const FlickerRun* flicker, RfError* error )
{
    char path[FLICKER_NAME_SIZE];
    for ( int i = 0; i < flicker->frame_count; ++i )
    {
        RfResult result = flicker_path( flicker->reference, flicker->frames[i], path, error );
        if ( result != RF_OK )
            return result;
        if ( access( path, F_OK ) != 0 )
            return rf_fail( error, RF_ERROR_IO, "%.400s: is missing: the reference needs frame %d, which %.400s has", path,
                            flicker->frames[i], flicker->pattern );
    }
    return RF_OK;
}

// Lists the frames: at least two, consecutive, all in the reference too.
static RfResult find_flicker_frames( FlickerRun* flicker, RfError* error )
{
    const char* patterns[2] = { flicker->pattern, flicker->reference };
    for ( int i = 0; i < 2; ++i )
    {
        if ( patterns[i] != NULL && !rf_is_sequence( patterns[i] ) )
            return rf_fail( error, RF_ERROR_USAGE, "%s%s: has no #### for the frame number: give a sequence",
                            i == 1 ? "--reference: " : "", patterns[i] );
    }
    RfResult result = rf_sequence_frames( flicker->pattern, &flicker->frames, &flicker->frame_count, error );
    if ( result != RF_OK )
        return result;
    flicker->first_frame = flicker->frames[0];
    if ( flicker->frame_list != NULL )
        result = choose_frames( flicker, error );
    if ( result == RF_OK )
        result = check_frames( flicker, error );
    if ( result == RF_OK && flicker->reference != NULL )
        result = check_reference( flicker, error );
    return result;
}

static RfResult fail_no_motion( const FlickerRun* flicker, RfError* error )
{
    return rf_fail( error, RF_ERROR_FORMAT,
                    "%s: has no motion layer: name its channels by --motion X,Y, or render --aov motion,depth",
                    flicker->first_path );
}

// Errors about names that were given, "motion: ...", are errors of the options.
static void name_option( const FlickerRun* flicker, RfError* error )
{
    bool given = flicker->motion != NULL || flicker->depth != NULL;
    if ( error->remedy == RF_REMEDY_NONE && given )
        rf_fail( error, error->code, "--%s", error->text );
}

// Layers of the main figures: those of the first frame, which all frames must have.
static RfResult find_main_layers( FlickerRun* flicker, bool compensate, RfError* error )
{
    RfFlickerLayers* layers = &flicker->layers;
    RfResult result = rf_read_exr_header( flicker->first_path, flicker->layer, &flicker->layered, error );
    if ( result == RF_OK && compensate )
    {
        result = rf_find_flicker_layers( flicker->first_path, &flicker->layered, flicker->motion, flicker->depth, layers, error );
        if ( result != RF_OK )
            name_option( flicker, error );
    }
    // the variance is the colour's, not that of another layer
    if ( result == RF_OK && flicker->reference == NULL && flicker->layer == NULL )
        result = rf_find_variance_layers( flicker->first_path, &flicker->layered, layers, error );
    if ( result == RF_OK && layers->motion[0] == NULL && ( flicker->compensate || flicker->depth != NULL ) )
        return fail_no_motion( flicker, error );
    flicker->report.compensated = layers->motion[0] != NULL;
    return result;
}

// Layers of the additional figures along the motion: those of the first frame that has any. If
// they are ambiguous the figures are left out, with a note.
static RfResult find_layers_beside( FlickerRun* flicker, RfError* error )
{
    char path[FLICKER_NAME_SIZE];
    RfFlickerLayers* layers = &flicker->layers;
    RfError unclear = { 0 };
    RfResult result = RF_OK;
    for ( int i = 0; i < flicker->frame_count && layers->motion[0] == NULL && unclear.code == RF_OK && result == RF_OK; ++i )
    {
        rf_destroy_exr_header( &flicker->layered );
        result = flicker_path( flicker->pattern, flicker->frames[i], path, error );
        if ( result == RF_OK )
            result = rf_read_exr_header( path, flicker->layer, &flicker->layered, error );
        if ( result == RF_OK &&
             rf_find_flicker_layers( path, &flicker->layered, NULL, flicker->depth, layers, &unclear ) != RF_OK )
            *layers = ( RfFlickerLayers ){ 0 };
    }
    if ( result != RF_OK )
        return result;
    if ( flicker->depth != NULL && unclear.code != RF_OK )
    {
        name_option( flicker, &unclear );
        *error = unclear;
        return unclear.code;
    }
    if ( flicker->depth != NULL && layers->motion[0] == NULL )
        return fail_no_motion( flicker, error );
    if ( unclear.code != RF_OK )
        rf_format_error( &unclear, flicker->report.unfollowed, sizeof flicker->report.unfollowed );
    flicker->report.follows = layers->motion[0] != NULL;
    layers->may_lack = true;
    return RF_OK;
}

// As the reference's first file calls it.
static RfResult name_reference_layer( FlickerRun* flicker, RfError* error )
{
    char path[FLICKER_NAME_SIZE];
    RfResult result = flicker_path( flicker->reference, flicker->frames[0], path, error );
    flicker->reference_layer = rf_layer_of_file( path, flicker->reference_layer, flicker->texts[1] );
    return result;
}

// Chooses layers from the header of the first frame. Against a reference, motion is also followed
// in additional figures, where any frame has it.
static RfResult find_layers_to_read( FlickerRun* flicker, RfError* error )
{
    RfFlickerReport* report = &flicker->report;
    RfFlickerLayers* layers = &flicker->layers;
    RfResult result = flicker_path( flicker->pattern, flicker->frames[0], flicker->first_path, error );
    if ( result != RF_OK )
        return result;
    if ( flicker->reference_layer == NULL )
        flicker->reference_layer = flicker->layer;
    flicker->layer = rf_layer_of_file( flicker->first_path, flicker->layer, flicker->texts[0] );
    result = rf_read_exr_header( flicker->first_path, flicker->layer, &flicker->header, error );
    if ( result == RF_OK && flicker->reference != NULL )
        result = name_reference_layer( flicker, error );
    if ( result != RF_OK )
        return result;
    bool by_default = flicker->reference == NULL || flicker->motion != NULL;
    bool beside = !by_default && !flicker->compensate_given;
    bool compensate = flicker->compensate_given ? flicker->compensate : by_default;
    result = beside ? find_layers_beside( flicker, error ) : find_main_layers( flicker, compensate, error );
    if ( result != RF_OK )
        return result;
    layers->colour = flicker->layer;
    layers->depth = layers->motion[0] != NULL ? layers->depth : NULL;
    report->masked = layers->depth != NULL;
    report->source = flicker->reference != NULL    ? RF_ERROR_FROM_REFERENCE
                     : layers->variance[0] != NULL ? RF_ERROR_FROM_VARIANCE
                                                   : RF_ERROR_UNKNOWN;
    return RF_OK;
}

// Frame by frame through the sequences of reframe flicker: reads, compares neighbours, adds up.

// Groups, the window of the spectrum and the slit-scan, by the frames found.
static RfResult prepare_flicker( FlickerRun* flicker, RfError* error )
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
static RfResult take_images( FlickerRun* flicker, int i, RfFlickerFrame* frame, const RfImage* reference, RfError* error )
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

static RfResult read_frame( FlickerRun* flicker, int i, RfError* error )
{
    char path[FLICKER_NAME_SIZE];
    RfFlickerFrame* frame = flicker->ring + i % flicker->ring_size;
    RfImage reference = { 0 };
    rf_destroy_flicker_frame( frame );
    RfResult result = flicker_path( flicker->pattern, flicker->frames[i], path, error );
    if ( result == RF_OK )
        result = rf_read_flicker_frame( path, &flicker->layers, &flicker->header, flicker->first_path, frame, error );
    if ( result == RF_OK && flicker->reference != NULL )
    {
        result = flicker_path( flicker->reference, flicker->frames[i], path, error );
        if ( result == RF_OK )
            result = rf_read_aligned( path, flicker->reference_layer, &flicker->header, flicker->first_path, &reference, error );
    }
    if ( result == RF_OK )
        result = take_images( flicker, i, frame, &reference, error );
    rf_destroy_image( &reference );
    return result;
}

// The same pair along the motion, where its frames have the layers.
static RfResult follow_pair( FlickerRun* flicker, const RfFlickerFrame* now, const RfFlickerFrame* before, bool border,
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

// The groups of a shot are its own.
static RfResult enter_shot( FlickerRun* flicker, int i, RfError* error )
{
    char path[FLICKER_NAME_SIZE];
    RfResult result = flicker_path( flicker->pattern, flicker->frames[i], path, error );
    flicker->report.cuts += 1;
    if ( result != RF_OK || flicker->period > 0 )
        return result;
    flicker->seams = rf_read_seams( path, flicker->frames[i], flicker->frames[flicker->frame_count - 1] );
    flicker->report.has_seams = flicker->report.has_seams || rf_has_seams( &flicker->seams );
    return RF_OK;
}

static RfResult measure_pair( FlickerRun* flicker, int i, RfError* error )
{
    RfFlickerReport* report = &flicker->report;
    const RfFlickerFrame* now = flicker->ring + i % flicker->ring_size;
    RfFlickerFrame* before = flicker->ring + ( i - 1 ) % flicker->ring_size;
    if ( rf_is_cut( now, before ) )
        return enter_shot( flicker, i, error );
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

static RfResult measure_window( FlickerRun* flicker, int i, RfError* error )
{
    int count = flicker->report.window;
    if ( !flicker->spectrum || !rf_ends_group( i, flicker->frame_count ) )
        return RF_OK;
    const RfFlickerFrame* frames[RF_SPECTRUM_FRAMES];
    for ( int t = 0; t < count; ++t )
        frames[t] = flicker->ring + ( i - count + 1 + t ) % flicker->ring_size;
    return rf_add_spectrum_group( &flicker->report.spectrum, frames, count, flicker->report.compensated, error );
}

static RfResult check_finite( const FlickerRun* flicker, RfError* error )
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

static RfResult finish( FlickerRun* flicker, RfError* error )
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

// Measures all frames and writes what is asked for.
static RfResult go_through_frames( FlickerRun* flicker, RfError* error )
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

#define COMMAND "flicker"

static RfResult check_options( const FlickerRun* flicker, RfError* error )
{
    const char* alone = flicker->motion != NULL ? "motion" : flicker->depth != NULL ? "depth" : NULL;
    if ( alone != NULL && flicker->compensate_given && !flicker->compensate )
        return rf_fail( error, RF_ERROR_USAGE, "--%s: has no effect with --no-compensate", alone );
    if ( flicker->reference_layer != NULL && flicker->reference == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--reference-layer: needs --reference" );
    if ( flicker->png == NULL && ( flicker->column_given || flicker->exposure_given ) )
        return rf_fail( error, RF_ERROR_USAGE, "--%s: needs --png", flicker->column_given ? "column" : "exposure" );
    return RF_OK;
}

static RfResult run( FlickerRun* flicker, RfError* error )
{
    flicker->table = rf_prints_text( flicker->json );
    flicker->report.pairs = json_array();
    RfResult result = check_options( flicker, error );
    if ( result == RF_OK )
        result = find_flicker_frames( flicker, error );
    if ( result == RF_OK )
        result = find_layers_to_read( flicker, error );
    if ( result == RF_OK )
        result = prepare_flicker( flicker, error );
    if ( result == RF_OK )
        result = go_through_frames( flicker, error );
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
    FlickerRun flicker = { .spectrum = true };
    const RfOption options[] = {
        { .name = "reference",
          .reads = true,
          .type = RF_OPTION_STRING,
          .value = &flicker.reference,
          .meta = "SEQ",
          .help = "reference sequence: measure the flicker of the error instead of that of the picture" },
        { .name = "frames",
          .type = RF_OPTION_STRING,
          .value = &flicker.frame_list,
          .meta = "[@]A-B",
          .default_text = "all",
          .help = "measure only these frames, which must be consecutive" },
        { .name = "layer",
          .type = RF_OPTION_STRING,
          .value = &flicker.layer,
          .meta = "NAME",
          .default_text = "colour",
          .help = "a layer, part or channel of the files, or three channels X,Y,Z" },
        { .name = "reference-layer",
          .type = RF_OPTION_STRING,
          .value = &flicker.reference_layer,
          .meta = "NAME",
          .default_text = "that of --layer",
          .help = "layer of the reference, if it is named differently" },
        { .name = "compensate",
          .type = RF_OPTION_BOOL,
          .value = &flicker.compensate,
          .given = &flicker.compensate_given,
          .default_text = "if there are motion layers; with a reference, in addition to the plain figures",
          .help = "measure along the motion layers, masked by depth; --no-compensate: in place only",
          .heading = RF_HEADING_MEASUREMENT },
        { .name = "motion",
          .type = RF_OPTION_STRING,
          .value = &flicker.motion,
          .meta = "X,Y",
          .default_text = "the layer motion or Vector",
          .help = "channels of the motion to the previous frame, in pixels, +x right, +y up; implies --compensate",
          .heading = RF_HEADING_MEASUREMENT },
        { .name = "depth",
          .type = RF_OPTION_STRING,
          .value = &flicker.depth,
          .meta = "NAME",
          .default_text = "depth.Z, Depth.Z, Depth.V or Z",
          .help = "depth channel, to find disocclusions",
          .heading = RF_HEADING_MEASUREMENT },
        { .name = "border",
          .type = RF_OPTION_INT,
          .value = &flicker.period,
          .min = 2,
          .max = 1000000,
          .meta = "N",
          .default_text = "Reframe's own groups",
          .help = "report separately the borders of groups of N frames, counted from the first frame",
          .heading = RF_HEADING_MEASUREMENT },
        { .name = "spectrum",
          .type = RF_OPTION_BOOL,
          .value = &flicker.spectrum,
          .help = "split the error into slow drift and boiling; keeps 16 frames in memory",
          .heading = RF_HEADING_MEASUREMENT },
        { .name = "png",
          .writes = ".png",
          .type = RF_OPTION_STRING,
          .value = &flicker.png,
          .meta = "FILE",
          .help = "write a slit-scan: one column over time, the reference's below",
          .heading = RF_HEADING_OUTPUT },
        { .name = "column",
          .type = RF_OPTION_INT,
          .value = &flicker.column,
          .min = 1,
          .max = 1 << 20,
          .meta = "X",
          .default_text = "the middle",
          .given = &flicker.column_given,
          .help = "column of the slit-scan; 1 is the leftmost",
          .heading = RF_HEADING_OUTPUT },
        { .name = "exposure",
          .type = RF_OPTION_REAL,
          .value = &flicker.exposure,
          .min = -32,
          .max = 32,
          .meta = "E",
          .given = &flicker.exposure_given,
          .help = "exposure of the slit-scan in stops",
          .heading = RF_HEADING_OUTPUT },
        { .name = "json",
          .writes = ".json",
          .type = RF_OPTION_STRING,
          .value = &flicker.json,
          .meta = "FILE",
          .help = "write the result as JSON; - for standard output, instead of the table",
          .heading = RF_HEADING_OUTPUT },
        { .name = "quiet", .type = RF_OPTION_BOOL, .value = &flicker.quiet, .help = "no progress", .heading = RF_HEADING_OUTPUT },
    };
    const RfCommandTable table = {
        .command = COMMAND,
        .summary = "Measures how much the error of a sequence changes from frame to frame. SEQ is a sequence of EXR files named "
                   "with ####.",
        .files = files,
        .file_count = 1,
        .options = options,
        .option_count = sizeof options / sizeof options[0],
    };
    RfError error = { 0 };
    bool help = false;
    RfResult result = rf_parse_options( &table, argc, argv, &flicker.pattern, &help, &error );
    if ( result == RF_OK && help )
        result = rf_show_help( &table, &error );
    else if ( result == RF_OK )
        result = run( &flicker, &error );
    return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
}
