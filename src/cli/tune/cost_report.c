#include "cli/tune/cost_report.h"

#include "cli/messages.h"
#include "cli/tune/verdict.h"
#include "image/atomic_file.h"
#include "measure/plot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void print_rows( const RfCostCurve* c, const char* name )
{
    for ( int i = 0; i < c->count; ++i )
        printf( "%-28s %7d %10.4g %10.4g %10.4g\n", name, c->rows[i].spp, c->rows[i].seconds, c->rows[i].cpu_seconds,
                c->rows[i].relmse );
}

static void print_slope( const RfCostCurve* c, const char* name )
{
    if ( !isfinite( c->slope.value ) )
        return;
    printf( "%s: error falls as seconds to the power of %.2f", name, c->slope.value );
    if ( isfinite( c->slope.low ) )
        printf( " (95 %%: %.2f to %.2f)", c->slope.low, c->slope.high );
    printf( "\n" );
}

// The whole render, including the loading of the scene.
static double path_seconds( const RfCostReport* r, RfCostPrediction p ) { return p.seconds + r->load_seconds; }

// What is wanted: a relMSE, or an F1.
typedef struct Goal
{
    const char* name;
    double value;
    bool is_flicker;
} Goal;

static Goal noise_goal( double relmse ) { return ( Goal ){ "relMSE", relmse, false }; }

static Goal flicker_goal( double f1 ) { return ( Goal ){ "F1", f1, true }; }

// By path tracing (0) or with reuse (1).
static RfCostPrediction predict( const RfCostReport* r, Goal goal, int curve )
{
    const RfCostCurve* c = curve == 0 ? &r->cost->plain : &r->cost->reuse;
    return goal.is_flicker ? rf_predict_flicker_cost( r->job, c, goal.value, r->per_sweep[curve] )
                           : rf_predict_cost( r->job, c, goal.value, r->per_sweep[curve] );
}

static void print_goal( const RfCostReport* r, Goal goal )
{
    RfCostPrediction reuse = predict( r, goal, 1 ), plain = predict( r, goal, 0 );
    RfSize size = r->options->render.size;
    char name[64], frame[32], all[32], plain_frame[32], plain_all[32];
    rf_format_reuse( r->cost->reuse.eyes, &r->cost->reuse.tile, name, sizeof name );
    if ( reuse.spp == 0 )
    {
        printf( "%s %g at %dx%d: more than %d samples, which is the most\n", goal.name, goal.value, size.width, size.height,
                RF_MAX_SPP );
        return;
    }
    rf_format_span( reuse.frame_seconds, frame, sizeof frame );
    rf_format_span( path_seconds( r, reuse ), all, sizeof all );
    printf( "%s %g at %dx%d: %s a frame with %s (--spp %d)", goal.name, goal.value, size.width, size.height, frame, name,
            reuse.spp );
    if ( plain.spp > 0 )
    {
        rf_format_span( plain.frame_seconds, plain_frame, sizeof plain_frame );
        rf_format_span( path_seconds( r, plain ), plain_all, sizeof plain_all );
        printf( ", %s by path tracing (--spp %d); all %d frame%s: %s, %s by path tracing\n", plain_frame, plain.spp,
                r->job->frame_count, r->job->frame_count == 1 ? "" : "s", all, plain_all );
    }
    else
        printf( "; all %d frame%s: %s\n", r->job->frame_count, r->job->frame_count == 1 ? "" : "s", all );
}

// Two lines: what reuse is worth, and what the first error asked for takes.
static void tell_verdict( const RfCostReport* r, char text[RF_VERDICT_SIZE] )
{
    const RfCost* cost = r->cost;
    char name[64], gain[160], frame[32], all[32];
    rf_format_reuse( cost->reuse.eyes, &cost->reuse.tile, name, sizeof name );
    rf_tell_gain( &cost->speedup, gain, sizeof gain );
    int used = snprintf( text, RF_VERDICT_SIZE, "a render with %s is %s", name, gain );
    if ( r->options->error_count == 0 )
        return;
    double relmse = r->options->errors[0];
    RfCostPrediction p = predict( r, noise_goal( relmse ), 1 );
    rf_format_span( p.frame_seconds, frame, sizeof frame );
    rf_format_span( path_seconds( r, p ), all, sizeof all );
    if ( p.spp > 0 )
        snprintf( text + used, RF_VERDICT_SIZE - (size_t)used,
                  "\nrelMSE %g, noise of %.2g %% in a pixel, takes %d samples: %s for a frame, %s for all %d", relmse,
                  100.0 * sqrt( relmse / 3.0 ), p.spp, frame, all, r->job->frame_count );
    else
        snprintf( text + used, RF_VERDICT_SIZE - (size_t)used, "\nrelMSE %g takes more than %d samples, which is the most",
                  relmse, RF_MAX_SPP );
}

void rf_print_cost( const RfCostReport* r )
{
    char verdict[RF_VERDICT_SIZE];
    tell_verdict( r, verdict );
    printf( "%s\n\n", verdict );
    const RfCost* cost = r->cost;
    char name[64];
    rf_format_reuse( cost->reuse.eyes, &cost->reuse.tile, name, sizeof name );
    printf( "%-28s %7s %10s %10s %10s\n", "", "spp", "seconds", "CPU s", "relMSE" );
    print_rows( &cost->plain, "path tracing" );
    print_rows( &cost->reuse, name );
    printf( "seconds: of a frame of %dx%d, on the clock; tried on pieces of %.0f pixels of it in all, at %d place%s of the path, "
            "for %.1f s\n",
            r->options->render.size.width, r->options->render.size.height, cost->pixels, cost->positions,
            cost->positions == 1 ? "" : "s", cost->seconds );
    print_slope( &cost->plain, "path tracing" );
    print_slope( &cost->reuse, name );
    printf( "at equal error %s take 1/%.2f of the time", name, cost->speedup.value );
    if ( isfinite( cost->speedup.low ) )
        printf( " (95 %%: 1/%.2f to 1/%.2f)", cost->speedup.low, cost->speedup.high );
    printf( "\n" );
    for ( int i = 0; i < r->options->error_count; ++i )
        print_goal( r, noise_goal( r->options->errors[i] ) );
    for ( int i = 0; i < r->options->flicker_count; ++i )
        print_goal( r, flicker_goal( r->options->flickers[i] ) );
}

static void add_rows( json_t* rows, const RfCostCurve* c, bool reuse )
{
    char tile[RF_TILE_NAME_SIZE];
    rf_tile_name( &c->tile, tile );
    for ( int i = 0; i < c->count; ++i )
        json_array_append_new( rows, json_pack( "{s:b, s:i, s:s, s:i, s:o, s:o, s:o}", "reuse", reuse, "group", c->group, "tile",
                                                tile, "spp", c->rows[i].spp, "seconds", rf_json_number( c->rows[i].seconds ),
                                                "cpu_seconds", rf_json_number( c->rows[i].cpu_seconds ), "relmse",
                                                rf_json_number( c->rows[i].relmse ) ) );
}

static json_t* prediction_json( const RfCostReport* r, RfCostPrediction p )
{
    return json_pack( "{s:o, s:o, s:o}", "spp", p.spp > 0 ? json_integer( p.spp ) : json_null(), "frame_seconds",
                      rf_json_number( p.frame_seconds ), "seconds", rf_json_number( path_seconds( r, p ) ) );
}

static json_t* goal_json( const RfCostReport* r, Goal goal, const char* key )
{
    return json_pack( "{s:f, s:o, s:o}", key, goal.value, "plain", prediction_json( r, predict( r, goal, 0 ) ), "reuse",
                      prediction_json( r, predict( r, goal, 1 ) ) );
}

json_t* rf_cost_json( const RfCostReport* r )
{
    const RfCost* cost = r->cost;
    json_t *rows = json_array(), *wanted = json_array(), *flickers = json_array();
    add_rows( rows, &cost->plain, false );
    add_rows( rows, &cost->reuse, true );
    for ( int i = 0; i < r->options->error_count; ++i )
    {
        json_array_append_new( wanted, goal_json( r, noise_goal( r->options->errors[i] ), "relmse" ) );
    }
    for ( int i = 0; i < r->options->flicker_count; ++i )
        json_array_append_new( flickers, goal_json( r, flicker_goal( r->options->flickers[i] ), "f1" ) );
    char verdict[RF_VERDICT_SIZE];
    tell_verdict( r, verdict );
    json_t* json = json_pack(
        "{s:s, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:i, s:i, s:f, s:i, s:i, s:f, s:f}", "verdict",
        verdict, "rows", rows, "slope", rf_json_number( cost->reuse.slope.value ), "slope_low",
        rf_json_number( cost->reuse.slope.low ), "slope_high", rf_json_number( cost->reuse.slope.high ), "slope_plain",
        rf_json_number( cost->plain.slope.value ), "slope_plain_low", rf_json_number( cost->plain.slope.low ), "slope_plain_high",
        rf_json_number( cost->plain.slope.high ), "speedup_at_equal_error", rf_json_number( cost->speedup.value ), "speedup_low",
        rf_json_number( cost->speedup.low ), "speedup_high", rf_json_number( cost->speedup.high ), "relmse_of_one_sample",
        json_pack( "[o, o]", rf_json_number( cost->plain.relmse ), rf_json_number( cost->reuse.relmse ) ), "wanted", wanted,
        "width", r->options->render.size.width, "height", r->options->render.size.height, "pixels", cost->pixels, "places",
        cost->positions, "frames", r->job->frame_count, "seconds", cost->seconds, "budget", r->options->budget );
    json_object_set_new(
        json, "f1_squared_of_one_sample",
        json_pack( "[o, o]", rf_json_number( cost->plain.f1_squared ), rf_json_number( cost->reuse.f1_squared ) ) );
    json_object_set_new( json, "wanted_flicker", flickers );
    return json;
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
    snprintf( curve->fit_name, sizeof curve->fit_name, "its slope, %.2f", c->slope.value );
    series[1] = ( RfPlotSeries ){ .name = curve->fit_name,
                                  .x = curve->fit_x,
                                  .y = curve->fit_y,
                                  .count = isfinite( c->slope.value ) ? 2 : 0,
                                  .dashed = true,
                                  .no_markers = true,
                                  .style = style };
}

RfResult rf_write_cost_plot( const RfCostReport* r, const char* path, RfError* error )
{
    const RfCost* cost = r->cost;
    Curve plain, reuse;
    RfPlotSeries series[4];
    snprintf( plain.name, sizeof plain.name, "path tracing" );
    char tile[RF_TILE_NAME_SIZE]; // the legend is narrow
    rf_tile_name( &cost->reuse.tile, tile );
    snprintf( reuse.name, sizeof reuse.name, "group %d, tile %s", cost->reuse.group, tile );
    draw_curve( &cost->plain, 0, &plain, series );
    draw_curve( &cost->reuse, 1, &reuse, series + 2 );
    char subtitle[512];
    const char* slash = strrchr( r->options->render.scene, '/' );
    int length = snprintf( subtitle, sizeof subtitle, "%.200s, %dx%d; at equal error 1/%.2f of the time",
                           slash != NULL ? slash + 1 : r->options->render.scene, r->options->render.size.width,
                           r->options->render.size.height, cost->speedup.value );
    if ( isfinite( cost->speedup.low ) && length > 0 && (size_t)length < sizeof subtitle )
        snprintf( subtitle + length, sizeof subtitle - (size_t)length, " (95 %%: 1/%.2f to 1/%.2f)", cost->speedup.low,
                  cost->speedup.high );
    RfPlot plot = { .title = "What accuracy costs",
                    .subtitle = subtitle,
                    .series = series,
                    .series_count = 4,
                    .x = { .label = "seconds of a frame", .log = true },
                    .y = { .label = "relMSE", .log = true } };
    char* svg;
    size_t size;
    RfResult result = rf_draw_plot( &plot, &svg, &size, error );
    if ( result == RF_OK )
        result = rf_write_file_atomic( path, svg, size, error );
    free( svg );
    return result;
}
