// reframe report DIR…: one self-contained HTML page of rendered sequences.
#include "base/try.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/shared_options.h"
#include "cli/report/report_frames.h"
#include "cli/render/render_json.h"
#include "image/atomic_file.h"
#include "image/sequence.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>
#include <unistd.h>

#define COMMAND "report"
#define HEAVY_BYTES 100000000 // pages from here on get a hint
#define FACT_SIZE 240         // characters of a value; the rest is cut
#define MOST_STRINGS 24       // attributes of other programs

static void format_count( double count, char text[32] )
{
    static const char* const units[] = { "", " k", " M", " G", " T" };
    int unit = 0;
    while ( count >= 1000.0 && unit < 4 )
    {
        count /= 1000.0;
        ++unit;
    }
    snprintf( text, 32, unit == 0 ? "%.0f%s" : "%.3g%s", count, units[unit] );
}

static void format_bytes( double bytes, char text[32] )
{
    char count[32];
    format_count( bytes, count );
    snprintf( text, 32, "%.20s%sB", count, strchr( count, ' ' ) != NULL ? "" : " " );
}

static void format_seconds( double seconds, char text[32] )
{
    double minutes = floor( seconds / 60.0 ), hours = floor( seconds / 3600.0 );
    if ( seconds < 100.0 )
        snprintf( text, 32, "%.3g s", seconds );
    else if ( hours < 1.0 )
        snprintf( text, 32, "%.0f min %.0f s", minutes, seconds - 60.0 * minutes );
    else
        snprintf( text, 32, "%.0f h %.0f min", hours, minutes - 60.0 * hours );
}

static void add_fact( json_t* facts, const char* group, const char* label, const char* format, ... )
    __attribute__( ( format( printf, 4, 5 ) ) );
static void add_fact( json_t* facts, const char* group, const char* label, const char* format, ... )
{
    char text[FACT_SIZE + sizeof "..."];
    va_list arguments;
    va_start( arguments, format );
    int length = vsnprintf( text, FACT_SIZE + 1, format, arguments );
    va_end( arguments );
    if ( length > FACT_SIZE )
        strcpy( text + FACT_SIZE, "..." );
    json_array_append_new( facts, json_pack( "[o, o, o]", rf_json_text( group ), rf_json_text( label ), rf_json_text( text ) ) );
}

static void format_three( double value, char text[32] ) { snprintf( text, 32, "%.3g", value ); }

typedef void Format( double value, char text[32] );

// Appends a row with a number; none where it is not known.
static void add_number( json_t* facts, const char* group, const char* label, double value, Format* format )
{
    char text[32];
    if ( !isfinite( value ) )
        return;
    format( value, text );
    add_fact( facts, group, label, "%s", text );
}

static void add_costs( json_t* facts, const json_t* render )
{
    double rays = 0.0;
    const char* key;
    json_t* value;
    if ( render == NULL )
        return;
    json_object_foreach( json_object_get( render, "rays" ), key, value ) rays += json_number_value( value );
    add_number( facts, "Cost", "Time", rf_json_number_of( render, "seconds" ), format_seconds );
    add_number( facts, "Cost", "Threads", rf_json_number_of( render, "threads" ), format_count );
    add_number( facts, "Cost", "Memory, peak", rf_json_number_of( render, "peak_bytes" ), format_bytes );
    add_number( facts, "Cost", "Rays", rays > 0.0 ? rays : (double)NAN, format_count );
}

static void format_samples( double samples, char text[32] ) { snprintf( text, 32, samples < 1000.0 ? "%.4g" : "%.0f", samples ); }

// "12 to 14.5", of what the frames have at an offset in RfPageFrame; nothing where no frame says.
static void add_range( json_t* facts, const char* label, const RfPageTrack* track, size_t offset )
{
    double least = INFINITY, most = -INFINITY;
    char parts[2][32];
    for ( int i = 0; i < track->run->count; ++i )
    {
        const double* value = (const double*)( (const char*)( track->frames + i ) + offset );
        least = fmin( least, *value ); // passes over NaN
        most = fmax( most, *value );
    }
    format_samples( least, parts[0] );
    format_samples( most, parts[1] );
    bool same = strcmp( parts[0], parts[1] ) == 0;
    if ( least <= most )
        add_fact( facts, "Cost", label, "%s%s%s", parts[0], same ? "" : " to ", same ? "" : parts[1] );
}

static void add_picture( json_t* facts, const RfPageTrack* track )
{
    const RfExrHeader* header = &track->sequence.header;
    RfExrWindow window = rf_page_window( header );
    char text[96];
    int shown = 0, first = 0, last = 0;
    for ( int i = 0; i < track->run->count; ++i )
    {
        if ( !track->frames[i].shown )
            continue;
        first = shown++ == 0 ? track->run->numbers[i] : first;
        last = track->run->numbers[i];
    }
    add_fact( facts, "Picture", "Frames", "%d, from %d to %d", shown, first, last );
    int used = snprintf( text, sizeof text, "%d x %d", window.width, window.height );
    if ( window.width != header->width || window.height != header->height )
        used += snprintf( text + used, sizeof text - (size_t)used, ", with overscan %d x %d", header->width, header->height );
    if ( track->picture_width != window.width )
        snprintf( text + used, sizeof text - (size_t)used, ", shown as %d x %d", track->picture_width, track->picture_height );
    add_fact( facts, "Picture", "Size", "%s", text );
}

// What is not on the page: frames that are not there, and passes that have no room or lie elsewhere.
static void add_absent( json_t* facts, const RfPageTrack* track )
{
    char text[512];
    const RfFilePasses* passes = &track->layers.passes;
    RfFilePasses left_out = { passes->passes + track->layers.count, passes->count - track->layers.count, NULL };
    rf_format_frames( track->missing, track->missing_count, text, 240 );
    if ( track->missing_count > 0 )
        add_fact( facts, "Picture", "Missing frames", "%s", text );
    rf_name_passes( &left_out, text, sizeof text );
    if ( left_out.count > 0 )
        add_fact( facts, "Picture", "Passes left out", "%s", text );
}

static void add_error( json_t* facts, const RfPageTrack* track )
{
    const RfErrorMetrics* e = &track->error;
    bool measured = track->has_error && isfinite( e->relmse ), at_least = false;
    double relmse = measured ? e->relmse : track->estimate;
    char noise[RF_NOISE_TEXT_SIZE];
    for ( int i = 0; i < track->run->count; ++i )
        at_least |= track->frames[i].at_least;
    rf_format_noise( relmse, noise );
    if ( isfinite( relmse ) )
        add_fact( facts, "Error", "relMSE", "%s%.3g, %s noise%s", at_least ? "at least " : "", relmse, noise,
                  measured ? "" : ", estimated" );
    if ( measured )
    {
        bool relative = e->reference_mean > 0.0;
        double scale = relative ? 100.0 / e->reference_mean : 1.0;
        add_number( facts, "Error", "without the worst 0.1 %", e->relmse_trimmed, format_three );
        add_fact( facts, "Error", "Mean error", "%+.2g%s (95 %%: %+.2g to %+.2g%s)", e->bias * scale, relative ? " %" : "",
                  e->bias_low * scale, e->bias_high * scale, relative ? " %" : "" );
    }
    RfFlickerMetrics flicker = rf_flicker_metrics( &track->flicker );
    add_number( facts, "Error", "Flicker: phi", track->flicker.pairs > 0 ? flicker.phi : (double)NAN, format_three );
    add_number( facts, "Error", "Flicker: relative F1", track->flicker.pairs > 0 ? flicker.f1_relative : (double)NAN,
                format_three );
}

typedef struct Strings
{
    json_t* facts;
    int count;
} Strings;

// An attribute of the first file, unless it is of that frame alone, or of the part.
static void take_string( void* user, const char* name, const char* value )
{
    static const char own[] = "reframe/";
    static const char left_out[] =
        " type name reframe/frame reframe/frames reframe/shot reframe/step reframe/effects reframe/calls-for reframe/fingerprint "
        "reframe/checksum reframe/relmse-estimate reframe/relmse-is-lower-bound reframe/relmse-likely reframe/worst-ten-share "
        "reframe/flicker-estimate reframe/flicker-is-lower-bound reframe/flicker-likely reframe/flicker-worst-ten-share "
        "reframe/denoised-relmse reframe/denoised-relmse-low reframe/denoised-relmse-high "
        "reframe/reached reframe/native-spp reframe/effective-spp reframe/clipped-pixels ";
    Strings* strings = user;
    bool is_own = strncmp( name, own, sizeof own - 1 ) == 0;
    char word[64];
    if ( snprintf( word, sizeof word, " %s ", name ) < (int)sizeof word && strstr( left_out, word ) != NULL )
        return;
    if ( is_own )
        add_fact( strings->facts, "Settings", name + sizeof own - 1, "%s", value );
    else if ( strings->count++ < MOST_STRINGS )
        add_fact( strings->facts, "Header", name, "%s", value );
}

static json_t* facts_json( const RfPageTrack* track )
{
    const RfPageSequence* sequence = &track->sequence;
    Strings strings = { .facts = json_array() };
    add_picture( strings.facts, track );
    add_absent( strings.facts, track );
    add_fact( strings.facts, "Picture", "Files", "%s", sequence->input.pattern );
    add_error( strings.facts, track );
    add_costs( strings.facts, sequence->render );
    add_range( strings.facts, "Samples a pixel", track, offsetof( RfPageFrame, samples ) );
    add_range( strings.facts, "Effective samples a pixel", track, offsetof( RfPageFrame, effective ) );
    rf_list_exr_strings( sequence->first, take_string, &strings, NULL );
    return strings.facts;
}

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
                   "value_factor", track->value_factor, "facts", facts_json( track ) );
    for ( int i = 0; i < track->run->count; ++i )
        add_frame_json( object, track, i );
    return object;
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
    return json_pack( "{s:o, s:s, s:f, s:f, s:o, s:o, s:o}", "title", rf_json_text( title ), "subtitle", subtitle, "fps", fps,
                      "exposure", shown->exposure, "frames", rf_json_frames( report->numbers, report->count ), "sequences",
                      tracks, "view", rf_json_text( view ) );
}

// What `report --json` writes of a sequence.
static json_t* track_result_json( const RfPageTrack* track )
{
    RfFlickerMetrics flicker = rf_flicker_metrics( &track->flicker );
    bool has_flicker = track->flicker.pairs > 0;
    int shown = 0;
    for ( int k = 0; k < track->run->count; ++k )
        shown += track->frames[k].shown;
    return json_pack( "{s:o, s:o, s:b, s:i, s:i, s:o, s:I, s:I, s:I, s:o, s:o, s:o, s:o}", "name",
                      rf_json_text( track->sequence.name ), "files", rf_json_text( track->sequence.input.pattern ), "reference",
                      track->sequence.is_reference, "frames", shown, "missing", track->missing_count, "missing_frames",
                      rf_json_frames( track->missing, track->missing_count ), "picture_bytes", (json_int_t)track->picture_bytes,
                      "value_bytes", (json_int_t)track->value_bytes, "aov_bytes", (json_int_t)track->layer_bytes, "relmse",
                      rf_json_number( track->has_error ? track->error.relmse : (double)NAN ), "relmse_estimate",
                      rf_json_number( track->estimate ), "f1", rf_json_number( has_flicker ? flicker.f1_relative : (double)NAN ),
                      "phi", rf_json_number( has_flicker ? flicker.phi : (double)NAN ) );
}

static json_t* page_result_json( const RfPageRun* report, uint64_t bytes )
{
    json_t* tracks = json_array();
    for ( int i = 0; i < report->track_count; ++i )
        json_array_append_new( tracks, track_result_json( report->tracks + i ) );
    return json_pack( "{s:o, s:I, s:i, s:o}", "output", rf_json_text( report->output ), "bytes", (json_int_t)bytes, "frames",
                      report->count, "sequences", tracks );
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
    RF_TRY( rf_parse_frames( report->frame_list, report->numbers, report->count, &wanted, &count, error ) );
    report->count = keep_wanted( report->numbers, report->count, wanted, count );
    report->hole_count = keep_wanted( report->holes, report->hole_count, wanted, count );
    free( wanted );
    if ( report->count == 0 )
        return rf_fail( error, RF_ERROR_USAGE, "--frames: '%s': none of these is there", report->frame_list );
    RfResult result = RF_OK;
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
    RF_TRY( rf_open_view( &text, &view, error ) );
    unsigned char* cube = malloc( RF_VIEW_CUBE_BYTES );
    RfResult result = RF_OK;
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
    RF_TRY( rf_open_page( report->output, title, &page, error ) );
    RfResult result = add_tracks( report, &page, error );
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
    char weight[32];
    RfLog log = rf_stderr_log( COMMAND );
    format_bytes( (double)bytes, weight );
    if ( rf_prints_text( report->json ) )
        rf_print( "%s: %d frame%s, %s\n", report->output, report->count, report->count == 1 ? "" : "s", weight );
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
    RF_TRY( prepare_page( report, error ) );
    RF_TRY( write_page( report, &bytes, error ) );
    return report_result( report, bytes, error );
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
        RF_RESULT_OPTIONS( report, "write the result as JSON; - for standard output", "no progress and no hints" ),
    };
    const RfCommandTable table = {
        .command = COMMAND,
        .summary =
            "Writes one HTML page of rendered sequences: playback at any exposure, side by side or wiped, a pixel "
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
