// reframe plan: group size against memory, before anything is rendered.
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/options/frame_lists.h"
#include "cli/options/render_options.h"
#include "cli/options/shot.h"
#include "cli/options/shared_options.h"
#include "cli/tune/verdict.h"
#include "measure/cost.h"
#include "output/names.h"
#include "reframe/plan.h"
#include "render/settings.h"
#include "scene/json/json_document.h"

#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

// The samples of the harder of the goals of job->settings, and the seconds of the frames asked for, by a measured curve.
// spp is 0 where there is no goal, or more than a render can have are needed.
static RfCostPrediction predict_goals( const RfCostJob* job, const RfCostCurve* curve, int per_sweep )
{
    const RfRenderSettings* s = job->settings;
    RfCostPrediction noise = { 0 }, flicker = { 0 };
    if ( s->noise > 0.0 )
        noise = rf_predict_cost( job, curve, s->noise, per_sweep );
    if ( s->flicker > 0.0 )
        flicker = rf_predict_flicker_cost( job, curve, s->flicker, per_sweep );
    bool missing = ( s->noise > 0.0 && noise.spp == 0 ) || ( s->flicker > 0.0 && flicker.spp == 0 );
    return missing ? ( RfCostPrediction ){ 0 } : noise.spp > flicker.spp ? noise : flicker;
}

// {"spp", "seconds"}; null where nothing is predicted.
static json_t* predicted_json( const RfCostPrediction* predicted )
{
    if ( predicted->spp == 0 )
        return json_null();
    return json_pack( "{s:i, s:o}", "spp", predicted->spp, "seconds", rf_json_number( predicted->seconds ) );
}

static const char* const s_files[] = { "SCENE" };
static RfRenderOptions s_parsed; // the table points here
static bool s_group_given;

static const RfOption s_options[] = {
    RF_PATH_OPTIONS( s_parsed, "frames to render, for rays and seconds; the chosen group does not depend on them" ),
    RF_LENS_OPTIONS( s_parsed ),
    RF_MOVEMENT_OPTIONS( s_parsed ),
    RF_STOP_OPTIONS( s_parsed,
                     "plan for a render that stops at this relMSE: its memory and approximate time; rays and seconds in the "
                     "table are upper limits",
                     "the same for a render that stops at this F1",
                     "the same for a render that stops after this time per frame" ),
    RF_ADAPTIVE_OPTION( s_parsed, "include the memory for extra samples; their rays are not predicted" ),
    RF_FILTER_OPTIONS( s_parsed ),
    RF_PATH_TRACING_OPTIONS( s_parsed ),
    RF_AOV_OPTION( s_parsed, "additional layers, which take memory:" ),
    RF_RESULT_OPTIONS( s_parsed, "write the result as JSON; - for standard output", "no progress" ),
    { .name = "group",
      .type = RF_OPTION_INT,
      .value = &s_parsed.settings.group,
      .min = 0,
      .max = RF_MAX_GROUP,
      .keyword = "auto",
      .keyword_value = RF_GROUP_AUTO,
      .meta = "N|auto",
      .given = &s_group_given,
      .default_text = "the scene file's, else auto",
      .help = "group size assumed when frames are split over --nodes",
      .heading = RF_HEADING_PERFORMANCE },
    RF_TILE_OPTION( s_parsed ),
    RF_MACHINE_OPTIONS( s_parsed, "threads; the chosen group does not depend on them" ),
    RF_NODES_OPTION( s_parsed, "also split the frames into ranges for N machines, and report the overhead" ),
    RF_ESTIMATOR_OPTION( s_parsed ),
    RF_WEIGHT_OPTIONS( s_parsed ),
    RF_EFFECT_OPTIONS( s_parsed ),
};

static const RfCommandTable s_table = {
    .command = "plan",
    .summary = "Shows which group sizes fit in memory and which is best: a row for each half-width N with memory, chunks, rays "
               "and expected gain; * marks the choice of render --group auto. SCENE and options are those of render that "
               "affect memory or the choice.",
    .files = s_files,
    .file_count = 1,
    .options = s_options,
    .option_count = sizeof s_options / sizeof s_options[0]
};

// Parses the command line over a scene file's defaults, or with NULL over ours, and checks what can be checked without the scene.
// With *help set the help was asked for and nothing else is valid. There is no `output`.
static RfResult parse( const RfField* defaults, int argc, char** argv, RfRenderOptions* options, bool* help, RfError* error )
{
    s_parsed = rf_default_render_options();
    s_group_given = false;
    RfResult result = defaults != NULL ? rf_read_render_defaults( defaults, &s_parsed ) : RF_OK;
    if ( result == RF_OK )
        result = rf_parse_options( &s_table, argc, argv, &s_parsed.scene, help, error );
    if ( result != RF_OK || *help )
        return result;
    if ( s_group_given && s_parsed.nodes == 0 )
        return rf_fail( error, RF_ERROR_USAGE, "--group: needs --nodes; without it the table has a row for each group" );
    *options = s_parsed;
    return rf_settle_render_options( options, error );
}

#define MEASURE_SECONDS 1.0
#define TRY_PIXELS 70000.0 // of the frames of a group together, for holding the chosen row against path tracing

// The example of Reusing Frames in Camera Animation, section 4.3: 800x600, 7
// frames, 2 samples per pixel.
#define PAPER_PATHS ( 800.0 * 600.0 * 7.0 * 2.0 )
#define PAPER_BYTES 1787520000.0

typedef struct Job
{
    int argc; // the command line: it wins over a scene file, which is read later
    char** argv;
    RfRenderOptions options;
    RfLoadedShot shot; // options may point into it
    RfPlan plan;
    double paper_bytes;         // what our records take for its example
    RfInterval tried;           // gain of the chosen row over path tracing; NaN: not tried
    RfCostPrediction predicted; // of --noise and --flicker, by the same trial; spp 0: nothing
    RfRanges ranges;            // for --nodes
} Job;

static RfResult take_defaults( const RfField* defaults, void* user, RfError* error )
{
    Job* job = user;
    bool help;
    return parse( defaults, job->argc, job->argv, &job->options, &help, error );
}

// Has the render groups, and records of hits?
static bool has_groups( const Job* job ) { return rf_has_groups( job->options.settings.estimator ); }

// Plain records: without tiles, and one light sample, as in the paper.
static void compare_with_paper( Job* job )
{
    RfRenderSettings settings = job->options.settings;
    settings.tile = ( RfTile ){ RF_TILE_NONE, 1, 1 };
    settings.light_samples = 1;
    size_t diffuse, glossy;
    rf_record_bytes( &job->shot.scene, &settings, 7, &diffuse, &glossy );
    double share = job->plan.glossy_share;
    job->paper_bytes = PAPER_PATHS * ( (double)diffuse * ( 1.0 - share ) + (double)glossy * share );
}

// Renders pieces with the chosen row and by path tracing: the model knows nothing of tiles, nor what a reused sample is worth.
static RfResult try_chosen( Job* job, RfError* error )
{
    const RfPlanRow* row = job->plan.rows + job->plan.chosen;
    RfRenderSettings settings = job->options.settings;
    double all = (double)job->options.size.width * job->options.size.height;
    settings.group = row->group;
    job->tried = ( RfInterval ){ (double)NAN, (double)NAN, (double)NAN };
    if ( row->eyes == 1 && settings.tile.kind == RF_TILE_NONE )
        return RF_OK;
    RfCostJob trial = { .shot = rf_shot_to_render( &job->shot ),
                        .settings = &settings,
                        .pixels = fmin( TRY_PIXELS / row->eyes, all / RF_COST_POSITIONS ) };
    RfCost cost;
    RfResult result = rf_measure_cost( &trial, &cost, error );
    job->tried = result == RF_OK ? cost.speedup : job->tried;
    if ( result == RF_OK )
        job->predicted = predict_goals( &trial, &cost.reuse, row->fit.sweeps > 1 ? row->fit.films : job->shot.frame_count );
    return result == RF_ERROR_SCENE ? RF_OK : result; // black pictures can be planned, too
}

static RfResult make_plan( Job* job, RfError* error )
{
    const RfRenderSettings* settings = &job->options.settings;
    RfShot shot = rf_shot_to_render( &job->shot );
    RfResult result = rf_plan_render( &shot, settings, &job->plan, error );
    if ( result != RF_OK )
        return result;
    if ( !job->options.quiet )
        fprintf( stderr, "reframe plan: measuring the costs of rays, which takes a few seconds\n" );
    compare_with_paper( job );
    result = rf_measure_plan( &shot, settings, MEASURE_SECONDS, &job->plan, error );
    return result == RF_OK ? try_chosen( job, error ) : result;
}

// Cuts the frames for the group that was asked for, else for the chosen one.
static RfResult cut_ranges( Job* job, RfError* error )
{
    RfRenderSettings settings = job->options.settings;
    if ( job->options.nodes == 0 )
        return RF_OK;
    if ( settings.group == RF_GROUP_AUTO )
        settings.group = job->plan.rows[job->plan.chosen].group;
    RfDividedFrames frames = { job->shot.asked,     job->shot.asked_runs, job->shot.asked_count,
                               job->shot.path.step, job->shot.path.count, job->shot.path.eyes };
    return rf_cut_ranges( job->options.nodes, &frames, &settings, &job->ranges, error );
}

static void print_row( const RfPlanRow* row )
{
    char sweeps[32] = "", text[128];
    const char* excluded = rf_format_excluded( row->excluded, &row->fit, text, sizeof text );
    if ( !rf_plan_row_fits( row ) )
    {
        printf( " %4d %7d %5d  %s\n", row->group, row->eyes, row->spp, excluded );
        return;
    }
    if ( row->fit.sweeps > 1 )
        snprintf( sweeps, sizeof sweeps, "  in %d sweeps", row->fit.sweeps );
    printf( "%c%4d %7d %5d %9.1f %8.1f %8.1f %7d %10.4g %10.4g %10.4g %10.4g %10.4g %6.1f %6.1f %6.1f %8.3g%s%s%s\n",
            row->chosen ? '*' : ' ', row->group, row->eyes, row->spp, (double)row->fit.bytes_films / 1048576.0,
            (double)row->fit.bytes_hits / 1048576.0, (double)row->fit.bytes_lists / 1048576.0, row->fit.chunks, row->rays_primary,
            row->rays_path, row->rays_shadow, row->rays_tile, row->rays_eye, row->reach, row->gain, row->measured_gain,
            row->seconds, sweeps, excluded != NULL ? "  not for auto: " : "", excluded != NULL ? excluded : "" );
}

static bool at_most( const Job* job )
{
    const RfRenderSettings* s = &job->options.settings;
    return s->noise > 0.0 || s->flicker > 0.0 || s->time > 0.0;
}

// Two lines: the chosen group and what it is worth, and what the render takes with it.
static void format_verdict( const Job* job, char text[RF_VERDICT_SIZE] )
{
    const RfPlanRow* row = job->plan.rows + job->plan.chosen;
    char name[64], gain[160], all[32];
    bool predicted = job->predicted.spp > 0 && !( job->options.settings.time > 0.0 );
    double bytes = (double)( row->fit.bytes_films + row->fit.bytes_hits + row->fit.bytes_lists );
    rf_format_reuse( row->eyes, &job->options.settings.tile, name, sizeof name );
    rf_format_gain( &job->tried, gain, sizeof gain );
    rf_format_span( predicted ? job->predicted.seconds : row->seconds, all, sizeof all );
    bool groups = has_groups( job );
    int used = snprintf( text, RF_VERDICT_SIZE, "--%s %s: %s", groups ? "group" : "estimator",
                         groups ? "auto" : rf_estimator_name( job->options.settings.estimator ), name );
    if ( isfinite( job->tried.value ) )
        used += snprintf( text + used, RF_VERDICT_SIZE - (size_t)used, ", %s", gain );
    snprintf( text + used, RF_VERDICT_SIZE - (size_t)used, "\n%d frame%s at %dx%d and %s%d spp: %s %s, %.0f MiB beyond the scene",
              job->shot.frame_count, job->shot.frame_count == 1 ? "" : "s", job->options.size.width, job->options.size.height,
              predicted ? "about " : "", predicted ? job->predicted.spp : row->spp,
              at_most( job ) && !predicted ? "at most" : "about", all, ceil( bytes / 1048576.0 ) );
}

static void print_plan( const Job* job )
{
    const RfPlan* plan = &job->plan;
    char verdict[RF_VERDICT_SIZE];
    format_verdict( job, verdict );
    printf( "%s\n\n", verdict );
    printf( "%5s %7s %5s %9s %8s %8s %7s %10s %10s %10s %10s %10s %6s %6s %6s %8s\n", "group", "cameras", "spp", "films MiB",
            "hits MiB", "work MiB", "chunks", "primary", "path", "shadow", "tile", "to cameras", "reach", "fixed", "gain",
            "seconds" );
    for ( int i = 0; i < plan->count; ++i )
        print_row( plan->rows + i );
    printf( "fixed, gain: upper bounds for frame reuse over the tile alone, as if every reused sample were worth one of the "
            "pixel's own; fixed: with fixed ray costs, which decide the choice; gain: with those measured here, and sweeps\n" );
    if ( at_most( job ) )
        printf( "rays and seconds are for %d spp, the limit with --noise, --flicker and --time\n", job->options.settings.spp );
    if ( has_groups( job ) )
        printf( "* --group auto chooses %d: %s\n", plan->rows[plan->chosen].group, plan->why );
    printf( "costs measured here, ns: camera ray %.0f, light at its hit %.0f, one reuse %.0f\n", 1e9 * plan->c_e, 1e9 * plan->c_l,
            1e9 * plan->c_v );
    if ( !has_groups( job ) )
        return;
    printf( "hit record: %zu bytes diffuse, %zu glossy; %.1f %% of first hits are glossy\n", plan->bytes_diffuse,
            plan->bytes_glossy, 100.0 * plan->glossy_share );
    printf( "the paper's example (800x600, 7 frames, 2 spp, no tiles), all hit records: %.0f bytes in the paper, %.0f here "
            "(1/%.1f)\n",
            PAPER_BYTES, job->paper_bytes, PAPER_BYTES / job->paper_bytes );
}

static json_t* row_json( const RfPlanRow* row, const char* tile )
{
    char text[128];
    json_t* rays = json_pack( "{s:o, s:o, s:o, s:o, s:o}", "primary", rf_json_number( row->rays_primary ), "path",
                              rf_json_number( row->rays_path ), "shadow", rf_json_number( row->rays_shadow ), "tile",
                              rf_json_number( row->rays_tile ), "eye", rf_json_number( row->rays_eye ) );
    return json_pack( "{s:i, s:i, s:s, s:i, s:I, s:I, s:I, s:I, s:i, s:i, s:o, s:o, s:o, s:o, s:o, s:n, s:n, s:n, s:s?, s:b}",
                      "group", row->group, "eyes", row->eyes, "tile", tile, "spp", row->spp, "bytes_films",
                      (json_int_t)row->fit.bytes_films, "bytes_hits", (json_int_t)row->fit.bytes_hits, "bytes_lists",
                      (json_int_t)row->fit.bytes_lists, "bytes_least", (json_int_t)row->fit.least, "chunks", row->fit.chunks,
                      "sweeps", row->fit.sweeps, "rays", rays, "reach", rf_json_number( row->reach ), "gain_fixed",
                      rf_json_number( row->gain ), "predicted_gain", rf_json_number( row->measured_gain ), "seconds",
                      rf_json_number( row->seconds ), "relmse", "flicker", "efficiency", "excluded",
                      rf_format_excluded( row->excluded, &row->fit, text, sizeof text ), "chosen", row->chosen );
}

static json_t* plan_json( const Job* job )
{
    const RfPlan* plan = &job->plan;
    char tile[RF_TILE_NAME_SIZE];
    rf_tile_name( &job->options.settings.tile, tile );
    json_t* rows = json_array();
    for ( int i = 0; i < plan->count; ++i )
        json_array_append_new( rows, row_json( plan->rows + i, tile ) );
    json_t* costs = json_pack( "{s:o, s:o, s:o}", "c_e", rf_json_number( plan->c_e ), "c_l", rf_json_number( plan->c_l ), "c_v",
                               rf_json_number( plan->c_v ) );
    json_t* record = json_pack( "{s:I, s:I, s:f}", "diffuse", (json_int_t)plan->bytes_diffuse, "glossy",
                                (json_int_t)plan->bytes_glossy, "glossy_share", plan->glossy_share );
    json_t* paper =
        json_pack( "{s:f, s:o}", "theirs", PAPER_BYTES, "ours", has_groups( job ) ? json_real( job->paper_bytes ) : json_null() );
    char verdict[RF_VERDICT_SIZE];
    format_verdict( job, verdict );
    json_t* tried = json_pack( "{s:o, s:o, s:o}", "gain", rf_json_number( job->tried.value ), "gain_low",
                               rf_json_number( job->tried.low ), "gain_high", rf_json_number( job->tried.high ) );
    json_t* json = json_pack( "{s:s, s:o, s:o, s:o, s:s, s:s, s:b, s:o, s:o, s:o}", "verdict", verdict, "predicted",
                              predicted_json( &job->predicted ), "tried", tried, "rows", rows, "adaptive_mode",
                              rf_adaptive_name( plan->adaptive ), "why", plan->why, "at_most", at_most( job ), "costs", costs,
                              "bytes_record", record, "bytes_paper_example", paper );
    if ( job->ranges.list != NULL )
        json_object_set_new( json, "nodes", rf_ranges_json( &job->ranges ) );
    return json;
}

static RfResult run( Job* job, RfError* error )
{
    RfResult result = rf_load_shot( "plan", &job->options, take_defaults, job, &job->shot, error );
    if ( result == RF_OK )
        result = make_plan( job, error );
    if ( result == RF_OK )
        result = cut_ranges( job, error );
    if ( result != RF_OK )
        return result;
    const char* json = job->options.json;
    if ( rf_prints_text( json ) )
    {
        print_plan( job );
        if ( job->ranges.list != NULL )
            rf_print_ranges( &job->ranges );
        result = rf_flush_output( error );
    }
    return result == RF_OK && json != NULL ? rf_write_json( json, plan_json( job ), error ) : result;
}

int rf_command_plan( int argc, char** argv )
{
    RfError error;
    bool help;
    Job job = { .argc = argc, .argv = argv };
    RfResult result = parse( NULL, argc, argv, &job.options, &help, &error );
    if ( result == RF_OK && help )
        result = rf_show_help( &s_table, &error );
    else if ( result == RF_OK )
        result = run( &job, &error );
    rf_free_ranges( &job.ranges );
    rf_destroy_shot( &job.shot );
    return result == RF_OK ? 0 : rf_report_error( "plan", &error );
}
