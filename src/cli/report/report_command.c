// reframe report DIR…: one self-contained HTML page of rendered sequences.
#include "base/words.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/report/report_facts.h"
#include "cli/signals.h"
#include "image/atomic_file.h"
#include "image/sequence.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#define COMMAND "report"
#define HEAVY_BYTES 100000000 // pages from here on get a hint

// Appends to the list of each key what a sequence has of a frame.
static void add_frame_json( json_t* object, const RfPageTrack* track, int i )
{
    const RfPageFrame* frame = track->frames + i;
    char id[32];
    rf_page_block_id( track, track->run->numbers[i], id );
    json_t* row =
        json_pack( "{s:o, s:o, s:o, s:o, s:o, s:o, s:b, s:o, s:b}", "relmse", rf_json_number( frame->relmse ), "phi",
                   rf_json_number( frame->phi ), "f1", rf_json_number( frame->f1 ), "seconds", rf_json_number( frame->seconds ),
                   "samples", rf_json_number( frame->samples ), "bad", json_integer( (json_int_t)frame->bad ), "at_least",
                   frame->at_least, "blocks", frame->shown ? json_string( id ) : json_null(), "has_layers", frame->has_layers );
    const char* key;
    json_t* value;
    json_object_foreach( row, key, value )
    {
        if ( json_object_get( object, key ) == NULL )
            json_object_set_new( object, key, json_array() );
        json_array_append( json_object_get( object, key ), value );
    }
    json_decref( row );
}

static json_t* track_json( const RfPageTrack* track )
{
    RfExrWindow window = rf_page_window( &track->sequence.header );
    json_t* object =
        json_pack( "{s:o, s:o, s:b, s:i, s:i, s:i, s:i, s:o, s:b, s:i, s:o}", "name", rf_json_text( track->sequence.name ),
                   "path", rf_json_text( track->sequence.input.pattern ), "reference", track->sequence.is_reference, "width",
                   track->picture_width, "height", track->picture_height, "file_width", window.width, "file_height",
                   window.height, "layers", rf_page_layers_json( &track->layers ), "mixes", rf_has_page_mix( &track->layers ),
                   "value_factor", track->value_factor, "facts", rf_page_facts_json( track ) );
    for ( int i = 0; i < track->run->count; ++i )
        add_frame_json( object, track, i );
    return object;
}

// What the curves are of.
static json_t* notes_json( const RfPageRun* report )
{
    bool compensated = false, still = false, variance = false;
    for ( int i = 0; i < report->track_count; ++i )
    {
        compensated |= report->tracks[i].compensated;
        still |= !report->tracks[i].compensated;
        variance |= report->tracks[i].has_variance;
    }
    if ( report->reference != NULL )
        return json_pack( "{s:s, s:s, s:s}", "relmse", "Against the reference", "phi",
                          "1: independent noise in each frame, 0: a frozen error", "f1",
                          "How much the error changes from the frame before, root mean square" );
    return json_pack( "{s:s, s:s, s:s}", "relmse", "Estimated by the renderer, without a reference", "phi",
                      variance ? "The change over the variance layers; moving edges and highlights count too" : "", "f1",
                      compensated && still ? "Change from the frame before, along the motion layers where there are any"
                      : compensated        ? "Change from the frame before along the motion layers"
                                           : "Change from the frame before: what moves counts too (no motion layers)" );
}

// NULL where memory ran out.
static json_t* page_data_json( const RfPageRun* report, const char* title )
{
    json_t* tracks = json_array();
    for ( int i = 0; i < report->track_count; ++i )
        json_array_append_new( tracks, track_json( report->tracks + i ) );
    char subtitle[96], view[2 * RF_VIEW_NAME_SIZE + 4];
    const RfExrHeader* header = &report->tracks[0].sequence.header;
    const RfViewText* shown = &report->shown;
    RfExrWindow window = rf_page_window( header );
    bool has_look = shown->look[0] != '\0' && strcasecmp( shown->look, "None" ) != 0;
    double fps = report->fps.numerator > 0   ? (double)report->fps.numerator / report->fps.denominator
                 : header->fps_numerator > 0 ? (double)header->fps_numerator / header->fps_denominator
                                             : 24.0;
    snprintf( subtitle, sizeof subtitle, "%d frame%s of %dx%d pixels", report->count, report->count == 1 ? "" : "s", window.width,
              window.height );
    snprintf( view, sizeof view, "%s%s%s", shown->transform, has_look ? ", " : "", has_look ? shown->look : "" );
    return json_pack( "{s:o, s:s, s:f, s:f, s:o, s:o, s:o, s:o, s:o, s:o}", "title", rf_json_text( title ), "subtitle", subtitle,
                      "fps", fps, "exposure", shown->exposure, "frames", rf_json_frames( report->numbers, report->count ),
                      "sequences", tracks, "notes", notes_json( report ), "verdict", rf_page_verdict_json( report ), "view",
                      rf_json_text( view ), "warnings", rf_page_warnings_json( report ) );
}

// What `report --json` writes of a sequence.
static json_t* track_result_json( const RfPageTrack* track )
{
    RfFlickerMetrics flicker = rf_flicker_metrics( &track->flicker );
    bool has_flicker = track->flicker.pairs > 0;
    json_t* missing = rf_page_missing_json( track );
    int shown = 0;
    for ( int k = 0; k < track->run->count; ++k )
        shown += track->frames[k].shown;
    json_t* json = json_pack(
        "{s:o, s:o, s:o, s:b, s:i, s:i, s:o, s:I, s:I, s:I, s:o, s:o, s:o, s:o}", "damaged_frames", rf_page_damaged_json( track ),
        "name", rf_json_text( track->sequence.name ), "files", rf_json_text( track->sequence.input.pattern ), "reference",
        track->sequence.is_reference, "frames", shown, "missing", (int)json_array_size( missing ), "missing_frames", missing,
        "picture_bytes", (json_int_t)track->picture_bytes, "value_bytes", (json_int_t)track->value_bytes, "aov_bytes",
        (json_int_t)track->layer_bytes, "relmse", rf_json_number( track->has_error ? track->error.relmse : (double)NAN ),
        "relmse_estimate", rf_json_number( track->estimate ), "f1", rf_json_number( has_flicker ? flicker.f1 : (double)NAN ),
        "phi", rf_json_number( has_flicker ? flicker.phi : (double)NAN ) );
    if ( track->sequence.progress != NULL )
        json_object_set( json, "progress", track->sequence.progress );
    return json;
}

static json_t* page_result_json( const RfPageRun* report, uint64_t bytes )
{
    json_t *tracks = json_array(), *verdict = rf_page_verdict_json( report );
    for ( int i = 0; i < report->track_count; ++i )
        json_array_append_new( tracks, track_result_json( report->tracks + i ) );
    json_t* json =
        json_pack( "{s:o, s:I, s:i, s:o, s:O, s:O, s:o}", "output", rf_json_text( report->output ), "bytes", (json_int_t)bytes,
                   "frames", report->count, "sequences", tracks, "verdict", json_object_get( verdict, "text" ), "worst_frame",
                   json_object_get( verdict, "worst_frame" ), "warnings", rf_page_warnings_json( report ) );
    json_decref( verdict );
    return json;
}

static RfResult open_sequence( RfPageRun* report, const char* place, const char* layer, RfError* error )
{
    RfPageTrack* track = report->tracks + report->track_count;
    track->run = report;
    track->index = report->track_count++;
    return rf_open_page_sequence( place, layer, &track->sequence, error );
}

static RfResult open_sequences( RfPageRun* report, RfError* error )
{
    RfResult result = RF_OK;
    for ( int i = 0; i < report->place_count && result == RF_OK; ++i )
        result = open_sequence( report, report->places[i], report->layer, error );
    if ( result == RF_OK && report->reference != NULL )
    {
        const char* layer = report->reference_layer != NULL ? report->reference_layer : report->layer;
        result = open_sequence( report, report->reference, layer, error );
        report->tracks[report->place_count].sequence.is_reference = true;
    }
    for ( int i = 0; i < report->place_count && report->reference != NULL; ++i )
        report->tracks[i].reference = report->tracks + report->place_count;
    if ( result == RF_OK && report->render_file != NULL )
        result = rf_load_render_json( report->render_file, "--render-json", &report->tracks[0].sequence.render, error );
    return result;
}

// Folders of the same name are labelled by the paths that were given.
static void tell_names_apart( RfPageRun* report )
{
    for ( int i = 0; i < report->place_count; ++i )
    {
        bool alike = strcmp( report->tracks[i].sequence.name, "." ) == 0 || strcmp( report->tracks[i].sequence.name, ".." ) == 0;
        for ( int k = 0; k < report->track_count; ++k )
            alike |= k != i && strcmp( report->tracks[i].sequence.name, report->tracks[k].sequence.name ) == 0;
        if ( alike )
            snprintf( report->tracks[i].sequence.name, sizeof report->tracks[i].sequence.name, "%.255s", report->places[i] );
    }
    if ( report->reference != NULL )
        snprintf( report->tracks[report->place_count].sequence.name, sizeof report->tracks[0].sequence.name, "reference" );
}

// The frames of all sequences, each once, and those that none of them has.
static RfResult join_frames( RfPageRun* report, RfError* error )
{
    int room = 0, all = 0;
    for ( int i = 0; i < report->place_count; ++i )
        room += report->tracks[i].sequence.input.count;
    report->numbers = malloc( (size_t)room * sizeof( int ) );
    if ( report->numbers == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "out of memory for the numbers of %d frames", room );
    for ( int i = 0; i < report->place_count; ++i )
    {
        const RfSequenceInput* input = &report->tracks[i].sequence.input;
        memcpy( report->numbers + all, input->frames, (size_t)input->count * sizeof( int ) );
        all += input->count;
    }
    qsort( report->numbers, (size_t)all, sizeof( int ), rf_compare_frames );
    for ( int i = 0; i < all; ++i )
    {
        if ( report->count == 0 || report->numbers[report->count - 1] != report->numbers[i] )
            report->numbers[report->count++] = report->numbers[i];
    }
    return rf_missing_frames( report->numbers, report->count, &report->holes, &report->hole_count, error );
}

// Keeps those of the numbers that are wanted, both ascending.
static int keep_wanted( int* numbers, int count, const int* wanted, int wanted_count )
{
    int left = 0;
    for ( int i = 0; i < count; ++i )
    {
        if ( bsearch( numbers + i, wanted, (size_t)wanted_count, sizeof( int ), rf_compare_frames ) != NULL )
            numbers[left++] = numbers[i];
    }
    return left;
}

static RfResult choose_frames( RfPageRun* report, RfError* error )
{
    int *wanted, count;
    if ( report->frame_list == NULL )
        return RF_OK;
    RfResult result = rf_parse_frames( report->frame_list, report->numbers, report->count, &wanted, &count, error );
    if ( result != RF_OK )
        return result;
    report->count = keep_wanted( report->numbers, report->count, wanted, count );
    report->hole_count = keep_wanted( report->holes, report->hole_count, wanted, count );
    free( wanted );
    if ( report->count == 0 )
        return rf_fail( error, RF_ERROR_USAGE, "--frames: '%s': none of these is there", report->frame_list );
    return result;
}

// As the first file has it; values of a layer are shown by the sRGB curve unless another view is asked for.
static RfResult choose_view( RfPageRun* report, RfError* error )
{
    RfView* view;
    report->shown = ( RfViewText ){ .exposure = report->view.exposure };
    if ( report->layer != NULL && report->view.view == NULL )
        return RF_OK;
    RfLog log = rf_stderr_log( COMMAND );
    RfResult result = rf_open_chosen_view( &report->view, report->tracks[0].sequence.first, &log, &view, &report->shown, error );
    if ( result == RF_OK )
        rf_close_view( view ); // before there is work for nothing
    return result;
}

static RfResult check_options( RfPageRun* report, RfError* error )
{
    if ( report->output == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--output: is missing: give the page's name, such as -o report.html" );
    if ( !rf_ends_with( report->output, ".html" ) && !rf_ends_with( report->output, ".htm" ) )
        return rf_fail( error, RF_ERROR_USAGE, "--output: expected a name that ends with .html, got '%s'", report->output );
    if ( report->reference_layer != NULL && report->reference == NULL )
        return rf_fail( error, RF_ERROR_USAGE, "--reference-layer: needs --reference" );
    if ( report->render_file != NULL && report->place_count > 1 )
        return rf_fail( error, RF_ERROR_USAGE,
                        "--render-json: takes one sequence, and %d are given: put each file into the folder of its frames",
                        report->place_count );
    if ( !report->overwrite && access( report->output, F_OK ) == 0 )
        return rf_fail( error, RF_ERROR_IO, "%s: already exists: --overwrite replaces it", report->output );
    return RF_OK;
}

// Opens the sequences and lists the frames of the page. destroy_page_run in any case.
static RfResult prepare_page( RfPageRun* report, RfError* error )
{
    static RfResult ( *const steps[] )( RfPageRun*, RfError* ) = { check_options, open_sequences, join_frames, choose_frames,
                                                                   choose_view };
    RfResult result = RF_OK;
    for ( size_t i = 0; i < sizeof steps / sizeof steps[0] && result == RF_OK; ++i )
        result = steps[i]( report, error );
    if ( result == RF_OK )
        result = rf_try_output_file( report->output, error );
    if ( result == RF_OK )
        tell_names_apart( report );
    return result;
}

static void destroy_page_run( RfPageRun* report )
{
    for ( int i = 0; i < report->track_count; ++i )
        rf_free_page_track( report->tracks + i );
    free( report->numbers );
    free( report->holes );
}

static const char* title_of( RfPageRun* report )
{
    if ( report->title != NULL )
        return report->title;
    for ( int i = 0; i < report->place_count; ++i )
    {
        size_t used = strlen( report->own_title );
        snprintf( report->own_title + used, sizeof report->own_title - used, "%s%s", i > 0 ? ", " : "",
                  report->tracks[i].sequence.name );
    }
    return report->own_title;
}

static RfResult add_tracks( RfPageRun* report, RfPage* page, RfError* error )
{
    RfResult result = RF_OK;
    for ( int i = 0; i < report->track_count; ++i )
    {
        for ( int k = 0; k < report->count; ++k )
            report->all += rf_has_page_frame( &report->tracks[i].sequence, report->numbers[k] );
    }
    for ( int i = 0; i < report->track_count && result == RF_OK; ++i )
        result = rf_add_page_track( page, report->tracks + i, error );
    return result;
}

// The view's cube, which the page looks colours up in.
static RfResult add_view( const RfViewText* shown, RfPage* page, RfError* error )
{
    RfViewText text = *shown;
    RfView* view;
    text.exposure = 0.0; // which the page has a slider for
    if ( text.transform[0] == '\0' )
        return RF_OK;
    RfResult result = rf_open_view( &text, &view, error );
    if ( result != RF_OK )
        return result;
    unsigned char* cube = malloc( RF_VIEW_CUBE_BYTES );
    if ( cube == NULL )
        result = rf_fail( error, RF_ERROR_MEMORY, "out of memory for the view" );
    else
    {
        rf_fill_view_cube( view, cube );
        result = rf_add_page_block( page, "view-cube", cube, RF_VIEW_CUBE_BYTES, error );
    }
    free( cube );
    rf_close_view( view );
    return result;
}

static RfResult end_page( const RfPageRun* report, RfPage* page, const char* title, RfError* error )
{
    json_t* json = page_data_json( report, title );
    char* text = json != NULL ? json_dumps( json, JSON_COMPACT | JSON_REAL_PRECISION( 9 ) ) : NULL;
    json_decref( json );
    if ( text == NULL )
    {
        rf_discard_page( page );
        return rf_fail( error, RF_ERROR_MEMORY, "%s: out of memory for the page's data", report->output );
    }
    RfResult result = rf_end_page( page, text, error );
    free( text );
    return result;
}

static RfResult write_page( RfPageRun* report, uint64_t* bytes, RfError* error )
{
    RfPage page;
    const char* title = title_of( report );
    RfResult result = rf_open_page( report->output, title, &page, error );
    if ( result != RF_OK )
        return result;
    result = add_tracks( report, &page, error );
    if ( result == RF_OK )
        result = add_view( &report->shown, &page, error );
    if ( result == RF_OK )
        result = end_page( report, &page, title, error );
    else
        rf_discard_page( &page );
    *bytes = page.bytes;
    return result;
}

static RfResult report_result( const RfPageRun* report, uint64_t bytes, RfError* error )
{
    char weight[32], text[RF_DAMAGE_SIZE];
    bool prints = rf_prints_text( report->json );
    RfLog log = rf_stderr_log( COMMAND );
    rf_format_bytes( (double)bytes, weight );
    if ( prints )
        rf_print( "%s: %d frame%s, %s\n", report->output, report->count, report->count == 1 ? "" : "s", weight );
    for ( int i = 0; i < report->track_count; ++i )
    {
        if ( prints && rf_format_unfinished( report->tracks[i].sequence.progress, text ) )
            rf_print( "%s: %s\n", report->tracks[i].sequence.name, text );
        if ( rf_format_damage( report->tracks + i, text ) )
            rf_warn( &log, "%.256s: %s", report->tracks[i].sequence.name, text );
    }
    if ( bytes > HEAVY_BYTES && !report->quiet )
        rf_warn( &log, "%s: %s is slow to open in a browser: --width makes the pictures smaller, --frames selects some",
                 report->output, weight );
    return report->json != NULL ? rf_write_json( report->json, page_result_json( report, bytes ), error )
                                : rf_flush_output( error );
}

static RfResult run( void* user, RfError* error )
{
    RfPageRun* report = user;
    rf_catch_interrupts();
    uint64_t bytes;
    RfResult result = prepare_page( report, error );
    if ( result == RF_OK )
        result = write_page( report, &bytes, error );
    return result == RF_OK ? report_result( report, bytes, error ) : result;
}

int rf_command_report( int argc, char** argv )
{
    static const char* const files[] = { "DIR" };
    RfPageRun report = { .values = (size_t)12 << 20, .passes = (size_t)16 << 20 };
    const RfOption options[] = {
        RF_TEXT_OPTION( "output", &report.output, "FILE.html", "the HTML page to write", .writes = "", .letter = 'o' ),
        RF_FLAG_OPTION( "overwrite", &report.overwrite, "replace an existing page", .heading = RF_HEADING_OUTPUT ),
        RF_TEXT_OPTION( "reference", &report.reference, "DIR",
                        "reference sequence, for true error and flicker; shown beside the others", .reads = true ),
        RF_TEXT_OPTION( "layer", &report.layer, "NAME", "a layer, part or channel of all files, or three channels X,Y,Z",
                        .default_text = "colour" ),
        RF_TEXT_OPTION( "reference-layer", &report.reference_layer, "NAME", "layer of the reference, if it is named differently",
                        .default_text = "that of --layer" ),
        RF_TEXT_OPTION( "render-json", &report.render_file, "FILE",
                        "output of render --json: time, memory, rays, estimated error", .reads = true,
                        .default_text = "the one in the folder" ),
        RF_TEXT_OPTION( "frames", &report.frame_list, "[@]A-B[xSTEP][,...]", "show only these frames", .default_text = "all" ),
        RF_INT_OPTION( "width", &report.width, 16, 65500, "W",
                       "maximum width of the pictures; the figures are those of the files", .default_text = "as they are",
                       .heading = RF_HEADING_OUTPUT ),
        RF_MEMORY_OPTION( "values", &report.values, 0, "SIZE",
                          "page space for the scene values of the pixel probe; less is coarser, 0: none",
                          .heading = RF_HEADING_OUTPUT ),
        RF_MEMORY_OPTION( "passes", &report.passes, 0, "SIZE",
                          "page space for pictures of the files' passes, which become smaller or are left out to fit; 0: none",
                          .heading = RF_HEADING_OUTPUT ),
        RF_FPS_OPTION( "fps", &report.fps, "R", "playback rate, frames per second", .default_text = "the files', else 24",
                       .heading = RF_HEADING_OUTPUT ),
        RF_REAL_OPTION( "exposure", &report.view.exposure, -8, 8, "E", "initial exposure in stops",
                        .given = &report.view.exposure_given, .default_text = "the files', else 0",
                        .heading = RF_HEADING_OUTPUT ),
        RF_VIEW_OPTIONS( report.view, RF_HEADING_OUTPUT ),
        RF_TEXT_OPTION( "title", &report.title, "TEXT", "title of the page", .default_text = "the folders' names",
                        .heading = RF_HEADING_OUTPUT ),
        RF_TEXT_OPTION( "json", &report.json, "FILE", "write the result as JSON; - for standard output", .writes = ".json",
                        .heading = RF_HEADING_OUTPUT ),
        RF_FLAG_OPTION( "quiet", &report.quiet, "no progress and no hints", .heading = RF_HEADING_OUTPUT ),
    };
    const RfCommandTable table = {
        .command = COMMAND,
        .summary =
            "Writes one HTML page of rendered sequences: a verdict, playback at any exposure, side by side or wiped, a pixel "
            "probe, passes, curves, settings. Each DIR is a folder of EXR files, or a sequence named with ####. 48 frames at "
            "960x540 take about 10 MB of pictures per sequence, at most 40 MB, and --values for the probe and --passes for the "
            "passes of the files.",
        RF_TABLE_ROWS( files, options ),
        .file_max = RF_PAGE_MOST_SEQUENCES,
        .file_total = &report.place_count,
    };
    int status = rf_run_command( &table, argc, argv, report.places, run, &report );
    destroy_page_run( &report );
    return status;
}
