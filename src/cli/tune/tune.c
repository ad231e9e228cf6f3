// reframe tune: finds the best group and tile by short renders.
#include "measure/tune.h"

#include "cli/commands.h"
#include "cli/render/interrupt.h"
#include "cli/messages.h"
#include "cli/options/shot.h"
#include "cli/options/tune_options.h"
#include "cli/tune/tune_report.h"

#include <stdlib.h>
#include <string.h>

typedef struct Job
{
    int argc;
    char** argv;
    RfTuneOptions options;
    RfShot shot; // options may point into it
    RfTune tune;
} Job;

static RfResult take_defaults( const RfField* defaults, void* user, RfError* error )
{
    Job* job = user;
    return rf_parse_tune_options_over( defaults, job->argc, job->argv, &job->options, error );
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
        fprintf( stderr, "reframe tune: round %d: %d settings on pieces of %.0f pixels, %d place%s of the path, about %.0f s\n",
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
    const RfTuneOptions* options = &job->options;
    const RfTuneRow* best = job->tune.chosen >= 0 ? job->tune.rows + job->tune.chosen : NULL;
    char* command =
        best != NULL ? rf_tuned_command( job->argc, job->argv, named_estimator( job ), best->group, &best->tile ) : NULL;
    RfTuneReport r = { .tune = &job->tune,
                       .scene = options->render.scene,
                       .command = command,
                       .width = options->render.size.width,
                       .height = options->render.size.height,
                       .frames = job->shot.frame_count,
                       .budget = options->budget };
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
    RfResult result = rf_load_shot( "tune", &job->options.render, take_defaults, job, &job->shot, error );
    if ( result != RF_OK )
        return result;
    RfTrialWatch watch = { go_on, NULL };
    RfTuneJob tune = { .tracer = job->shot.tracer,
                       .eyes = job->shot.path.eyes,
                       .eye_count = job->shot.path.count,
                       .frames = job->shot.frames,
                       .frame_count = job->shot.frame_count,
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
    rf_destroy_shot( &job.shot );
    return result == RF_OK ? 0 : rf_report_error( "tune", &error );
}
