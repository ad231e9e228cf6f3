#include "cli/report/report_settings.h"

#include "cli/options/render_options.h"
#include "cli/report/report_rows.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

// Attributes that Reframe writes into its files, in the order of the table.
static const struct
{
    const char *attribute, *group, *label;
} s_known[] = {
    { "reframe/scene", "Scene", "Scene" },
    { "reframe/camera", "Scene", "Camera" },
    { "reframe/no-effect", "Scene", "Effects left out" },
    { "reframe/estimator", "Settings", "Estimator" },
    { "reframe/reconstruction", "Settings", "Reconstruction" },
    { "reframe/group", "Settings", "Group" },
    { "reframe/tile", "Settings", "Tile" },
    { "reframe/adaptive", "Settings", "Adaptive" },
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
    { "reframe/version", "Settings", "Reframe" },
    { "reframe/device", "Settings", "Device" },
};

void rf_add_settings( json_t* facts, const char* path, const char* group )
{
    char value[RF_FACT_SIZE + 16];
    for ( size_t i = 0; i < sizeof s_known / sizeof s_known[0]; ++i )
    {
        if ( strcmp( s_known[i].group, group ) == 0 &&
             rf_read_exr_string( path, s_known[i].attribute, value, sizeof value, NULL ) == RF_OK )
            rf_add_fact( facts, group, s_known[i].label, value );
    }
}

static void format_samples( double samples, char text[32] ) { snprintf( text, 32, samples < 1000.0 ? "%.4g" : "%.0f", samples ); }

// Samples traced, least and most of all frames; with --noise and --time also their limit,
// where it is known.
void rf_add_samples( json_t* facts, const RfPageTrack* track )
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
        rf_add_fact( facts, "Settings", "Samples a pixel", text );
}
