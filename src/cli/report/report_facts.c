// Facts of a sequence on the page, its warnings, and the verdict, which compares sequences by the time they need for equal error.
#include "cli/report/report_facts.h"

#include "cli/messages.h"
#include "cli/render/render_json.h"

#include <math.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>

#define LONGEST 600     // characters of a warning
#define MOST_LINES 100  // of a kind
#define FACT_SIZE 240   // characters of a value; the rest is cut
#define MOST_STRINGS 24 // attributes of other programs

typedef struct List
{
    json_t* json;
    int track;
} List;

static json_t* cut_text( const char* text, int most )
{
    char cut[LONGEST + 4];
    snprintf( cut, sizeof cut, "%.*s%s", most, text, strlen( text ) > (size_t)most ? "..." : "" );
    return rf_json_text( cut );
}

static void warn( const List* list, const char* format, ... ) __attribute__( ( format( printf, 2, 3 ) ) );
static void warn( const List* list, const char* format, ... )
{
    char text[2 * LONGEST];
    va_list arguments;
    va_start( arguments, format );
    vsnprintf( text, sizeof text, format, arguments );
    va_end( arguments );
    json_array_append_new(
        list->json, json_pack( "{s:i, s:o, s:b}", "sequence", list->track, "text", cut_text( text, LONGEST ), "loss", 0 ) );
}

// Of losses of the picture all, in full.
static void add_lines( const List* list, const json_t* lines, bool loss )
{
    size_t i;
    json_t* line;
    json_array_foreach( lines, i, line )
    {
        if ( json_is_string( line ) && loss )
            json_array_append_new( list->json, json_pack( "{s:i, s:O, s:b}", "sequence", list->track, "text", line, "loss", 1 ) );
        else if ( json_is_string( line ) && i < MOST_LINES )
            warn( list, "%s", json_string_value( line ) );
    }
}

// What render --json repeats of the scene's loading and of the render.
static void add_reported( const List* list, const json_t* render )
{
    const json_t* lines = json_object_get( render, "warnings" );
    double missed = rf_json_number_of( json_object_get( render, "noise" ), "missed" );
    add_lines( list, lines, false );
    if ( isgreater( missed, 0.0 ) && lines == NULL )
        warn( list, "--noise was not reached in %.0f frame%s", missed, missed == 1.0 ? "" : "s" );
    if ( json_is_true( json_object_get( render, "interrupted" ) ) )
        warn( list, "the render was interrupted: --resume continues it" );
}

// Of a render that other machines are at, no fault.
static void add_absent( const List* list, const RfPageTrack* track )
{
    char text[RF_UNFINISHED_SIZE];
    const json_t* progress = track->sequence.progress;
    json_t* missing = rf_page_missing_json( track );
    if ( progress != NULL && rf_format_unfinished( progress, text ) )
        warn( list, "still rendering: %s", text );
    else if ( progress == NULL && rf_format_numbers( missing, text, 240 ) )
        warn( list, "%s missing: %s", json_array_size( missing ) == 1 ? "a frame is" : "frames are", text );
    json_decref( missing );
}

// Frames whose pixels or estimates are not what they seem.
static void add_doubts( const List* list, const RfPageTrack* track )
{
    size_t bad = 0, clipped = 0;
    int first = -1, bad_frames = 0, clipped_frames = 0, bounds = 0, count = track->run->count;
    double share = 0.0;
    for ( int i = 0; i < count; ++i )
    {
        const RfPageFrame* frame = track->frames + i;
        bad += frame->bad;
        clipped += frame->clipped;
        bad_frames += frame->bad > 0;
        clipped_frames += frame->clipped > 0;
        bounds += frame->at_least;
        first = first < 0 && frame->bad > 0 ? track->run->numbers[i] : first;
        share = fmax( share, frame->worst_ten_share ); // fmax passes over NaN
    }
    if ( bad > 0 )
        warn( list, "%zu pixel%s NaN or infinite, in %d frame%s from %d on; NaN is shown in magenta", bad,
              bad == 1 ? " is" : "s are", bad_frames, bad_frames == 1 ? "" : "s", first );
    if ( clipped > 0 && track->sequence.render == NULL ) // else that has warned
        warn( list, "%zu pixel%s clipped by the range of the file's channels, in %d frame%s", clipped,
              clipped == 1 ? " is" : "s are", clipped_frames, clipped_frames == 1 ? "" : "s" );
    char worst[64] = "";
    if ( share > 0.0 )
        snprintf( worst, sizeof worst, " (the ten worst up to %.0f %%)", 100.0 * share );
    if ( bounds > 0 )
        warn( list, "the estimated relMSE is a lower bound in %d of %d frame%s: few pixels carry much of it%s", bounds, count,
              count == 1 ? "" : "s", worst );
}

json_t* rf_page_warnings_json( const RfPageRun* report )
{
    List list = { .json = json_array() };
    for ( list.track = 0; list.track < report->track_count; ++list.track )
        add_lines( &list, json_object_get( report->tracks[list.track].sequence.render, "export_losses" ), true );
    for ( list.track = 0; list.track < report->track_count; ++list.track )
    {
        char text[RF_DAMAGE_SIZE];
        const RfPageTrack* track = report->tracks + list.track;
        const RfFilePasses* passes = &track->layers.passes;
        RfFilePasses left_out = { passes->passes + track->layers.count, passes->count - track->layers.count, NULL };
        add_reported( &list, track->sequence.render );
        add_absent( &list, track );
        if ( rf_format_damage( track, text ) )
            warn( &list, "%s", text );
        add_doubts( &list, track );
        rf_name_passes( &left_out, text, 512 );
        if ( left_out.count > 0 )
            warn( &list, "passes that are not on this page: %s", text );
        add_lines( &list, json_object_get( track->sequence.render, "export_warnings" ), false );
    }
    return list.json;
}

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

void rf_format_bytes( double bytes, char text[32] )
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
    char text[2 * LONGEST];
    va_list arguments;
    va_start( arguments, format );
    vsnprintf( text, sizeof text, format, arguments );
    va_end( arguments );
    json_array_append_new( facts,
                           json_pack( "[o, o, o]", rf_json_text( group ), rf_json_text( label ), cut_text( text, FACT_SIZE ) ) );
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

// What they are of: only the frames that the last run rendered have their costs in the JSON.
static int add_rendered( json_t* facts, const json_t* render )
{
    size_t i;
    const json_t* row;
    int all = (int)json_array_size( json_object_get( render, "frames" ) ), kept = 0;
    bool interrupted = json_is_true( json_object_get( render, "interrupted" ) );
    char more[64] = "";
    json_array_foreach( json_object_get( render, "frames" ), i, row ) kept += json_is_true( json_object_get( row, "kept" ) );
    if ( kept > 0 )
        snprintf( more, sizeof more, "; %d kept from before", kept );
    if ( kept > 0 || interrupted )
        add_fact( facts, "Cost", "Totals", "of %d frame%s rendered last%s%s", all - kept, all - kept == 1 ? "" : "s",
                  interrupted ? ", then interrupted" : "", more );
    return interrupted ? 0 : all - kept;
}

static void add_costs( json_t* facts, const json_t* render )
{
    double seconds = rf_json_number_of( render, "seconds" ), rays = 0.0;
    const char* key;
    json_t* value;
    if ( render == NULL )
        return;
    int count = add_rendered( facts, render );
    json_object_foreach( json_object_get( render, "rays" ), key, value ) rays += json_number_value( value );
    add_number( facts, "Cost", "Time", seconds, format_seconds );
    if ( count > 0 ) // else the time of unfinished frames is in it
        add_number( facts, "Cost", "Time a frame", seconds / count, format_seconds );
    add_number( facts, "Cost", "Tasks", rf_json_number_of( render, "tasks" ), format_count );
    add_number( facts, "Cost", "Threads", rf_json_number_of( render, "threads" ), format_count );
    add_number( facts, "Cost", "Memory, peak", rf_json_number_of( render, "peak_bytes" ), rf_format_bytes );
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
    add_number( facts, "Error", "Flicker: F1", track->flicker.pairs > 0 ? flicker.f1 : (double)NAN, format_three );
}

static void add_progress( json_t* facts, const json_t* progress )
{
    char label[240];
    size_t i;
    const json_t* task;
    json_array_foreach( json_object_get( progress, "tasks" ), i, task )
    {
        snprintf( label, sizeof label, "Task %zu: %.200s", i, json_string_value( json_object_get( task, "frames" ) ) );
        if ( i < MOST_LINES )
            add_fact( facts, "Progress", label, "%.0f of %.0f", rf_json_number_of( task, "finished" ),
                      rf_json_number_of( task, "count" ) );
    }
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

json_t* rf_page_facts_json( const RfPageTrack* track )
{
    const RfPageSequence* sequence = &track->sequence;
    Strings strings = { .facts = json_array() };
    add_picture( strings.facts, track );
    add_fact( strings.facts, "Picture", "Files", "%s", sequence->input.pattern );
    add_error( strings.facts, track );
    add_costs( strings.facts, sequence->render );
    add_range( strings.facts, "Samples a pixel", track, offsetof( RfPageFrame, samples ) );
    add_range( strings.facts, "Effective samples a pixel", track, offsetof( RfPageFrame, effective ) );
    add_progress( strings.facts, sequence->progress );
    rf_list_exr_strings( sequence->first, take_string, &strings, NULL );
    return strings.facts;
}

static bool is_compared( const RfPageTrack* track )
{
    bool has_error = false;
    for ( int i = 0; i < track->run->count; ++i )
        has_error |= isgreater( track->frames[i].relmse, 0.0 );
    return has_error && !track->sequence.is_reference;
}

// True if every compared sequence has an error in this frame, and with `least` >= 0 seconds of at least that.
static bool is_common( const RfPageRun* report, int frame, double least )
{
    for ( int i = 0; i < report->track_count; ++i )
    {
        const RfPageFrame* figures = report->tracks[i].frames + frame;
        if ( is_compared( report->tracks + i ) &&
             ( !isgreater( figures->relmse, 0.0 ) || ( least >= 0.0 && !isgreaterequal( figures->seconds, least ) ) ) )
            return false;
    }
    return true;
}

// A sequence over the frames that all compared sequences have.
typedef struct Entry
{
    int index;
    double relmse, score; // means: of the error, and where times can be compared of error times seconds
    int bounds;           // estimates of its error that are lower bounds
} Entry;

// The sequences that need least and most time for the same error, or have the least and the most error.
typedef struct Contest
{
    Entry best, worst;
    int compared, frames; // sequences and frames
    int threads; // of every sequence; 0: they differ, or are not known, and wall-clock seconds say nothing about each other
    bool with_seconds;
} Contest;

static Entry enter( const RfPageRun* report, const Contest* c, int index )
{
    const RfPageFrame* frames = report->tracks[index].frames;
    Entry entry = { .index = index };
    double seconds = 0.0;
    for ( int i = 0; i < report->count; ++i )
    {
        entry.bounds += frames[i].at_least;
        if ( !is_common( report, i, c->with_seconds ? 0.0 : -1.0 ) ) // repeated frames take no time
            continue;
        entry.relmse += frames[i].relmse / c->frames;
        seconds += frames[i].seconds / c->frames;
    }
    entry.score = c->with_seconds ? entry.relmse * seconds : entry.relmse;
    return entry;
}

static Contest hold_contest( const RfPageRun* report )
{
    Contest c = { .threads = -1 };
    for ( int i = 0; i < report->track_count; ++i )
    {
        double threads = rf_json_number_of( report->tracks[i].sequence.render, "threads" );
        int known = isgreaterequal( threads, 1.0 ) ? (int)threads : 0;
        if ( is_compared( report->tracks + i ) )
            c.threads = c.threads == -1 || c.threads == known ? known : 0;
    }
    for ( int i = 0; i < report->count && c.threads > 0; ++i )
        c.with_seconds |= is_common( report, i, 1e-9 );
    for ( int i = 0; i < report->count; ++i )
        c.frames += is_common( report, i, c.with_seconds ? 0.0 : -1.0 );
    for ( int i = 0; i < report->track_count; ++i )
    {
        if ( !is_compared( report->tracks + i ) )
            continue;
        Entry entry = enter( report, &c, i );
        c.best = c.compared == 0 || entry.score < c.best.score ? entry : c.best;
        c.worst = c.compared == 0 || entry.score >= c.worst.score ? entry : c.worst;
        c.compared += 1;
    }
    return c;
}

static void compare_words( const RfPageRun* report, const Contest* c, char* text, size_t size )
{
    const char *best = report->tracks[c->best.index].sequence.name, *worst = report->tracks[c->worst.index].sequence.name;
    double times = c->worst.score / c->best.score;
    char ratio[48]; // with what lower bounds leave of it
    snprintf( ratio, sizeof ratio, times < 9.95 ? "%s%.2g" : "%s%.0f",
              c->best.bounds > 0 && c->worst.bounds > 0 ? "about "
              : c->best.bounds > 0                      ? "at most "
              : c->worst.bounds > 0                     ? "at least "
                                                        : "",
              times );
    if ( times < 1.05 )
        snprintf( text, size,
                  c->with_seconds ? "%.200s and %.200s are about equally fast at equal noise"
                                  : "%.200s and %.200s are about equally noisy",
                  best, worst );
    else if ( c->with_seconds )
        snprintf( text, size, "%.200s is %s times faster than %.200s at equal noise", best, ratio, worst );
    else
        snprintf( text, size, "%.200s has %s times the relMSE of %.200s", worst, ratio, best );
}

// One sequence: how noisy it is.
static void single_words( const RfPageRun* report, const Contest* c, char* text, size_t size )
{
    const json_t* frames = json_object_get( report->tracks[c->best.index].sequence.render, "frames" );
    json_t* specks = report->reference != NULL ? NULL : rf_sum_specks( frames );
    char percent[RF_NOISE_TEXT_SIZE];
    rf_format_noise( c->best.relmse, percent );
    if ( !rf_format_specks( specks, text, size ) )
        snprintf( text, size, "%s %s noise (relMSE %.3g)", c->best.bounds > 0 ? "At least" : "About", percent, c->best.relmse );
    json_decref( specks );
}

static void basis_words( const RfPageRun* report, const Contest* c, char* text, size_t size )
{
    int bounds = 0;
    for ( int i = 0; i < report->track_count; ++i )
        bounds += enter( report, c, i ).bounds;
    size_t used =
        (size_t)snprintf( text, size, "%s, mean of %d frame%s",
                          report->reference != NULL ? "relMSE against the reference" : "relMSE estimated by the renderer",
                          c->frames, c->frames == 1 ? "" : "s" );
    if ( c->compared > 1 && c->with_seconds )
        used += (size_t)snprintf( text + used, size - used, "; wall-clock time, %d thread%s each", c->threads,
                                  c->threads == 1 ? "" : "s" );
    else if ( c->compared > 1 )
        used += (size_t)snprintf( text + used, size - used,
                                  "; times are not compared: that needs render --json with the same number of threads" );
    if ( bounds > 0 )
        snprintf( text + used, size - used, "; %d estimate%s a lower bound: --reference gives the true error", bounds,
                  bounds == 1 ? " is" : "s are" );
}

// The index of the frame with the largest error of the sequence that the verdict is about; -1: not known.
static int worst_frame( const RfPageRun* report, const Contest* c )
{
    int worst = -1;
    const RfPageFrame* frames = report->tracks[c->best.index].frames;
    for ( int i = 0; i < report->count; ++i )
    {
        if ( isgreater( frames[i].relmse, 0.0 ) && ( worst < 0 || frames[i].relmse > frames[worst].relmse ) )
            worst = i;
    }
    return worst;
}

json_t* rf_page_verdict_json( const RfPageRun* report )
{
    char text[768] = "The error is unknown",
         basis[512] = "--reference measures it; render writes its estimate into the frames and its JSON";
    Contest c = hold_contest( report );
    bool known = c.compared > 0 && c.frames > 0;
    int worst = known ? worst_frame( report, &c ) : -1;
    if ( known )
    {
        ( c.compared > 1 ? compare_words : single_words )( report, &c, text, sizeof text );
        basis_words( report, &c, basis, sizeof basis );
    }
    bool names = worst >= 0 && report->count > 1;
    return json_pack( "{s:o, s:s, s:o}", "text", rf_json_text( text ), "basis", basis, "worst_frame",
                      names ? json_integer( report->numbers[worst] ) : json_null() );
}
