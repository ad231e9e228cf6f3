#include "cli/options/shot.h"

#include "cli/options/frame_list.h"
#include "cli/messages.h"

#include <stdio.h>
#include <stdlib.h>

RfResult rf_load_shot( const char* command, const RfRenderOptions* options, RfTakeDefaults* take, void* user, RfShot* shot,
                       RfError* error )
{
    *shot = ( RfShot ){ .frame_count = 0 };
    RfLog log = rf_stderr_log( command );
    RfResult result = rf_open_scene_file( options->scene, &shot->file, error );
    if ( result != RF_OK )
        return result;
    RfField defaults = rf_scene_file_defaults( &shot->file, error );
    if ( defaults.json != NULL )
        result = take( &defaults, user, error );
    if ( result == RF_OK )
        result = rf_load_scene_file( &shot->file, &shot->scene, &log, error );
    if ( result == RF_OK )
        result = rf_create_camera_path( &shot->scene, options->camera, options->fps, options->size.width, options->size.height,
                                        &shot->path, error );
    if ( result == RF_OK )
        result = rf_choose_frames( options->frames, &shot->file, shot->path.count, &shot->frames, &shot->frame_count, error );
    return result == RF_OK ? rf_create_tracer( &shot->scene, &shot->tracer, error ) : result;
}

const char* rf_tell_excluded( const char* excluded, const RfMemoryFit* fit, char* text, size_t size )
{
    if ( excluded == NULL )
        return NULL;
    bool fits = fit->films > 0;
    snprintf( text, size, fits ? "%s" : "%s, the least is %zuM", excluded, rf_whole_mib( fit->least ) );
    return text;
}

void rf_destroy_shot( RfShot* shot )
{
    rf_destroy_tracer( shot->tracer );
    rf_destroy_camera_path( &shot->path );
    rf_destroy_scene( &shot->scene );
    rf_close_scene_file( &shot->file );
    free( shot->frames );
}
