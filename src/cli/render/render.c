// reframe render: from a scene and a camera path to EXR files.
#include "cli/commands.h"
#include "cli/messages.h"
#include "cli/render/interrupt.h"
#include "cli/render/render_job.h"
#include "cli/render/render_json.h"
#include "cli/render/render_kept.h"

#include <string.h>
#include <time.h>

static double now( void )
{
    struct timespec time;
    clock_gettime( CLOCK_MONOTONIC, &time );
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

// A black picture of a scene with lights: most likely the camera is inside something.
static void warn_if_black( RfRenderJob* job, const RfFrameResult* result )
{
    size_t count = 3 * (size_t)result->width * (size_t)result->height;
    if ( job->told_black || !rf_tracer_has_light( job->tracer ) )
        return;
    for ( size_t i = 0; i < count; ++i )
    {
        if ( result->rgb[i] != 0.0f )
            return;
    }
    job->told_black = true;
    rf_clear_progress( &job->line );
    rf_warn( &job->log, "%s: frame %d is black, no light reaches the camera: is it inside a wall, or looking away?",
             job->options.scene, rf_frame_number( &job->path, result->frame ) );
}

static RfResult write_frame( RfRenderJob* job, const RfFrameResult* result, int same_as, RfError* error )
{
    RfResult written = rf_write_frame( &job->output, result, error );
    if ( written != RF_OK )
        return written;
    pthread_mutex_lock( &job->speech );
    ++job->frames_done;
    rf_note_frame_error( &job->errors, result, rf_frame_number( &job->path, result->frame ) );
    warn_if_black( job, result );
    rf_show_frame( &job->line, result, rf_frame_number( &job->path, result->frame ), job->frames_done, job->frame_count,
                   now() - job->start - job->seconds_scene );
    pthread_mutex_unlock( &job->speech );
    json_array_append_new( job->frames_json, rf_frame_json( result, &job->path, job->options.settings.noise, same_as ) );
    return RF_OK;
}

// A finished run: every frame of it that is wanted gets the picture. Called in the thread that writes.
static RfResult on_run( void* user, const RfFrameResult* run, RfError* error )
{
    RfRenderJob* job = user;
    RfFrameResult frame = *run;
    int same_as = -1;
    while ( job->frames_done < job->frame_count && job->path.run_of_frame[job->frames[job->frames_done]] == run->frame )
    {
        frame.frame = job->frames[job->frames_done];
        RfResult result = write_frame( job, &frame, same_as, error );
        if ( result != RF_OK )
            return result;
        same_as = same_as < 0 ? frame.frame : same_as;
        frame.seconds = 0.0; // rendered once
    }
    return RF_OK;
}

static bool on_progress( void* user, const RfProgress* progress )
{
    RfRenderJob* job = user;
    pthread_mutex_lock( &job->speech );
    rf_show_progress( &job->line, progress );
    pthread_mutex_unlock( &job->speech );
    return !rf_is_interrupted();
}

static RfResult render( RfRenderJob* job, RfError* error )
{
    if ( rf_is_interrupted() )
        return rf_fail( error, RF_ERROR_INTERRUPTED, "interrupted before the first frame" );
    job->line = rf_create_progress_line( job->options.quiet );
    RfRenderCallbacks callbacks = { .user = job, .frame = on_run, .progress = on_progress };
    RfResult result = rf_render( job->tracer, job->path.runs, job->path.run_count, job->runs, job->run_count,
                                 &job->options.settings, &callbacks, &job->stats, error );
    job->stats.missed = job->errors.missed; // of frames, not of runs
    rf_clear_progress( &job->line );
    if ( result == RF_ERROR_INTERRUPTED )
        return rf_fail( error, result, "interrupted: %d of %d frames are finished and kept, %s goes on",
                        job->kept_count + job->frames_done, job->kept_count + job->frame_count,
                        job->options.overwrite ? "--resume --overwrite" : "--resume" );
    if ( result == RF_OK )
        rf_warn_of_stop( &job->errors, &job->options.settings, &job->stats, job->frame_count, job->run_count, &job->log );
    return result;
}

static RfResult write_json( const RfRenderJob* job, bool interrupted, RfError* error )
{
    const RfRenderOptions* options = &job->options;
    RfRenderRun run = { .stats = &job->stats,
                        .seconds = now() - job->start,
                        .seconds_scene = job->seconds_scene,
                        .frames = rf_join_kept_frames( options, &job->path, job->kept, job->kept_count, job->frames_json ),
                        .kept = job->kept_count,
                        .warnings = job->told.lines,
                        .repeated = job->frame_count - job->run_count,
                        .effects = job->effects,
                        .effect_count = job->effect_count,
                        .interrupted = interrupted };
    return rf_write_json( options->json, rf_render_json( options, &run ), error );
}

static RfResult report( RfRenderJob* job, RfError* error )
{
    double seconds = now() - job->start;
    const char* json_name = job->options.json;
    if ( json_name == NULL || strcmp( json_name, "-" ) != 0 )
    {
        rf_print( "%d frame%s in %s, %.1f s", job->frame_count, job->frame_count == 1 ? "" : "s", job->options.output, seconds );
        rf_print_frame_errors( &job->errors );
        if ( job->kept_count > 0 )
            printf( "; %d kept from before", job->kept_count );
        printf( "\n" );
    }
    return json_name == NULL ? rf_flush_output( error ) : write_json( job, false, error );
}

static RfResult run( RfRenderJob* job, RfError* error )
{
    RfResult result = rf_load_render_job( job, error );
    if ( result == RF_OK )
        rf_warn_before_render( job );
    job->frames_json = json_array();
    job->seconds_scene = now() - job->start;
    // where nothing is rendered: all frames exist already, or an interruption came first
    job->stats = ( RfRenderStats ){ .group = job->options.settings.group, .spp = job->options.settings.spp };
    if ( result == RF_OK && job->frame_count > 0 )
        result = render( job, error );
    if ( result == RF_OK )
        rf_clean_output_folder( job->options.output );
    if ( result == RF_ERROR_INTERRUPTED && job->options.json != NULL )
    {
        RfResult written = write_json( job, true, error ); // `error` keeps the line about the interruption
        return written == RF_OK ? result : written;
    }
    return result == RF_OK ? report( job, error ) : result;
}

int rf_command_render( int argc, char** argv )
{
    RfError error;
    bool help;
    RfRenderJob job = {
        .argc = argc, .argv = argv, .told = { "render", json_array() }, .speech = PTHREAD_MUTEX_INITIALIZER, .start = now()
    };
    job.log = rf_keeping_log( &job.told );
    RfResult result = rf_parse_render_options( argc, argv, &job.options, &help, &error );
    if ( result == RF_OK && help )
    {
        rf_print_render_help();
        result = rf_flush_output( &error );
        rf_destroy_render_job( &job );
        return result == RF_OK ? 0 : rf_report_error( "render", &error );
    }
    if ( result == RF_OK )
    {
        rf_catch_interrupts();
        result = run( &job, &error );
    }
    rf_destroy_render_job( &job );
    return result == RF_OK ? 0 : rf_report_error( "render", &error );
}
