// reframe cost: what accuracy costs in time.
#include "base/system.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/render_options.h"
#include "cli/options/shot.h"
#include "cli/options/shared_options.h"
#include "cli/signals.h"
#include "cli/tune/verdict.h"
#include "measure/cost.h"
#include "measure/plot.h"
#include "base/json.h"
#include "scene/leave_out.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define COST_ERRORS 16

typedef struct CostOptions
{
    RfRenderOptions render;     // without output
    double budget;              // seconds
    const char* noise;          // as the user wrote it
    double errors[COST_ERRORS]; // relMSE, as parsed from `noise`
    int error_count;
    const char* flicker;          // NULL: none
    double flickers[COST_ERRORS]; // F1, as parsed from it
    int flicker_count;
    const char* svg; // NULL: none
} CostOptions;

typedef struct Job
{
    int argc;
    char** argv;
    bool help; // was asked for
    CostOptions options;
    RfLoadedShot shot; // options may point into it
    RfCostJob asked;
    RfCost cost;
    int threads;
    int per_sweep[2];           // frames of a sweep, by path tracing and with reuse
    double start, load_seconds; // until rays can be traced: part of a render of all frames
} Job;

typedef struct NoiseText
{
    char text[RF_NOISE_TEXT_SIZE];
} NoiseText;

// "7.1 %", or "?" where the errors of a curve are known too little.
static NoiseText noise_of( const RfCostCurve* c, double relmse )
{
    NoiseText noise = { "?" };
    if ( rf_is_known( &c->error ) )
        rf_format_noise( relmse, noise.text );
    return noise;
}

static void print_rows( const RfCostCurve* c, const char* name )
{
    for ( int i = 0; i < c->count; ++i )
        printf( "%-28s %7d %10.3g %10.3g %8s %10.3g\n", name, c->rows[i].spp, c->rows[i].seconds, c->rows[i].cpu_seconds,
                noise_of( c, c->rows[i].relmse ).text, c->rows[i].relmse );
}

// The same samples with the clamp that leaves the least error.
static void print_clamped( const Job* r )
{
    const RfCostCurve* c = &r->cost.reuse;
    for ( int i = 0; i < c->count && r->cost.clamp_count > 0; ++i )
    {
        double relmse;
        char noise[RF_NOISE_TEXT_SIZE];
        const RfCostClamp* clamp = rf_best_clamp( &r->cost, c->rows[i].spp, &relmse );
        if ( clamp == NULL )
            break;
        rf_format_noise( relmse, noise );
        printf( "%-28s %7d %10.3g %10.3g %8s %10.3g  --clamp %.3g, %.2g %% of the light missing\n", "  clamped", c->rows[i].spp,
                c->rows[i].seconds, c->rows[i].cpu_seconds, rf_is_known( &clamp->error ) ? noise : "?", relmse, clamp->threshold,
                100.0 * clamp->missing );
    }
}

static void print_slope( const RfCostCurve* c, const char* name )
{
    if ( isfinite( c->slope.low ) )
        printf( "%s: relMSE falls as time^%.2f (95 %%: %.2f to %.2f)\n", name, c->slope.value, c->slope.low, c->slope.high );
}

// The whole render, including the loading of the scene.
static double path_seconds( const Job* r, RfCostPrediction p ) { return p.seconds + r->load_seconds; }

// What is wanted: a relMSE, or an F1.
typedef struct Goal
{
    const char* name;
    double value;
    bool is_flicker;
} Goal;

static Goal noise_goal( double relmse ) { return ( Goal ){ "relMSE", relmse, false }; }

static Goal flicker_goal( double f1 ) { return ( Goal ){ "F1", f1, true }; }

static const RfCostCurve* curve_of( const Job* r, int number ) { return number == 0 ? &r->cost.plain : &r->cost.reuse; }

// By the curve of path tracing (0) or with reuse (1), or one in its place.
static RfCostPrediction predict( const Job* r, Goal goal, int number, const RfCostCurve* c )
{
    return goal.is_flicker ? rf_predict_flicker_cost( &r->asked, c, goal.value, r->per_sweep[number] )
                           : rf_predict_cost( &r->asked, c, goal.value, r->per_sweep[number] );
}

// What a goal takes: samples and seconds, with `at_least` where the error is known too little, so that this is the lower end.
typedef struct Price
{
    RfCostPrediction prediction;
    bool at_least;
    const RfCostClamp* clamp; // NULL: none
} Price;

static Price exact_price( const Job* r, Goal goal, int number )
{
    RfCostCurve c = *curve_of( r, number );
    bool at_least = !rf_is_known( &c.error ) && isfinite( c.error.low );
    if ( at_least )
    {
        c.f1_squared *= c.error.low / c.relmse;
        c.relmse = c.error.low;
    }
    return ( Price ){ predict( r, goal, number, &c ), at_least, NULL };
}

static Price clamped_price( const Job* r, Goal goal )
{
    Price price = { { 0 }, false, NULL };
    if ( goal.is_flicker )
        return price;
    RfCost lower = r->cost;
    for ( int i = 0; i < lower.clamp_count; ++i )
    {
        RfInterval* error = &lower.clamps[i].error;
        error->value = rf_is_known( error ) || !isfinite( error->low ) ? error->value : error->low;
    }
    const RfCostClamp* clamp;
    price.prediction = rf_predict_clamped_cost( &r->asked, &lower, goal.value, r->per_sweep[1], &clamp );
    price.clamp = clamp != NULL ? r->cost.clamps + ( clamp - lower.clamps ) : NULL;
    price.at_least = clamp != NULL && !rf_is_known( &price.clamp->error );
    return price;
}

// "94 s a frame, 16 min for all 48 (--spp 28)".
static void print_price( const Job* r, const char* name, Price price )
{
    char frame[32], all[32], clamp[32] = "", missing[64] = "";
    if ( price.prediction.spp == 0 )
    {
        printf( "  %-16s more than %d spp, the limit\n", name, RF_MAX_SPP );
        return;
    }
    rf_format_span( price.prediction.frame_seconds, frame, sizeof frame );
    rf_format_span( path_seconds( r, price.prediction ), all, sizeof all );
    if ( price.clamp != NULL )
    {
        snprintf( clamp, sizeof clamp, " --clamp %.3g", price.clamp->threshold );
        snprintf( missing, sizeof missing, ", %.2g %% of the light missing", 100.0 * price.clamp->missing );
    }
    printf( "  %-16s %s%s a frame, %s for all %d (--spp %d%s)%s\n", name, price.at_least ? "at least " : "", frame, all,
            r->asked.shot.frame_count, price.prediction.spp, clamp, missing );
}

static void format_goal( Goal goal, char* text, size_t size )
{
    char noise[RF_NOISE_TEXT_SIZE];
    rf_format_noise( goal.value, noise );
    if ( goal.is_flicker )
        snprintf( text, size, "F1 %g", goal.value );
    else
        snprintf( text, size, "%s noise (relMSE %.3g)", noise, goal.value );
}

static void print_goal( const Job* r, Goal goal )
{
    char name[64];
    format_goal( goal, name, sizeof name );
    printf( "%s:\n", name );
    Price clamped = clamped_price( r, goal );
    print_price( r, "exact", exact_price( r, goal, 1 ) );
    if ( clamped.clamp != NULL )
        print_price( r, "clamped", clamped );
    else if ( r->cost.clamp_count > 0 && !goal.is_flicker )
        printf( "  %-16s no clamp that was tried takes fewer samples\n", "clamped" );
    else if ( rf_is_left_out( rf_tracer_scene( r->asked.shot.tracer ), RF_EFFECT_CAUSTICS ) )
        printf( "  %-16s not tried where caustics are left out\n", "clamped" );
    print_price( r, "path tracing", exact_price( r, goal, 0 ) );
}

// What reuse is worth, and what the first error asked for takes.
static void format_verdict( const Job* r, char text[RF_VERDICT_SIZE] )
{
    const RfCost* cost = &r->cost;
    char name[64], gain[160];
    rf_format_reuse( cost->reuse.eyes, &cost->reuse.tile, name, sizeof name );
    rf_format_gain( &cost->speedup, cost->seconds, gain, sizeof gain );
    snprintf( text, RF_VERDICT_SIZE, "%s: %s", name, gain );
    if ( r->options.error_count == 0 )
        return;
    Goal goal = noise_goal( r->options.errors[0] );
    Price exact = exact_price( r, goal, 1 ), clamped = clamped_price( r, goal );
    char wanted[64], frame[32];
    format_goal( goal, wanted, sizeof wanted );
    rf_format_span( exact.prediction.frame_seconds, frame, sizeof frame );
    if ( exact.prediction.spp == 0 )
        rf_append( text, RF_VERDICT_SIZE, "\n%s: exact more than %d spp, the limit", wanted, RF_MAX_SPP );
    else
        rf_append( text, RF_VERDICT_SIZE, "\n%s: exact %s%s a frame", wanted, exact.at_least ? "at least " : "", frame );
    rf_format_span( clamped.prediction.frame_seconds, frame, sizeof frame );
    if ( clamped.clamp != NULL && clamped.prediction.spp > 0 )
        rf_append( text, RF_VERDICT_SIZE, ", clamp %s%s and %.2g %% of the light missing", clamped.at_least ? "at least " : "",
                   frame, 100.0 * clamped.clamp->missing );
}

static void print_cost( const Job* r )
{
    char verdict[RF_VERDICT_SIZE];
    format_verdict( r, verdict );
    printf( "%s\n\n", verdict );
    const RfCost* cost = &r->cost;
    char name[64];
    rf_format_reuse( cost->reuse.eyes, &cost->reuse.tile, name, sizeof name );
    printf( "%-28s %7s %10s %10s %8s %10s\n", "", "spp", "seconds", "CPU s", "noise", "relMSE" );
    print_rows( &cost->plain, "path tracing" );
    print_rows( &cost->reuse, name );
    print_clamped( r );
    printf( "seconds: of a frame of %dx%d with %d threads, from %.0f of its pixels at %d camera position%s, measured in %.1f s\n",
            r->options.render.size.width, r->options.render.size.height, r->threads, cost->pixels, cost->positions,
            cost->positions == 1 ? "" : "s", cost->seconds );
    print_slope( &cost->plain, "path tracing" );
    print_slope( &cost->reuse, name );
    for ( int i = 0; i < r->options.error_count; ++i )
        print_goal( r, noise_goal( r->options.errors[i] ) );
    for ( int i = 0; i < r->options.flicker_count; ++i )
        print_goal( r, flicker_goal( r->options.flickers[i] ) );
}

static void add_rows( json_t* rows, const RfCostCurve* c, bool reuse )
{
    char tile[RF_TILE_NAME_SIZE];
    rf_tile_name( &c->tile, tile );
    for ( int i = 0; i < c->count; ++i )
    {
        json_t* row = json_pack( "{s:b, s:i, s:s, s:i}", "reuse", reuse, "group", c->group, "tile", tile, "spp", c->rows[i].spp );
        json_array_append_new( rows,
                               RF_SET_FIGURES( row, { "seconds", c->rows[i].seconds }, { "cpu_seconds", c->rows[i].cpu_seconds },
                                               { "relmse", c->rows[i].relmse } ) );
    }
}

static json_t* prediction_json( const Job* r, RfCostPrediction p )
{
    return RF_SET_FIGURES( json_pack( "{s:o}", "spp", p.spp > 0 ? json_integer( p.spp ) : json_null() ),
                           { "frame_seconds", p.frame_seconds }, { "seconds", path_seconds( r, p ) } );
}

// Of path tracing, and with reuse.
static json_t* both_json( double plain, double reuse )
{
    return json_pack( "[o, o]", rf_json_number( plain ), rf_json_number( reuse ) );
}

static json_t* goal_json( const Job* r, Goal goal, const char* key )
{
    const RfCostClamp* clamp;
    RfCostPrediction p = rf_predict_clamped_cost( &r->asked, &r->cost, goal.value, r->per_sweep[1], &clamp );
    json_t* clamped = json_null();
    if ( !goal.is_flicker && clamp != NULL && p.spp > 0 )
    {
        clamped = RF_SET_FIGURES( prediction_json( r, p ), { "clamp", clamp->threshold }, { "missing", clamp->missing } );
    }
    return json_pack( "{s:o, s:f, s:o, s:o}", "clamped", clamped, key, goal.value, "plain",
                      prediction_json( r, predict( r, goal, 0, &r->cost.plain ) ), "reuse",
                      prediction_json( r, predict( r, goal, 1, &r->cost.reuse ) ) );
}

static json_t* cost_json( const Job* r )
{
    const RfCost* cost = &r->cost;
    const RfInterval *reuse = &cost->reuse.slope, *plain = &cost->plain.slope, *speedup = &cost->speedup;
    json_t *rows = json_array(), *wanted = json_array(), *flickers = json_array(), *clamps = json_array();
    char verdict[RF_VERDICT_SIZE];
    add_rows( rows, &cost->plain, false );
    add_rows( rows, &cost->reuse, true );
    for ( int i = 0; i < r->options.error_count; ++i )
        json_array_append_new( wanted, goal_json( r, noise_goal( r->options.errors[i] ), "relmse" ) );
    for ( int i = 0; i < r->options.flicker_count; ++i )
        json_array_append_new( flickers, goal_json( r, flicker_goal( r->options.flickers[i] ), "f1" ) );
    for ( const RfCostClamp* c = cost->clamps; c < cost->clamps + cost->clamp_count; ++c )
        json_array_append_new( clamps, RF_SET_FIGURES( json_object(), { "clamp", c->threshold },
                                                       { "relmse_of_one_sample", c->error.value }, { "bias", c->bias },
                                                       { "missing", c->missing } ) );
    format_verdict( r, verdict );
    // the scene, so that `report` can refuse what was measured with another one
    json_t* json = json_pack( "{s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:i, s:i, s:i, s:i}", "verdict", verdict, "scene",
                              rf_json_text( r->options.render.scene ), "rows", rows, "wanted", wanted, "wanted_flicker", flickers,
                              "clamps", clamps, "relmse_of_one_sample", both_json( cost->plain.relmse, cost->reuse.relmse ),
                              "f1_squared_of_one_sample", both_json( cost->plain.f1_squared, cost->reuse.f1_squared ), "width",
                              r->options.render.size.width, "height", r->options.render.size.height, "places", cost->positions,
                              "frames", r->asked.shot.frame_count );
    return RF_SET_FIGURES( json, { "slope", reuse->value }, { "slope_low", reuse->low }, { "slope_high", reuse->high },
                           { "slope_plain", plain->value }, { "slope_plain_low", plain->low },
                           { "slope_plain_high", plain->high }, { "speedup_at_equal_error", speedup->value },
                           { "speedup_low", speedup->low }, { "speedup_high", speedup->high }, { "pixels", cost->pixels },
                           { "seconds", cost->seconds }, { "budget", r->options.budget },
                           { "beyond_depth_share", r->shot.beyond_depth } );
}

// The points of a curve and the line fitted to them.
typedef struct Curve
{
    double x[RF_COST_LEVELS], y[RF_COST_LEVELS];
    double fit_x[2], fit_y[2];
    char name[64], fit_name[80];
} Curve;

static void draw_curve( const RfCostCurve* c, int style, Curve* curve, RfPlotSeries series[2] )
{
    double u = 0.0, v = 0.0;
    for ( int i = 0; i < c->count; ++i )
    {
        curve->x[i] = c->rows[i].seconds;
        curve->y[i] = c->rows[i].relmse;
        u += log( curve->x[i] ) / c->count;
        v += log( curve->y[i] ) / c->count;
    }
    series[0] =
        ( RfPlotSeries ){ .name = curve->name, .x = curve->x, .y = curve->y, .count = c->count, .no_line = true, .style = style };
    for ( int k = 0; k < 2; ++k )
    {
        curve->fit_x[k] = k == 0 ? curve->x[0] : curve->x[c->count - 1];
        curve->fit_y[k] = exp( v + c->slope.value * ( log( curve->fit_x[k] ) - u ) );
    }
    snprintf( curve->fit_name, sizeof curve->fit_name, "fit, slope %.2f", c->slope.value );
    series[1] = ( RfPlotSeries ){ .name = curve->fit_name,
                                  .x = curve->fit_x,
                                  .y = curve->fit_y,
                                  .count = isfinite( c->slope.value ) ? 2 : 0,
                                  .dashed = true,
                                  .no_markers = true,
                                  .style = style };
}

static RfResult write_cost_plot( const Job* r, const char* path, RfError* error )
{
    const RfCost* cost = &r->cost;
    Curve plain, reuse;
    RfPlotSeries series[4];
    snprintf( plain.name, sizeof plain.name, "path tracing" );
    char tile[RF_TILE_NAME_SIZE]; // the legend is narrow
    rf_tile_name( &cost->reuse.tile, tile );
    snprintf( reuse.name, sizeof reuse.name, "group %d, tile %s", cost->reuse.group, tile );
    draw_curve( &cost->plain, 0, &plain, series );
    draw_curve( &cost->reuse, 1, &reuse, series + 2 );
    char subtitle[512], gain[160];
    const char* slash = strrchr( r->options.render.scene, '/' );
    rf_format_gain( &cost->speedup, cost->seconds, gain, sizeof gain );
    snprintf( subtitle, sizeof subtitle, "%.200s, %dx%d; %s", slash != NULL ? slash + 1 : r->options.render.scene,
              r->options.render.size.width, r->options.render.size.height, gain );
    RfPlot plot = { .title = "Error against render time",
                    .subtitle = subtitle,
                    .series = series,
                    .series_count = 4,
                    .x = { .label = "seconds per frame", .log = true },
                    .y = { .label = "relMSE", .log = true } };
    return rf_write_plot( &plot, path, error );
}

#define BUDGET 60.0 // seconds
#define ERRORS "0.1,0.01,0.001"

static const char* const s_files[] = { "SCENE" };
static CostOptions s_parsed; // the table points here

static const RfOption s_options[] = {
    RF_PATH_OPTIONS( s_parsed.render, "frames to render; a few are measured, the total time is predicted" ),
    RF_LENS_OPTIONS( s_parsed.render ),
    RF_MOVEMENT_OPTIONS( s_parsed.render ),
    RF_TIME_OPTION( "budget", &s_parsed.budget, 1.0, 1e6, "T",
                    "time to spend, in seconds or as 5m; more time narrows the intervals" ),
    RF_TEXT_OPTION( "noise", &s_parsed.noise, "E[,...]",
                    "predict the time to reach each relMSE, or noise of a channel in percent: 5.8% is relMSE 0.01" ),
    RF_TEXT_OPTION( "flicker", &s_parsed.flicker, "F[,...]", "predict the time to reach each F1 between neighbouring frames" ),
    RF_FILTER_OPTIONS( s_parsed.render ),
    RF_PATH_TRACING_OPTIONS( s_parsed.render ),
    RF_SEED_OPTION( s_parsed.render ),
    RF_TEXT_OPTION( "svg", &s_parsed.svg, "FILE", "plot error against time, with and without reuse", .writes = ".svg",
                    .heading = RF_HEADING_OUTPUT ),
    RF_RESULT_OPTIONS( s_parsed.render, "write the result as JSON; - for standard output", "no progress" ),
    RF_GROUP_OPTION( s_parsed.render, "with reuse, share paths between 2N+1 neighbouring frames" ),
    RF_TILE_OPTION( s_parsed.render ),
    RF_MACHINE_OPTIONS( s_parsed.render, "threads" ),
    RF_ESTIMATOR_OPTION( s_parsed.render ),
    RF_EFFECT_OPTIONS( s_parsed.render ),
};

static const RfCommandTable s_table = {
    .command = "cost",
    .summary = "Measures error against render time: renders a few frames at increasing sample counts, with path tracing and with "
               "reuse, and predicts the time to reach each target error, per frame and in total. SCENE and options are those of "
               "render.",
    RF_TABLE_ROWS( s_files, s_options )
};

// The numbers of an option; those of relMSE may be in percent.
static RfResult parse_list( const char* name, const char* text, bool is_noise, double values[COST_ERRORS], int* count,
                            RfError* error )
{
    const char* all = text;
    *count = 0;
    for ( ; text != NULL; )
    {
        const char* end;
        double value;
        bool is_number = rf_parse_noise( text, &value, &end );
        if ( !is_number || !( value > 0.0 ) || ( *end != ',' && *end != '\0' ) || ( !is_noise && end[-1] == '%' ) )
            return rf_fail( error, RF_ERROR_USAGE, "%s: expected numbers above 0%s with commas between them, got '%s'", name,
                            is_noise ? ", or percent such as 5%," : "", all );
        if ( *count == COST_ERRORS )
            return rf_fail( error, RF_ERROR_USAGE, "%s: more than %d numbers", name, COST_ERRORS );
        values[( *count )++] = value;
        text = *end == '\0' ? NULL : end + 1;
    }
    return RF_OK;
}

// Parses the command line over a scene file's defaults, or with NULL over ours, and checks what can be checked without the scene.
static RfResult parse( const RfField* defaults, void* user, RfError* error )
{
    Job* job = user;
    s_parsed = ( CostOptions ){ .render = rf_default_render_options(), .budget = BUDGET, .noise = ERRORS };
    RfResult result = defaults != NULL ? rf_read_render_defaults( defaults, &s_parsed.render ) : RF_OK;
    if ( result == RF_OK )
        result = rf_parse_options( &s_table, job->argc, job->argv, &s_parsed.render.scene, &job->help, error );
    if ( result != RF_OK || job->help )
        return result;
    rf_take_estimator_option( &s_parsed.render );
    rf_settle_filter( &s_parsed.render );
    result = rf_parse_tile_option( &s_parsed.render, error );
    if ( result == RF_OK )
        result = parse_list( "--noise", s_parsed.noise, true, s_parsed.errors, &s_parsed.error_count, error );
    if ( result == RF_OK )
        result = parse_list( "--flicker", s_parsed.flicker, false, s_parsed.flickers, &s_parsed.flicker_count, error );
    job->options = s_parsed;
    return result;
}

static void say( void* user, const RfCost* cost, int spp )
{
    const Job* job = user;
    if ( !job->options.render.quiet )
        fprintf( stderr, "reframe cost: %d spp on %.0f pixels at %d camera position%s\n", spp, cost->pixels, cost->positions,
                 cost->positions == 1 ? "" : "s" );
}

// Finds how many frames one sweep of a render finishes.
static RfResult count_per_sweep( Job* job, int number, RfError* error )
{
    RfRenderSettings settings = job->options.render.settings, resolved;
    settings.group = curve_of( job, number )->group;
    settings.tile = curve_of( job, number )->tile;
    RfMemoryFit fit;
    RfResult result = rf_resolve_settings( &job->asked.shot, &settings, &resolved, error );
    if ( result == RF_OK )
        result = rf_fit_memory( &job->asked.shot, &resolved, &fit, error );
    if ( result != RF_OK )
        return result;
    job->per_sweep[number] = fit.sweeps > 1 ? fit.films : job->shot.frame_count;
    job->threads = fit.threads;
    return RF_OK;
}

// Reports what was found so far, also after an interruption.
static RfResult report( Job* job, RfError* error )
{
    const char *json = job->options.render.json, *svg = job->options.svg;
    RfResult result = count_per_sweep( job, 0, error );
    if ( result == RF_OK )
        result = count_per_sweep( job, 1, error );
    if ( result == RF_OK && rf_prints_text( json ) )
    {
        print_cost( job );
        result = rf_flush_output( error );
    }
    if ( result == RF_OK && svg != NULL )
        result = write_cost_plot( job, svg, error );
    return result == RF_OK && json != NULL ? rf_write_json( json, cost_json( job ), error ) : result;
}

static RfResult run( Job* job, RfError* error )
{
    RfResult result = rf_load_shot( "cost", &job->options.render, parse, job, &job->shot, error );
    if ( result != RF_OK )
        return result;
    job->load_seconds = rf_wall_seconds() - job->start;
    RfTrialWatch watch = { rf_may_go_on, NULL };
    job->asked = ( RfCostJob ){ .shot = rf_shot_to_render( &job->shot ),
                                .settings = &job->options.render.settings,
                                .watch = &watch,
                                .report = say,
                                .user = job };
    if ( job->options.error_count > 0 )
        job->asked.relmse = job->options.errors[job->options.error_count / 2];
    job->asked.budget = rf_budget_left( job->options.budget, job->start, &job->asked.deadline );
    result = rf_measure_cost( &job->asked, &job->cost, error );
    if ( result == RF_ERROR_INTERRUPTED && job->cost.reuse.count == 0 )
        return rf_fail( error, result, "interrupted before the first result" );
    if ( result != RF_OK && result != RF_ERROR_INTERRUPTED )
        return result;
    RfResult reported = report( job, error );
    return result == RF_OK || reported != RF_OK
               ? reported
               : rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted: the results so far are above" );
}

int rf_command_cost( int argc, char** argv )
{
    RfError error;
    Job job = { .argc = argc, .argv = argv, .start = rf_wall_seconds() };
    RfResult result = parse( NULL, &job, &error );
    if ( result == RF_OK && job.help )
        result = rf_show_help( &s_table, &error );
    else if ( result == RF_OK )
    {
        rf_catch_interrupts();
        result = run( &job, &error );
    }
    rf_destroy_shot( &job.shot );
    return result == RF_OK ? 0 : rf_report_error( "cost", &error );
}
