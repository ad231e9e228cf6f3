#include "cli/render/render_job.h"

#include "cli/options/frame_list.h"
#include "cli/options/shot.h"
#include "cli/render/render_output.h"
#include "cli/render/render_settings.h"
#include "cli/render/render_warnings.h"
#include "trace/trace.h"

#include <stdlib.h>

void rf_destroy_render_job( RfRenderJob* job )
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

static RfOutput output_of( const RfRenderJob* job )
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
static RfResult resolve( RfRenderJob* job, RfError* error )
{
    job->asked = job->options.settings;
    RfResult result =
        rf_resolve_settings( job->tracer, job->path.runs, job->path.run_count, &job->asked, &job->options.settings, error );
    return result == RF_OK ? rf_fit_memory( &job->scene, job->path.runs, job->path.run_count, job->run_count,
                                            &job->options.settings, &job->fit, error )
                           : result;
}

static RfResult load_scene( RfRenderJob* job, RfError* error )
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

static RfResult fail_numbers( const RfRenderJob* job, RfError* error )
{
    return rf_fail( error, RF_ERROR_MEMORY, "no memory left for the numbers of %d frames", job->frame_count );
}

static RfResult find_runs( RfRenderJob* job, RfError* error )
{
    free( job->runs );
    job->runs = rf_runs_of_frames( &job->path, job->frames, job->frame_count, &job->run_count );
    return job->runs != NULL ? RF_OK : fail_numbers( job, error );
}

static void list_effects( RfRenderJob* job )
{
    const RfRenderSettings* settings = &job->options.settings;
    job->effect_count = rf_list_render_effects( &job->scene, job->path.runs, job->path.run_count, settings, job->effects );
    uint64_t on = 0;
    for ( int i = 0; i < job->effect_count; ++i )
        on |= job->effects[i].on ? RF_EFFECT_BIT( job->effects[i].id ) : 0;
    rf_format_effects( on, job->calls_for, sizeof job->calls_for );
}

RfResult rf_load_render_job( RfRenderJob* job, RfError* error )
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
        result = rf_create_tracer_by( job->options.settings.threads, &job->scene, &job->tracer, error );
    if ( result == RF_OK )
        result = resolve( job, error );
    if ( result != RF_OK )
        return result;
    list_effects( job );
    job->output = output_of( job );
    if ( job->options.check )
        return RF_OK;
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

void rf_warn_before_render( RfRenderJob* job )
{
    rf_warn_of_scene( &job->options, &job->scene, job->tracer, &job->log );
    rf_warn_of_variance( &job->options.settings, &job->path, job->frames, job->frame_count, &job->log );
    rf_warn_of_reconstruction( &job->options.settings, &job->log );
    rf_warn_of_light_paths( &job->options.settings, job->effects + RF_EFFECT_LIGHT_PATHS, &job->log );
}
