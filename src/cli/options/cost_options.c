#include "cli/options/cost_options.h"

#include "cli/options/shot_options.h"

#include <math.h>
#include <stdlib.h>

#define BUDGET 60.0 // seconds
#define ERRORS "0.1,0.01,0.001"

static const char* const s_files[] = { "SCENE" };
static RfCostOptions s_parsed; // the table points here
static const char* s_scene;

static const RfOption s_options[] = {
    { .name = "budget",
      .type = RF_OPTION_TIME,
      .value = &s_parsed.budget,
      .min = 1.0,
      .max = 1e6,
      .meta = "T",
      .default_text = "60",
      .help = "seconds that it may take, or 5m, after a first round that is always finished; more make the figures surer" },
    { .name = "noise",
      .type = RF_OPTION_STRING,
      .value = &s_parsed.noise,
      .meta = "E[,...]",
      .default_text = ERRORS,
      .help = "relMSE whose cost is reported; 1% is 0.01" },
    { .name = "flicker",
      .type = RF_OPTION_STRING,
      .value = &s_parsed.flicker,
      .meta = "F[,...]",
      .default_text = "none",
      .help = "F1 of neighbouring frames whose cost is reported, too" },
    { .name = "svg",
      .writes = ".svg",
      .type = RF_OPTION_STRING,
      .value = &s_parsed.svg,
      .meta = "FILE",
      .help = "a plot: seconds across, error up, with and without reuse" },
    RF_PATH_OPTIONS( s_parsed.render, "frames that are to be rendered: some of them are tried, and all are counted" ),
    RF_LENS_OPTIONS( s_parsed.render, true ),
    RF_EFFECT_OPTIONS( s_parsed.render, true ),
    { .name = "group",
      .type = RF_OPTION_INT,
      .value = &s_parsed.render.settings.group,
      .min = 0,
      .max = RF_MAX_GROUP,
      .keyword = "auto",
      .keyword_value = RF_GROUP_AUTO,
      .meta = "N|auto",
      .default_text = "auto",
      .help = "half-width of the groups with reuse: groups of 2N+1 frames" },
    RF_ESTIMATOR_OPTION( s_parsed.render ),
    RF_TILE_OPTION( s_parsed.render ),
    RF_LIGHT_OPTIONS( s_parsed.render ),
    RF_FILTER_OPTIONS( s_parsed.render, true ),
    RF_SEED_OPTION( s_parsed.render ),
    RF_MACHINE_OPTIONS( s_parsed.render, "threads of the render" ),
    RF_RESULT_OPTIONS( s_parsed.render, "no words on what is being tried" ),
};

static const RfCommandTable s_table = {
    .command = "cost",
    .summary =
        "Tells what accuracy costs in time: renders a few frames with ever more samples, by path tracing and with reuse, and "
        "from these the seconds that a wanted error takes, for a frame and for all. Options and SCENE are those of render.",
    .files = s_files,
    .file_count = 1,
    .options = s_options,
    .option_count = sizeof s_options / sizeof s_options[0]
};

// The numbers of an option.
static RfResult parse_list( const char* name, const char* text, double values[RF_COST_ERRORS], int* count, RfError* error )
{
    const char* all = text;
    *count = 0;
    for ( ; text != NULL; )
    {
        char* end;
        double value = strtod( text, &end );
        if ( end != text && *end == '%' )
        {
            value /= 100.0;
            end += 1;
        }
        if ( end == text || !( value > 0.0 ) || !isfinite( value ) || ( *end != ',' && *end != '\0' ) )
            return rf_fail( error, RF_ERROR_USAGE, "%s: wants numbers above 0 with commas between them, got '%s'", name, all );
        if ( *count == RF_COST_ERRORS )
            return rf_fail( error, RF_ERROR_USAGE, "%s: more than %d numbers", name, RF_COST_ERRORS );
        values[( *count )++] = value;
        text = *end == '\0' ? NULL : end + 1;
    }
    return RF_OK;
}

// Parses on top of the current values.
static RfResult parse( int argc, char** argv, RfCostOptions* options, bool* help, RfError* error )
{
    RfResult result = rf_parse_options( &s_table, argc, argv, &s_scene, help, error );
    if ( result != RF_OK || *help )
        return result;
    s_parsed.render.scene = s_scene;
    result = rf_parse_estimator_option( &s_parsed.render, error );
    if ( result == RF_OK )
        rf_settle_filter( &s_parsed.render );
    if ( result == RF_OK )
        result = rf_parse_tile_option( &s_parsed.render, error );
    if ( result == RF_OK )
        result = parse_list( "--noise", s_parsed.noise, s_parsed.errors, &s_parsed.error_count, error );
    if ( result == RF_OK )
        result = parse_list( "--flicker", s_parsed.flicker, s_parsed.flickers, &s_parsed.flicker_count, error );
    *options = s_parsed;
    return result;
}

RfResult rf_parse_cost_options( int argc, char** argv, RfCostOptions* options, bool* help, RfError* error )
{
    s_parsed = ( RfCostOptions ){ .render = rf_default_render_options(), .budget = BUDGET, .noise = ERRORS };
    return parse( argc, argv, options, help, error );
}

RfResult rf_parse_cost_options_over( const RfField* defaults, int argc, char** argv, RfCostOptions* options, RfError* error )
{
    bool help;
    s_parsed = ( RfCostOptions ){ .budget = BUDGET, .noise = ERRORS };
    RfResult result = rf_read_render_defaults( defaults, &s_parsed.render );
    return result == RF_OK ? parse( argc, argv, options, &help, error ) : result;
}

void rf_print_cost_help( void ) { rf_print_help( &s_table, stdout ); }
