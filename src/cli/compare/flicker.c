// reframe flicker SEQ: how much the error of a sequence changes from frame to
// frame, against a reference or along the motion layers.
#include "cli/commands.h"
#include "cli/compare/flicker_run.h"
#include "cli/options/options.h"
#include "cli/messages.h"

#include <stdlib.h>
#include <string.h>

#define COMMAND "flicker"

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
        result = rf_prepare_flicker( flicker, error );
    if ( result == RF_OK )
        result = rf_go_through_frames( flicker, error );
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
