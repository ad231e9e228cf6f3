// Loads scene, camera path and tracer for `tune` and `cost`; frames of a camera at rest become one.
#include "cli/options/shot.h"

#include "base/system.h"
#include "cli/options/frame_lists.h"
#include "cli/messages.h"
#include "trace/trace.h"

#include <stdio.h>
#include <stdlib.h>

int* rf_runs_of_frames( const RfCameraPath* path, const int* frames, int frame_count, int* run_count )
{
    int* runs = malloc( ( (size_t)frame_count + 1 ) * sizeof *runs );
    *run_count = 0;
    for ( int i = 0; i < frame_count && runs != NULL; ++i )
    {
        int run = path->run_of_frame[frames[i]];
        if ( *run_count == 0 || runs[*run_count - 1] != run )
            runs[( *run_count )++] = run;
    }
    return runs;
}

#define LITTLE_LIGHT 0.0005 // of all: JSON and headers alone say it

RfResult rf_warn_of_depth( const RfShot* shot, const RfRenderSettings* settings, RfLog* log, double* share, RfError* error )
{
    RfResult result = rf_find_light_beyond_depth( shot, settings, share, error );
    if ( result == RF_OK && *share >= LITTLE_LIGHT )
        rf_warn( log, "--max-depth %d: about %.2g %% of the light is beyond and missing: raise it, or leave it out",
                 settings->max_depth, 100.0 * *share );
    return result;
}

// Makes a path of the runs alone.
static void keep_runs( RfCameraPath* path )
{
    free( path->eyes );
    free( path->run_of_frame );
    path->eyes = path->runs;
    path->count = path->run_count;
    path->runs = NULL;
    path->run_of_frame = NULL;
}

static RfResult choose_runs( const RfRenderOptions* options, RfLoadedShot* shot, RfError* error )
{
    int* frames = NULL;
    int count;
    RfResult result = rf_choose_frames( options->frames, &shot->file, &shot->path, &frames, &count, error );
    if ( result != RF_OK )
        return result;
    shot->frames = rf_runs_of_frames( &shot->path, frames, count, &shot->frame_count );
    shot->asked_runs = malloc( (size_t)count * sizeof( int ) );
    for ( int i = 0; i < count && shot->asked_runs != NULL; ++i )
    {
        shot->asked_runs[i] = shot->path.run_of_frame[frames[i]];
        frames[i] = rf_frame_number( &shot->path, frames[i] );
    }
    shot->asked = frames;
    shot->asked_count = count;
    keep_runs( &shot->path );
    return shot->frames != NULL && shot->asked_runs != NULL
               ? RF_OK
               : rf_fail( error, RF_ERROR_MEMORY, "no memory left for the numbers of %d frames", count );
}

RfResult rf_load_shot( const char* command, RfRenderOptions* options, RfTakeDefaults* take, void* user, RfLoadedShot* shot,
                       RfError* error )
{
    *shot = ( RfLoadedShot ){ .frame_count = 0 };
    RfLog log = rf_stderr_log( command );
    RfResult result = rf_open_scene_file( options->scene, &shot->file, error );
    if ( result != RF_OK )
        return result;
    RfField defaults = rf_scene_file_defaults( &shot->file, error );
    if ( defaults.json != NULL )
        result = take( &defaults, user, error );
    if ( result == RF_OK )
        result = rf_load_scene_file( &shot->file, &options->movement, &shot->scene, &log, error );
    if ( result == RF_OK )
        result = rf_check_rendered( &shot->scene, error );
    if ( result == RF_OK )
        result = rf_check_file_light_groups( options, &shot->file, &shot->scene, error );
    if ( result == RF_OK )
        result = rf_take_effect_options( options, &shot->scene, &log, error );
    if ( result == RF_OK )
        result = rf_create_asked_path( options, &shot->scene, &shot->path, &log, error );
    if ( result == RF_OK )
    {
        options->size = ( RfSize ){ shot->path.eyes[0].width, shot->path.eyes[0].height };
        result = choose_runs( options, shot, error );
    }
    if ( result == RF_OK )
        result = rf_create_tracer_by( options->settings.threads, &shot->scene, &shot->tracer, error );
    RfShot whole = rf_shot_to_render( shot );
    return result == RF_OK ? rf_warn_of_depth( &whole, &options->settings, &log, &shot->beyond_depth, error ) : result;
}

#define OVERTIME 0.1 // of the budget, and these seconds, for what is being rendered
#define OVERTIME_SECONDS 2.0

double rf_budget_left( double budget, double start, double* deadline )
{
    double now = rf_wall_seconds(), left = start + budget - now;
    left = left > 0.5 * budget ? left : 0.5 * budget;
    *deadline = now + left + OVERTIME * budget + OVERTIME_SECONDS;
    return left;
}

const char* rf_format_excluded( const char* excluded, const RfMemoryFit* fit, char* text, size_t size )
{
    if ( excluded == NULL )
        return NULL;
    bool fits = fit->films > 0;
    snprintf( text, size, fits ? "%s" : "%s, needs at least %zuM", excluded, rf_whole_mib( fit->least ) );
    return text;
}

void rf_destroy_shot( RfLoadedShot* shot )
{
    rf_destroy_tracer( shot->tracer );
    rf_destroy_camera_path( &shot->path );
    rf_destroy_scene( &shot->scene );
    rf_close_scene_file( &shot->file );
    free( shot->frames );
    free( shot->asked );
    free( shot->asked_runs );
}
