// Facts of a sequence on the page: settings, costs, rays, samples, warnings, and what accuracy costs.
#include "cli/report/report_facts.h"

#include "cli/messages.h"
#include "cli/render/changes_json.h"
#include "cli/render/specks_json.h"
#include "cli/options/render_options.h"
#include "cli/report/report_command.h"
#include "cli/report/report_frames.h"
#include "cli/report/report_input.h"
#include "image/sequence.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define FACT_SIZE 240 // characters of a value; the rest is cut

#define MOST_LINES 100 // of a sequence
#define LONGEST 600    // characters of a line

typedef struct List
{
    json_t* json;
    int track;
} List;

static void add( const List* list, const char* text )
{
    char cut[LONGEST + 4];
    snprintf( cut, sizeof cut, "%.*s%s", LONGEST, text, strlen( text ) > LONGEST ? "..." : "" );
    json_array_append_new( list->json,
                           json_pack( "{s:i, s:o, s:b}", "sequence", list->track, "text", rf_json_text( cut ), "loss", 0 ) );
}

// What the export lost of the picture: all of it, in full.
static void add_losses( const List* list, const json_t* render )
{
    size_t i;
    json_t* line;
    json_array_foreach( json_object_get( render, "export_losses" ), i, line )
    {
        if ( json_is_string( line ) )
            json_array_append_new( list->json, json_pack( "{s:i, s:O, s:b}", "sequence", list->track, "text", line, "loss", 1 ) );
    }
}

static void add_lines( const List* list, const json_t* lines )
{
    size_t i;
    const json_t* line;
    json_array_foreach( lines, i, line )
    {
        if ( json_is_string( line ) && i < MOST_LINES )
            add( list, json_string_value( line ) );
    }
}

// What render --json repeats of the scene's loading and of the render.
static void add_reported( const List* list, const json_t* render )
{
    add_lines( list, json_object_get( render, "warnings" ) );
    double missed = rf_json_number_of( json_object_get( render, "noise" ), "missed" );
    char text[128];
    snprintf( text, sizeof text, "--noise was not reached in %.0f frame%s", missed, missed == 1.0 ? "" : "s" );
    if ( isgreater( missed, 0.0 ) && json_object_get( render, "warnings" ) == NULL )
        add( list, text );
    if ( json_is_true( json_object_get( render, "interrupted" ) ) )
        add( list, "the render was interrupted: --resume continues it" );
}

// Of a render that other machines are at: no fault.
static void add_unfinished( const List* list, const json_t* progress )
{
    char frames[240], text[400];
    const json_t* left = json_object_get( progress, "left" );
    rf_format_left( left, frames, sizeof frames );
    snprintf( text, sizeof text, "still rendering: %.0f of %.0f frames are finished, missing %s",
              rf_json_number_of( progress, "finished" ), rf_json_number_of( progress, "asked" ), frames );
    if ( json_array_size( left ) > 0 )
        add( list, text );
}

static void warn_of_missing( const List* list, const RfPageTrack* track )
{
    char frames[240], text[300];
    int count;
    int* missing = rf_page_missing_frames( track, &count );
    rf_format_frames( missing, count, frames, sizeof frames );
    snprintf( text, sizeof text, "%s missing: %s", count == 1 ? "a frame is" : "frames are", frames );
    if ( count > 0 )
        add( list, text );
    free( missing );
}

static void add_damage( const List* list, const RfPageTrack* track )
{
    char text[RF_DAMAGE_SIZE];
    if ( rf_format_damage( track, text ) )
        add( list, text );
}

static void add_bad( const List* list, const RfPageTrack* track )
{
    size_t bad = 0;
    int first = -1, count = 0;
    for ( int i = 0; i < track->count; ++i )
    {
        bad += track->frames[i].bad;
        count += track->frames[i].bad > 0;
        first = first < 0 && track->frames[i].bad > 0 ? i : first;
    }
    char text[160];
    if ( first < 0 )
        return;
    snprintf( text, sizeof text, "%zu pixel%s NaN or infinite, in %d frame%s from %d on; NaN is shown in magenta", bad,
              bad == 1 ? " is" : "s are", count, count == 1 ? "" : "s", track->numbers[first] );
    add( list, text );
}

// Where the JSON of the render warns of them, it has been reported already.
static void add_clipped( const List* list, const RfPageTrack* track )
{
    size_t clipped = 0;
    int count = 0;
    for ( int i = 0; i < track->count; ++i )
    {
        clipped += track->frames[i].clipped;
        count += track->frames[i].clipped > 0;
    }
    char text[160];
    snprintf( text, sizeof text, "%zu pixel%s clipped by the range of the file's channels, in %d frame%s", clipped,
              clipped == 1 ? " is" : "s are", count, count == 1 ? "" : "s" );
    if ( count > 0 && track->sequence->render == NULL )
        add( list, text );
}

// Estimates of heavy-tailed noise.
static void add_bounds( const List* list, const RfPageTrack* track )
{
    int count = 0;
    double most = 0.0;
    for ( int i = 0; i < track->count; ++i )
    {
        count += track->frames[i].at_least;
        most = fmax( most, track->frames[i].worst_ten_share ); // fmax passes over NaN
    }
    char text[240];
    if ( count == 0 )
        return;
    int used =
        snprintf( text, sizeof text, "the estimated relMSE is a lower bound in %d of %d frame%s: few pixels carry much of it",
                  count, track->count, track->count == 1 ? "" : "s" );
    if ( most > 0.0 )
        snprintf( text + used, sizeof text - (size_t)used, " (the ten worst up to %.0f %%)", 100.0 * most );
    add( list, text );
}

static void warn_of_passes( const List* list, const RfPageTrack* track )
{
    char text[640];
    snprintf( text, sizeof text, "passes that are not on this page: %s", track->layers.left_out );
    if ( track->layers.left_out[0] != '\0' )
        add( list, text );
}

json_t* rf_page_warnings_json( const RfPageData* data )
{
    List list = { .json = json_array() };
    for ( list.track = 0; list.track < data->track_count; ++list.track )
        add_losses( &list, data->tracks[list.track].sequence->render );
    for ( list.track = 0; list.track < data->track_count; ++list.track )
    {
        const RfPageTrack* track = data->tracks + list.track;
        add_reported( &list, track->sequence->render );
        if ( track->sequence->progress != NULL )
            add_unfinished( &list, track->sequence->progress );
        else
            warn_of_missing( &list, track );
        add_damage( &list, track );
        add_bad( &list, track );
        add_clipped( &list, track );
        add_bounds( &list, track );
        warn_of_passes( &list, track );
        add_lines( &list, json_object_get( track->sequence->render, "export_warnings" ) );
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

// Appends a row.
static void add_fact( json_t* facts, const char* group, const char* label, const char* value )
{
    char cut[FACT_SIZE + 4];
    snprintf( cut, sizeof cut, "%.*s%s", FACT_SIZE, value, strlen( value ) > FACT_SIZE ? "..." : "" );
    json_t* row = json_array();
    json_array_append_new( row, rf_json_text( group ) );
    json_array_append_new( row, rf_json_text( label ) );
    json_array_append_new( row, rf_json_text( cut ) );
    json_array_append_new( facts, row );
}

// Appends a row with a number, by a format of printf; none for NaN and infinity.
static void add_fact_number( json_t* facts, const char* group, const char* label, const char* format, double value )
{
    char text[64];
    snprintf( text, sizeof text, format, value );
    if ( isfinite( value ) )
        add_fact( facts, group, label, text );
}

static RfResult refuse( const char* file, const json_t* cost, const RfPageSequence* sequence, const char* what_to_do,
                        RfError* error )
{
    return rf_fail( error, RF_ERROR_USAGE, "%.300s: is of the scene %.200s, and the frames %.300s are of %.200s: %s", file,
                    rf_scene_of_json( cost ), sequence->pattern, sequence->scene, what_to_do );
}

RfResult rf_check_cost_scene( const RfPageRun* report, RfError* error )
{
    bool fits = report->cost == NULL;
    for ( int i = 0; i < report->place_count && !fits; ++i )
        fits = rf_is_same_scene( rf_scene_of_json( report->cost ), report->sequences[i].scene );
    if ( !fits )
        return refuse( report->cost_file, report->cost, report->sequences, "give --cost what was measured with this scene",
                       error );
    for ( int i = 0; i < report->place_count && report->cost == NULL; ++i )
    {
        const RfPageSequence* sequence = report->sequences + i;
        if ( sequence->cost != NULL && !rf_is_same_scene( rf_scene_of_json( sequence->cost ), sequence->scene ) )
            return refuse( sequence->cost_file, sequence->cost, sequence,
                           "move it out of the folder, or give --cost what was measured with this scene", error );
    }
    return RF_OK;
}

// "9.1 times faster"; "1.3 times slower" for a speedup below 1; "about as fast" around it.
static void format_speedup( double speedup, char text[48] )
{
    double times = speedup < 1.0 ? 1.0 / speedup : speedup;
    if ( times < 1.05 )
    {
        snprintf( text, 48, "about as fast" );
        return;
    }
    snprintf( text, 48, times < 10.0 ? "%.2g times %s" : "%.0f times %s", times, speedup < 1.0 ? "slower" : "faster" );
}

// "reuse is 4.5 times faster at equal error (95 %: 4 to 5)"; where the interval holds 1, it says which way: "2 times slower
// to 1.2 times faster"
static void append_speedup( char* text, size_t size, const json_t* cost )
{
    double speedup = rf_json_number_of( cost, "speedup_at_equal_error" ), low = rf_json_number_of( cost, "speedup_low" ),
           high = rf_json_number_of( cost, "speedup_high" );
    char words[3][48];
    size_t used = strlen( text );
    if ( !( speedup > 0.0 ) )
        return;
    format_speedup( speedup, words[0] );
    snprintf( text + used, size - used, "%sreuse is %s at equal error", used > 0 ? "; " : "", words[0] );
    if ( !( low > 0.0 && high > 0.0 ) )
        return;
    used = strlen( text );
    bool is_slower = low < 1.0 && high < 1.0;
    if ( is_slower || ( low >= 1.0 && high >= 1.0 ) )
    {
        snprintf( text + used, size - used, " (95 %%: %.2g to %.2g)", is_slower ? 1.0 / high : low,
                  is_slower ? 1.0 / low : high );
        return;
    }
    format_speedup( low, words[1] );
    format_speedup( high, words[2] );
    snprintf( text + used, size - used, " (95 %%: %s to %s)", words[1], words[2] );
}

static void append_slope( char* text, size_t size, const json_t* cost )
{
    double slope = rf_json_number_of( cost, "slope" ), low = rf_json_number_of( cost, "slope_low" ),
           high = rf_json_number_of( cost, "slope_high" );
    size_t used = strlen( text );
    if ( isfinite( slope ) && isfinite( low ) && isfinite( high ) )
        snprintf( text + used, size - used, "%srelMSE falls as time^%.2f (%.2f to %.2f)", used > 0 ? "; " : "", slope, low,
                  high );
}

// The label of a row of cost: "path tracing", "group 3, tile 3x3".
static json_t* row_name_json( const json_t* row )
{
    const json_t *reuse = json_object_get( row, "reuse" ), *group = json_object_get( row, "group" );
    const char* tile = json_string_value( json_object_get( row, "tile" ) );
    char text[96];
    if ( json_is_string( reuse ) )
        return json_incref( (json_t*)reuse );
    if ( json_is_true( reuse ) && json_is_integer( group ) )
    {
        snprintf( text, sizeof text, "group %lld%s%.32s", (long long)json_integer_value( group ), tile != NULL ? ", tile " : "",
                  tile != NULL ? tile : "" );
        return rf_json_text( text );
    }
    return json_is_boolean( reuse ) ? json_string( json_is_true( reuse ) ? "with reuse" : "path tracing" ) : NULL;
}

// Copies only what the script needs, so that other content of the file can do no harm.
static void add_cost( json_t* list, const char* name, const json_t* cost )
{
    if ( cost == NULL )
        return;
    const char* verdict = json_string_value( json_object_get( cost, "verdict" ) );
    char note[640] = "";
    if ( verdict != NULL )
        snprintf( note, sizeof note, "%.400s", verdict );
    else
        append_speedup( note, sizeof note, cost );
    append_slope( note, sizeof note, cost );
    json_t* rows = json_array();
    size_t i;
    json_t* row;
    json_array_foreach( json_object_get( cost, "rows" ), i, row )
    {
        const json_t *seconds = json_object_get( row, "seconds" ), *relmse = json_object_get( row, "relmse" );
        json_t* reuse = row_name_json( row );
        if ( reuse != NULL && json_is_number( seconds ) && json_is_number( relmse ) )
            json_array_append_new( rows, json_pack( "{s:O, s:o, s:o}", "reuse", reuse, "seconds",
                                                    rf_json_number( json_number_value( seconds ) ), "relmse",
                                                    rf_json_number( json_number_value( relmse ) ) ) );
        json_decref( reuse );
    }
    json_array_append_new(
        list, json_pack( "{s:o, s:o, s:o}", "name", rf_json_text( name ), "note", rf_json_text( note ), "rows", rows ) );
}

json_t* rf_page_cost_json( const RfPageData* data )
{
    json_t* list = json_array();
    add_cost( list, "error against time", data->cost );
    for ( int i = 0; i < data->track_count && data->cost == NULL; ++i )
    {
        const RfPageSequence* sequence = data->tracks[i].sequence;
        add_cost( list, sequence->name, sequence->is_reference ? NULL : sequence->cost );
    }
    return list;
}

// Appends the names of the effects.
static void add_effects( json_t* facts, const json_t* render )
{
    char text[FACT_SIZE + 16] = "";
    size_t i;
    const json_t* name;
    json_array_foreach( json_object_get( render, "effects" ), i, name )
    {
        size_t used = strlen( text );
        if ( json_is_string( name ) )
            snprintf( text + used, sizeof text - used, "%s%s", used > 0 ? ", " : "", json_string_value( name ) );
    }
    if ( text[0] != '\0' )
        add_fact( facts, "Scene", "Effects", text );
}

#define MOST_MOVING 10 // objects named

// What moves and changes, and how its light is shared.
static void add_changes( json_t* facts, const json_t* render )
{
    const json_t *moving = json_object_get( render, "moving" ), *sharing = json_object_get( render, "sharing" ), *row;
    char text[RF_CHANGE_TEXT] = "", label[128];
    size_t i, count = json_array_size( moving );
    json_array_foreach( moving, i, row )
    {
        size_t used = strlen( text );
        if ( json_is_string( row ) && i < MOST_MOVING )
            snprintf( text + used, sizeof text - used, "%s%.32s", i > 0 ? ", " : "", json_string_value( row ) );
    }
    if ( count > MOST_MOVING )
        snprintf( text + strlen( text ), 32, " and %zu more", count - MOST_MOVING );
    if ( count > 0 )
        add_fact( facts, "Scene", "Moving", text );
    json_array_foreach( json_object_get( render, "changing" ), i, row )
    {
        const char* name = json_string_value( json_object_get( row, "name" ) );
        const char* kind = json_string_value( json_object_get( row, "kind" ) );
        snprintf( label, sizeof label, "Changing: %.20s '%.60s'", kind != NULL ? kind : "", name != NULL ? name : "" );
        rf_format_change( row, sharing, text );
        add_fact( facts, "Scene", label, text );
    }
    rf_format_sharing( sharing, text );
    if ( text[0] != '\0' )
        add_fact( facts, "Scene", "Light", text );
}

typedef void Format( double value, char text[32] );

static void add_formatted( json_t* facts, const char* group, const char* label, double value, Format* format )
{
    char text[32];
    if ( !isfinite( value ) || value < 0.0 )
        return;
    format( value, text );
    add_fact( facts, group, label, text );
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
        add_fact( facts, group, "Totals", text );
    return all - kept;
}

// Appends time, memory and rays.
static void add_costs( json_t* facts, const json_t* render )
{
    static const char* const rays[][2] = { { "primary", "From the camera" },
                                           { "path", "Paths" },
                                           { "shadow", "To lights" },
                                           { "tile", "Within tiles" },
                                           { "eye", "To other cameras" } };
    double seconds = rf_json_number_of( render, "seconds" ), all = 0.0;
    int count = add_rendered( facts, render, "Time and memory" );
    add_fact_number( facts, "Time and memory", "Added up over tasks", "%.0f", rf_json_number_of( render, "tasks" ) );
    add_formatted( facts, "Time and memory", "In all", seconds, format_seconds );
    add_formatted( facts, "Time and memory", "Loading the scene", rf_json_number_of( render, "seconds_scene" ), format_seconds );
    if ( count == 0 ) // nothing to count
        return;
    if ( !json_is_true( json_object_get( render, "interrupted" ) ) ) // else the time of unfinished frames is in it
        add_formatted( facts, "Time and memory", "A frame", seconds / count, format_seconds );
    add_formatted( facts, "Time and memory", "Threads", rf_json_number_of( render, "threads" ), format_count );
    add_formatted( facts, "Time and memory", "Memory, peak", rf_json_number_of( render, "peak_bytes" ), rf_format_bytes );
    add_formatted( facts, "Time and memory", "Memory, budget", rf_json_number_of( render, "budget_bytes" ), rf_format_bytes );
    add_rendered( facts, render, "Rays" );
    for ( size_t i = 0; i < sizeof rays / sizeof rays[0]; ++i )
    {
        double number = rf_json_number_of( json_object_get( render, "rays" ), rays[i][0] );
        all += isfinite( number ) ? number : 0.0;
        add_formatted( facts, "Rays", rays[i][1], number, format_count );
    }
    add_formatted( facts, "Rays", "In all", all, format_count );
    if ( seconds > 0.0 )
        add_formatted( facts, "Rays", "A second", all / seconds, format_count );
}

// Attributes that Reframe writes into its files, in the order of the table.
static const struct
{
    const char *attribute, *group, *label;
} s_known[] = {
    { "reframe/scene", "Scene", "Scene" },
    { "reframe/camera", "Scene", "Camera" },
    { "reframe/overscan", "Scene", "Overscan" },
    { "reframe/timecode", "Scene", "Time code, start" },
    { "reframe/no-effect", "Scene", "Effects left out" },
    { "reframe/estimator", "Settings", "Estimator" },
    { "reframe/reconstruction", "Settings", "Reconstruction" },
    { "reframe/group", "Settings", "Group" },
    { "reframe/tile", "Settings", "Tile" },
    { "reframe/adaptive", "Settings", "Adaptive" },
    { "reframe/clamp", "Settings", "Clamp" },
    { "reframe/clamp-chains", "Settings", "Clamp of chains" },
    { "reframe/clamp-threshold", "Settings", "Clamp, threshold" },
    { "reframe/clamp-threshold-chains", "Settings", "Clamp, threshold of chains" },
    { "reframe/removed-share", "Settings", "Light removed, share (first frame)" },
    { "reframe/beyond-depth-share", "Settings", "Light beyond the maximum depth, share" },
    { "reframe/blur-steps", "Settings", "Steps of the shutter" },
    { "reframe/filter", "Settings", "Pixel filter" },
    { "reframe/filter-width", "Settings", "Filter width" },
    { "reframe/light-paths", "Settings", "Light paths" },
    { "reframe/kernel-normalization", "Settings", "Kernel normalisation" },
    { "reframe/weights", "Settings", "Weights" },
    { "reframe/noise", "Settings", "Wanted relMSE" },
    { "reframe/flicker", "Settings", "Wanted F1" },
    { "reframe/time", "Settings", "Wanted seconds" },
    { "reframe/normalize", "Settings", "Normalisation" },
    { "reframe/max-depth", "Settings", "Depth" },
    { "reframe/light-samples", "Settings", "Light samples" },
    { "reframe/seed", "Settings", "Seed" },
    { "reframe/aov", "Settings", "Layers" },
    { "reframe/cryptomatte", "Settings", "Cryptomatte" },
    { "reframe/light-groups", "Settings", "Light groups" },
    { "reframe/names", "Settings", "Names of channels" },
    { "reframe/compression", "Settings", "Compression" },
    { "reframe/parts", "Settings", "Parts" },
    { "reframe/float", "Settings", "32-bit floats" },
    { "reframe/colorspace", "Settings", "Colour space" },
    { "reframe/clipped-layers", "Settings", "Clipped layers (first frame)" },
    { "reframe/version", "Settings", "Reframe" },
    { "reframe/view", "Scene", "View" },
    { "reframe/look", "Scene", "Look" },
    { "reframe/exposure", "Scene", "Exposure" },
    { "reframe/gamma", "Scene", "Gamma" },
    { "reframe/device", "Settings", "Device" },
};

// Appends those of a group, "Scene" or "Settings", that the header of a file has.
static void add_settings( json_t* facts, const char* path, const char* group )
{
    char value[FACT_SIZE + 16];
    for ( size_t i = 0; i < sizeof s_known / sizeof s_known[0]; ++i )
    {
        if ( strcmp( s_known[i].group, group ) == 0 &&
             rf_read_exr_string( path, s_known[i].attribute, value, sizeof value, NULL ) == RF_OK )
            add_fact( facts, group, s_known[i].label, value );
    }
}

static void format_samples( double samples, char text[32] )
{
    snprintf( text, 32, isless( samples, 1000.0 ) ? "%.4g" : "%.0f", samples );
}

// "12 to 14.5"; nothing where no frame says.
static void format_range( double least, double most, char* text, size_t size )
{
    char parts[2][32];
    format_samples( least, parts[0] );
    format_samples( most, parts[1] );
    if ( islessequal( least, most ) )
        snprintf( text, size, strcmp( parts[0], parts[1] ) == 0 ? "%s" : "%s to %s", parts[0], parts[1] );
}

static void add_effective_samples( json_t* facts, const RfPageTrack* track )
{
    double least = INFINITY, most = -INFINITY;
    char text[128] = "";
    for ( int i = 0; i < track->count; ++i )
    {
        least = fmin( least, track->frames[i].effective );
        most = fmax( most, track->frames[i].effective );
    }
    format_range( least, most, text, sizeof text );
    if ( text[0] != '\0' )
        add_fact( facts, "Settings", "Effective samples a pixel", text );
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
    char limit[32], text[128] = "";
    format_samples( asked, limit );
    format_range( least, most, text, sizeof text ); // where the frames say
    bool is_bound = isgreater( noise, 0.0 ) || isgreater( flicker, 0.0 ) || isgreater( time, 0.0 ),
         is_said = asked != rf_default_most_spp( noise, flicker );
    if ( text[0] == '\0' && isgreater( asked, 0.0 ) && !is_bound )
        snprintf( text, sizeof text, "%s", limit );
    size_t used = strlen( text );
    if ( isgreater( asked, 0.0 ) && is_bound && is_said )
        snprintf( text + used, sizeof text - used, "%sat most %s", used > 0 ? ", " : "", limit );
    if ( text[0] != '\0' )
        add_fact( facts, "Settings", "Samples a pixel", text );
    add_effective_samples( facts, track );
}

#define MOST_STRINGS 24 // of other programs

// "3, 4, 8-12"
static void add_missing( json_t* facts, const RfPageTrack* track )
{
    char text[FACT_SIZE];
    int count;
    int* missing = rf_page_missing_frames( track, &count );
    rf_format_frames( missing, count, text, sizeof text );
    if ( count > 0 )
        add_fact( facts, "Picture", "Missing", text );
    free( missing );
}

// "48, from 1 to 48"
static void add_frames( json_t* facts, const RfPageTrack* track )
{
    int shown = 0, first = 0, last = 0;
    size_t bad = 0, clipped = 0;
    for ( int i = 0; i < track->count; ++i )
    {
        if ( !track->frames[i].shown )
            continue;
        first = shown == 0 ? track->numbers[i] : first;
        last = track->numbers[i];
        bad += track->frames[i].bad;
        clipped += track->frames[i].clipped;
        ++shown;
    }
    char text[96];
    snprintf( text, sizeof text, "%d, from %d to %d", shown, first, last );
    add_fact( facts, "Picture", "Frames", text );
    if ( track->sequence->progress == NULL )
        add_missing( facts, track );
    if ( bad > 0 )
        add_fact_number( facts, "Picture", "No numbers", "%.0f pixels with NaN or infinity", (double)bad );
    if ( clipped > 0 )
        add_fact_number( facts, "Picture", "Clipped", "%.0f pixels, by the range of the file's channels", (double)clipped );
}

static void add_picture( json_t* facts, const RfPageTrack* track )
{
    const RfExrHeader* header = &track->sequence->header;
    RfExrWindow window = rf_page_window( header );
    char text[96];
    add_frames( facts, track );
    int used = snprintf( text, sizeof text, "%d x %d", window.width, window.height );
    if ( window.width != header->width || window.height != header->height )
        snprintf( text + used, sizeof text - (size_t)used, ", with overscan %d x %d", header->width, header->height );
    add_fact( facts, "Picture", "Size", text );
    if ( track->picture_width != window.width )
    {
        snprintf( text, sizeof text, "%d x %d", track->picture_width, track->picture_height );
        add_fact( facts, "Picture", "Shown as", text );
    }
    if ( header->fps_numerator > 0 )
        add_fact_number( facts, "Picture", "Frames/s", "%.5g", (double)header->fps_numerator / header->fps_denominator );
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
    char text[RF_NOISE_TEXT_SIZE + 16], noise[RF_NOISE_TEXT_SIZE];
    add_fact_number( facts, "Error", "relMSE, estimated", at_least ? "at least %.3g" : "%.3g", track->estimate );
    rf_format_noise( track->estimate, noise );
    snprintf( text, sizeof text, "%s%s", at_least ? "at least " : "", noise );
    if ( isfinite( track->estimate ) )
        add_fact( facts, "Error", "Noise of a channel, estimated", text );
    if ( share > 0.0 && isfinite( track->estimate ) )
        add_fact_number( facts, "Error", "Share of the ten worst pixels", "up to %.0f %%", 100.0 * share );
}

#define MOST_SPECK_ROWS 4

// Where the error is, as render found it: the pixels that stand out, and by material and kind.
static void add_specks( json_t* facts, const json_t* render )
{
    char label[128], text[64];
    json_t *specks = rf_sum_specks( json_object_get( render, "frames" ) ), *row;
    size_t i;
    if ( isgreater( rf_json_number_of( specks, "pixels" ), 0.0 ) )
    {
        snprintf( text, sizeof text, "%.0f pixels hold %.0f %%", rf_json_number_of( specks, "pixels" ),
                  100.0 * rf_json_number_of( specks, "share" ) );
        add_fact( facts, "Error", "Specks", text );
        rf_format_noise( rf_json_number_of( specks, "rest_relmse" ), text );
        add_fact( facts, "Error", "Noise of the rest", text );
    }
    json_array_foreach( json_object_get( specks, "materials" ), i, row )
    {
        const char* name = json_string_value( json_object_get( row, "material" ) );
        if ( i == MOST_SPECK_ROWS )
            break;
        snprintf( label, sizeof label, name != NULL ? "Specks on '%.60s' (%s)" : "Specks in the sky%.0s (%s)",
                  name != NULL ? name : "", json_string_value( json_object_get( row, "kind" ) ) );
        snprintf( text, sizeof text, "%.0f pixels hold %.2g %%", rf_json_number_of( row, "pixels" ),
                  100.0 * rf_json_number_of( row, "share" ) );
        add_fact( facts, "Error", label, text );
    }
    json_decref( specks );
}

static void add_error( json_t* facts, const RfPageTrack* track )
{
    const RfErrorMetrics* e = &track->error;
    char text[96];
    if ( track->has_error && isfinite( e->relmse ) )
    {
        add_fact_number( facts, "Error", "relMSE", "%.3g", e->relmse );
        add_fact_number( facts, "Error", "without the worst 0.1 %", "%.3g", e->relmse_trimmed );
        rf_format_noise( e->relmse, text );
        add_fact( facts, "Error", "Noise of a channel", text );
        bool relative = e->reference_mean > 0.0;
        double scale = relative ? 100.0 / e->reference_mean : 1.0;
        snprintf( text, sizeof text, "%+.2g%s (95 %%: %+.2g to %+.2g%s)", e->bias * scale, relative ? " %" : "",
                  e->bias_low * scale, e->bias_high * scale, relative ? " %" : "" );
        add_fact( facts, "Error", "Mean error", text );
    }
    add_estimate( facts, track );
    add_specks( facts, track->sequence->render );
    RfFlickerMetrics flicker = rf_flicker_metrics( &track->flicker );
    if ( track->flicker.pairs == 0 )
        return;
    add_fact_number( facts, "Error", "Flicker: phi", "%.3f", flicker.phi );
    add_fact_number( facts, "Error", "Flicker: F1", "%.3g", flicker.f1 );
    if ( track->compensated )
        add_fact_number( facts, "Error", "Flicker: coverage", "%.2f %%", 100.0 * flicker.coverage );
    if ( track->followed.pairs > 0 )
        add_fact_number( facts, "Error", "Flicker along the motion: phi", "%.3f", rf_flicker_metrics( &track->followed ).phi );
}

// Pairs whose files lack the layers of the first file have no flicker along the motion.
static void add_pairs( json_t* facts, const RfPageTrack* track )
{
    char text[96];
    int pairs = track->follows ? track->followed.pairs : track->flicker.pairs;
    if ( pairs == track->pair_count )
        return;
    snprintf( text, sizeof text, "%d of %d pairs, the other frames lack the layers", pairs, track->pair_count );
    add_fact( facts, "Error", track->follows ? "Flicker along the motion: of" : "Flicker: of", text );
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
        add_fact( strings->facts, "Header", name, value );
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
    add_settings( facts, sequence->first, "Scene" );
    add_changes( facts, sequence->render );
    add_effects( facts, sequence->render );
    add_samples( facts, track );
    add_settings( facts, sequence->first, "Settings" );
    if ( sequence->render != NULL )
        add_costs( facts, sequence->render );
    add_fact( facts, "Header", "Files", sequence->pattern );
    Strings strings = { .facts = facts };
    rf_list_exr_strings( sequence->first, take_string, &strings, NULL );
    return facts;
}
