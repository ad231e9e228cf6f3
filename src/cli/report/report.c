// reframe report DIR…: one self-contained HTML page of rendered sequences.
#include "cli/commands.h"
#include "cli/render/interrupt.h"
#include "cli/options/options.h"
#include "cli/report/report_data.h"
#include "cli/report/report_numbers.h"
#include "cli/report/report_run.h"
#include "cli/report/report_tasks.h"
#include "cli/report/report_values.h"
#include "cli/render/progress.h"
#include "cli/messages.h"

#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#define COMMAND "report"
#define BLOCK_BYTES 64        // of the markup about a block
#define HEAVY_BYTES 100000000 // pages from here on get a hint

static bool ends_with( const char* name, const char* suffix )
{
    size_t length = strlen( name ), end = strlen( suffix );
    return length > end && strcmp( name + length - end, suffix ) == 0;
}

static RfResult check_options( const RfPageRun* report, RfError* error )
{
    if ( report->output == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--output: is missing: give the page's name, such as -o report.html" );
    if ( !ends_with( report->output, ".html" ) && !ends_with( report->output, ".htm" ) )
        return rf_fail( error, RF_ERROR_USAGE, "--output: wants a name that ends with .html, got '%s'", report->output );
    if ( report->reference_layer != NULL && report->reference == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--reference-layer: is of the sequence that --reference names" );
    if ( report->render_file != NULL && report->place_count > 1 )
        return rf_fail( error, RF_ERROR_USAGE,
                        "--render-json: is of one sequence, and %d are given: put each file into the folder of its frames",
                        report->place_count );
    if ( !report->overwrite && access( report->output, F_OK ) == 0 )
        return rf_fail( error, RF_ERROR_IO, "%s: is there already: --overwrite replaces it", report->output );
    return RF_OK;
}

static bool on_picture( void* user )
{
    RfPageRun* report = user;
    rf_show_frame_count( report->quiet, ++report->done, report->all );
    return !rf_is_interrupted();
}

static const char* title_of( RfPageRun* report )
{
    if ( report->title != NULL )
        return report->title;
    for ( int i = 0; i < report->place_count; ++i )
    {
        size_t used = strlen( report->words );
        snprintf( report->words + used, sizeof report->words - used, "%s%s", i > 0 ? ", " : "", report->sequences[i].name );
    }
    return report->words;
}

static RfPageData data_of( RfPageRun* report, const char* title )
{
    const RfExrHeader* header = &report->sequences[0].header;
    double fps = report->fps.numerator > 0   ? (double)report->fps.numerator / report->fps.denominator
                 : header->fps_numerator > 0 ? (double)header->fps_numerator / header->fps_denominator
                                             : 24.0;
    return ( RfPageData ){ .title = title,
                           .fps = fps,
                           .exposure = report->exposure,
                           .numbers = report->numbers,
                           .count = report->count,
                           .tracks = report->tracks,
                           .track_count = report->sequence_count,
                           .has_reference = report->reference != NULL,
                           .cost = report->cost };
}

static RfResult add_tracks( RfPageRun* report, RfPage* page, RfError* error )
{
    RfResult result = RF_OK;
    const RfPageSequence* reference = report->reference != NULL ? report->sequences + report->place_count : NULL;
    for ( int i = 0; i < report->sequence_count && result == RF_OK; ++i )
    {
        const RfPageSequence* sequence = report->sequences + i;
        report->tracks[i] = ( RfPageTrack ){ .sequence = sequence,
                                             .reference = sequence->is_reference ? NULL : reference,
                                             .index = i,
                                             .width = report->width,
                                             .numbers = report->numbers,
                                             .count = report->count,
                                             .holes = report->holes,
                                             .hole_count = report->hole_count,
                                             .layer_share = report->aov ? RF_PAGE_LAYER_BYTES / report->sequence_count : 0.0 };
        report->tracks[i].value_factor = rf_page_value_factor( report, report->tracks + i );
        result = rf_add_page_track( page, report->tracks + i, on_picture, report, error );
    }
    return result;
}

static RfResult end_page( RfPage* page, const RfPageData* data, RfError* error )
{
    json_t* json = rf_page_data_json( data );
    char* text = json != NULL ? json_dumps( json, JSON_COMPACT | JSON_REAL_PRECISION( 9 ) ) : NULL;
    json_decref( json );
    if ( text != NULL )
    {
        RfResult result = rf_end_page( page, text, error );
        free( text );
        return result;
    }
    rf_discard_page( page );
    return rf_fail( error, RF_ERROR_MEMORY, "%s: no memory left for the page's data", page->file.path );
}

static RfResult tell( const RfPageRun* report, const RfPageData* data, uint64_t bytes, RfError* error )
{
    char weight[32];
    rf_format_bytes( (double)bytes, weight );
    bool prints = report->json == NULL || strcmp( report->json, "-" ) != 0;
    if ( prints )
        rf_print( "%s: %d frame%s, %s\n", report->output, report->count, report->count == 1 ? "" : "s", weight );
    for ( int i = 0; i < report->place_count && prints; ++i )
        rf_tell_unfinished( report->sequences[i].name, report->sequences[i].progress );
    RfLog log = rf_stderr_log( COMMAND );
    if ( bytes > HEAVY_BYTES && !report->quiet )
        rf_warn( &log, "%s: weighs %s, which a browser takes long to open: --width makes pictures smaller, --frames takes some",
                 report->output, weight );
    if ( report->json != NULL )
        return rf_write_json( report->json, rf_page_result_json( data, report->output, bytes ), error );
    return rf_flush_output( error );
}

static RfResult write_page( RfPageRun* report, RfError* error )
{
    RfPage page;
    const char* title = title_of( report );
    RfResult result = rf_open_page( report->output, title, &page, error );
    if ( result != RF_OK )
        return result;
    result = add_tracks( report, &page, error );
    RfPageData data = data_of( report, title );
    if ( result == RF_OK )
        result = rf_add_fine_values( report, &data, &page, error );
    if ( result != RF_OK )
    {
        rf_discard_page( &page );
        return result;
    }
    result = end_page( &page, &data, error );
    return result == RF_OK ? tell( report, &data, page.bytes, error ) : result;
}

static RfResult run( RfPageRun* report, RfError* error )
{
    RfResult result = check_options( report, error );
    if ( result == RF_OK )
        result = rf_prepare_page( report, error );
    return result == RF_OK ? write_page( report, error ) : result;
}

int rf_command_report( int argc, char** argv )
{
    static const char* const files[] = { "DIR" };
    RfPageRun report = { .values = (size_t)12 << 20, .aov = true };
    const RfOption options[] = {
        { .name = "output",
          .writes = "",
          .letter = 'o',
          .type = RF_OPTION_STRING,
          .value = &report.output,
          .meta = "FILE.html",
          .help = "the page" },
        { .name = "overwrite",
          .type = RF_OPTION_BOOL,
          .value = &report.overwrite,
          .default_text = "off",
          .help = "replace a page that is there" },
        { .name = "reference",
          .reads = true,
          .type = RF_OPTION_STRING,
          .value = &report.reference,
          .meta = "DIR",
          .help = "what the frames should be: true error and flicker, and shown beside them" },
        { .name = "layer",
          .type = RF_OPTION_STRING,
          .value = &report.layer,
          .meta = "NAME",
          .default_text = "the colour",
          .help = "a layer, part or channel of all sequences' files, or three channels X,Y,Z" },
        { .name = "reference-layer",
          .type = RF_OPTION_STRING,
          .value = &report.reference_layer,
          .meta = "NAME",
          .default_text = "that of --layer",
          .help = "the same of the reference, where its name is another" },
        { .name = "render-json",
          .reads = true,
          .type = RF_OPTION_STRING,
          .value = &report.render_file,
          .meta = "FILE",
          .default_text = "one in the folder",
          .help = "what render --json wrote: time, memory, rays, estimated error" },
        { .name = "cost",
          .reads = true,
          .type = RF_OPTION_STRING,
          .value = &report.cost_file,
          .meta = "FILE",
          .default_text = "one in the folder",
          .help = "what cost --json wrote, for the curve of error against time" },
        { .name = "frames",
          .type = RF_OPTION_STRING,
          .value = &report.frame_list,
          .meta = "A-B[xSTEP][,...]",
          .default_text = "all",
          .help = "only these, by their numbers" },
        { .name = "width",
          .type = RF_OPTION_INT,
          .value = &report.width,
          .min = 16,
          .max = 65500,
          .meta = "W",
          .default_text = "as they are",
          .help = "pictures no wider than this; figures stay those of the files" },
        { .name = "values",
          .type = RF_OPTION_MEMORY,
          .value = &report.values,
          .min = 0,
          .meta = "SIZE",
          .default_text = "12M",
          .help = "most that the pixel probe's scene values take of the page; less is coarser, 0 is none" },
        { .name = "aov",
          .type = RF_OPTION_BOOL,
          .value = &report.aov,
          .default_text = "yes",
          .help = "show the AOVs that the files have, too" },
        { .name = "fps",
          .type = RF_OPTION_FPS,
          .value = &report.fps,
          .meta = "R",
          .default_text = "the files', else 24",
          .help = "frames per second to play" },
        { .name = "exposure",
          .type = RF_OPTION_REAL,
          .value = &report.exposure,
          .min = -8,
          .max = 8,
          .meta = "E",
          .default_text = "0",
          .help = "that the page begins with, stops" },
        { .name = "title",
          .type = RF_OPTION_STRING,
          .value = &report.title,
          .meta = "TEXT",
          .default_text = "the folders' names",
          .help = "of the page" },
        { .name = "json",
          .writes = ".json",
          .type = RF_OPTION_STRING,
          .value = &report.json,
          .meta = "FILE",
          .help = "write what was written as JSON, - for standard output" },
        { .name = "quiet", .type = RF_OPTION_BOOL, .value = &report.quiet, .help = "no progress and no hints on standard error" },
    };
    const RfCommandTable table = {
        .command = COMMAND,
        .summary =
            "One HTML page of rendered sequences: a verdict, frames that play at any exposure, side by side or wiped, a pixel "
            "probe, AOVs, curves, settings. Each DIR is a folder of EXR files, or a sequence named with ####. 48 frames of "
            "960x540 take less than 40 MB for the pictures of a sequence (mostly 10), --values for the probe and at most "
            "16 MB for AOVs.",
        .files = files,
        .file_count = 1,
        .file_max = RF_PAGE_MOST_SEQUENCES,
        .file_total = &report.place_count,
        .options = options,
        .option_count = sizeof options / sizeof options[0],
    };
    RfError error = { 0 };
    bool help = false;
    RfResult result = rf_parse_options( &table, argc, argv, report.places, &help, &error );
    if ( result == RF_OK && help )
    {
        rf_print_help( &table, stdout );
        result = rf_flush_output( &error );
        return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
    }
    rf_catch_interrupts();
    if ( result == RF_OK )
        result = run( &report, &error );
    rf_destroy_page_run( &report );
    return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
}
