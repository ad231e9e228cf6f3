// reframe render: from a scene and a camera path to EXR files.
#include "cli/commands.h"
#include "cli/options/effect_options.h"
#include "cli/options/frame_list.h"
#include "cli/options/shot.h"
#include "cli/render/frame_errors.h"
#include "cli/render/interrupt.h"
#include "cli/render/progress.h"
#include "cli/render/render_json.h"
#include "cli/render/render_kept.h"
#include "cli/render/render_output.h"
#include "cli/render/render_settings.h"
#include "cli/render/render_warnings.h"
#include "cli/messages.h"
#include "scene/json/scene_file.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

// State of a render, created in this order and freed by destroy_job.
typedef struct Job
{
    int argc; // the command line, which overrides the scene file that is read later
    char** argv;
    RfRenderOptions options;
    RfRenderSettings asked; // before they were resolved
    RfMemoryFit fit;
    RfLog log;
    RfToldWarnings told;
    RfSceneFile file; // options may point into it
    RfScene scene;
    RfCameraPath path;
    int* frames; // to be written, indices from 0
    int frame_count;
    int* runs; // of the path that hold them: to be rendered
    int run_count;
    int* kept; // by --resume, likewise
    int kept_count;
    RfTracer* tracer;
    RfEffect effects[RF_MAX_EFFECTS]; // by path and settings
    int effect_count;
    char calls_for[RF_EFFECTS_TEXT_SIZE]; // their names
    RfOutput output;
    pthread_mutex_t speech; // guards messages: frames are written by another thread
    RfProgressLine line;
    int frames_done;
    bool told_black; // the warning comes once
    RfFrameErrors errors;
    json_t* frames_json;
    double start, seconds_scene; // monotonic time of the start; seconds until rays can be traced
    RfRenderStats stats;
} Job;

static double now( void )
{
    struct timespec time;
    clock_gettime( CLOCK_MONOTONIC, &time );
    return (double)time.tv_sec + 1e-9 * (double)time.tv_nsec;
}

static void destroy_job( Job* job )
{
    pthread_mutex_destroy( &job->speech );
    rf_destroy_tracer( job->tracer );
    rf_destroy_camera_path( &job->path );
    rf_destroy_scene( &job->scene );
    rf_close_scene_file( &job->file );
    free( job->frames );
    free( job->runs );
    free( job->kept );
    json_decref( job->frames_json );
    json_decref( job->told.lines );
}

static RfOutput output_of( const Job* job )
{
    return ( RfOutput ){
        .pattern = job->options.output,
        .tracer = job->tracer,
        .path = &job->path,
        .settings = job->options.settings,
        .calls_for = job->calls_for,
    };
}

// Replaces the settings by those that are used.
static RfResult resolve( Job* job, RfError* error )
{
    job->asked = job->options.settings;
    RfResult result =
        rf_resolve_settings( job->tracer, job->path.runs, job->path.run_count, &job->asked, &job->options.settings, error );
    return result == RF_OK ? rf_fit_memory( &job->scene, job->path.runs, job->path.run_count, job->run_count,
                                            &job->options.settings, &job->fit, error )
                           : result;
}

static RfResult load_scene( Job* job, RfError* error )
{
    RfResult result = rf_open_scene_file( job->options.scene, &job->file, error );
    if ( result != RF_OK )
        return result;
    RfField defaults = rf_scene_file_defaults( &job->file, error );
    if ( defaults.json != NULL )
        result = rf_parse_render_options_over( &defaults, job->argc, job->argv, &job->options, error );
    if ( result == RF_OK )
        result = rf_load_scene_file( &job->file, &job->scene, &job->log, error );
    return result == RF_OK ? rf_take_effect_options( &job->options, &job->scene, &job->log, error ) : result;
}

static RfResult fail_numbers( const Job* job, RfError* error )
{
    return rf_fail( error, RF_ERROR_MEMORY, "no memory left for the numbers of %d frames", job->frame_count );
}

static RfResult find_runs( Job* job, RfError* error )
{
    free( job->runs );
    job->runs = rf_runs_of_frames( &job->path, job->frames, job->frame_count, &job->run_count );
    return job->runs != NULL ? RF_OK : fail_numbers( job, error );
}

static void list_effects( Job* job )
{
    const RfRenderSettings* settings = &job->options.settings;
    job->effect_count = rf_list_render_effects( &job->scene, job->path.runs, job->path.run_count, settings, job->effects );
    uint64_t on = 0;
    for ( int i = 0; i < job->effect_count; ++i )
        on |= job->effects[i].on ? RF_EFFECT_BIT( job->effects[i].id ) : 0;
    rf_format_effects( on, job->calls_for, sizeof job->calls_for );
}

static RfResult load( Job* job, RfError* error )
{
    RfLens lens;
    RfResult result = load_scene( job, error );
    if ( result == RF_OK )
        result = rf_parse_lens_options( &job->options, &lens, error );
    if ( result == RF_OK )
        result = rf_create_lens_path( &job->scene, job->options.camera, &lens, job->options.fps, job->options.size.width,
                                      job->options.size.height, &job->path, error );
    if ( result == RF_OK )
        result = rf_choose_frames( job->options.frames, &job->file, &job->path, &job->frames, &job->frame_count, error );
    if ( result != RF_OK )
        return result;
    int asked_count = job->frame_count;
    job->kept = malloc( (size_t)asked_count * sizeof( int ) );
    result = job->kept != NULL ? find_runs( job, error ) : fail_numbers( job, error );
    if ( result == RF_OK )
        result = rf_create_tracer( &job->scene, &job->tracer, error );
    if ( result == RF_OK )
        result = resolve( job, error );
    if ( result != RF_OK )
        return result;
    list_effects( job );
    job->output = output_of( job );
    result = rf_prepare_output( &job->output, &job->options, job->frames, &job->frame_count, job->kept, error );
    job->kept_count = asked_count - job->frame_count;
    if ( result == RF_OK )
        result = find_runs( job, error ); // of what is left
    if ( result != RF_OK || job->options.quiet )
        return result;
    rf_tell_settings( &job->asked, &job->options.settings, &job->fit, job->path.run_count );
    rf_tell_effects( job->effects, job->effect_count );
    rf_tell_runs( &job->path, job->frames, job->frame_count, job->run_count );
    return RF_OK;
}

static void warn_before( Job* job )
{
    rf_warn_of_scene( &job->options, &job->scene, job->tracer, &job->log );
    rf_warn_of_variance( &job->options.settings, &job->path, job->frames, job->frame_count, &job->log );
    rf_warn_of_reconstruction( &job->options.settings, &job->log );
}

// A black picture of a scene with lights: most likely the camera is inside something.
static void warn_if_black( Job* job, const RfFrameResult* result )
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

static RfResult write_frame( Job* job, const RfFrameResult* result, int same_as, RfError* error )
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
    Job* job = user;
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
    Job* job = user;
    pthread_mutex_lock( &job->speech );
    rf_show_progress( &job->line, progress );
    pthread_mutex_unlock( &job->speech );
    return !rf_is_interrupted();
}

static RfResult render( Job* job, RfError* error )
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
        rf_warn_of_solves( &job->errors, &job->log );
    if ( result == RF_OK )
        rf_warn_of_stop( &job->errors, &job->options.settings, &job->stats, job->frame_count, job->run_count, &job->log );
    return result;
}

static RfResult write_json( const Job* job, bool interrupted, RfError* error )
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

static RfResult report( Job* job, RfError* error )
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

static RfResult run( Job* job, RfError* error )
{
    RfResult result = load( job, error );
    if ( result == RF_OK )
        warn_before( job );
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
    Job job = {
        .argc = argc, .argv = argv, .told = { "render", json_array() }, .speech = PTHREAD_MUTEX_INITIALIZER, .start = now()
    };
    job.log = rf_keeping_log( &job.told );
    RfResult result = rf_parse_render_options( argc, argv, &job.options, &help, &error );
    if ( result == RF_OK && help )
    {
        rf_print_render_help();
        result = rf_flush_output( &error );
        destroy_job( &job );
        return result == RF_OK ? 0 : rf_report_error( "render", &error );
    }
    if ( result == RF_OK )
    {
        rf_catch_interrupts();
        result = run( &job, &error );
    }
    destroy_job( &job );
    return result == RF_OK ? 0 : rf_report_error( "render", &error );
}
