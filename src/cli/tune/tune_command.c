// reframe tune: finds the best group and tile by short renders.
#include "base/plain_text.h"
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/render_options.h"
#include "cli/options/shot.h"
#include "cli/options/shared_options.h"
#include "cli/signals.h"
#include "cli/tune/verdict.h"
#include "measure/plot.h"
#include "measure/tune.h"
#include "scene/json/json_document.h"

#include <ctype.h>
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

typedef struct TuneOptions
{
    RfRenderOptions render; // without group, tile and output
    double budget;          // seconds
    int goal;               // an RfTuneGoal
    const char* svg;        // NULL: none
} TuneOptions;

typedef struct TuneReport
{
    const RfTune* tune;
    const char* scene;
    const char* command; // of the winner; NULL: there is none
    int width, height;   // of the render
    int frames;          // asked for
    double budget;
} TuneReport;

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
        const char* excluded = rf_format_excluded( row->excluded, &row->fit, text, sizeof text );
        printf( "  not measured%s%s\n", excluded != NULL ? ": " : "", excluded != NULL ? excluded : "" );
        return;
    }
    char sweeps[32] = "";
    if ( row->fit.sweeps > 1 )
        snprintf( sweeps, sizeof sweeps, "  in %d sweeps", row->fit.sweeps );
    snprintf( interval, sizeof interval, isfinite( row->gain.low ) ? "%.2f-%.2f" : "-", row->gain.low, row->gain.high );
    printf( " %9.1f %9.3g %9.3g %9.3g %6.2f %10.4g %7.2f %11s %6d%s\n", bytes_of( row ) / 1048576.0, row->seconds, row->relmse,
            row->f1, row->phi, row->efficiency, row->gain.value, interval, row->rounds, sweeps );
}

static void print_rounds( const TuneReport* r )
{
    const RfTune* tune = r->tune;
    printf( "measured in %.1f s:", tune->seconds );
    for ( int i = 0; i < tune->round_count; ++i )
        printf( "%s round %d on %.0f pixels at %d camera position%s", i > 0 ? "," : "", i + 1, tune->rounds[i].pixels,
                tune->rounds[i].regions, tune->rounds[i].regions == 1 ? "" : "s" );
    printf( "\n" );
}

// Two lines: the best setting and what it is worth, and what the render takes with it.
static void format_verdict( const TuneReport* r, char text[RF_VERDICT_SIZE] )
{
    if ( r->tune->chosen < 0 )
    {
        snprintf( text, RF_VERDICT_SIZE, "no setting was fully measured" );
        return;
    }
    const RfTuneRow* row = r->tune->rows + r->tune->chosen;
    char name[64], gain[160], all[32];
    bool reuse = row->eyes > 1 || row->tile.kind != RF_TILE_NONE;
    rf_format_reuse( row->eyes, &row->tile, name, sizeof name );
    bool flicker = r->tune->goal == RF_TUNE_FLICKER;
    snprintf( gain, sizeof gain, "as no group or tile is faster at equal %s", flicker ? "flicker" : "noise" );
    if ( reuse )
        ( flicker ? rf_tell_flicker_gain : rf_format_gain )( &row->gain, gain, sizeof gain );
    rf_format_span( row->seconds, all, sizeof all );
    int used = snprintf( text, RF_VERDICT_SIZE,
                         "best: %s, %s\n%d frame%s at %dx%d and %d spp: about %s, relMSE about %.2g (%.2g %% noise per pixel)",
                         name, gain, r->frames, r->frames == 1 ? "" : "s", r->width, r->height, row->spp, all, row->relmse,
                         100.0 * sqrt( row->relmse / 3.0 ) );
    if ( flicker )
        snprintf( text + used, RF_VERDICT_SIZE - (size_t)used, ", F1 about %.2g", row->f1 );
}

static void print_tune( const TuneReport* r )
{
    const RfTune* tune = r->tune;
    char verdict[RF_VERDICT_SIZE];
    format_verdict( r, verdict );
    printf( "%s\n\n", verdict );
    printf( "%6s %8s %5s %9s %9s %9s %9s %6s %10s %7s %11s %6s\n", "group", "tile", "spp", "MiB", "seconds", "relMSE", "F1",
            "phi", "efficiency", "gain", "95 %", "rounds" );
    for ( int i = 0; i < tune->count; ++i )
        print_row( tune->rows + i );
    printf( "seconds: wall-clock time of all %d frames; efficiency: 1 / (%s x CPU seconds per frame); gain: over path "
            "tracing (group 0, tile 1) on the same pixels\n",
            r->frames, tune->goal == RF_TUNE_FLICKER ? "F1 squared" : "relMSE" );
    print_rounds( r );
    if ( r->command != NULL )
        printf( "* best:\n%s\n", r->command );
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
        "excluded", rf_format_excluded( row->excluded, &row->fit, text, sizeof text ), "chosen", row->chosen );
}

static json_t* tune_json( const TuneReport* r )
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
    format_verdict( r, verdict );
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

static RfResult write_tune_plot( const TuneReport* r, const char* path, RfError* error )
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
                    .x = { .label = "memory beyond the scene, MiB", .log = true },
                    .y = { .label = tune->goal == RF_TUNE_FLICKER ? "efficiency, 1 / (F1 squared \xc2\xb7 CPU seconds per frame)"
                                                                  : "efficiency, 1 / (relMSE \xc2\xb7 CPU seconds per frame)",
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
    return rf_write_plot( &plot, path, error );
}

#define BUDGET 60.0 // seconds

static const char* const s_goals[] = { "noise", "flicker", NULL }; // in the order of RfTuneGoal
static const char* const s_files[] = { "SCENE" };
static TuneOptions s_parsed; // the table points here
static const char* s_scene;

static const RfOption s_options[] = {
    RF_PATH_OPTIONS( s_parsed.render, "frames to render; a few are measured, the total time is predicted" ),
    RF_LENS_OPTIONS( s_parsed.render ),
    RF_MOVEMENT_OPTIONS( s_parsed.render ),
    { .name = "budget",
      .type = RF_OPTION_TIME,
      .value = &s_parsed.budget,
      .min = 1.0,
      .max = 1e6,
      .meta = "T",
      .help = "time to spend, in seconds or as 5m; a longer search is more reliable" },
    { .name = "goal",
      .type = RF_OPTION_CHOICE,
      .value = &s_parsed.goal,
      .choices = s_goals,
      .help = "what to minimise at equal CPU time: relMSE, or F1 between neighbouring frames" },
    RF_SPP_OPTION( s_parsed.render ),
    RF_FILTER_OPTIONS( s_parsed.render ),
    RF_PATH_TRACING_OPTIONS( s_parsed.render ),
    RF_SEED_OPTION( s_parsed.render ),
    RF_AOV_OPTION( s_parsed.render, "additional layers, which take memory:" ),
    { .name = "svg",
      .writes = ".svg",
      .type = RF_OPTION_STRING,
      .value = &s_parsed.svg,
      .meta = "FILE",
      .help = "plot efficiency against memory, one line per tile",
      .heading = RF_HEADING_OUTPUT },
    RF_RESULT_OPTIONS( s_parsed.render, "write the result as JSON; - for standard output", "no progress" ),
    RF_MACHINE_OPTIONS( s_parsed.render, "threads; each measures one setting at a time" ),
    RF_ESTIMATOR_OPTION( s_parsed.render ),
    RF_EFFECT_OPTIONS( s_parsed.render ),
};

static const RfCommandTable s_table = { .command = "tune",
                                        .summary =
                                            "Finds the most efficient group and tile for this animation and machine by short "
                                            "renders. Prints memory, time, error, flicker and efficiency of each setting, and "
                                            "the best as a command line. SCENE and options are those of render.",
                                        .files = s_files,
                                        .file_count = 1,
                                        .options = s_options,
                                        .option_count = sizeof s_options / sizeof s_options[0] };

// Parses the command line over a scene file's defaults, or with NULL over ours, and checks what can be checked without the scene.
// With *help set the help was asked for and nothing else is valid.
static RfResult parse( const RfField* defaults, int argc, char** argv, TuneOptions* options, bool* help, RfError* error )
{
    s_parsed = ( TuneOptions ){ .render = rf_default_render_options(), .budget = BUDGET };
    RfResult result = defaults != NULL ? rf_read_render_defaults( defaults, &s_parsed.render ) : RF_OK;
    if ( result == RF_OK )
        result = rf_parse_options( &s_table, argc, argv, &s_scene, help, error );
    if ( result != RF_OK || *help )
        return result;
    s_parsed.render.scene = s_scene;
    rf_take_estimator_option( &s_parsed.render );
    rf_settle_filter( &s_parsed.render );
    result = rf_parse_aov_option( &s_parsed.render, error );
    *options = s_parsed;
    return result;
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
    static const char* const names[] = { "--budget", "--goal", "--svg", "--json", "--quiet", "--no-quiet", "--estimator" };
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
            return s_options[i].type != RF_OPTION_BOOL;
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

// The command line of the best settings: "reframe render SCENE -o frame.####.exr --group N
// --tile T" and those of the user's options that `render` takes, quoted for a shell. The
// caller frees it; NULL where memory ran out. `estimator` is named unless it is NULL.
static char* tuned_command( int argc, char** argv, const RfEstimator* estimator, int group, const RfTile* tile )
{
    char *text = NULL, name[24];
    size_t size;
    FILE* file = open_memstream( &text, &size );
    if ( file == NULL )
        return NULL;
    rf_tile_name( tile, name );
    fputs( "reframe render", file );
    bool dash = s_scene[0] == '-';
    if ( !dash )
        print_word( file, s_scene );
    fprintf( file, " -o out/frame.####.exr --group %d --tile %s", group, name );
    if ( estimator != NULL )
        fprintf( file, " --estimator %s", rf_estimator_name( estimator ) );
    print_options( file, argc, argv );
    if ( dash )
    {
        fputs( " --", file );
        print_word( file, s_scene );
    }
    if ( fclose( file ) == 0 )
        return text;
    free( text );
    return NULL;
}

typedef struct Job
{
    int argc;
    char** argv;
    TuneOptions options;
    RfLoadedShot shot; // options may point into it
    RfTune tune;
} Job;

static RfResult take_defaults( const RfField* defaults, void* user, RfError* error )
{
    Job* job = user;
    bool help;
    return parse( defaults, job->argc, job->argv, &job->options, &help, error );
}

static void say( void* user, const RfTune* tune, const RfTuneRound* round, int candidates )
{
    const Job* job = user;
    if ( !job->options.render.quiet )
        fprintf( stderr, "reframe tune: round %d: %d settings on %.0f pixels at %d camera position%s, about %.0f s\n",
                 tune->round_count + 1, candidates, round->pixels, round->regions, round->regions == 1 ? "" : "s",
                 round->seconds );
}

// That of the best setting, where another one than the default was asked for.
static const RfEstimator* named_estimator( const Job* job )
{
    const RfEstimator *usual = rf_default_render_settings().estimator, *asked = job->options.render.settings.estimator;
    const RfTuneRow* best = job->tune.rows + job->tune.chosen;
    if ( asked == usual )
        return NULL;
    return best->tile.kind == RF_TILE_NONE ? usual : asked;
}

// Reports what was found so far, also after an interruption.
static RfResult report( Job* job, RfError* error )
{
    const TuneOptions* options = &job->options;
    const RfTuneRow* best = job->tune.chosen >= 0 ? job->tune.rows + job->tune.chosen : NULL;
    char* command = best != NULL ? tuned_command( job->argc, job->argv, named_estimator( job ), best->group, &best->tile ) : NULL;
    TuneReport r = { .tune = &job->tune,
                     .scene = options->render.scene,
                     .command = command,
                     .width = options->render.size.width,
                     .height = options->render.size.height,
                     .frames = job->shot.frame_count,
                     .budget = options->budget };
    const char* json = options->render.json;
    RfResult result = RF_OK;
    if ( rf_prints_text( json ) )
    {
        print_tune( &r );
        result = rf_flush_output( error );
    }
    if ( result == RF_OK && options->svg != NULL )
        result = write_tune_plot( &r, options->svg, error );
    if ( result == RF_OK && json != NULL )
        result = rf_write_json( json, tune_json( &r ), error );
    free( command );
    return result;
}

static RfResult run( Job* job, RfError* error )
{
    RfResult result = rf_load_shot( "tune", &job->options.render, take_defaults, job, &job->shot, error );
    if ( result != RF_OK )
        return result;
    RfTrialWatch watch = { rf_may_go_on, NULL };
    RfTuneJob tune = { .shot = rf_shot_to_render( &job->shot ),
                       .settings = &job->options.render.settings,
                       .budget = job->options.budget,
                       .goal = (RfTuneGoal)job->options.goal,
                       .watch = &watch,
                       .report = say,
                       .user = job };
    result = rf_tune( &tune, &job->tune, error );
    if ( result == RF_ERROR_INTERRUPTED && job->tune.round_count > 0 )
    {
        RfResult reported = report( job, error );
        return reported != RF_OK
                   ? reported
                   : rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted after %d round%s: the results so far are above",
                              job->tune.round_count, job->tune.round_count == 1 ? "" : "s" );
    }
    if ( result == RF_ERROR_INTERRUPTED )
        return rf_fail( error, result, "interrupted in the first round: no results yet" );
    return result == RF_OK ? report( job, error ) : result;
}

int rf_command_tune( int argc, char** argv )
{
    RfError error;
    bool help;
    Job job = { .argc = argc, .argv = argv };
    RfResult result = parse( NULL, argc, argv, &job.options, &help, &error );
    if ( result == RF_OK && help )
        result = rf_show_help( &s_table, &error );
    else if ( result == RF_OK )
    {
        rf_catch_interrupts();
        result = run( &job, &error );
    }
    rf_destroy_shot( &job.shot );
    return result == RF_OK ? 0 : rf_report_error( "tune", &error );
}
