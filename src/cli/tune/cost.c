// reframe cost: what accuracy costs in time.
#include "measure/cost.h"

#include "base/system.h"
#include "cli/commands.h"
#include "cli/tune/cost_report.h"
#include "cli/render/interrupt.h"
#include "cli/messages.h"
#include "cli/options/shot.h"

#include <stdlib.h>
#include <string.h>

typedef struct Job
{
    int argc;
    char** argv;
    RfCostOptions options;
    RfShot shot; // options may point into it
    RfCost cost;
    double load_seconds;
} Job;

static RfResult take_defaults( const RfField* defaults, void* user, RfError* error )
{
    Job* job = user;
    return rf_parse_cost_options_over( defaults, job->argc, job->argv, &job->options, error );
}

static RfResult load( Job* job, RfError* error )
{
    double start = rf_wall_seconds();
    RfResult result = rf_load_shot( "cost", &job->options.render, take_defaults, job, &job->shot, error );
    job->load_seconds = rf_wall_seconds() - start;
    return result;
}

static bool go_on( void* user )
{
    (void)user;
    return !rf_is_interrupted();
}

static void say( void* user, const RfCost* cost, int spp )
{
    const Job* job = user;
    if ( !job->options.render.quiet )
        fprintf( stderr, "reframe cost: %d samples, pieces of %.0f pixels, %d place%s of the path\n", spp, cost->pixels,
                 cost->positions, cost->positions == 1 ? "" : "s" );
}

// Frames that one sweep of a render finishes.
static RfResult count_per_sweep( const Job* job, const RfCostCurve* curve, int* per_sweep, RfError* error )
{
    RfRenderSettings settings = job->options.render.settings, resolved;
    settings.group = curve->group;
    settings.tile = curve->tile;
    RfMemoryFit fit;
    RfResult result =
        rf_resolve_settings( job->shot.tracer, job->shot.path.eyes, job->shot.path.count, &settings, &resolved, error );
    if ( result == RF_OK )
        result = rf_fit_memory( &job->shot.scene, job->shot.path.eyes, job->shot.path.count, job->shot.frame_count, &resolved,
                                &fit, error );
    if ( result == RF_OK )
        *per_sweep = fit.sweeps > 1 ? fit.films : job->shot.frame_count;
    return result;
}

// Names the scene, so that `report` can refuse what was measured with another one.
static json_t* result_json( const RfCostReport* r )
{
    json_t* json = rf_cost_json( r );
    json_object_set_new( json, "scene", rf_json_text( r->options->render.scene ) );
    return json;
}

// Reports what was found so far, also after an interruption.
static RfResult report( const Job* job, const RfCostJob* cost_job, RfError* error )
{
    RfCostReport r = { .options = &job->options, .job = cost_job, .cost = &job->cost, .load_seconds = job->load_seconds };
    RfResult result = count_per_sweep( job, &job->cost.plain, r.per_sweep, error );
    if ( result == RF_OK )
        result = count_per_sweep( job, &job->cost.reuse, r.per_sweep + 1, error );
    if ( result != RF_OK )
        return result;
    const char* json = job->options.render.json;
    if ( json == NULL || strcmp( json, "-" ) != 0 )
    {
        rf_print_cost( &r );
        result = rf_flush_output( error );
    }
    if ( result == RF_OK && job->options.svg != NULL )
        result = rf_write_cost_plot( &r, job->options.svg, error );
    return result == RF_OK && json != NULL ? rf_write_json( json, result_json( &r ), error ) : result;
}

static RfResult run( Job* job, RfError* error )
{
    RfResult result = load( job, error );
    if ( result != RF_OK )
        return result;
    RfTrialWatch watch = { go_on, NULL };
    RfCostJob cost = { .tracer = job->shot.tracer,
                       .eyes = job->shot.path.eyes,
                       .eye_count = job->shot.path.count,
                       .frames = job->shot.frames,
                       .frame_count = job->shot.frame_count,
                       .settings = &job->options.render.settings,
                       .budget = job->options.budget,
                       .watch = &watch,
                       .report = say,
                       .user = job };
    result = rf_measure_cost( &cost, &job->cost, error );
    if ( result == RF_ERROR_INTERRUPTED && job->cost.reuse.count > 0 )
    {
        RfResult reported = report( job, &cost, error );
        return reported != RF_OK ? reported : rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted: what was found stands above" );
    }
    if ( result == RF_ERROR_INTERRUPTED )
        return rf_fail( error, result, "interrupted before anything was found" );
    return result == RF_OK ? report( job, &cost, error ) : result;
}

int rf_command_cost( int argc, char** argv )
{
    RfError error;
    bool help;
    Job job = { .argc = argc, .argv = argv };
    RfResult result = rf_parse_cost_options( argc, argv, &job.options, &help, &error );
    if ( result == RF_OK && help )
    {
        rf_print_cost_help();
        result = rf_flush_output( &error );
    }
    else if ( result == RF_OK )
    {
        rf_catch_interrupts();
        result = run( &job, &error );
    }
    rf_destroy_shot( &job.shot );
    return result == RF_OK ? 0 : rf_report_error( "cost", &error );
}
