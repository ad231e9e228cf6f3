#include "cli/tune/tune_report.h"

#include "cli/messages.h"
#include "cli/options/shot.h"
#include "cli/tune/verdict.h"
#include "image/atomic_file.h"
#include "measure/plot.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static double bytes_of( const RfTuneRow* row )
{
    return (double)( row->fit.bytes_films + row->fit.bytes_hits + row->fit.bytes_lists );
}

static void print_row( const RfTuneRow* row )
{
    char tile[RF_TILE_NAME_SIZE], text[128], interval[48];
    rf_tile_name( &row->tile, tile );
    printf( "%c%5d %8s %5d", row->chosen ? '*' : ' ', row->group, tile, row->spp );
    if ( row->rounds == 0 )
    {
        const char* excluded = rf_tell_excluded( row->excluded, &row->fit, text, sizeof text );
        printf( "  not tried%s%s\n", excluded != NULL ? ": " : "", excluded != NULL ? excluded : "" );
        return;
    }
    char sweeps[32] = "";
    if ( row->fit.sweeps > 1 )
        snprintf( sweeps, sizeof sweeps, "  in %d sweeps", row->fit.sweeps );
    snprintf( interval, sizeof interval, isfinite( row->gain.low ) ? "%.2f-%.2f" : "-", row->gain.low, row->gain.high );
    printf( " %9.1f %9.3g %9.3g %9.3g %6.2f %10.4g %7.2f %11s %6d%s\n", bytes_of( row ) / 1048576.0, row->seconds, row->relmse,
            row->f1, row->phi, row->efficiency, row->gain.value, interval, row->rounds, sweeps );
}

static void print_rounds( const RfTuneReport* r )
{
    const RfTune* tune = r->tune;
    printf( "%.1f s;", tune->seconds );
    for ( int i = 0; i < tune->round_count; ++i )
        printf( "%s round %d on pieces of %.0f pixels, %d place%s", i > 0 ? "," : "", i + 1, tune->rounds[i].pixels,
                tune->rounds[i].regions, tune->rounds[i].regions == 1 ? "" : "s" );
    printf( "\n" );
}

// Two lines: the best setting and what it is worth, and what the render takes with it.
static void tell_verdict( const RfTuneReport* r, char text[RF_VERDICT_SIZE] )
{
    if ( r->tune->chosen < 0 )
    {
        snprintf( text, RF_VERDICT_SIZE, "no setting was tried to the end" );
        return;
    }
    const RfTuneRow* row = r->tune->rows + r->tune->chosen;
    char name[64], gain[160], all[32];
    bool reuse = row->eyes > 1 || row->tile.kind != RF_TILE_NONE;
    rf_format_reuse( row->eyes, &row->tile, name, sizeof name );
    bool flicker = r->tune->goal == RF_TUNE_FLICKER;
    snprintf( gain, sizeof gain, "no group and no tile is faster at equal %s", flicker ? "flicker" : "noise" );
    if ( reuse )
        ( flicker ? rf_tell_flicker_gain : rf_tell_gain )( &row->gain, gain, sizeof gain );
    rf_format_span( row->seconds, all, sizeof all );
    int used = snprintf(
        text, RF_VERDICT_SIZE,
        "the best is %s: %s\nwith it %d frame%s of %dx%d at %d samples take%s about %s, with a relMSE of about %.2g: noise of "
        "%.2g %% in a pixel",
        name, gain, r->frames, r->frames == 1 ? "" : "s", r->width, r->height, row->spp, r->frames == 1 ? "s" : "", all,
        row->relmse, 100.0 * sqrt( row->relmse / 3.0 ) );
    if ( flicker )
        snprintf( text + used, RF_VERDICT_SIZE - (size_t)used, ", and an F1 of about %.2g", row->f1 );
}

void rf_print_tune( const RfTuneReport* r )
{
    const RfTune* tune = r->tune;
    char verdict[RF_VERDICT_SIZE];
    tell_verdict( r, verdict );
    printf( "%s\n\n", verdict );
    printf( "%6s %8s %5s %9s %9s %9s %9s %6s %10s %7s %11s %6s\n", "group", "tile", "spp", "MiB", "seconds", "relMSE", "F1",
            "phi", "efficiency", "gain", "95 %", "rounds" );
    for ( int i = 0; i < tune->count; ++i )
        print_row( tune->rows + i );
    printf( "seconds: of all %d frames, wall-clock; efficiency: 1 / (%s x CPU seconds of a frame); gain: over "
            "group 0, tile 1, on the same pieces\n",
            r->frames, tune->goal == RF_TUNE_FLICKER ? "F1 squared" : "relMSE" );
    print_rounds( r );
    if ( r->command != NULL )
        printf( "* the best:\n%s\n", r->command );
}

static json_t* row_json( const RfTuneRow* row )
{
    char tile[RF_TILE_NAME_SIZE], text[128];
    rf_tile_name( &row->tile, tile );
    return json_pack(
        "{s:i, s:i, s:s, s:i, s:I, s:I, s:I, s:I, s:i, s:i, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:o, s:i, s:s?, s:b}",
        "group", row->group, "eyes", row->eyes, "tile", tile, "spp", row->spp, "bytes_films", (json_int_t)row->fit.bytes_films,
        "bytes_hits", (json_int_t)row->fit.bytes_hits, "bytes_lists", (json_int_t)row->fit.bytes_lists, "bytes_least",
        (json_int_t)row->fit.least, "chunks", row->fit.chunks, "sweeps", row->fit.sweeps, "predicted_gain",
        rf_json_number( row->predicted_gain ), "seconds", rf_json_number( row->seconds ), "cpu_seconds",
        rf_json_number( row->cpu_seconds ), "relmse", rf_json_number( row->relmse ), "flicker", rf_json_number( row->f1 ), "phi",
        rf_json_number( row->phi ), "efficiency", rf_json_number( row->efficiency ), "gain", rf_json_number( row->gain.value ),
        "gain_low", rf_json_number( row->gain.low ), "gain_high", rf_json_number( row->gain.high ), "rounds", row->rounds,
        "excluded", rf_tell_excluded( row->excluded, &row->fit, text, sizeof text ), "chosen", row->chosen );
}

json_t* rf_tune_json( const RfTuneReport* r )
{
    json_t *rows = json_array(), *rounds = json_array();
    for ( int i = 0; i < r->tune->count; ++i )
        json_array_append_new( rows, row_json( r->tune->rows + i ) );
    for ( int i = 0; i < r->tune->round_count; ++i )
    {
        const RfTuneRound* round = r->tune->rounds + i;
        json_array_append_new( rounds, json_pack( "{s:i, s:i, s:f, s:i, s:i}", "width", r->width, "height", r->height, "pixels",
                                                  round->pixels, "places", round->regions, "passes", round->passes ) );
    }
    char verdict[RF_VERDICT_SIZE];
    tell_verdict( r, verdict );
    return json_pack( "{s:s, s:s, s:o, s:o, s:f, s:f, s:i, s:i, s:i, s:o}", "verdict", verdict, "goal",
                      r->tune->goal == RF_TUNE_FLICKER ? "flicker" : "noise", "rows", rows, "rounds", rounds, "seconds",
                      r->tune->seconds, "budget", r->budget, "frames", r->frames, "width", r->width, "height", r->height,
                      "command", r->command != NULL ? rf_json_text( r->command ) : json_null() );
}

typedef struct Curves
{
    RfPlotSeries series[RF_TUNE_TILES];
    int count;
    double x[RF_TUNE_ROWS], y[RF_TUNE_ROWS];
    char names[RF_TUNE_TILES][32], labels[RF_TUNE_ROWS][32];
    const char* label[RF_TUNE_ROWS];
} Curves;

// Rows are ordered by tile; those that were not tried are left out.
static void collect( const RfTune* tune, Curves* c )
{
    int points = 0;
    c->count = 0;
    for ( int i = 0; i < tune->count; ++i )
    {
        const RfTuneRow* row = tune->rows + i;
        bool first = i == 0 || memcmp( &row->tile, &tune->rows[i - 1].tile, sizeof row->tile ) != 0;
        if ( first )
        {
            char tile[RF_TILE_NAME_SIZE];
            rf_tile_name( &row->tile, tile );
            snprintf( c->names[c->count], sizeof c->names[0], "tile %s", row->tile.kind == RF_TILE_NONE ? "1 (none)" : tile );
            c->series[c->count] = ( RfPlotSeries ){
                .name = c->names[c->count], .x = c->x + points, .y = c->y + points, .labels = c->label + points, .style = c->count
            };
            c->count += 1;
        }
        if ( row->rounds == 0 )
            continue;
        RfPlotSeries* series = c->series + c->count - 1;
        c->x[points] = bytes_of( row ) / 1048576.0;
        c->y[points] = row->efficiency;
        snprintf( c->labels[points], sizeof c->labels[0], "%d", row->group );
        c->label[points] = c->labels[points];
        series->count += 1;
        series->show_labels = series->show_labels || row->chosen;
        points += 1;
    }
}

RfResult rf_write_tune_plot( const RfTuneReport* r, const char* path, RfError* error )
{
    const RfTune* tune = r->tune;
    Curves curves = { 0 };
    collect( tune, &curves );
    char subtitle[512], note[64] = "", tile[RF_TILE_NAME_SIZE];
    const char* slash = strrchr( r->scene, '/' );
    snprintf( subtitle, sizeof subtitle, "%.200s, %dx%d, %d frames; numbers are the group's half-width N",
              slash != NULL ? slash + 1 : r->scene, r->width, r->height, r->frames );
    RfPlot plot = { .title = "Efficiency against memory",
                    .subtitle = subtitle,
                    .series = curves.series,
                    .series_count = curves.count,
                    .x = { .label = "memory of the render beyond the scene, MiB", .log = true },
                    .y = { .label = tune->goal == RF_TUNE_FLICKER ? "efficiency, 1 / (F1 squared \xc2\xb7 CPU seconds of a frame)"
                                                                  : "efficiency, 1 / (relMSE \xc2\xb7 CPU seconds of a frame)",
                           .log = true } };
    RfPlotNote best;
    if ( tune->chosen >= 0 )
    {
        const RfTuneRow* row = tune->rows + tune->chosen;
        rf_tile_name( &row->tile, tile );
        snprintf( note, sizeof note, "group %d, tile %s", row->group, tile );
        best = ( RfPlotNote ){ bytes_of( row ) / 1048576.0, row->efficiency, note };
        plot.notes = &best;
        plot.note_count = 1;
    }
    char* svg;
    size_t size;
    RfResult result = rf_draw_plot( &plot, &svg, &size, error );
    if ( result == RF_OK )
        result = rf_write_file_atomic( path, svg, size, error );
    free( svg );
    return result;
}
