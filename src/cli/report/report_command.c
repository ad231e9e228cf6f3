// reframe report DIR…: one self-contained HTML page of rendered sequences.
#include "cli/report/report_command.h"

#include "base/words.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "cli/options/options.h"
#include "cli/render/progress.h"
#include "cli/report/report_facts.h"
#include "cli/report/report_frames.h"
#include "cli/report/report_input.h"
#include "cli/report/report_verdict.h"
#include "cli/signals.h"
#include "image/atomic_file.h"
#include "image/sequence.h"
#include "page/page.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#define COMMAND "report"

#define BLOCK_BYTES 64 // of the markup about a block

// Of the bytes for values each sequence has an equal part. Where not all its frames can have those of each
// pixel, the one with the largest error shall.
static double value_share( const RfPageRun* report ) { return (double)report->values / report->sequence_count; }

static double fine_share( const RfPageRun* report, const RfPageTrack* track )
{
    RfExrWindow window = rf_page_window( &track->sequence->header );
    double whole = rf_values_page_bytes( window.width, window.height, 1 ) + BLOCK_BYTES, share = value_share( report );
    return report->count * whole <= share ? 0.0 : fmin( whole, 0.7 * share );
}

// The factor by which the values of all frames of a sequence are coarser than its pixels; 0: it has none.
static int page_value_factor( const RfPageRun* report, const RfPageTrack* track )
{
    RfExrWindow window = rf_page_window( &track->sequence->header );
    double rest = value_share( report ) - fine_share( report, track );
    return rf_values_factor( window.width, window.height, rest / report->count - BLOCK_BYTES );
}

// Adds finer values of one frame: of the one that the verdict calls the worst, else of the first.
static RfResult add_fine_values( RfPageRun* report, const RfPageData* data, RfPage* page, RfError* error )
{
    RfResult result = RF_OK;
    int track_index, worst = rf_worst_page_frame( data, &track_index );
    int number = report->numbers[worst >= 0 ? worst : 0];
    for ( int i = 0; i < report->sequence_count && result == RF_OK; ++i )
    {
        RfPageTrack* track = report->tracks + i;
        RfExrWindow window = rf_page_window( &track->sequence->header );
        int factor = rf_values_factor( window.width, window.height, fine_share( report, track ) - BLOCK_BYTES );
        bool is_finer = factor > 0 && ( track->value_factor == 0 || factor < track->value_factor );
        if ( is_finer && track->frames[worst >= 0 ? worst : 0].shown )
            result = rf_add_page_fine_values( page, track, number, factor, error );
    }
    return result;
}

static json_t* blocks_json( const RfPageTrack* track )
{
    json_t* blocks = json_array();
    char id[32];
    for ( int i = 0; i < track->count; ++i )
    {
        rf_page_block_id( track, track->numbers[i], id );
        json_array_append_new( blocks, track->frames[i].shown ? json_string( id ) : json_null() );
    }
    return blocks;
}

static void set_curves( json_t* object, const RfPageTrack* track )
{
    json_t *relmse = json_array(), *phi = json_array(), *f1 = json_array(), *seconds = json_array(), *samples = json_array(),
           *bad = json_array(), *at_least = json_array();
    for ( int i = 0; i < track->count; ++i )
    {
        const RfPageFrame* frame = track->frames + i;
        json_array_append_new( relmse, rf_json_number( frame->relmse ) );
        json_array_append_new( phi, rf_json_number( frame->phi ) );
        json_array_append_new( f1, rf_json_number( frame->f1 ) );
        json_array_append_new( seconds, rf_json_number( frame->seconds ) );
        json_array_append_new( samples, rf_json_number( frame->samples ) );
        json_array_append_new( bad, json_integer( (json_int_t)frame->bad ) );
        json_array_append_new( at_least, json_boolean( frame->at_least ) );
    }
    json_object_set_new( object, "relmse", relmse );
    json_object_set_new( object, "phi", phi );
    json_object_set_new( object, "f1", f1 );
    json_object_set_new( object, "seconds", seconds );
    json_object_set_new( object, "samples", samples );
    json_object_set_new( object, "bad", bad );
    json_object_set_new( object, "at_least", at_least );
}

static json_t* has_layers_json( const RfPageTrack* track )
{
    json_t* list = json_array();
    for ( int i = 0; i < track->count; ++i )
        json_array_append_new( list, json_boolean( track->frames[i].has_layers ) );
    return list;
}

static json_t* track_json( const RfPageTrack* track )
{
    RfExrWindow window = rf_page_window( &track->sequence->header );
    json_t* object = json_pack( "{s:o, s:o, s:b, s:i, s:i, s:o, s:o}", "name", rf_json_text( track->sequence->name ), "path",
                                rf_json_text( track->sequence->pattern ), "reference", track->sequence->is_reference, "width",
                                track->picture_width, "height", track->picture_height, "blocks", blocks_json( track ), "facts",
                                rf_page_facts_json( track ) );
    json_object_set_new( object, "file_width", json_integer( window.width ) );
    json_object_set_new( object, "file_height", json_integer( window.height ) );
    json_object_set_new( object, "index", json_integer( track->index ) );
    json_object_set_new( object, "layers", rf_page_layers_json( &track->layers ) );
    json_object_set_new( object, "mixes", json_boolean( rf_has_page_mix( &track->layers ) ) );
    json_object_set_new( object, "has_layers", has_layers_json( track ) );
    json_object_set_new( object, "value_factor", json_integer( track->value_factor ) );
    json_object_set_new( object, "fine_frame", json_integer( track->fine_frame ) );
    json_object_set_new( object, "fine_factor", json_integer( track->fine_factor ) );
    set_curves( object, track );
    return object;
}

static json_t* notes_json( const RfPageData* data )
{
    bool compensated = false, still = false, variance = false;
    for ( int i = 0; i < data->track_count; ++i )
    {
        compensated |= data->tracks[i].compensated;
        still |= !data->tracks[i].compensated;
        variance |= data->tracks[i].has_variance;
    }
    const char* f1 =
        data->has_reference    ? "How much the error changes from the frame before, root mean square"
        : compensated && still ? "Change from the frame before, root mean square: along the motion layers where there are any"
        : compensated          ? "Change from the frame before along the motion layers, root mean square"
                      : "Change of the picture from the frame before, root mean square: what moves counts too (no motion layers)";
    const char* phi =
        data->has_reference ? "1: independent noise in each frame, 0: a frozen error"
        : variance ? "The change over the variance layers; moving edges and highlights count too, unless there is a reference"
                   : "";
    return json_pack( "{s:s, s:s, s:s, s:s, s:s}", "relmse",
                      data->has_reference ? "Against the reference" : "Estimated by the renderer, without a reference", "phi",
                      phi, "f1", f1, "seconds", "Each frame's, as the renderer reported", "samples",
                      "Traced per pixel of each frame" );
}

// NULL where memory ran out.
static json_t* page_data_json( const RfPageData* data )
{
    json_t *tracks = json_array(), *frames = json_array();
    for ( int i = 0; i < data->track_count; ++i )
        json_array_append_new( tracks, track_json( data->tracks + i ) );
    for ( int i = 0; i < data->count; ++i )
        json_array_append_new( frames, json_integer( data->numbers[i] ) );
    char subtitle[96];
    RfExrWindow window = rf_page_window( &data->tracks[0].sequence->header );
    snprintf( subtitle, sizeof subtitle, "%d frame%s of %dx%d pixels", data->count, data->count == 1 ? "" : "s", window.width,
              window.height );
    char view[2 * RF_VIEW_NAME_SIZE + 4];
    bool has_look = data->view->look[0] != '\0' && strcasecmp( data->view->look, "None" ) != 0;
    snprintf( view, sizeof view, "%s%s%s", data->view->transform, has_look ? ", " : "", has_look ? data->view->look : "" );
    return json_pack( "{s:o, s:s, s:f, s:f, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "title", rf_json_text( data->title ), "subtitle",
                      subtitle, "fps", data->fps, "exposure", data->exposure, "frames", frames, "sequences", tracks, "notes",
                      notes_json( data ), "cost", rf_page_cost_json( data ), "verdict", rf_page_verdict_json( data ), "view",
                      rf_json_text( view ), "warnings", rf_page_warnings_json( data ) );
}

// What `report --json` writes.
static json_t* page_result_json( const RfPageData* data, const char* output, uint64_t bytes )
{
    json_t* tracks = json_array();
    for ( int i = 0; i < data->track_count; ++i )
    {
        const RfPageTrack* track = data->tracks + i;
        RfFlickerMetrics flicker = rf_flicker_metrics( &track->flicker );
        bool has_flicker = track->flicker.pairs > 0;
        int shown = 0, lacking;
        int* missing = rf_page_missing_frames( track, &lacking );
        for ( int k = 0; k < track->count; ++k )
            shown += track->frames[k].shown;
        json_array_append_new(
            tracks, json_pack( "{s:o, s:o, s:o, s:b, s:i, s:i, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o}", "damaged_frames",
                               rf_page_damaged_json( track ), "name", rf_json_text( track->sequence->name ), "files",
                               rf_json_text( track->sequence->pattern ), "reference", track->sequence->is_reference, "frames",
                               shown, "missing", lacking, "missing_frames", rf_json_frames( missing, lacking ), "picture_bytes",
                               json_integer( (json_int_t)track->picture_bytes ), "value_bytes",
                               json_integer( (json_int_t)track->value_bytes ), "aov_bytes",
                               json_integer( (json_int_t)track->layer_bytes ), "relmse",
                               rf_json_number( track->has_error ? track->error.relmse : NAN ), "relmse_estimate",
                               rf_json_number( track->estimate ), "f1", rf_json_number( has_flicker ? flicker.f1 : NAN ), "phi",
                               rf_json_number( has_flicker ? flicker.phi : NAN ) ) );
        if ( track->sequence->progress != NULL )
            json_object_set( json_array_get( tracks, (size_t)i ), "progress", track->sequence->progress );
        free( missing );
    }
    json_t* verdict = rf_page_verdict_json( data );
    json_t* json = json_pack( "{s:o, s:o, s:i, s:o, s:O, s:O, s:o}", "output", rf_json_text( output ), "bytes",
                              json_integer( (json_int_t)bytes ), "frames", data->count, "sequences", tracks, "verdict",
                              json_object_get( verdict, "text" ), "worst_frame", json_object_get( verdict, "worst_frame" ),
                              "warnings", rf_page_warnings_json( data ) );
    json_decref( verdict );
    return json;
}

static RfResult open_sequences( RfPageRun* report, RfError* error )
{
    RfResult result = RF_OK;
    for ( int i = 0; i < report->place_count && result == RF_OK; ++i )
        result = rf_open_page_sequence( report->places[i], report->layer, report->sequences + report->sequence_count++, error );
    if ( result == RF_OK && report->reference != NULL )
    {
        RfPageSequence* reference = report->sequences + report->sequence_count++;
        const char* layer = report->reference_layer != NULL ? report->reference_layer : report->layer;
        result = rf_open_page_sequence( report->reference, layer, reference, error );
        reference->is_reference = true;
    }
    if ( result == RF_OK && report->render_file != NULL )
        result = rf_load_render_json( report->render_file, "--render-json", &report->sequences[0].render, error );
    if ( result == RF_OK && report->cost_file != NULL )
        result = rf_load_cost_json( report->cost_file, "--cost", &report->cost, error );
    return result == RF_OK ? rf_check_cost_scene( report, error ) : result;
}

// Folders of the same name are labelled by the paths that were given.
static void tell_names_apart( RfPageRun* report )
{
    for ( int i = 0; i < report->place_count; ++i )
    {
        bool alike = strcmp( report->sequences[i].name, "." ) == 0 || strcmp( report->sequences[i].name, ".." ) == 0;
        for ( int k = 0; k < report->sequence_count; ++k )
            alike |= k != i && strcmp( report->sequences[i].name, report->sequences[k].name ) == 0;
        if ( alike )
            snprintf( report->sequences[i].name, sizeof report->sequences[i].name, "%.255s", report->places[i] );
    }
    if ( report->reference != NULL )
        snprintf( report->sequences[report->place_count].name, sizeof report->sequences[0].name, "reference" );
}

// The frames of all sequences, each once.
static RfResult join_frames( RfPageRun* report, RfError* error )
{
    int room = 0;
    for ( int i = 0; i < report->place_count; ++i )
        room += report->sequences[i].frame_count;
    report->numbers = malloc( (size_t)room * sizeof( int ) );
    if ( report->numbers == NULL )
        return rf_fail( error, RF_ERROR_MEMORY, "no memory left for the numbers of %d frames", room );
    int all = 0;
    for ( int i = 0; i < report->place_count; ++i )
    {
        const RfPageSequence* sequence = report->sequences + i;
        memcpy( report->numbers + all, sequence->frames, (size_t)sequence->frame_count * sizeof( int ) );
        all += sequence->frame_count;
    }
    qsort( report->numbers, (size_t)all, sizeof( int ), rf_compare_frames );
    for ( int i = 0; i < all; ++i )
    {
        if ( report->count == 0 || report->numbers[report->count - 1] != report->numbers[i] )
            report->numbers[report->count++] = report->numbers[i];
    }
    return RF_OK;
}

// Keeps those of the ascending numbers that are wanted (indices from 0).
static int keep_wanted( int* numbers, int count, const int* wanted, int wanted_count )
{
    int left = 0;
    for ( int i = 0, k = 0; i < count; ++i )
    {
        while ( k < wanted_count && wanted[k] < numbers[i] )
            ++k;
        if ( k < wanted_count && wanted[k] == numbers[i] )
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

static void count_pictures( RfPageRun* report )
{
    for ( int i = 0; i < report->sequence_count; ++i )
    {
        for ( int k = 0; k < report->count; ++k )
            report->all += rf_has_page_frame( report->sequences + i, report->numbers[k] );
    }
}

// Opens the sequences and lists the frames of the page. destroy_page_run in any case.
// As the first file has it; values of a layer are shown by the sRGB curve unless another view is asked for.
static RfResult choose_view( RfPageRun* report, RfError* error )
{
    char name[RF_FILE_NAME_SIZE];
    RfView* view;
    report->shown = ( RfViewText ){ .exposure = report->view.exposure };
    if ( report->layer != NULL && report->view.view == NULL )
        return RF_OK;
    RfResult result = rf_sequence_name( report->sequences[0].pattern, report->numbers[0], name, sizeof name, error );
    if ( result != RF_OK )
        return result;
    RfLog log = rf_stderr_log( COMMAND );
    result = rf_open_chosen_view( &report->view, name, &log, &view, &report->shown, error );
    if ( result == RF_OK )
        rf_close_view( view ); // before there is work for nothing
    return result;
}

static RfResult prepare_page( RfPageRun* report, RfError* error )
{
    RfResult result = open_sequences( report, error );
    if ( result == RF_OK )
        result = join_frames( report, error );
    if ( result == RF_OK )
        result = rf_missing_frames( report->numbers, report->count, &report->holes, &report->hole_count, error );
    if ( result == RF_OK )
        result = choose_frames( report, error );
    if ( result == RF_OK )
        result = choose_view( report, error );
    if ( result != RF_OK )
        return result;
    tell_names_apart( report );
    count_pictures( report );
    return RF_OK;
}

static void destroy_page_run( RfPageRun* report )
{
    for ( int i = 0; i < report->sequence_count; ++i )
    {
        rf_close_page_sequence( report->sequences + i );
        rf_free_page_track( report->tracks + i );
    }
    json_decref( report->cost );
    free( report->numbers );
    free( report->holes );
}

#define HEAVY_BYTES 100000000 // pages from here on get a hint

static RfResult check_options( const RfPageRun* report, RfError* error )
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
                           .exposure = report->shown.exposure,
                           .view = &report->shown,
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
                                             .layer_share = (double)report->passes / report->sequence_count };
        report->tracks[i].value_factor = page_value_factor( report, report->tracks + i );
        result = rf_add_page_track( page, report->tracks + i, on_picture, report, error );
    }
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
        result = rf_fail( error, RF_ERROR_MEMORY, "no memory left for the view" );
    else
    {
        rf_fill_view_cube( view, cube );
        result = rf_add_page_block( page, "view-cube", cube, RF_VIEW_CUBE_BYTES, error );
    }
    free( cube );
    rf_close_view( view );
    return result;
}

static RfResult end_page( RfPage* page, const RfPageData* data, RfError* error )
{
    json_t* json = page_data_json( data );
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

static RfResult report_result( const RfPageRun* report, const RfPageData* data, uint64_t bytes, RfError* error )
{
    char weight[32];
    rf_format_bytes( (double)bytes, weight );
    bool prints = rf_prints_text( report->json );
    if ( prints )
        rf_print( "%s: %d frame%s, %s\n", report->output, report->count, report->count == 1 ? "" : "s", weight );
    for ( int i = 0; i < report->place_count && prints; ++i )
        rf_tell_unfinished( report->sequences[i].name, report->sequences[i].progress );
    RfLog log = rf_stderr_log( COMMAND );
    for ( int i = 0; i < report->sequence_count; ++i )
    {
        char text[RF_DAMAGE_SIZE];
        if ( rf_format_damage( report->tracks + i, text ) )
            rf_warn( &log, "%.256s: %s", report->sequences[i].name, text );
    }
    if ( bytes > HEAVY_BYTES && !report->quiet )
        rf_warn( &log, "%s: %s is slow to open in a browser: --width makes the pictures smaller, --frames selects some",
                 report->output, weight );
    if ( report->json != NULL )
        return rf_write_json( report->json, page_result_json( data, report->output, bytes ), error );
    return rf_flush_output( error );
}

static RfResult write_page( RfPageRun* report, RfError* error )
{
    RfPage page;
    const char* title = title_of( report );
    RfResult result = rf_try_output_file( report->output, error );
    if ( result == RF_OK )
        result = rf_open_page( report->output, title, &page, error );
    if ( result != RF_OK )
        return result;
    result = add_tracks( report, &page, error );
    RfPageData data = data_of( report, title );
    if ( result == RF_OK )
        result = add_fine_values( report, &data, &page, error );
    if ( result == RF_OK )
        result = add_view( &report->shown, &page, error );
    if ( result != RF_OK )
    {
        rf_discard_page( &page );
        return result;
    }
    result = end_page( &page, &data, error );
    return result == RF_OK ? report_result( report, &data, page.bytes, error ) : result;
}

static RfResult run( RfPageRun* report, RfError* error )
{
    RfResult result = check_options( report, error );
    if ( result == RF_OK )
        result = prepare_page( report, error );
    return result == RF_OK ? write_page( report, error ) : result;
}

int rf_command_report( int argc, char** argv )
{
    static const char* const files[] = { "DIR" };
    RfPageRun report = { .values = (size_t)12 << 20, .passes = (size_t)16 << 20 };
    const RfOption options[] = {
        { .name = "output",
          .writes = "",
          .letter = 'o',
          .type = RF_OPTION_STRING,
          .value = &report.output,
          .meta = "FILE.html",
          .help = "the HTML page to write" },
        { .name = "overwrite",
          .type = RF_OPTION_BOOL,
          .value = &report.overwrite,
          .help = "replace an existing page",
          .heading = RF_HEADING_OUTPUT },
        { .name = "reference",
          .reads = true,
          .type = RF_OPTION_STRING,
          .value = &report.reference,
          .meta = "DIR",
          .help = "reference sequence, for true error and flicker; shown beside the others" },
        { .name = "layer",
          .type = RF_OPTION_STRING,
          .value = &report.layer,
          .meta = "NAME",
          .default_text = "colour",
          .help = "a layer, part or channel of all files, or three channels X,Y,Z" },
        { .name = "reference-layer",
          .type = RF_OPTION_STRING,
          .value = &report.reference_layer,
          .meta = "NAME",
          .default_text = "that of --layer",
          .help = "layer of the reference, if it is named differently" },
        { .name = "render-json",
          .reads = true,
          .type = RF_OPTION_STRING,
          .value = &report.render_file,
          .meta = "FILE",
          .default_text = "the one in the folder",
          .help = "output of render --json: time, memory, rays, estimated error" },
        { .name = "cost",
          .reads = true,
          .type = RF_OPTION_STRING,
          .value = &report.cost_file,
          .meta = "FILE",
          .default_text = "the one in the folder",
          .help = "output of cost --json, for the curve of error against time" },
        { .name = "frames",
          .type = RF_OPTION_STRING,
          .value = &report.frame_list,
          .meta = "[@]A-B[xSTEP][,...]",
          .default_text = "all",
          .help = "show only these frames" },
        { .name = "width",
          .type = RF_OPTION_INT,
          .value = &report.width,
          .min = 16,
          .max = 65500,
          .meta = "W",
          .default_text = "as they are",
          .help = "maximum width of the pictures; the figures are those of the files",
          .heading = RF_HEADING_OUTPUT },
        { .name = "values",
          .type = RF_OPTION_MEMORY,
          .value = &report.values,
          .min = 0,
          .meta = "SIZE",
          .help = "page space for the scene values of the pixel probe; less is coarser, 0: none",
          .heading = RF_HEADING_OUTPUT },
        { .name = "passes",
          .type = RF_OPTION_MEMORY,
          .value = &report.passes,
          .min = 0,
          .meta = "SIZE",
          .help = "page space for pictures of the files' passes, which become smaller or are left out to fit; 0: none",
          .heading = RF_HEADING_OUTPUT },
        { .name = "fps",
          .type = RF_OPTION_FPS,
          .value = &report.fps,
          .meta = "R",
          .default_text = "the files', else 24",
          .help = "playback rate, frames per second",
          .heading = RF_HEADING_OUTPUT },
        { .name = "exposure",
          .type = RF_OPTION_REAL,
          .value = &report.view.exposure,
          .given = &report.view.exposure_given,
          .min = -8,
          .max = 8,
          .meta = "E",
          .default_text = "the files', else 0",
          .help = "initial exposure in stops",
          .heading = RF_HEADING_OUTPUT },
        RF_VIEW_OPTIONS( report.view, RF_HEADING_OUTPUT ),
        { .name = "title",
          .type = RF_OPTION_STRING,
          .value = &report.title,
          .meta = "TEXT",
          .default_text = "the folders' names",
          .help = "title of the page",
          .heading = RF_HEADING_OUTPUT },
        { .name = "json",
          .writes = ".json",
          .type = RF_OPTION_STRING,
          .value = &report.json,
          .meta = "FILE",
          .help = "write the result as JSON; - for standard output",
          .heading = RF_HEADING_OUTPUT },
        { .name = "quiet",
          .type = RF_OPTION_BOOL,
          .value = &report.quiet,
          .help = "no progress and no hints",
          .heading = RF_HEADING_OUTPUT },
    };
    const RfCommandTable table = {
        .command = COMMAND,
        .summary =
            "Writes one HTML page of rendered sequences: a verdict, playback at any exposure, side by side or wiped, a pixel "
            "probe, passes, curves, settings. Each DIR is a folder of EXR files, or a sequence named with ####. 48 frames at "
            "960x540 take about 10 MB of pictures per sequence, at most 40 MB, and --values for the probe and --passes for the "
            "passes of the files.",
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
        result = rf_show_help( &table, &error );
        return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
    }
    rf_catch_interrupts();
    if ( result == RF_OK )
        result = run( &report, &error );
    destroy_page_run( &report );
    return result == RF_OK ? 0 : rf_report_error( COMMAND, &error );
}
