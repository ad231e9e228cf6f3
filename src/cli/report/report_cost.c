#include "cli/report/report_cost.h"

#include "cli/messages.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

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

void rf_format_speedup( double speedup, char text[48] )
{
    double times = speedup < 1.0 ? 1.0 / speedup : speedup;
    if ( times < 1.05 )
    {
        snprintf( text, 48, "about as fast" );
        return;
    }
    snprintf( text, 48, times < 10.0 ? "%.2g times %s" : "%.0f times %s", times, speedup < 1.0 ? "slower" : "faster" );
}

// "at equal error reuse is 4.5 times faster (95 %: 4 to 5)"; where the interval holds 1, it says which way: "2 times slower
// to 1.2 times faster"
static void append_speedup( char* text, size_t size, const json_t* cost )
{
    double speedup = rf_json_number_of( cost, "speedup_at_equal_error" ), low = rf_json_number_of( cost, "speedup_low" ),
           high = rf_json_number_of( cost, "speedup_high" );
    char words[3][48];
    size_t used = strlen( text );
    if ( !( speedup > 0.0 ) )
        return;
    rf_format_speedup( speedup, words[0] );
    snprintf( text + used, size - used, "%sat equal error reuse is %s", used > 0 ? "; " : "", words[0] );
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
    rf_format_speedup( low, words[1] );
    rf_format_speedup( high, words[2] );
    snprintf( text + used, size - used, " (95 %%: %s to %s)", words[1], words[2] );
}

static void append_slope( char* text, size_t size, const json_t* cost )
{
    double slope = rf_json_number_of( cost, "slope" ), low = rf_json_number_of( cost, "slope_low" ),
           high = rf_json_number_of( cost, "slope_high" );
    size_t used = strlen( text );
    if ( !isfinite( slope ) )
        return;
    snprintf( text + used, size - used, "%serror falls as time to the power of %.2f", used > 0 ? "; " : "", slope );
    used = strlen( text );
    if ( isfinite( low ) && isfinite( high ) )
        snprintf( text + used, size - used, " (%.2f to %.2f)", low, high );
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
