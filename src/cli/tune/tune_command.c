// reframe tune: finds the best group and tile by short renders.
#include "base/plain_text.h"
#include "base/try.h"
#include "base/words.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "cli/options/shared_options.h"
#include "cli/tune/trial_command.h"
#include "measure/plot.h"
#include "measure/trial_runs.h"
#include "measure/tune.h"
#include "reframe/plan.h"
#include "reframe/render.h"
#include "render/settings.h"
#include "scene/light_groups.h"

#include <ctype.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

// What it costs to split the light of a render by groups (--light-groups) and passes (--aov emission and so on): memory by the plan, time by
// short renders with and without.

typedef struct SplitCosts
{
    int films;                      // more of each frame; 0: nothing is asked for
    size_t bytes_films, bytes_hits; // more
    double time_share;              // more time, as a share of that without; NaN: not measured
} SplitCosts;

#define PIXELS 4096.0 // of each frame that is measured
#define PASSES 2

static RfRenderSettings without_split( const RfRenderSettings* settings )
{
    RfRenderSettings plain = *settings;
    plain.light_groups = NULL;
    plain.aovs &= ~RF_PASS_AOVS;
    return plain;
}

static RfResult count_films( const RfShot* shot, const RfRenderSettings* settings, int* films, RfError* error )
{
    RfLightGroups groups;
    RF_TRY( rf_find_light_groups( rf_tracer_scene( shot->tracer ), settings->light_groups, &groups, error ) );
    *films = groups.count + __builtin_popcount( settings->aovs & RF_PASS_AOVS );
    rf_destroy_light_groups( &groups );
    return RF_OK;
}

static RfResult measure_time( const RfShot* shot, const RfRenderSettings* settings, const RfRenderSettings* plain, double* share,
                              RfError* error )
{
    RfTestRegion region;
    RfTrial trials[2] = { 0 };
    RfTestSite site = { .centre = shot->eye_count / 2, .frames = 2 * settings->group + 1, .pixels = PIXELS };
    RfResult result = rf_create_test_region( shot, NULL, &site, plain, &region, error );
    for ( int k = 0; k < 2 && result == RF_OK; ++k )
    {
        RfRenderSettings one = rf_trial_settings( k == 0 ? plain : settings );
        one.threads = 1;
        result = rf_run_trial( &region, 1, PASSES, &one, trials + k, error );
    }
    rf_destroy_test_region( &region );
    if ( result == RF_OK )
        *share = rf_trial_sample_seconds( trials + 1 ) / rf_trial_sample_seconds( trials ) - 1.0;
    return result;
}

// Of a render of the shot with these settings, whose group is known. `measure`: the time is measured on some pixels.
static RfResult find_split_costs( const RfShot* shot, const RfRenderSettings* settings, bool measure, SplitCosts* costs,
                                  RfError* error )
{
    RfMemoryFit fit[2];
    RfRenderSettings plain = without_split( settings );
    *costs = ( SplitCosts ){ .time_share = (double)NAN };
    RfResult result = count_films( shot, settings, &costs->films, error );
    if ( result != RF_OK || costs->films == 0 )
        return result;
    RF_TRY( rf_fit_memory( shot, settings, fit, error ) );
    RF_TRY( rf_fit_memory( shot, &plain, fit + 1, error ) );
    size_t of_batch = fit[0].bytes_hits / (size_t)fit[0].batches - fit[1].bytes_hits / (size_t)fit[1].batches;
    costs->bytes_films = fit[0].bytes_films > fit[1].bytes_films ? fit[0].bytes_films - fit[1].bytes_films : 0;
    costs->bytes_hits = of_batch * (size_t)fit[0].batches;
    return measure ? measure_time( shot, settings, &plain, &costs->time_share, error ) : RF_OK;
}

static void print_split_costs( const SplitCosts* costs )
{
    char time[64] = "time: not measured";
    if ( costs->films == 0 )
        return;
    if ( isfinite( costs->time_share ) )
        snprintf( time, sizeof time, "%.0f %% more time", 100.0 * fmax( costs->time_share, 0.0 ) );
    rf_print( "light groups and passes: %d film%s more of each frame, %.1f MiB of films and %.1f MiB of hits more, %s\n",
              costs->films, costs->films == 1 ? "" : "s", (double)costs->bytes_films / 1048576.0,
              (double)costs->bytes_hits / 1048576.0, time );
}

static json_t* split_costs_json( const SplitCosts* costs )
{
    if ( costs->films == 0 )
        return json_null();
    return json_pack( "{s:i, s:I, s:I, s:o}", "films", costs->films, "bytes_films", (json_int_t)costs->bytes_films, "bytes_hits",
                      (json_int_t)costs->bytes_hits, "time_share", rf_json_number( costs->time_share ) );
}

static RfTrialOptions s_given; // the table points here
static int s_goal;             // an RfTuneGoal
static bool s_group_given;

typedef struct Job
{
    RfTrialCommand command;
    RfPlan plan;
    RfTune tune;
    RfRenderSettings settings; // of its trials: what was given, with the guide
    RfGuide* guide;            // NULL: none
    RfRanges ranges;           // for --nodes; its list is NULL: none
    char* best;                // the command line of the winner; NULL: there is none
    SplitCosts split;
} Job;

static double fit_mib( const RfMemoryFit* fit )
{
    return (double)( fit->bytes_films + fit->bytes_hits + fit->bytes_lists ) / 1048576.0;
}

// What a render without --group takes; NULL where nothing with this tile fits.
static const RfPlanRow* auto_row( const Job* r ) { return r->plan.count > 0 ? r->plan.rows + r->plan.chosen : NULL; }

static bool at_most( const RfRenderSettings* s ) { return s->noise > 0.0 || s->flicker > 0.0 || s->time > 0.0; }

// Why a row is excluded, with the least budget where it does not fit: "does not fit in memory, needs at least 3M". NULL where it is not.
static const char* format_excluded( const char* excluded, const RfMemoryFit* fit, char* text, size_t size )
{
    if ( excluded == NULL )
        return NULL;
    snprintf( text, size, fit->films > 0 ? "%s" : "%s, needs at least %zuM", excluded, rf_whole_mib( fit->least ) );
    return text;
}

static void print_group( const RfPlanRow* row )
{
    char sweeps[32] = "", text[128];
    const char* excluded = format_excluded( row->excluded, &row->fit, text, sizeof text );
    char tile[RF_TILE_NAME_SIZE];
    rf_tile_name( &row->tile, tile );
    printf( "%c%5d %7d %5s %5d", row->chosen ? '*' : ' ', row->group, row->eyes, tile, row->spp );
    if ( !rf_plan_row_fits( row ) )
    {
        printf( "  %s\n", excluded );
        return;
    }
    if ( row->fit.sweeps > 1 )
        snprintf( sweeps, sizeof sweeps, "  in %d sweeps", row->fit.sweeps );
    printf( " %9.1f %8.1f %8.1f %8.1f %7d %6.1f %6.1f%s%s%s\n", fit_mib( &row->fit ), (double)row->fit.bytes_films / 1048576.0,
            (double)row->fit.bytes_hits / 1048576.0, (double)row->fit.bytes_lists / 1048576.0, row->fit.chunks, row->reach,
            row->gain, sweeps, excluded != NULL ? "  not for auto: " : "", excluded != NULL ? excluded : "" );
}

static void print_groups( const Job* r )
{
    const RfRenderSettings* settings = &s_given.render.settings;
    bool groups = rf_has_groups( settings->estimator ), tiles = settings->tile.kind == RF_TILE_AUTO;
    if ( r->plan.count == 0 )
        return;
    printf( "%6s %7s %5s %5s %9s %8s %8s %8s %7s %6s %6s\n", "group", "cameras", "tile", "spp", "MiB", "films", "hits", "work",
            "chunks", "reach", "gain" );
    for ( int i = 0; i < r->plan.count; ++i )
        print_group( r->plan.rows + i );
    printf( "MiB: beyond the scene; reach: effective samples for each one traced; gain: upper bound, over %s\n",
            tiles ? "path tracing" : "the tile alone" );
    if ( at_most( &s_given.render.settings ) )
        printf( "memory is for %d spp, the limit with --noise, --flicker and --time\n", s_given.render.settings.spp );
    if ( groups )
        printf( "* --group auto%s: %s\n", tiles ? " and --tile auto" : "", r->plan.why );
    printf( "\n" );
}

static void print_row( const RfTrialRow* row )
{
    char tile[RF_TILE_NAME_SIZE], relmse[RF_FIGURE_SIZE], noise[RF_NOISE_TEXT_SIZE], gain[RF_FIGURE_SIZE],
        interval[48] = "", flicker[RF_NOISE_TEXT_SIZE];
    rf_tile_name( &row->tile, tile );
    rf_format_flicker( row->f1, flicker );
    rf_format_figure( &row->error, relmse );
    rf_format_figure( &row->gain, gain );
    if ( rf_is_known( &row->error ) )
        rf_format_noise( row->relmse, noise );
    else
        snprintf( noise, sizeof noise, "?" );
    if ( rf_is_known( &row->gain ) && !rf_is_plain_row( row ) )
        snprintf( interval, sizeof interval, "%.3g to %.3g", row->gain.low, row->gain.high );
    printf( "%c%5d %8s %5d %9.1f %9.3g %8s %9s %9s %8s  %s", row->chosen ? '*' : ' ', row->group, tile, row->spp,
            fit_mib( &row->fit ), row->seconds, noise, relmse, flicker, gain, interval );
    printf( row->fit.sweeps > 1 ? "  in %d sweeps\n" : "\n", row->fit.sweeps );
}

// How many settings were left out, and why.
static void print_left_out( const RfTune* tune )
{
    const char* before = "not measured: ";
    for ( int i = 0; i < tune->count; ++i )
    {
        const RfTrialRow* row = tune->rows + i;
        int count = 0;
        bool said = row->rounds > 0;
        for ( int k = 0; k < tune->count; ++k )
        {
            bool same = tune->rows[k].rounds == 0 && tune->rows[k].excluded == row->excluded;
            said = said || ( same && k < i );
            count += same;
        }
        if ( said )
            continue;
        printf( "%s%d setting%s: %s", before, count, count > 1 ? "s" : "",
                row->excluded != NULL ? row->excluded : "no time left" );
        before = "; ";
    }
    printf( "%s", before[0] == ';' ? "\n" : "" );
}

static void print_rows( const Job* r )
{
    const RfTune* tune = &r->tune;
    printf( "%6s %8s %5s %9s %9s %8s %9s %9s %8s  %s\n", "group", "tile", "spp", "MiB", "seconds", "noise", "relMSE", "flicker",
            "gain", "95 %" );
    for ( int i = 0; i < tune->count; ++i )
    {
        if ( tune->rows[i].rounds > 0 )
            print_row( tune->rows + i );
    }
    printf(
        "seconds: of all %d frames with %d threads; gain: over path tracing (group 0, tile 1) at equal %s; > and ?: the interval "
        "is wider than a factor of 4\n",
        r->command.shot.frame_count, tune->rows[0].fit.threads, tune->goal == RF_TUNE_FLICKER ? "flicker" : "noise" );
    print_left_out( tune );
    printf( "measured in %.1f s:", tune->seconds );
    for ( int i = 0; i < tune->round_count; ++i )
        printf( "%s round %d on %.0f pixels at %d camera position%s", i > 0 ? "," : "", i + 1, tune->rounds[i].pixels,
                tune->rounds[i].regions, tune->rounds[i].regions == 1 ? "" : "s" );
    printf( "\n" );
}

static void append_shot( const Job* r, int spp, char text[RF_VERDICT_SIZE] )
{
    rf_append( text, RF_VERDICT_SIZE, "%d frame%s at %dx%d and %d spp: ", r->command.shot.frame_count,
               r->command.shot.frame_count == 1 ? "" : "s", s_given.render.size.width, s_given.render.size.height, spp );
}

// What is known without rendering, or in too little time.
static void format_planned( const Job* r, char text[RF_VERDICT_SIZE] )
{
    const RfPlanRow* row = auto_row( r );
    const RfEstimator* estimator = s_given.render.settings.estimator;
    char name[64], span[32], rest[112] = "; time and noise: --budget 20";
    rf_format_span( r->tune.needed, span, sizeof span );
    if ( s_given.budget > 0.0 )
        snprintf( rest, sizeof rest, "; time and noise not known within the budget: needs about %s", span );
    if ( row == NULL )
    {
        snprintf( text, RF_VERDICT_SIZE, "no group with this tile fits in memory\n%s", rest + 2 );
        return;
    }
    rf_format_reuse( row->eyes, &s_given.render.settings.tile, name, sizeof name );
    snprintf( text, RF_VERDICT_SIZE, "--%s %s: %s\n", rf_has_groups( estimator ) ? "group" : "estimator",
              rf_has_groups( estimator ) ? "auto" : rf_estimator_name( estimator ), name );
    append_shot( r, row->spp, text );
    rf_append( text, RF_VERDICT_SIZE, "%s%.0f MiB beyond the scene%s", at_most( &s_given.render.settings ) ? "at most " : "",
               ceil( fit_mib( &row->fit ) ), rest );
}

// "about 11 min, 419 MiB beyond the scene, about 7.1 % noise (relMSE 0.015)".
static void append_promise( const Job* r, const RfTrialRow* row, char* text, size_t size )
{
    char all[32], noise[RF_NOISE_TEXT_SIZE];
    bool known = rf_is_known( &row->error );
    double relmse = known ? row->relmse : row->error.low;
    rf_format_span( row->seconds, all, sizeof all );
    rf_format_noise( relmse, noise );
    rf_append( text, size, "%s %s, %.0f MiB beyond the scene", at_most( &s_given.render.settings ) ? "at most" : "about", all,
               ceil( fit_mib( &row->fit ) ) );
    if ( isfinite( relmse ) )
        rf_append( text, size, ", %s %s noise (relMSE %.2g)", known ? "about" : "at least", noise, relmse );
    rf_format_flicker( row->f1, noise );
    if ( r->tune.goal == RF_TUNE_FLICKER )
        rf_append( text, size, ", flicker about %s", noise );
}

// As rf_format_gain at equal flicker, of which the interval is not known.
static void format_flicker_gain( const RfInterval* gain, char* text, size_t size )
{
    bool slower = isless( gain->value, 1.0 );
    if ( isfinite( gain->value ) )
        snprintf( text, size, "about %.2f times %s than path tracing at equal flicker", slower ? 1.0 / gain->value : gain->value,
                  slower ? "slower" : "faster" );
    else
        snprintf( text, size, "not compared with path tracing" );
}

// Two lines: the best setting and what it is worth, and what the render takes with it.
static void format_verdict( const Job* r, char text[RF_VERDICT_SIZE] )
{
    if ( r->tune.chosen < 0 )
    {
        format_planned( r, text );
        return;
    }
    const RfTrialRow* row = r->tune.rows + r->tune.chosen;
    char name[64], gain[160];
    bool reuse = row->eyes > 1 || row->tile.kind != RF_TILE_NONE, flicker = r->tune.goal == RF_TUNE_FLICKER;
    rf_format_reuse( row->eyes, &row->tile, name, sizeof name );
    snprintf( gain, sizeof gain, "no group or tile is known to be faster at equal %s", flicker ? "flicker" : "noise" );
    if ( reuse && flicker )
        format_flicker_gain( &row->gain, gain, sizeof gain );
    else if ( reuse )
        rf_format_gain( &row->gain, r->tune.seconds, gain, sizeof gain );
    snprintf( text, RF_VERDICT_SIZE, "best: %s, %s\n", name, gain );
    append_shot( r, row->spp, text );
    append_promise( r, row, text, RF_VERDICT_SIZE );
}

// What a render without --group and --tile takes, where that is not the best.
static void print_default( const Job* r )
{
    for ( int i = 0; i < r->tune.count; ++i )
    {
        const RfTrialRow* row = r->tune.rows + i;
        char name[64], promise[256] = "";
        if ( !row->usual || row->rounds == 0 || row->chosen )
            continue;
        rf_format_reuse( row->eyes, &row->tile, name, sizeof name );
        append_promise( r, row, promise, sizeof promise );
        printf( "--group auto: %s, %s\n", name, promise );
    }
}

static void print_tune( const void* user )
{
    const Job* r = user;
    char verdict[RF_VERDICT_SIZE];
    format_verdict( r, verdict );
    printf( "%s\n\n", verdict );
    print_groups( r );
    if ( r->tune.chosen >= 0 )
    {
        print_rows( r );
        print_default( r );
    }
    print_split_costs( &r->split );
    if ( r->best != NULL )
        printf( "* best:\n%s\n", r->best );
    if ( r->ranges.list != NULL )
        rf_print_ranges( &r->ranges );
}

static json_t* memory_json( json_t* object, const RfMemoryFit* fit, const char* excluded )
{
    char text[128];
    return rf_json_add( object, "{s:I, s:I, s:I, s:I, s:i, s:i, s:s?}", "bytes_films", (json_int_t)fit->bytes_films, "bytes_hits",
                        (json_int_t)fit->bytes_hits, "bytes_lists", (json_int_t)fit->bytes_lists, "bytes_least",
                        (json_int_t)fit->least, "chunks", fit->chunks, "sweeps", fit->sweeps, "excluded",
                        format_excluded( excluded, fit, text, sizeof text ) );
}

static json_t* group_json( const RfPlanRow* row )
{
    char tile[RF_TILE_NAME_SIZE];
    rf_tile_name( &row->tile, tile );
    json_t* json = json_pack( "{s:i, s:i, s:s, s:i}", "group", row->group, "eyes", row->eyes, "tile", tile, "spp", row->spp );
    memory_json( json, &row->fit, row->excluded );
    json_object_set_new( json, "rays",
                         RF_SET_FIGURES( json_object(), { "primary", row->rays_primary }, { "path", row->rays_path },
                                         { "shadow", row->rays_shadow }, { "tile", row->rays_tile }, { "eye", row->rays_eye } ) );
    RF_SET_FIGURES( json, { "reach", row->reach }, { "predicted_gain", row->gain } );
    return rf_json_add( json, "{s:b}", "chosen", row->chosen );
}

static json_t* row_json( const RfTrialRow* row )
{
    json_t* json = memory_json( json_pack( "{s:i}", "eyes", row->eyes ), &row->fit, row->excluded );
    RF_SET_FIGURES( rf_trial_row_json( json, row ), { "predicted_gain", row->predicted_gain }, { "relmse_low", row->error.low },
                    { "relmse_high", row->error.high }, { "flicker", row->f1 }, { "phi", row->phi },
                    { "efficiency", row->efficiency }, { "gain", row->gain.value }, { "gain_low", row->gain.low },
                    { "gain_high", row->gain.high } );
    return rf_json_add( json, "{s:i, s:b, s:b}", "rounds", row->rounds, "default", row->usual, "chosen", row->chosen );
}

static json_t* tune_json( const void* user )
{
    const Job* r = user;
    const RfPlan* plan = &r->plan;
    const RfRenderSettings* settings = &s_given.render.settings;
    RfSize size = s_given.render.size;
    json_t *groups = json_array(), *rows = json_array(), *rounds = json_array();
    for ( int i = 0; i < plan->count; ++i )
        json_array_append_new( groups, group_json( plan->rows + i ) );
    for ( int i = 0; i < r->tune.count; ++i )
        json_array_append_new( rows, row_json( r->tune.rows + i ) );
    for ( int i = 0; i < r->tune.round_count; ++i )
    {
        const RfTuneRound* round = r->tune.rounds + i;
        json_array_append_new( rounds, json_pack( "{s:i, s:i, s:f, s:i, s:i}", "width", size.width, "height", size.height,
                                                  "pixels", round->pixels, "places", round->regions, "passes", round->passes ) );
    }
    json_t* record = json_pack( "{s:I, s:I, s:f}", "diffuse", (json_int_t)plan->bytes_diffuse, "glossy",
                                (json_int_t)plan->bytes_glossy, "glossy_share", plan->glossy_share );
    char verdict[RF_VERDICT_SIZE];
    format_verdict( r, verdict );
    json_t* json =
        json_pack( "{s:s, s:s, s:o, s:o, s:o, s:s, s:s, s:b, s:o, s:f, s:f, s:i, s:i, s:i, s:o}", "verdict", verdict, "goal",
                   r->tune.goal == RF_TUNE_FLICKER ? "flicker" : "noise", "groups", groups, "rows", rows, "rounds", rounds, "why",
                   plan->why, "adaptive_mode", rf_adaptive_name( plan->adaptive ), "at_most", at_most( settings ), "bytes_record",
                   record, "seconds", r->tune.seconds, "budget", s_given.budget, "frames", r->command.shot.frame_count, "width",
                   size.width, "height", size.height, "command", r->best != NULL ? rf_json_text( r->best ) : json_null() );
    return rf_json_add( json, "{s:o, s:o, s:o*}", "beyond_depth_share", rf_json_number( r->command.beyond_depth ), "split_light",
                        split_costs_json( &r->split ), "nodes", r->ranges.list != NULL ? rf_ranges_json( &r->ranges ) : NULL );
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
        const RfTrialRow* row = tune->rows + i;
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
        c->x[points] = fit_mib( &row->fit );
        c->y[points] = row->efficiency;
        snprintf( c->labels[points], sizeof c->labels[0], "%d", row->group );
        c->label[points] = c->labels[points];
        series->count += 1;
        series->show_labels = series->show_labels || row->chosen;
        points += 1;
    }
}

static RfResult write_tune_plot( const void* user, const char* path, RfError* error )
{
    const Job* r = user;
    const RfTune* tune = &r->tune;
    Curves curves = { 0 };
    collect( tune, &curves );
    char subtitle[512], note[64] = "", tile[RF_TILE_NAME_SIZE];
    const RfRenderOptions* o = &s_given.render;
    snprintf( subtitle, sizeof subtitle, "%.200s, %dx%d, %d frames; numbers are the group's half-width N",
              rf_scene_title( &s_given ), o->size.width, o->size.height, r->command.shot.frame_count );
    RfPlot plot = { .title = "Efficiency against memory",
                    .subtitle = subtitle,
                    .series = curves.series,
                    .series_count = curves.count,
                    .x = { .label = "memory beyond the scene, MiB", .log = true },
                    .y = { .label = tune->goal == RF_TUNE_FLICKER ? "efficiency, 1 / (F1 squared \xc2\xb7 CPU seconds per frame)"
                                                                  : "efficiency, 1 / (relMSE \xc2\xb7 CPU seconds per frame)",
                           .log = true } };
    RfPlotNote best;
    if ( tune->chosen >= 0 )
    {
        const RfTrialRow* row = tune->rows + tune->chosen;
        rf_tile_name( &row->tile, tile );
        snprintf( note, sizeof note, "group %d, tile %s", row->group, tile );
        best = ( RfPlotNote ){ fit_mib( &row->fit ), row->efficiency, note };
        plot.notes = &best;
        plot.note_count = 1;
    }
    return rf_write_plot( &plot, path, error );
}

#define BUDGET 60.0 // seconds

static const char* const s_goals[] = { "noise", "flicker", NULL }; // in the order of RfTuneGoal
static const char* const s_files[] = { "SCENE" };

static const RfOption s_options[] = {
    RF_PATH_OPTIONS( s_given.render, "frames to render; a few are measured, the total time is predicted" ),
    RF_LENS_OPTIONS( s_given.render ),
    RF_MOVEMENT_OPTIONS( s_given.render ),
    RF_TIME_OPTION(
        "budget", &s_given.budget, 0.0, 1e6, "T",
        "time to spend, in seconds or as 5m: more time tries more settings and narrows the intervals; 0: no renders, only "
        "the table of groups" ),
    RF_CHOICE_OPTION( "goal", &s_goal, s_goals,
                      "what to minimise at equal CPU time: relMSE, or the flicker of neighbouring frames" ),
    RF_STOP_OPTIONS( s_given.render,
                     "of a render that stops at this relMSE, or noise in percent: its memory; time and rays are upper limits, "
                     "cost --noise predicts them",
                     "the same for a render that stops at this flicker",
                     "the same for a render that stops after this time per frame" ),
    RF_ADAPTIVE_OPTION( s_given.render, "include the memory for extra samples; their time is not predicted" ),
    RF_CLAMP_OPTION( s_given.render, "include the memory of a clamp; cost says what it saves" ),
    RF_FILTER_OPTIONS( s_given.render ),
    RF_PATH_TRACING_OPTIONS( s_given.render ),
    RF_SEED_OPTION( s_given.render ),
    RF_AOV_OPTION( s_given.render, "additional layers, which take memory:" ),
    RF_CRYPTOMATTE_OPTION( s_given.render, "count the memory of Cryptomatte of these kinds:" ),
    RF_LIGHT_GROUPS_OPTION( s_given.render, "say what layers of light groups cost:" ),
    RF_TEXT_OPTION( "svg", &s_given.svg, "FILE", "plot efficiency against memory, one line per tile", .writes = ".svg",
                    .heading = RF_HEADING_OUTPUT ),
    RF_RESULT_OPTIONS( s_given.render, "write the result as JSON; - for standard output", "no progress" ),
    RF_INT_OPTION( "group", &s_given.render.settings.group, 0, RF_MAX_GROUP, "N|auto",
                   "group size assumed when frames are split over --nodes", .keyword = "auto", .keyword_value = RF_GROUP_AUTO,
                   .given = &s_group_given, .default_text = "the scene file's, else auto", .heading = RF_HEADING_PERFORMANCE ),
    RF_TEXT_OPTION( "tile", &s_given.render.tile, "WxH|rooksN|1", "tile of the table of groups; the renders try others, too",
                    .default_text = rf_default_texts.tile, .heading = RF_HEADING_PERFORMANCE ),
    RF_MACHINE_OPTIONS( s_given.render, "threads; each measures one setting at a time" ),
    RF_NODES_OPTION( s_given.render, "also split the frames into ranges for N machines, and report the overhead" ),
    RF_ESTIMATOR_OPTION( s_given.render ),
    RF_WEIGHT_OPTIONS( s_given.render ),
    RF_EFFECT_OPTIONS( s_given.render ),
};

static const RfCommandTable s_table = { .command = "tune",
                                        .summary =
                                            "Finds group and tile for this animation and machine: first which groups fit in "
                                            "memory and which one --group auto takes, without rendering; then by short renders "
                                            "time, noise, flicker and gain of the settings, and the best as a command line. "
                                            "SCENE and options are those of render.",
                                        RF_TABLE_ROWS( s_files, s_options ) };

static void reset( void )
{
    s_group_given = false;
    s_goal = 0;
    s_given = ( RfTrialOptions ){ .render = rf_default_render_options(), .budget = BUDGET };
}

static RfResult settle( void* user, RfError* error )
{
    (void)user;
    if ( s_group_given && s_given.render.nodes == 0 )
        return rf_fail( error, RF_ERROR_USAGE, "--group: needs --nodes; without it the tables have rows for each group" );
    return rf_settle_render_options( &s_given.render, error );
}

static bool is_plain( const char* text )
{
    return text[0] != '\0' &&
           text[strspn( text, "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_./,:=+-@%" )] == '\0';
}

// Control characters as $'\x1b', which bash and zsh read: no terminal obeys the command.
static void print_escaped( FILE* file, const char* text )
{
    fputs( " $'", file );
    for ( const unsigned char* c = (const unsigned char*)text; *c != '\0'; ++c )
        fprintf( file, iscntrl( *c ) || *c >= 0x80 ? "\\x%02x" : *c == '\'' || *c == '\\' ? "\\%c" : "%c", *c );
    fputc( '\'', file );
}

static void print_word( FILE* file, const char* text )
{
    char shown[8192];
    if ( is_plain( text ) )
    {
        fprintf( file, " %s", text );
        return;
    }
    if ( strcmp( rf_plain_text( text, shown, sizeof shown ), text ) != 0 )
    {
        print_escaped( file, text );
        return;
    }
    fputs( " '", file );
    for ( ; *text != '\0'; ++text )
    {
        if ( *text == '\'' )
            fputs( "'\\''", file );
        else
            fputc( *text, file );
    }
    fputc( '\'', file );
}

// Is this option (with its two dashes) one of `tune` that `render` does not take, or that the best setting replaces?
static bool is_own( const char* argument )
{
    static const char* const names[] = { "--budget",   "--goal",      "--svg",   "--json", "--quiet",
                                         "--no-quiet", "--estimator", "--group", "--tile", "--nodes" };
    for ( size_t i = 0; i < sizeof names / sizeof names[0]; ++i )
    {
        size_t length = strlen( names[i] );
        if ( strncmp( argument, names[i], length ) == 0 && ( argument[length] == '\0' || argument[length] == '=' ) )
            return true;
    }
    return false;
}

static bool takes_value( const char* argument )
{
    if ( strchr( argument, '=' ) != NULL )
        return false;
    for ( int i = 0; i < s_table.option_count; ++i )
    {
        if ( strcmp( argument + 2, s_options[i].name ) == 0 )
            return s_options[i].type != RF_OPTION_BOOL && s_options[i].bare == NULL;
    }
    return false;
}

// The arguments have been parsed before: whatever begins with dashes is an option, up to "--".
static void print_options( FILE* file, int argc, char** argv )
{
    for ( int i = 1; i < argc && strcmp( argv[i], "--" ) != 0; ++i )
    {
        if ( strncmp( argv[i], "--", 2 ) != 0 )
            continue;
        bool own = is_own( argv[i] ), value = takes_value( argv[i] ) && i + 1 < argc;
        if ( !own )
            print_word( file, argv[i] );
        i += value;
        if ( !own && value )
            print_word( file, argv[i] );
    }
}

// The best setting's estimator, where another one than the default was asked for; else NULL.
static const RfEstimator* named_estimator( const Job* job )
{
    const RfEstimator *usual = rf_default_render_settings().estimator, *asked = s_given.render.settings.estimator;
    const RfTrialRow* best = job->tune.rows + job->tune.chosen;
    return asked == usual ? NULL : best->tile.kind == RF_TILE_NONE ? usual : asked;
}

// The command line of the best settings: "reframe render SCENE -o frame.####.exr --group N
// --tile T" and those of the user's options that `render` takes, quoted for a shell. The
// caller frees it; NULL where there is no best one, or memory ran out.
static char* tuned_command( const Job* job )
{
    char *text = NULL, tile[RF_TILE_NAME_SIZE];
    size_t size;
    FILE* file = job->tune.chosen >= 0 ? open_memstream( &text, &size ) : NULL;
    if ( file == NULL )
        return NULL;
    const char* scene = s_given.render.scene;
    const RfTrialRow* best = job->tune.rows + job->tune.chosen;
    const RfEstimator* estimator = named_estimator( job );
    rf_tile_name( &best->tile, tile );
    fputs( "reframe render", file );
    if ( scene[0] != '-' )
        print_word( file, scene );
    fprintf( file, " -o out/frame.####.exr --group %d --tile %s", best->group, tile );
    if ( estimator != NULL )
        fprintf( file, " --estimator %s", rf_estimator_name( estimator ) );
    print_options( file, job->command.argc, job->command.argv );
    if ( scene[0] == '-' )
    {
        fputs( " --", file );
        print_word( file, scene );
    }
    if ( fclose( file ) == 0 )
        return text;
    free( text );
    return NULL;
}

static void say( void* user, const RfTune* tune, const RfTuneRound* round, int candidates )
{
    (void)user;
    if ( !s_given.render.quiet )
        fprintf( stderr, "reframe tune: round %d: %d settings on %.0f pixels at %d camera position%s, about %.0f s\n",
                 tune->round_count + 1, candidates, round->pixels, round->regions, round->regions == 1 ? "" : "s",
                 round->seconds );
}

// The command line of the best setting, and what layers of light cost with it or with what the plan chooses.
static RfResult finish( void* user, RfError* error )
{
    Job* job = user;
    RfRenderSettings asked = s_given.render.settings, settings;
    const RfTrialRow* best = job->tune.chosen >= 0 ? job->tune.rows + job->tune.chosen : NULL;
    job->best = tuned_command( job );
    if ( ( asked.light_groups == NULL && ( asked.aovs & RF_PASS_AOVS ) == 0 ) || ( best == NULL && job->plan.count == 0 ) )
        return RF_OK;
    asked.group = best != NULL ? best->group : job->plan.rows[job->plan.chosen].group;
    asked.tile = best != NULL ? best->tile : asked.tile;
    RF_TRY( rf_resolve_settings( &job->command.shot, &asked, &settings, error ) );
    return find_split_costs( &job->command.shot, &settings, best != NULL, &job->split, error );
}

// What is known without rendering. With short renders another tile may fit where this one does not.
static RfResult make_plan( Job* job, RfError* error )
{
    const RfTrialCommand* c = &job->command;
    RfRenderSettings settings = s_given.render.settings;
    RfResult result = rf_plan_render( &c->shot, &settings, &job->plan, error );
    if ( result == RF_ERROR_MEMORY && s_given.budget > 0.0 )
    {
        job->plan = ( RfPlan ){ .adaptive = settings.adaptive };
        result = RF_OK;
    }
    if ( result != RF_OK || s_given.render.nodes == 0 )
        return result;
    if ( settings.group == RF_GROUP_AUTO )
        settings.group = job->plan.rows[job->plan.chosen].group;
    RfDividedFrames frames = { c->asked, c->asked_runs, c->asked_count, c->path.step, c->path.count, c->path.eyes };
    return rf_cut_ranges( s_given.render.nodes, &frames, &settings, &job->ranges, error );
}

static RfResult search( void* user, RfError* error )
{
    static const RfTrialWatch watch = { rf_may_go_on, NULL };
    Job* job = user;
    RfTuneJob tune = { .shot = job->command.shot,
                       .settings = &job->settings,
                       .goal = (RfTuneGoal)s_goal,
                       .watch = &watch,
                       .report = say,
                       .user = job };
    RfResult result = make_plan( job, error );
    if ( result != RF_OK || !( s_given.budget > 0.0 ) )
        return result;
    RF_TRY( rf_guide_parts( &tune.shot, &s_given.render.settings, &job->settings, &job->guide, error ) );
    tune.budget = rf_budget_left( &job->command, &tune.deadline );
    result = rf_tune( &tune, &job->tune, error );
    int rounds = job->tune.round_count;
    job->command.found = rounds > 0;
    if ( result != RF_ERROR_INTERRUPTED )
        return result;
    if ( rounds == 0 )
        return rf_fail( error, result, "interrupted in the first round: no results yet" );
    return rf_fail( error, result, "interrupted after %d round%s: the results so far are above", rounds, rounds == 1 ? "" : "s" );
}

int rf_command_tune( int argc, char** argv )
{
    static Job job;
    job = ( Job ){ .tune = { .chosen = -1 },
                   .command = { .table = &s_table,
                                .options = &s_given,
                                .reset = reset,
                                .settle = settle,
                                .search = search,
                                .finish = finish,
                                .print = print_tune,
                                .json = tune_json,
                                .plot = write_tune_plot,
                                .user = &job,
                                .argc = argc,
                                .argv = argv } };
    int status = rf_run_trial_command( &job.command );
    free( job.best );
    rf_forget_guide( job.guide );
    rf_free_ranges( &job.ranges );
    return status;
}
