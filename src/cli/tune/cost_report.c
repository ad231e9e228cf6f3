#include "cli/tune/cost_report.h"

#include "cli/messages.h"
#include "image/atomic_file.h"
#include "measure/plot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

void rf_format_span( double seconds, char* text, size_t size )
{
    static const struct
    {
        double below, unit;
        const char* name;
    } units[] = { { 120.0, 1.0, "s" }, { 7200.0, 60.0, "min" }, { 172800.0, 3600.0, "h" }, { INFINITY, 86400.0, "days" } };
    int k = 0;
    while ( k < 3 && !( seconds < units[k].below ) )
        k += 1;
    double value = seconds / units[k].unit;
    snprintf( text, size, value < 10.0 ? "%.2g %s" : "%.0f %s", value, units[k].name );
}

void rf_format_reuse( const RfCostCurve* curve, char* text, size_t size )
{
    char tile[24];
    rf_tile_name( &curve->tile, tile );
    bool tiles = curve->tile.kind != RF_TILE_NONE;
    if ( curve->eyes > 1 )
        snprintf( text, size, tiles ? "groups of %d and %s tiles" : "groups of %d", curve->eyes, tile );
    else
        snprintf( text, size, "%s tiles", tile );
}

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

// All of a render: with the scene's loading.
static double path_seconds( const RfCostReport* r, RfCostPrediction p ) { return p.seconds + r->load_seconds; }

static void print_error( const RfCostReport* r, double relmse )
{
    RfCostPrediction reuse = rf_predict_cost( r->job, &r->cost->reuse, relmse, r->per_sweep[1] );
    RfCostPrediction plain = rf_predict_cost( r->job, &r->cost->plain, relmse, r->per_sweep[0] );
    RfSize size = r->options->render.size;
    char name[64], frame[32], all[32], plain_frame[32], plain_all[32];
    rf_format_reuse( &r->cost->reuse, name, sizeof name );
    if ( reuse.spp == 0 )
    {
        printf( "relMSE %g at %dx%d: more than %d samples, which is the most\n", relmse, size.width, size.height, RF_MAX_SPP );
        return;
    }
    rf_format_span( reuse.frame_seconds, frame, sizeof frame );
    rf_format_span( path_seconds( r, reuse ), all, sizeof all );
    printf( "relMSE %g at %dx%d: %s a frame with %s (--spp %d)", relmse, size.width, size.height, frame, name, reuse.spp );
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

void rf_print_cost( const RfCostReport* r )
{
    const RfCost* cost = r->cost;
    char name[64];
    rf_format_reuse( &cost->reuse, name, sizeof name );
    printf( "%-28s %7s %10s %10s %10s\n", "", "spp", "seconds", "CPU s", "relMSE" );
    print_rows( &cost->plain, "path tracing" );
    print_rows( &cost->reuse, name );
    printf( "seconds: of a frame of %dx%d, on the clock; tried at %dx%d, at %d place%s of the path, for %.1f s in all\n",
            r->options->render.size.width, r->options->render.size.height, cost->width, cost->height, cost->positions,
            cost->positions == 1 ? "" : "s", cost->seconds );
    if ( (double)cost->width * cost->height < 0.5 * r->options->render.size.width * r->options->render.size.height )
        printf( "tiles do more on large pictures than on those tried: a longer --budget makes them larger\n" );
    print_slope( &cost->plain, "path tracing" );
    print_slope( &cost->reuse, name );
    printf( "at equal error %s take 1/%.2f of the time", name, cost->speedup.value );
    if ( isfinite( cost->speedup.low ) )
        printf( " (95 %%: 1/%.2f to 1/%.2f)", cost->speedup.low, cost->speedup.high );
    printf( "\n" );
    for ( int i = 0; i < r->options->error_count; ++i )
        print_error( r, r->options->errors[i] );
}

static void add_rows( json_t* rows, const RfCostCurve* c, bool reuse )
{
    char tile[24];
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

json_t* rf_cost_json( const RfCostReport* r )
{
    const RfCost* cost = r->cost;
    json_t *rows = json_array(), *wanted = json_array();
    add_rows( rows, &cost->plain, false );
    add_rows( rows, &cost->reuse, true );
    for ( int i = 0; i < r->options->error_count; ++i )
    {
        double e = r->options->errors[i];
        json_array_append_new(
            wanted, json_pack( "{s:f, s:o, s:o}", "relmse", e, "plain",
                               prediction_json( r, rf_predict_cost( r->job, &cost->plain, e, r->per_sweep[0] ) ), "reuse",
                               prediction_json( r, rf_predict_cost( r->job, &cost->reuse, e, r->per_sweep[1] ) ) ) );
    }
    return json_pack( "{s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:i, s:i, s:i, s:i, s:f, s:f}", "rows", rows,
                      "slope", rf_json_number( cost->reuse.slope.value ), "slope_low", rf_json_number( cost->reuse.slope.low ),
                      "slope_high", rf_json_number( cost->reuse.slope.high ), "slope_plain",
                      rf_json_number( cost->plain.slope.value ), "slope_plain_low", rf_json_number( cost->plain.slope.low ),
                      "slope_plain_high", rf_json_number( cost->plain.slope.high ), "speedup_at_equal_error",
                      rf_json_number( cost->speedup.value ), "speedup_low", rf_json_number( cost->speedup.low ), "speedup_high",
                      rf_json_number( cost->speedup.high ), "relmse_of_one_sample",
                      json_pack( "[o, o]", rf_json_number( cost->plain.relmse ), rf_json_number( cost->reuse.relmse ) ), "wanted",
                      wanted, "width", cost->width, "height", cost->height, "places", cost->positions, "frames",
                      r->job->frame_count, "seconds", cost->seconds, "budget", r->options->budget );
}

// A curve's points, and the line through them.
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
    char tile[24]; // the legend is narrow
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
