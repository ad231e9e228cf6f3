// reframe cost: what accuracy costs in time.
#include "base/system.h"
#include "base/try.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/shared_options.h"
#include "cli/tune/trial_command.h"
#include "measure/cost.h"
#include "measure/plot.h"
#include "scene/leave_out.h"

#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define COST_ERRORS 16
#define BUDGET 60.0        // seconds
#define DENOISED_SHARE 0.2 // of it, for each of the two denoised curves

// The numbers of an option, as the user wrote it, and parsed.
typedef struct Goals
{
    const char* text; // NULL: none
    double values[COST_ERRORS];
    int count;
} Goals;

static RfTrialOptions s_given;   // the table points here, and to the goals
static Goals s_noise, s_flicker; // relMSE, relative F1

typedef struct Job
{
    RfTrialCommand command;
    RfCostJob asked;
    RfRenderSettings settings; // of it: what was given, with the guide
    RfGuide* guide;            // NULL: none
    RfCost cost;
    RfDenoiser* denoiser;       // NULL: without --denoise
    RfDenoisedCost denoised[2]; // by path tracing and with reuse
    int threads;
    int per_sweep[2];    // frames of a sweep, by path tracing and with reuse
    double load_seconds; // until rays can be traced: part of a render of all frames
} Job;

typedef struct NoiseText
{
    char text[RF_NOISE_TEXT_SIZE];
} NoiseText;

// "7.1 %", or "?" where the errors of a curve are known too little.
static NoiseText noise_of( const RfCostCurve* c, double relmse )
{
    NoiseText noise = { "?" };
    if ( rf_is_known( &c->line.error ) )
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
                c->rows[i].seconds, c->rows[i].cpu_seconds, rf_is_known( &clamp->line.error ) ? noise : "?", relmse,
                clamp->threshold, 100.0 * clamp->missing );
    }
}

static const RfCostCurve* curve_of( const Job* r, int number ) { return number == 0 ? &r->cost.plain : &r->cost.reuse; }

static void print_denoised( const Job* r, int number, const char* name )
{
    const RfDenoisedCost* d = r->denoised + number;
    const RfCostCurve* c = curve_of( r, number );
    char noise[RF_NOISE_TEXT_SIZE], low[RF_NOISE_TEXT_SIZE], high[RF_NOISE_TEXT_SIZE], span[32];
    if ( r->denoiser != NULL && d->spp == 0 )
    {
        rf_format_span( d->needed / DENOISED_SHARE, span, sizeof span );
        printf( "%s, denoised: not known within the budget: needs about %s\n", name, span );
    }
    if ( d->spp == 0 )
        return;
    RfCostPrediction p = rf_predict_samples( &r->asked, c, d->spp, r->per_sweep[number] );
    double seconds = p.frame_seconds + d->seconds;
    rf_format_noise( fmax( d->error.relmse, 0.0 ), noise );
    rf_format_noise( d->error.low, low );
    rf_format_noise( d->error.high, high );
    printf( "%-28s %7d %10.3g %10.3g %8s %10.3g  95 %%: %s to %s%s\n", "  denoised", d->spp, seconds, seconds * r->threads, noise,
            d->error.relmse, low, high, d->error.is_vague ? " or more" : "" );
}

static void print_slope( const RfCostCurve* c, const char* name )
{
    const RfInterval* p = &c->line.exponent;
    if ( c->count > 1 ) // one says nothing
        printf( "%s: relMSE falls as samples^%.2f (95 %%: %.2f to %.2f)\n", name, -p->value, -p->high, -p->low );
}

// The whole render, including the loading of the scene.
static double path_seconds( const Job* r, RfCostPrediction p ) { return p.seconds + r->load_seconds; }

// What is wanted: a relMSE, or a relative F1.
typedef struct Goal
{
    const char* name;
    double value;
    bool is_flicker;
} Goal;

static Goal noise_goal( double relmse ) { return ( Goal ){ "relMSE", relmse, false }; }

static Goal flicker_goal( double f1 ) { return ( Goal ){ "F1", f1, true }; }

// By path tracing (0) or with reuse (1).
static RfCostPrediction predict( const Job* r, Goal goal, int number )
{
    return goal.is_flicker ? rf_predict_flicker_cost( &r->asked, curve_of( r, number ), goal.value, r->per_sweep[number] )
                           : rf_predict_cost( &r->asked, curve_of( r, number ), goal.value, r->per_sweep[number] );
}

// What a goal takes: samples and seconds, with `at_least` where the error is known too little, so that this is the lower end.
typedef struct Price
{
    RfCostPrediction prediction;
    bool at_least;
    const RfCostClamp* clamp; // NULL: none
} Price;

// What the lower end of the interval takes, where the upper one is over four times as much.
static Price price_of( const Job* r, int number, RfCostPrediction p, const RfCostClamp* clamp )
{
    RfInterval seconds = { p.frame_seconds, p.low, p.high };
    Price price = { p, isgreater( p.low, 0.0 ) && !rf_is_known( &seconds ), clamp };
    if ( price.at_least )
        price.prediction =
            rf_predict_samples( &r->asked, curve_of( r, number ), ceil( p.spp * p.low / p.frame_seconds ), r->per_sweep[number] );
    return price;
}

static Price exact_price( const Job* r, Goal goal, int number )
{
    return price_of( r, number, predict( r, goal, number ), NULL );
}

static Price clamped_price( const Job* r, Goal goal )
{
    const RfCostClamp* clamp = NULL;
    RfCostPrediction p = { 0 };
    if ( !goal.is_flicker )
        p = rf_predict_clamped_cost( &r->asked, &r->cost, goal.value, r->per_sweep[1], &clamp );
    return price_of( r, 1, p, clamp );
}

// Of the error in the middle of those wanted.
static double main_error( void ) { return s_noise.values[s_noise.count / 2]; }

static RfInterval main_speedup( const Job* r ) { return rf_cost_speedup( &r->asked, &r->cost, main_error(), r->per_sweep ); }

// "94 s a frame (95 %: 81 s to 110 s), 16 min for all 48 (--spp 28)".
static void print_price( const Job* r, const char* name, Price price )
{
    const RfCostPrediction* p = &price.prediction;
    char frame[32], all[32], clamp[32] = "", missing[64] = "", interval[80] = "", tried[48] = "";
    if ( p->spp == 0 )
    {
        printf( "  %-16s more than %d spp, the limit\n", name, RF_MAX_SPP );
        return;
    }
    rf_format_span( p->frame_seconds, frame, sizeof frame );
    rf_format_span( path_seconds( r, *p ), all, sizeof all );
    if ( price.clamp != NULL )
    {
        snprintf( clamp, sizeof clamp, " --clamp %.3g", price.clamp->threshold );
        snprintf( missing, sizeof missing, ", %.2g %% of the light missing", 100.0 * price.clamp->missing );
    }
    if ( isgreater( p->low, 0.0 ) && isfinite( p->high ) )
    {
        char low[32], high[32];
        rf_format_span( p->low, low, sizeof low );
        rf_format_span( p->high, high, sizeof high );
        snprintf( interval, sizeof interval, " (95 %%: %s to %s)", low, high );
    }
    if ( p->tried > 0 )
        snprintf( tried, sizeof tried, ", extrapolated from %d spp", p->tried );
    printf( "  %-16s %s%s a frame%s, %s for all %d (--spp %d%s)%s%s\n", name, price.at_least ? "at least " : "", frame, interval,
            all, r->asked.shot.frame_count, p->spp, clamp, tried, missing );
}

// By the denoised picture; nothing where its error is not known.
static void print_denoised_price( const Job* r, const char* name, Goal goal, int number )
{
    const RfDenoisedCost* d = r->denoised + number;
    if ( goal.is_flicker || !( d->spp > 0 && d->error.relmse > 0.0 ) )
        return;
    RfCostPrediction p = rf_predict_denoised_cost( &r->asked, curve_of( r, number ), d, goal.value, r->per_sweep[number] );
    print_price( r, name, ( Price ){ p, false, NULL } );
}

static void format_goal( Goal goal, char* text, size_t size )
{
    char noise[RF_NOISE_TEXT_SIZE];
    ( goal.is_flicker ? rf_format_flicker : rf_format_noise )( goal.value, noise );
    if ( goal.is_flicker )
        snprintf( text, size, "flicker %s", noise );
    else
        snprintf( text, size, "%s noise (relMSE %.3g)", noise, goal.value );
}

static void print_goal( const Job* r, Goal goal )
{
    char name[160];
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
    print_denoised_price( r, "denoised", goal, 1 );
    print_price( r, "path tracing", exact_price( r, goal, 0 ) );
    print_denoised_price( r, "  denoised", goal, 0 );
    if ( goal.is_flicker )
        return;
    RfInterval speedup = rf_cost_speedup( &r->asked, &r->cost, goal.value, r->per_sweep );
    rf_format_gain( &speedup, r->cost.seconds, name, sizeof name );
    printf( "  %-16s %s\n", "reuse", name );
}

// What reuse is worth, and what the first error asked for takes.
static void format_verdict( const Job* r, char text[RF_VERDICT_SIZE] )
{
    const RfCost* cost = &r->cost;
    const RfInterval speedup = main_speedup( r );
    char name[64], gain[160], noise[RF_NOISE_TEXT_SIZE];
    rf_format_reuse( cost->reuse.eyes, &cost->reuse.tile, name, sizeof name );
    rf_format_gain( &speedup, cost->seconds, gain, sizeof gain );
    rf_format_noise( main_error(), noise );
    snprintf( text, RF_VERDICT_SIZE, "%s, at %s noise: %s", name, noise, gain );
    Goal goal = noise_goal( s_noise.values[0] );
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

static void print_cost( const void* user )
{
    const Job* r = user;
    char verdict[RF_VERDICT_SIZE];
    format_verdict( r, verdict );
    printf( "%s\n\n", verdict );
    const RfCost* cost = &r->cost;
    char name[64];
    rf_format_reuse( cost->reuse.eyes, &cost->reuse.tile, name, sizeof name );
    printf( "%-28s %7s %10s %10s %8s %10s\n", "", "spp", "seconds", "CPU s", "noise", "relMSE" );
    print_rows( &cost->plain, "path tracing" );
    print_denoised( r, 0, "path tracing" );
    print_rows( &cost->reuse, name );
    print_clamped( r );
    print_denoised( r, 1, name );
    printf( "seconds: of a frame of %dx%d with %d threads, from %.0f of its pixels at %d camera position%s, measured in %.1f s\n",
            s_given.render.size.width, s_given.render.size.height, r->threads, cost->pixels, cost->positions,
            cost->positions == 1 ? "" : "s", cost->seconds );
    print_slope( &cost->plain, "path tracing" );
    print_slope( &cost->reuse, name );
    for ( int i = 0; i < s_noise.count; ++i )
        print_goal( r, noise_goal( s_noise.values[i] ) );
    for ( int i = 0; i < s_flicker.count; ++i )
        print_goal( r, flicker_goal( s_flicker.values[i] ) );
}

static void add_rows( json_t* rows, const RfCostCurve* c, bool reuse )
{
    for ( int i = 0; i < c->count; ++i )
        json_array_append_new( rows, rf_trial_row_json( json_pack( "{s:b}", "reuse", reuse ), c->rows + i ) );
}

static json_t* prediction_json( const Job* r, RfCostPrediction p )
{
    return RF_SET_FIGURES( json_pack( "{s:o, s:o}", "spp", p.spp > 0 ? json_integer( p.spp ) : json_null(), "extrapolated_from",
                                      p.tried > 0 ? json_integer( p.tried ) : json_null() ),
                           { "frame_seconds", p.frame_seconds }, { "frame_seconds_low", p.low }, { "frame_seconds_high", p.high },
                           { "seconds", path_seconds( r, p ) } );
}

// Of one sample, by the line from some number of samples on.
static double of_one( const RfCostCurve* c, double value ) { return value * pow( c->line.samples, c->line.exponent.value ); }

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
    json_t* json = json_pack( "{s:o, s:f, s:o, s:o}", "clamped", clamped, key, goal.value, "plain",
                              prediction_json( r, predict( r, goal, 0 ) ), "reuse", prediction_json( r, predict( r, goal, 1 ) ) );
    RfInterval speedup = rf_cost_speedup( &r->asked, &r->cost, goal.value, r->per_sweep );
    return goal.is_flicker ? json
                           : RF_SET_FIGURES( json, { "speedup", speedup.value }, { "speedup_low", speedup.low },
                                             { "speedup_high", speedup.high } );
}

static json_t* denoised_json( const Job* r, int number )
{
    const RfDenoisedCost* d = r->denoised + number;
    json_t *json = json_pack( "{s:i, s:b}", "spp", d->spp, "is_vague", d->error.is_vague ), *wanted = json_array();
    if ( d->spp == 0 )
    {
        json_decref( json );
        json_decref( wanted );
        return json_null();
    }
    for ( int i = 0; i < s_noise.count; ++i )
        json_array_append_new( wanted,
                               prediction_json( r, rf_predict_denoised_cost( &r->asked, curve_of( r, number ), d,
                                                                             s_noise.values[i], r->per_sweep[number] ) ) );
    json_object_set_new( json, "wanted", wanted );
    return RF_SET_FIGURES( json, { "relmse", d->error.relmse }, { "low", d->error.low }, { "high", d->error.high },
                           { "exponent", d->exponent }, { "denoiser_seconds", d->seconds }, { "pixels", d->pixels } );
}

static json_t* cost_json( const void* user )
{
    const Job* r = user;
    const RfCost* cost = &r->cost;
    const RfInterval *reuse = &cost->reuse.line.exponent, *plain = &cost->plain.line.exponent, speedup = main_speedup( r );
    json_t *rows = json_array(), *wanted = json_array(), *flickers = json_array(), *clamps = json_array();
    char verdict[RF_VERDICT_SIZE];
    add_rows( rows, &cost->plain, false );
    add_rows( rows, &cost->reuse, true );
    for ( int i = 0; i < s_noise.count; ++i )
        json_array_append_new( wanted, goal_json( r, noise_goal( s_noise.values[i] ), "relmse" ) );
    for ( int i = 0; i < s_flicker.count; ++i )
        json_array_append_new( flickers, goal_json( r, flicker_goal( s_flicker.values[i] ), "f1" ) );
    for ( const RfCostClamp* c = cost->clamps; c < cost->clamps + cost->clamp_count; ++c )
        json_array_append_new( clamps, RF_SET_FIGURES( json_object(), { "clamp", c->threshold },
                                                       { "relmse_of_one_sample", rf_line_error( &c->line, 1.0 ).value },
                                                       { "bias", c->bias }, { "missing", c->missing } ) );
    format_verdict( r, verdict );
    // the scene, so that `report` can refuse what was measured with another one
    json_t* json = json_pack(
        "{s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:i, s:i, s:i, s:i}", "verdict", verdict, "scene",
        rf_json_text( s_given.render.scene ), "rows", rows, "wanted", wanted, "wanted_flicker", flickers, "clamps", clamps,
        "relmse_of_one_sample",
        both_json( of_one( &cost->plain, cost->plain.line.error.value ), of_one( &cost->reuse, cost->reuse.line.error.value ) ),
        "f1_squared_of_one_sample",
        both_json( of_one( &cost->plain, cost->plain.f1_squared ), of_one( &cost->reuse, cost->reuse.f1_squared ) ), "width",
        s_given.render.size.width, "height", s_given.render.size.height, "places", cost->positions, "frames",
        r->asked.shot.frame_count );
    rf_json_add( json, "{s:[o, o]}", "denoised", denoised_json( r, 0 ), denoised_json( r, 1 ) );
    return RF_SET_FIGURES( json, { "slope", -reuse->value }, { "slope_low", -reuse->high }, { "slope_high", -reuse->low },
                           { "slope_plain", -plain->value }, { "slope_plain_low", -plain->high },
                           { "slope_plain_high", -plain->low }, { "speedup_at_equal_error", speedup.value },
                           { "speedup_low", speedup.low }, { "speedup_high", speedup.high }, { "pixels", cost->pixels },
                           { "seconds", cost->seconds }, { "budget", s_given.budget },
                           { "beyond_depth_share", r->command.beyond_depth } );
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
    for ( int i = 0; i < c->count; ++i )
    {
        curve->x[i] = c->rows[i].seconds;
        curve->y[i] = c->rows[i].relmse;
    }
    series[0] =
        ( RfPlotSeries ){ .name = curve->name, .x = curve->x, .y = curve->y, .count = c->count, .no_line = true, .style = style };
    for ( int k = 0; k < 2; ++k )
    {
        int end = k * ( c->count - 1 );
        curve->fit_x[k] = curve->x[end];
        curve->fit_y[k] = rf_line_error( &c->line, c->rows[end].spp ).value;
    }
    snprintf( curve->fit_name, sizeof curve->fit_name, "error as samples^%.2f", -c->line.exponent.value );
    series[1] = ( RfPlotSeries ){ .name = curve->fit_name,
                                  .x = curve->fit_x,
                                  .y = curve->fit_y,
                                  .count = c->count > 0 ? 2 : 0,
                                  .dashed = true,
                                  .no_markers = true,
                                  .style = style };
}

#define DENOISED_REACH 8 // how many times fewer samples the line of denoised pictures shows

// The point that was measured, and a line by its exponent. False where there is none.
static bool draw_denoised( const Job* r, int number, Curve* curve, RfPlotSeries series[2] )
{
    const RfDenoisedCost* d = r->denoised + number;
    if ( !( d->spp > 0 && d->error.relmse > 0.0 ) )
        return false;
    for ( int k = 0; k < 2; ++k )
    {
        double times = k == 0 ? 1.0 : 1.0 / DENOISED_REACH;
        RfCostPrediction p = rf_predict_samples( &r->asked, curve_of( r, number ), times * d->spp, r->per_sweep[number] );
        curve->fit_x[k] = p.frame_seconds + d->seconds;
        curve->fit_y[k] = d->error.relmse * pow( times, -d->exponent );
    }
    curve->x[0] = curve->fit_x[0];
    curve->y[0] = curve->fit_y[0];
    snprintf( curve->name, sizeof curve->name, "%s", number == 0 ? "path tracing, denoised" : "reuse, denoised" );
    snprintf( curve->fit_name, sizeof curve->fit_name, "error as samples^%.2f", -d->exponent );
    series[0] =
        ( RfPlotSeries ){ .name = curve->name, .x = curve->x, .y = curve->y, .count = 1, .no_line = true, .style = 2 + number };
    series[1] = ( RfPlotSeries ){ .name = curve->fit_name,
                                  .x = curve->fit_x,
                                  .y = curve->fit_y,
                                  .count = 2,
                                  .dashed = true,
                                  .no_markers = true,
                                  .style = 2 + number };
    return true;
}

static RfResult write_cost_plot( const void* user, const char* path, RfError* error )
{
    const RfCost* cost = &( (const Job*)user )->cost;
    Curve plain, reuse, denoised[2];
    RfPlotSeries series[8];
    int count = 4;
    snprintf( plain.name, sizeof plain.name, "path tracing" );
    char tile[RF_TILE_NAME_SIZE]; // the legend is narrow
    rf_tile_name( &cost->reuse.tile, tile );
    snprintf( reuse.name, sizeof reuse.name, "group %d, tile %s", cost->reuse.group, tile );
    draw_curve( &cost->plain, 0, &plain, series );
    draw_curve( &cost->reuse, 1, &reuse, series + 2 );
    for ( int k = 0; k < 2; ++k )
        count += draw_denoised( user, k, denoised + k, series + count ) ? 2 : 0;
    char subtitle[512], gain[160];
    const RfInterval speedup = main_speedup( user );
    rf_format_gain( &speedup, cost->seconds, gain, sizeof gain );
    snprintf( subtitle, sizeof subtitle, "%.200s, %dx%d; %s", rf_scene_title( &s_given ), s_given.render.size.width,
              s_given.render.size.height, gain );
    RfPlot plot = { .title = "Error against render time",
                    .subtitle = subtitle,
                    .series = series,
                    .series_count = count,
                    .x = { .label = "seconds per frame", .log = true },
                    .y = { .label = "relMSE", .log = true } };
    return rf_write_plot( &plot, path, error );
}

#define ERRORS "0.1,0.01,0.001"

static const char* const s_files[] = { "SCENE" };
static const RfOption s_options[] = {
    RF_PATH_OPTIONS( s_given.render, "frames to render; a few are measured, the total time is predicted" ),
    RF_LENS_OPTIONS( s_given.render ),
    RF_MOVEMENT_OPTIONS( s_given.render ),
    RF_TIME_OPTION( "budget", &s_given.budget, 1.0, 1e6, "T",
                    "time to spend, in seconds or as 5m; more time narrows the intervals" ),
    RF_TEXT_OPTION( "noise", &s_noise.text, "E[,...]",
                    "predict the time to reach each relMSE, or noise of a channel in percent: 5.8% is relMSE 0.01" ),
    RF_TEXT_OPTION( "flicker", &s_flicker.text, "F[,...]",
                    "predict the time to reach each flicker of neighbouring frames, as a relative F1 or in percent" ),
    RF_FILTER_OPTIONS( s_given.render ),
    RF_PATH_TRACING_OPTIONS( s_given.render ),
    RF_SEED_OPTION( s_given.render ),
    RF_TEXT_OPTION( "svg", &s_given.svg, "FILE", "plot error against time, with and without reuse", .writes = ".svg",
                    .heading = RF_HEADING_OUTPUT ),
    RF_RESULT_OPTIONS( s_given.render, "write the result as JSON; - for standard output", "no progress" ),
    RF_GROUP_OPTION( s_given.render, "with reuse, share paths between 2N+1 neighbouring frames" ),
    RF_TILE_OPTION( s_given.render ),
    RF_FLAG_OPTION( "denoise", &s_given.render.denoise,
                    "also measure what denoised pictures cost, as of render --denoise, bias included", .in_file = true,
                    .heading = RF_HEADING_QUALITY ),
    RF_DENOISER_OPTION( s_given.render.denoiser ),
    RF_MACHINE_OPTIONS( s_given.render, "threads" ),
    RF_ESTIMATOR_OPTION( s_given.render ),
    RF_EFFECT_OPTIONS( s_given.render ),
};

static const RfCommandTable s_table = {
    .command = "cost",
    .summary = "Measures error against render time: renders a few frames at increasing sample counts, with path tracing and with "
               "reuse, and predicts the time to reach each target error, per frame and in total. SCENE and options are those of "
               "render.",
    RF_TABLE_ROWS( s_files, s_options )
};

// The numbers of an option, or percent.
static RfResult parse_goals( const char* name, bool is_noise, Goals* goals, RfError* error )
{
    goals->count = 0;
    for ( const char* text = goals->text; text != NULL; )
    {
        const char* end;
        double value;
        bool is_number = rf_parse_error_goal( text, !is_noise, &value, &end );
        if ( !is_number || !( value > 0.0 ) || ( *end != ',' && *end != '\0' ) )
            return rf_fail( error, RF_ERROR_USAGE,
                            "%s: expected numbers above 0, or percent such as 5%%, with commas between them, got '%s'", name,
                            goals->text );
        if ( goals->count == COST_ERRORS )
            return rf_fail( error, RF_ERROR_USAGE, "%s: more than %d numbers", name, COST_ERRORS );
        goals->values[goals->count++] = value;
        text = *end == '\0' ? NULL : end + 1;
    }
    return RF_OK;
}

static void reset( void )
{
    s_given = ( RfTrialOptions ){ .render = rf_default_render_options(), .budget = BUDGET };
    s_noise.text = ERRORS;
    s_flicker.text = NULL;
}

static RfResult settle( void* user, RfError* error )
{
    (void)user;
    rf_take_estimator_option( &s_given.render );
    rf_settle_filter( &s_given.render );
    RF_TRY( rf_parse_tile_option( &s_given.render, error ) );
    RF_TRY( parse_goals( "--noise", true, &s_noise, error ) );
    return parse_goals( "--flicker", false, &s_flicker, error );
}

static void say( void* user, const RfCost* cost, int spp )
{
    (void)user;
    if ( !s_given.render.quiet )
        fprintf( stderr, "reframe cost: %d spp on %.0f pixels at %d camera position%s\n", spp, cost->pixels, cost->positions,
                 cost->positions == 1 ? "" : "s" );
}

// Finds how many frames one sweep of a render finishes.
static RfResult count_per_sweep( void* user, RfError* error )
{
    Job* job = user;
    RfResult result = RF_OK;
    for ( int k = 0; k < 2 && result == RF_OK; ++k )
    {
        RfRenderSettings settings = s_given.render.settings, resolved;
        RfMemoryFit fit = { 0 };
        settings.group = curve_of( job, k )->group;
        settings.tile = curve_of( job, k )->tile;
        result = rf_resolve_settings( &job->asked.shot, &settings, &resolved, error );
        if ( result == RF_OK )
            result = rf_fit_memory( &job->asked.shot, &resolved, &fit, error );
        job->per_sweep[k] = fit.sweeps > 1 ? fit.films : job->asked.shot.frame_count;
        job->threads = fit.threads;
    }
    return result;
}

static RfResult search( void* user, RfError* error )
{
    static const RfTrialWatch watch = { rf_may_go_on, NULL };
    Job* job = user;
    job->load_seconds = fmin( rf_wall_seconds() - job->command.start, rf_process_seconds() ); // of an idle machine
    job->asked =
        ( RfCostJob ){ .shot = job->command.shot, .settings = &job->settings, .watch = &watch, .report = say, .user = job };
    RF_TRY( rf_guide_parts( &job->asked.shot, &s_given.render.settings, &job->settings, &job->guide, error ) );
    job->asked.relmse = main_error();
    job->asked.least = s_noise.values[0];
    for ( int i = 1; i < s_noise.count; ++i )
        job->asked.least = fmin( job->asked.least, s_noise.values[i] );
    double budget = rf_budget_left( &job->command, &job->asked.deadline );
    if ( s_given.render.denoise )
        RF_TRY( rf_open_denoiser( s_given.render.denoiser, s_given.render.settings.threads, &job->denoiser, error ) );
    job->asked.budget = job->denoiser != NULL ? ( 1.0 - 2.0 * DENOISED_SHARE ) * budget : budget;
    RfResult result = rf_measure_cost( &job->asked, &job->cost, error );
    for ( int k = 0; k < 2 && job->denoiser != NULL && result == RF_OK; ++k )
        result = rf_measure_denoised_cost( &job->asked, curve_of( job, k ), job->denoiser, DENOISED_SHARE * budget,
                                           job->denoised + k, error );
    job->command.found = job->cost.reuse.count > 0;
    if ( result != RF_ERROR_INTERRUPTED )
        return result;
    return rf_fail( error, result,
                    job->command.found ? "interrupted: the results so far are above" : "interrupted before the first result" );
}

int rf_command_cost( int argc, char** argv )
{
    static Job job;
    job = ( Job ){ .command = { .table = &s_table,
                                .options = &s_given,
                                .reset = reset,
                                .settle = settle,
                                .search = search,
                                .finish = count_per_sweep,
                                .print = print_cost,
                                .json = cost_json,
                                .plot = write_cost_plot,
                                .user = &job,
                                .argc = argc,
                                .argv = argv } };
    int status = rf_run_trial_command( &job.command );
    rf_close_denoiser( job.denoiser );
    rf_forget_guide( job.guide );
    return status;
}
