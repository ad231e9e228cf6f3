// reframe cost: what accuracy costs in time.
#include "measure/cost.h"

#include "base/system.h"
#include "cli/camera_options.h"
#include "cli/commands.h"
#include "cli/cost_report.h"
#include "cli/frame_list.h"
#include "cli/interrupt.h"
#include "cli/report.h"
#include "scene/scene_file.h"

#include <stdlib.h>
#include <string.h>

typedef struct Job
{
    int argc;
    char** argv;
    RfCostOptions options;
    RfSceneFile file; // options may point into it
    RfScene scene;
    RfCameraPath path;
    int* frames;
    int frame_count;
    RfTracer* tracer;
    RfCost cost;
    double load_seconds;
} Job;

static void destroy_job( Job* job )
{
    rf_destroy_tracer( job->tracer );
    rf_destroy_camera_path( &job->path );
    rf_destroy_scene( &job->scene );
    rf_close_scene_file( &job->file );
    free( job->frames );
}

static RfResult load( Job* job, RfError* error )
{
    RfLog log = rf_stderr_log( "cost" );
    double start = rf_wall_seconds();
    RfResult result = rf_open_scene_file( job->options.render.scene, &job->file, error );
    if ( result != RF_OK )
        return result;
    RfField defaults = rf_scene_file_defaults( &job->file, error );
    if ( defaults.json != NULL )
        result = rf_parse_cost_options_over( &defaults, job->argc, job->argv, &job->options, error );
    const RfRenderOptions* render = &job->options.render;
    if ( result == RF_OK )
        result = rf_load_scene_file( &job->file, &job->scene, &log, error );
    if ( result == RF_OK )
        result = rf_create_camera_path( &job->scene, render->camera, render->fps, render->size, &job->path, error );
    if ( result == RF_OK )
        result = rf_choose_frames( render->frames, &job->file, job->path.count, &job->frames, &job->frame_count, error );
    if ( result == RF_OK )
        result = rf_create_tracer( &job->scene, &job->tracer, error );
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
        fprintf( stderr, "reframe cost: %d samples, %dx%d, %d place%s of the path\n", spp, cost->width, cost->height, cost->places,
                 cost->places == 1 ? "" : "s" );
}

// Frames that a render goes through the path for at once.
static RfResult count_per_sweep( const Job* job, const RfCostCurve* curve, int* per_sweep, RfError* error )
{
    RfRenderSettings settings = job->options.render.settings, resolved;
    settings.group = curve->group;
    settings.tile = curve->tile;
    RfMemoryFit fit;
    RfResult result = rf_resolve_settings( job->tracer, job->path.eyes, job->path.count, &settings, &resolved, error );
    if ( result == RF_OK )
        result = rf_fit_memory( &job->scene, job->path.eyes, job->path.count, job->frame_count, &resolved, &fit, error );
    if ( result == RF_OK )
        *per_sweep = fit.sweeps > 1 ? fit.films : job->frame_count;
    return result;
}

// What was found so far, also where it was interrupted.
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
    return result == RF_OK && json != NULL ? rf_write_json( json, rf_cost_json( &r ), error ) : result;
}

static RfResult run( Job* job, RfError* error )
{
    RfResult result = load( job, error );
    if ( result != RF_OK )
        return result;
    RfTrialWatch watch = { go_on, NULL };
    RfCostJob cost = { .tracer = job->tracer, .eyes = job->path.eyes, .eye_count = job->path.count, .frames = job->frames,
                       .frame_count = job->frame_count, .settings = &job->options.render.settings, .budget = job->options.budget,
                       .watch = &watch, .say = say, .user = job };
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
    destroy_job( &job );
    return result == RF_OK ? 0 : rf_report_error( "cost", &error );
}
