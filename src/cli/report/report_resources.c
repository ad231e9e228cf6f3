#include "cli/report/report_resources.h"

#include "cli/messages.h"
#include "cli/report/report_numbers.h"
#include "cli/report/report_rows.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

void rf_add_effects( json_t* facts, const json_t* render )
{
    char text[RF_FACT_SIZE + 16] = "";
    size_t i;
    const json_t* name;
    json_array_foreach( json_object_get( render, "effects" ), i, name )
    {
        size_t used = strlen( text );
        if ( json_is_string( name ) )
            snprintf( text + used, sizeof text - used, "%s%s", used > 0 ? ", " : "", json_string_value( name ) );
    }
    if ( text[0] != '\0' )
        rf_add_fact( facts, "Scene", "Effects", text );
}

typedef void Format( double value, char text[32] );

static void add_formatted( json_t* facts, const char* group, const char* label, double value, Format* format )
{
    char text[32];
    if ( !isfinite( value ) || value < 0.0 )
        return;
    format( value, text );
    rf_add_fact( facts, group, label, text );
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
        rf_add_fact( facts, group, "Totals", text );
    return all - kept;
}

void rf_add_costs( json_t* facts, const json_t* render )
{
    static const char* const rays[][2] = { { "primary", "From the camera" },
                                           { "path", "Paths" },
                                           { "shadow", "To lights" },
                                           { "tile", "Within tiles" },
                                           { "eye", "To other eyes" } };
    double seconds = rf_json_number_of( render, "seconds" ), all = 0.0;
    int count = add_rendered( facts, render, "Time and memory" );
    rf_add_fact_number( facts, "Time and memory", "Added up over tasks", "%.0f", rf_json_number_of( render, "tasks" ) );
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
