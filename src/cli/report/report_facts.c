#include "cli/report/report_facts.h"

#include "cli/report/report_resources.h"
#include "cli/report/report_rows.h"
#include "cli/report/report_settings.h"
#include "cli/report/report_tasks.h"
#include "cli/messages.h"
#include "image/sequence.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#define MOST_STRINGS 24 // of other programs

// "3, 4, 8-12"
static void add_missing( json_t* facts, const RfPageTrack* track )
{
    char text[RF_FACT_SIZE];
    int count;
    int* missing = rf_page_missing_frames( track, &count );
    rf_format_frames( missing, count, text, sizeof text );
    if ( count > 0 )
        rf_add_fact( facts, "Picture", "Missing", text );
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
    rf_add_fact( facts, "Picture", "Frames", text );
    if ( track->sequence->progress == NULL )
        add_missing( facts, track );
    if ( bad > 0 )
        rf_add_fact_number( facts, "Picture", "No numbers", "%.0f pixels with NaN or infinity", (double)bad );
}

static void add_picture( json_t* facts, const RfPageTrack* track )
{
    const RfExrHeader* header = &track->sequence->header;
    char text[96];
    add_frames( facts, track );
    snprintf( text, sizeof text, "%d x %d", header->width, header->height );
    rf_add_fact( facts, "Picture", "Size", text );
    if ( track->picture_width != header->width )
    {
        snprintf( text, sizeof text, "%d x %d", track->picture_width, track->picture_height );
        rf_add_fact( facts, "Picture", "Shown as", text );
    }
    if ( header->fps_numerator > 0 )
        rf_add_fact_number( facts, "Picture", "Frames/s", "%.5g", (double)header->fps_numerator / header->fps_denominator );
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
    rf_add_fact_number( facts, "Error", "relMSE, estimated", at_least ? "at least %.3g" : "%.3g", track->estimate );
    if ( share > 0.0 && isfinite( track->estimate ) )
        rf_add_fact_number( facts, "Error", "Share of the ten worst pixels", "up to %.0f %%", 100.0 * share );
}

static void add_error( json_t* facts, const RfPageTrack* track )
{
    const RfErrorMetrics* e = &track->error;
    char text[96];
    if ( track->has_error && isfinite( e->relmse ) )
    {
        rf_add_fact_number( facts, "Error", "relMSE", "%.3g", e->relmse );
        rf_add_fact_number( facts, "Error", "without the worst 0.1 %", "%.3g", e->relmse_trimmed );
        rf_add_fact_number( facts, "Error", "Noise of a channel", "%.2g %%", 100.0 * sqrt( e->relmse / 3.0 ) );
        bool relative = e->reference_mean > 0.0;
        double scale = relative ? 100.0 / e->reference_mean : 1.0;
        snprintf( text, sizeof text, "%+.2g%s (95 %%: %+.2g to %+.2g%s)", e->bias * scale, relative ? " %" : "",
                  e->bias_low * scale, e->bias_high * scale, relative ? " %" : "" );
        rf_add_fact( facts, "Error", "Mean error", text );
    }
    add_estimate( facts, track );
    RfFlickerMetrics flicker = rf_flicker_metrics( &track->flicker );
    if ( track->flicker.pairs == 0 )
        return;
    rf_add_fact_number( facts, "Error", "Flicker: phi", "%.3f", flicker.phi );
    rf_add_fact_number( facts, "Error", "Flicker: F1", "%.3g", flicker.f1 );
    if ( track->compensated )
        rf_add_fact_number( facts, "Error", "Flicker: coverage", "%.2f %%", 100.0 * flicker.coverage );
    if ( track->followed.pairs > 0 )
        rf_add_fact_number( facts, "Error", "Flicker along the motion: phi", "%.3f", rf_flicker_metrics( &track->followed ).phi );
}

// Pairs whose files lack the layers of the first file have no flicker along the motion.
static void add_pairs( json_t* facts, const RfPageTrack* track )
{
    char text[96];
    int pairs = track->follows ? track->followed.pairs : track->flicker.pairs;
    if ( pairs == track->pair_count )
        return;
    snprintf( text, sizeof text, "%d of %d pairs, the other frames lack the layers", pairs, track->pair_count );
    rf_add_fact( facts, "Error", track->follows ? "Flicker along the motion: of" : "Flicker: of", text );
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
        rf_add_fact( strings->facts, "Header", name, value );
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
    rf_add_settings( facts, sequence->first, "Scene" );
    rf_add_effects( facts, sequence->render );
    rf_add_samples( facts, track );
    rf_add_settings( facts, sequence->first, "Settings" );
    if ( sequence->render != NULL )
        rf_add_costs( facts, sequence->render );
    rf_add_fact( facts, "Header", "Files", sequence->pattern );
    Strings strings = { .facts = facts };
    rf_list_exr_strings( sequence->first, take_string, &strings, NULL );
    return facts;
}
