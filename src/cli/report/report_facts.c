#include "cli/report/report_facts.h"

#include "cli/report/report_numbers.h"
#include "cli/report/report_tasks.h"
#include "cli/options/render_options.h"
#include "cli/messages.h"
#include "image/sequence.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_STRINGS 24 // of other programs
#define LONGEST 240     // characters of a value

static void add( json_t* facts, const char* group, const char* label, const char* value )
{
    char cut[LONGEST + 4];
    snprintf( cut, sizeof cut, "%.*s%s", LONGEST, value, strlen( value ) > LONGEST ? "..." : "" );
    json_t* row = json_array();
    json_array_append_new( row, rf_json_text( group ) );
    json_array_append_new( row, rf_json_text( label ) );
    json_array_append_new( row, rf_json_text( cut ) );
    json_array_append_new( facts, row );
}

static void add_number( json_t* facts, const char* group, const char* label, const char* format, double value )
{
    char text[64];
    snprintf( text, sizeof text, format, value );
    if ( isfinite( value ) )
        add( facts, group, label, text );
}

// "3, 4, 8-12"
static void add_missing( json_t* facts, const RfPageTrack* track )
{
    char text[LONGEST];
    int count;
    int* missing = rf_page_missing_frames( track, &count );
    rf_format_frames( missing, count, text, sizeof text );
    if ( count > 0 )
        add( facts, "Picture", "Missing", text );
    free( missing );
}

// "48, from 1 to 48"
static void add_frames( json_t* facts, const RfPageTrack* track )
{
    int shown = 0, first = 0, last = 0;
    size_t bad = 0;
    for ( int i = 0; i < track->count; ++i )
    {
        if ( !track->frames[i].shown )
            continue;
        first = shown == 0 ? track->numbers[i] : first;
        last = track->numbers[i];
        bad += track->frames[i].bad;
        ++shown;
    }
    char text[96];
    snprintf( text, sizeof text, "%d, from %d to %d", shown, first, last );
    add( facts, "Picture", "Frames", text );
    if ( track->sequence->progress == NULL )
        add_missing( facts, track );
    if ( bad > 0 )
        add_number( facts, "Picture", "No numbers", "%.0f pixels with NaN or infinity", (double)bad );
}

static void add_picture( json_t* facts, const RfPageTrack* track )
{
    const RfExrHeader* header = &track->sequence->header;
    char text[96];
    add_frames( facts, track );
    snprintf( text, sizeof text, "%d x %d", header->width, header->height );
    add( facts, "Picture", "Size", text );
    if ( track->picture_width != header->width )
    {
        snprintf( text, sizeof text, "%d x %d", track->picture_width, track->picture_height );
        add( facts, "Picture", "Shown as", text );
    }
    if ( header->fps_numerator > 0 )
        add_number( facts, "Picture", "Frames/s", "%.5g", (double)header->fps_numerator / header->fps_denominator );
}

// The renderer's estimate; where it is no more than a lower bound it says so.
static void add_estimate( json_t* facts, const RfPageTrack* track )
{
    bool at_least = false;
    double share = 0.0;
    for ( int i = 0; i < track->count; ++i )
    {
        at_least |= track->frames[i].at_least;
        share = fmax( share, track->frames[i].worst_ten_share ); // passes over NaN
    }
    add_number( facts, "Error", "relMSE, estimated", at_least ? "at least %.3g" : "%.3g", track->estimate );
    if ( share > 0.0 && isfinite( track->estimate ) )
        add_number( facts, "Error", "Share of the ten worst pixels", "up to %.0f %%", 100.0 * share );
}

static void add_error( json_t* facts, const RfPageTrack* track )
{
    const RfErrorMetrics* e = &track->error;
    char text[96];
    if ( track->has_error && isfinite( e->relmse ) )
    {
        add_number( facts, "Error", "relMSE", "%.3g", e->relmse );
        add_number( facts, "Error", "without the worst 0.1 %", "%.3g", e->relmse_trimmed );
        add_number( facts, "Error", "Noise of a channel", "%.2g %%", 100.0 * sqrt( e->relmse / 3.0 ) );
        bool relative = e->reference_mean > 0.0;
        double scale = relative ? 100.0 / e->reference_mean : 1.0;
        snprintf( text, sizeof text, "%+.2g%s (95 %%: %+.2g to %+.2g%s)", e->bias * scale, relative ? " %" : "",
                  e->bias_low * scale, e->bias_high * scale, relative ? " %" : "" );
        add( facts, "Error", "Mean error", text );
    }
    add_estimate( facts, track );
    RfFlickerMetrics flicker = rf_flicker_metrics( &track->flicker );
    if ( track->flicker.pairs == 0 )
        return;
    add_number( facts, "Error", "Flicker: phi", "%.3f", flicker.phi );
    add_number( facts, "Error", "Flicker: F1", "%.3g", flicker.f1 );
    if ( track->compensated )
        add_number( facts, "Error", "Flicker: coverage", "%.2f %%", 100.0 * flicker.coverage );
    if ( track->followed.pairs > 0 )
        add_number( facts, "Error", "Flicker along the motion: phi", "%.3f", rf_flicker_metrics( &track->followed ).phi );
}

// Pairs whose files lack the layers of the first file have no flicker along the motion.
static void add_pairs( json_t* facts, const RfPageTrack* track )
{
    char text[96];
    int pairs = track->follows ? track->followed.pairs : track->flicker.pairs;
    if ( pairs == track->pair_count )
        return;
    snprintf( text, sizeof text, "%d of %d pairs, the other frames lack the layers", pairs, track->pair_count );
    add( facts, "Error", track->follows ? "Flicker along the motion: of" : "Flicker: of", text );
}

// Attributes that Reframe writes into its files, in the order of the table.
static const struct
{
    const char *attribute, *group, *label;
} s_known[] = {
    { "reframe/scene", "Scene", "Scene" },
    { "reframe/camera", "Scene", "Camera" },
    { "reframe/group", "Settings", "Group" },
    { "reframe/tile", "Settings", "Tile" },
    { "reframe/adaptive", "Settings", "Adaptive" },
    { "reframe/filter", "Settings", "Pixel filter" },
    { "reframe/filter-width", "Settings", "Filter width" },
    { "reframe/weights", "Settings", "Weights" },
    { "reframe/noise", "Settings", "Wanted relMSE" },
    { "reframe/flicker", "Settings", "Wanted F1" },
    { "reframe/time", "Settings", "Wanted seconds" },
    { "reframe/normalize", "Settings", "Normalisation" },
    { "reframe/max-depth", "Settings", "Depth" },
    { "reframe/light-samples", "Settings", "Light samples" },
    { "reframe/seed", "Settings", "Seed" },
    { "reframe/aov", "Settings", "Layers" },
    { "reframe/version", "Settings", "Reframe" },
    { "reframe/device", "Settings", "Device" },
};

static void add_known( json_t* facts, const char* path, const char* group )
{
    char value[LONGEST + 16];
    for ( size_t i = 0; i < sizeof s_known / sizeof s_known[0]; ++i )
    {
        if ( strcmp( s_known[i].group, group ) == 0 &&
             rf_read_exr_string( path, s_known[i].attribute, value, sizeof value, NULL ) == RF_OK )
            add( facts, group, s_known[i].label, value );
    }
}

static void format_samples( double samples, char text[32] )
{
    snprintf( text, 32, isless( samples, 1000.0 ) ? "%.4g" : "%.0f", samples );
}

// Samples traced, least and most of all frames; with --noise and --time also their limit,
// where it is known.
static void add_samples( json_t* facts, const RfPageTrack* track )
{
    const char* first = track->sequence->first;
    double least = INFINITY, most = -INFINITY, asked = rf_read_exr_number( first, "reframe/spp" );
    double noise = rf_read_exr_number( first, "reframe/noise" ), flicker = rf_read_exr_number( first, "reframe/flicker" ),
           time = rf_read_exr_number( first, "reframe/time" );
    for ( int i = 0; i < track->count; ++i )
    {
        least = fmin( least, track->frames[i].samples );
        most = fmax( most, track->frames[i].samples );
    }
    char parts[3][32], text[128] = "";
    format_samples( least, parts[0] );
    format_samples( most, parts[1] );
    format_samples( asked, parts[2] );
    bool is_bound = isgreater( noise, 0.0 ) || isgreater( flicker, 0.0 ) || isgreater( time, 0.0 ),
         is_said = asked != rf_default_most_spp( noise, flicker );
    if ( islessequal( least, most ) ) // where the frames tell
        snprintf( text, sizeof text, strcmp( parts[0], parts[1] ) == 0 ? "%s" : "%s to %s", parts[0], parts[1] );
    else if ( isgreater( asked, 0.0 ) && !is_bound )
        snprintf( text, sizeof text, "%s", parts[2] );
    size_t used = strlen( text );
    if ( isgreater( asked, 0.0 ) && is_bound && is_said )
        snprintf( text + used, sizeof text - used, "%sat most %s", used > 0 ? ", " : "", parts[2] );
    if ( text[0] != '\0' )
        add( facts, "Settings", "Samples a pixel", text );
}

typedef struct Strings
{
    json_t* facts;
    int count;
} Strings;

static void take_string( void* user, const char* name, const char* value )
{
    Strings* strings = user;
    bool is_plain = strcmp( name, "type" ) == 0 || strcmp( name, "name" ) == 0; // of the part: nothing that a person looks for
    if ( !is_plain && strncmp( name, "reframe/", 8 ) != 0 && strings->count++ < MOST_STRINGS )
        add( strings->facts, "Header", name, value );
}

static void add_effects( json_t* facts, const json_t* render )
{
    char text[LONGEST + 16] = "";
    size_t i;
    const json_t* name;
    json_array_foreach( json_object_get( render, "effects" ), i, name )
    {
        size_t used = strlen( text );
        if ( json_is_string( name ) )
            snprintf( text + used, sizeof text - used, "%s%s", used > 0 ? ", " : "", json_string_value( name ) );
    }
    if ( text[0] != '\0' )
        add( facts, "Scene", "Effects", text );
}

typedef void Format( double value, char text[32] );

static void add_formatted( json_t* facts, const char* group, const char* label, double value, Format* format )
{
    char text[32];
    if ( !isfinite( value ) || value < 0.0 )
        return;
    format( value, text );
    add( facts, group, label, text );
}

// How many frames the last run rendered, where that is not all: the totals of the group
// are of these only.
static int add_rendered( json_t* facts, const json_t* render, const char* group )
{
    size_t i;
    const json_t* row;
    int all = (int)json_array_size( json_object_get( render, "frames" ) ), kept = 0;
    bool interrupted = json_is_true( json_object_get( render, "interrupted" ) );
    json_array_foreach( json_object_get( render, "frames" ), i, row ) kept += json_is_true( json_object_get( row, "kept" ) );
    char text[128];
    snprintf( text, sizeof text, "of %d frame%s rendered last%s", all - kept, all - kept == 1 ? "" : "s",
              interrupted ? ", then interrupted" : "" );
    size_t used = strlen( text );
    if ( kept > 0 )
        snprintf( text + used, sizeof text - used, "; %d kept from before", kept );
    if ( kept > 0 || interrupted )
        add( facts, group, "Totals", text );
    return all - kept;
}

static void add_costs( json_t* facts, const json_t* render )
{
    static const char* const rays[][2] = { { "primary", "From the camera" },
                                           { "path", "Paths" },
                                           { "shadow", "To lights" },
                                           { "tile", "Within tiles" },
                                           { "eye", "To other eyes" } };
    double seconds = rf_json_number_of( render, "seconds" ), all = 0.0;
    int count = add_rendered( facts, render, "Time and memory" );
    add_number( facts, "Time and memory", "Added up over tasks", "%.0f", rf_json_number_of( render, "tasks" ) );
    add_formatted( facts, "Time and memory", "In all", seconds, rf_format_seconds );
    add_formatted( facts, "Time and memory", "Loading the scene", rf_json_number_of( render, "seconds_scene" ),
                   rf_format_seconds );
    if ( count == 0 ) // nothing to count
        return;
    if ( !json_is_true( json_object_get( render, "interrupted" ) ) ) // else the time of unfinished frames is in it
        add_formatted( facts, "Time and memory", "A frame", seconds / count, rf_format_seconds );
    add_formatted( facts, "Time and memory", "Threads", rf_json_number_of( render, "threads" ), rf_format_count );
    add_formatted( facts, "Time and memory", "Memory, peak", rf_json_number_of( render, "peak_bytes" ), rf_format_bytes );
    add_formatted( facts, "Time and memory", "Memory, budget", rf_json_number_of( render, "budget_bytes" ), rf_format_bytes );
    add_rendered( facts, render, "Rays" );
    for ( size_t i = 0; i < sizeof rays / sizeof rays[0]; ++i )
    {
        double number = rf_json_number_of( json_object_get( render, "rays" ), rays[i][0] );
        all += isfinite( number ) ? number : 0.0;
        add_formatted( facts, "Rays", rays[i][1], number, rf_format_count );
    }
    add_formatted( facts, "Rays", "In all", all, rf_format_count );
    if ( seconds > 0.0 )
        add_formatted( facts, "Rays", "A second", all / seconds, rf_format_count );
}

json_t* rf_page_facts_json( const RfPageTrack* track )
{
    const RfPageSequence* sequence = track->sequence;
    json_t* facts = json_array();
    add_picture( facts, track );
    if ( sequence->progress != NULL )
        rf_add_progress_facts( facts, sequence->progress );
    add_error( facts, track );
    add_pairs( facts, track );
    add_known( facts, sequence->first, "Scene" );
    add_effects( facts, sequence->render );
    add_samples( facts, track );
    add_known( facts, sequence->first, "Settings" );
    if ( sequence->render != NULL )
        add_costs( facts, sequence->render );
    add( facts, "Header", "Files", sequence->pattern );
    Strings strings = { .facts = facts };
    rf_list_exr_strings( sequence->first, take_string, &strings, NULL );
    return facts;
}
