// reframe tune: which group and tile pay, by short renders.
#include "measure/tune.h"

#include "cli/camera_options.h"
#include "cli/commands.h"
#include "cli/frame_list.h"
#include "cli/interrupt.h"
#include "cli/report.h"
#include "cli/tune_options.h"
#include "cli/tune_report.h"
#include "scene/scene_file.h"

#include <stdlib.h>
#include <string.h>

typedef struct Job
{
    int argc;
    char** argv;
    RfTuneOptions options;
    RfSceneFile file; // options may point into it
    RfScene scene;
    RfCameraPath path;
    int* frames;
    int frame_count;
    RfTracer* tracer;
    RfTune tune;
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
    RfLog log = rf_stderr_log( "tune" );
    RfResult result = rf_open_scene_file( job->options.render.scene, &job->file, error );
    if ( result != RF_OK )
        return result;
    RfField defaults = rf_scene_file_defaults( &job->file, error );
    if ( defaults.json != NULL )
        result = rf_parse_tune_options_over( &defaults, job->argc, job->argv, &job->options, error );
    const RfRenderOptions* render = &job->options.render;
    if ( result == RF_OK )
        result = rf_load_scene_file( &job->file, &job->scene, &log, error );
    if ( result == RF_OK )
        result = rf_create_camera_path( &job->scene, render->camera, render->fps, render->size, &job->path, error );
    if ( result == RF_OK )
        result = rf_choose_frames( render->frames, &job->file, job->path.count, &job->frames, &job->frame_count, error );
    return result == RF_OK ? rf_create_tracer( &job->scene, &job->tracer, error ) : result;
}

static bool go_on( void* user )
{
    (void)user;
    return !rf_is_interrupted();
}

static void say( void* user, const RfTune* tune, const RfTuneRound* round, int candidates )
{
    const Job* job = user;
    if ( !job->options.render.quiet )
        fprintf( stderr, "reframe tune: round %d: %d settings at %dx%d, %d place%s of the path, about %.0f s\n", tune->round_count + 1,
                 candidates, round->width, round->height, round->sites, round->sites == 1 ? "" : "s", round->seconds );
}

// What was found so far, also where it was interrupted.
static RfResult report( Job* job, RfError* error )
{
    const RfTuneOptions* options = &job->options;
    const RfTuneRow* best = job->tune.chosen >= 0 ? job->tune.rows + job->tune.chosen : NULL;
    char* command = best != NULL ? rf_tuned_command( job->argc, job->argv, best->group, &best->tile ) : NULL;
    RfTuneReport r = { .tune = &job->tune, .scene = options->render.scene, .command = command, .width = options->render.size.width,
                       .height = options->render.size.height, .frames = job->frame_count, .budget = options->budget };
    const char* json = options->render.json;
    RfResult result = RF_OK;
    if ( json == NULL || strcmp( json, "-" ) != 0 )
    {
        rf_print_tune( &r );
        result = rf_flush_output( error );
    }
    if ( result == RF_OK && options->svg != NULL )
        result = rf_write_tune_plot( &r, options->svg, error );
    if ( result == RF_OK && json != NULL )
        result = rf_write_json( json, rf_tune_json( &r ), error );
    free( command );
    return result;
}

static RfResult run( Job* job, RfError* error )
{
    RfResult result = load( job, error );
    if ( result != RF_OK )
        return result;
    RfTrialWatch watch = { go_on, NULL };
    RfTuneJob tune = { .tracer = job->tracer, .eyes = job->path.eyes, .eye_count = job->path.count, .frames = job->frames,
                       .frame_count = job->frame_count, .settings = &job->options.render.settings, .budget = job->options.budget,
                       .watch = &watch, .say = say, .user = job };
    result = rf_tune( &tune, &job->tune, error );
    if ( result == RF_ERROR_INTERRUPTED && job->tune.round_count > 0 )
    {
        RfResult reported = report( job, error );
        return reported != RF_OK ? reported
                                 : rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted after %d round%s: what they found stands above",
                                            job->tune.round_count, job->tune.round_count == 1 ? "" : "s" );
    }
    if ( result == RF_ERROR_INTERRUPTED )
        return rf_fail( error, result, "interrupted in the first round: nothing is found yet" );
    return result == RF_OK ? report( job, error ) : result;
}

int rf_command_tune( int argc, char** argv )
{
    RfError error;
    bool help;
    Job job = { .argc = argc, .argv = argv };
    RfResult result = rf_parse_tune_options( argc, argv, &job.options, &help, &error );
    if ( result == RF_OK && help )
    {
        rf_print_tune_help();
        result = rf_flush_output( &error );
    }
    else if ( result == RF_OK )
    {
        rf_catch_interrupts();
        result = run( &job, &error );
    }
    destroy_job( &job );
    return result == RF_OK ? 0 : rf_report_error( "tune", &error );
}
